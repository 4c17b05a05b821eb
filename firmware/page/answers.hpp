#pragma once
// What can be read: the status, and what the page makes of status, log and its own ledger. Little is done at once, so
// that nobody waits for a request of somebody else.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "firmware/page/data/checkout.hpp"
#include "firmware/page/data/forecast_gap.hpp"
#include "firmware/page/data/ledger.hpp"
#include "firmware/page/data/site_clock.hpp"
#include "firmware/page/data/state_folder.hpp"
#include "firmware/page/data/trend_store.hpp"
#include "firmware/page/http/request_check.hpp"
#include "hal/site/site_file.hpp"

struct MHD_Response;

namespace airside::page {

struct Answer {
  int status = 200;  ///< HTTP
  MHD_Response* response = nullptr;
};

class Answers {
 public:
  explicit Answers(const hal::SiteFile& site);

  /// Looks for a new status and reads a little of the log; at most once in a fifth of a second. True: more is waiting.
  bool tick(std::int64_t now_ns);
  /// Answer of a route that reads. `span`: of the query, may be null.
  Answer read(Route route, const char* span);
  Ledger& ledger() { return ledger_; }
  Checkout& checkout() { return checkout_; }
  /// What the site's clock shows now, as the times of the status and of the log.
  std::string site_time() const { return page::site_time(status_, plant_clock_); }

 private:
  struct Cached {
    std::uint64_t generation = 0, count = 0;
    bool reading = true;
    std::string text;
  };
  /// Whether it is of the rows that the store has now.
  bool is_of_now(const Cached& cached) const;
  Answer status();
  Answer weights() const;
  Answer trends_json(std::string_view span);
  Answer trends_csv(std::string_view span) const;
  Answer gap();

  std::string state_dir_, site_text_;
  bool of_band_, plant_clock_;
  GapHint gap_hint_;
  StatusReader status_;
  Ledger ledger_;
  Checkout checkout_;
  TrendStore store_;
  std::array<Cached, 3> cached_;  ///< day, week, month
  Cached gap_;
  std::int64_t looked_ns_ = 0;
  bool more_ = true;
};

}  // namespace airside::page
