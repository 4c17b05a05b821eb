#pragma once
// An operator's wishes as files of the daemon's inbox, the same as `airside release` and its sisters leave there.

#include <string>
#include <string_view>

#include "firmware/page/http/refusals.hpp"
#include "hal/storage/store_error.hpp"

namespace airside::page {

/// The folder could not be opened or written: 507 where the disk is full, else 503.
Said inbox_refusal(hal::StoreFault fault);

/// `body`: hours after which the box takes over again, 1 to 168; empty: until a hand-back.
Said ask_release(const std::string& inbox_dir, std::string_view body);
Said ask_hand_back(const std::string& inbox_dir);
Said ask_rollback(const std::string& inbox_dir);
/// "release" or "hand-back", whichever lies in the inbox; empty where neither does, or it cannot be read. A release
/// stays there as long as it holds.
std::string waiting_wish(const std::string& inbox_dir);
/// The daemon reads every point of the map and says in points.json what it found.
Said ask_readings(const std::string& inbox_dir);
/// One write of the setpoint, and back; every point is read too.
Said ask_write_check(const std::string& inbox_dir);

}  // namespace airside::page
