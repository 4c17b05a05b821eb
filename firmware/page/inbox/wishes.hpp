#pragma once
// An operator's wishes as files of the daemon's inbox, the same as `airside release` and its sisters leave there.

#include <string>
#include <string_view>

namespace airside::page {

struct WishAnswer {
  int status = 500;  ///< HTTP
  std::string text;
};

/// `body`: hours after which the box takes over again, 1 to 168; empty: until a hand-back.
WishAnswer ask_release(const std::string& inbox_dir, std::string_view body);
WishAnswer ask_hand_back(const std::string& inbox_dir);
WishAnswer ask_rollback(const std::string& inbox_dir);
/// "release" or "hand-back", whichever lies in the inbox; empty where neither does, or it cannot be read. A release
/// stays there as long as it holds.
std::string waiting_wish(const std::string& inbox_dir);
/// The daemon reads every point of the map and says in points.json what it found.
WishAnswer ask_readings(const std::string& inbox_dir);
/// One write of the setpoint, and back; every point is read too.
WishAnswer ask_write_check(const std::string& inbox_dir);

}  // namespace airside::page
