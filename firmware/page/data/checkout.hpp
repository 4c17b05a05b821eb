#pragma once
// Point checkout: what the daemon read of each point of the map, and who signed it off. One small file of the page's
// own, replaced atomically with each sign-off.

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/page/http/refusals.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"

namespace airside::page {

class Checkout {
 public:
  static constexpr const char* file_name = "checkout.json";
  static constexpr std::uint64_t max_bytes = 524288;
  static constexpr std::size_t max_name_bytes = 80;  ///< of a person's name

  /// Errors: none; a site without a point map, or one that cannot be read, has no points and says so in trouble().
  explicit Checkout(const hal::SiteFile& site);

  /// Every point of the map in its order, what points.json of the daemon says of it, and its sign-off. A sign-off holds
  /// for the row of the map that it was given for: `signed.valid` is false where the row has changed since.
  /// {time, age_s, waiting, trouble, kept, total, signed, points: [...]}.
  nlohmann::json points() const;
  /// The same as CSV, a line a point. Texts that a spreadsheet would take for a formula begin with an apostrophe.
  std::string csv() const;

  /// `body`: point, person, time of the reading, a line each. What is signed is the reading that the person saw.
  /// Errors: 400 for another body, 404 for a point that the map lacks, 409 where the reading is another one by now or
  /// not plausible, 503 where the sign-off cannot be kept; then nothing is signed.
  Said sign(std::string_view body, const std::string& role);
  /// `body`: point. Errors: 404 where nothing was signed, 503.
  Said withdraw(std::string_view body);

 private:
  struct SignOff {
    std::string by, role, at, read_at, raw, value, row;
  };
  using SignOffs = std::map<std::string, SignOff, std::less<>>;

  void load();
  bool save(const SignOffs& all);
  nlohmann::json latest() const;
  nlohmann::json fact(const hal::Point& point, const nlohmann::json& reading) const;

  std::string state_dir_, inbox_dir_, dir_, trouble_;
  std::optional<hal::PointMap> map_;
  SignOffs signed_;
  bool kept_ = true;
};

}  // namespace airside::page
