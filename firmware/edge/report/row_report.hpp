#pragma once
// What the daemon says of a row, once a change: bus and control mode; and of the service manager's watchdog.

#include <string_view>

#include "airside/supervision/mode_arbiter.hpp"
#include "hal/points/point_map.hpp"

namespace airside::edge {

/// A watchdog that a late row would trip restarts a healthy daemon: says so. `given_s`: WatchdogSec, 0 without.
void say_watchdog(double given_s);

class RowReport {
 public:
  /// A point whose words make sense only in another order, or nullptr; it must outlive this.
  void say_doubted(const hal::Point* doubted);
  /// `storage_remedy`: what a person does about storage that failed, where its cause is known.
  void say_mode(const ActiveMode& on, std::string_view storage_remedy = {});

 private:
  std::string_view said_doubted_;
  ActiveMode said_mode_;
};

}  // namespace airside::edge
