#pragma once
// What the page itself remembers: alarms until somebody has seen them, and what became of pushed weights. One small
// file, replaced atomically whenever something in it changes.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace airside::page {

/// The alarms first to last, both included; of all numbers without limits.
struct AlarmIds {
  std::uint64_t first = 1, last = UINT64_MAX;
};

class Ledger {
 public:
  static constexpr const char* file_name = "ledger.json";
  static constexpr std::size_t max_alarms = 100, max_events = 50;
  static constexpr std::uint64_t max_bytes = 131072;

  /// `dir`: a folder of the page's own. Where it cannot be written all is remembered until the page ends.
  explicit Ledger(std::string dir);

  /// Follows a status of the daemon.
  void watch(const nlohmann::json& status);
  /// Somebody has seen the alarms `ids`, at `at` of the site's clock. False: none of those numbers was unseen.
  bool see(AlarmIds ids, std::string_view by, const std::string& at);
  /// Something that happened to weights at `at` of the site's clock, such as an upload.
  void note(const std::string& what, const std::string& detail, const std::string& by, const std::string& at);

  /// {alarms: active ones first, then those that ended unseen, then the rest}, newest first in each; {kept}.
  nlohmann::json alarms() const;
  /// Newest first.
  nlohmann::json events() const;
  /// Why the file cannot be kept; empty where it can.
  const std::string& trouble() const { return trouble_; }

 private:
  struct Alarm {
    std::uint64_t id = 0;
    std::string reason, since, ended, seen_by, seen_at;  ///< times of the site's clock; "": not yet
    std::uint64_t times = 1;                             ///< that it came from since to ended
    bool is_waiting() const { return !ended.empty() && seen_at.empty(); }
  };
  struct Event {
    std::string at, what, detail, by;
  };

  void load();
  void save();
  bool follow_alarms(const nlohmann::json& status);
  bool follow_weights(const nlohmann::json& status);
  bool merge_two();
  void make_room();
  void add_event(Event event);

  std::string dir_, now_, trouble_;
  std::vector<Alarm> alarms_;      ///< oldest first
  std::vector<Event> events_;      ///< oldest first
  std::string weights_, refusal_;  ///< as last seen, so that a change is noticed after a restart too
  std::uint64_t last_id_ = 0;
  bool has_seen_status_ = false;
};

}  // namespace airside::page
