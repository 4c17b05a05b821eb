#pragma once
// The daemon, whatever the topology of its room. Its parts are wired in daemon.hpp.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "airside/civil_time.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"
#include "hal/storage/store_error.hpp"

namespace airside::edge {

/// What the command line adds to the site file.
struct DaemonOptions {
  hal::Sync sync = hal::Sync::full;
  std::optional<CivilTime> until;  ///< stop there; for tests and demos
  double backoff_first_s = 1.0;
  double stall_s = 120.0;    ///< a simulated plant's clock may stand still for this long
  double clock_speed = 1.0;  ///< of the system clock, for measurements beside `airside serve --speed`
  int crash_limit = 3;       ///< this many starts within ten minutes are a crash loop; 0: never
};

class AnyDaemon {
 public:
  virtual ~AnyDaemon() = default;

  /// Opens state and log and finds out where to go on: the newest good state, else the blob, else the schedule.
  /// Errors: hal::InputError for a bad blob or history, or a state folder that another daemon uses.
  virtual void start() = 0;

  /// Reads what start() would read and leaves everything as it is, beside a running daemon too. Returns the trusted
  /// keys, for people.
  /// Errors: hal::InputError as of start(), but for the state folder.
  virtual std::string check() = 0;

  /// Runs until a stop is requested, or until options.until; called again, it goes on. Returns the process's exit code.
  /// Cost: no heap.
  virtual int run() = 0;

  /// Transitions remembered since the state began, also those that the ring has dropped.
  [[nodiscard]] virtual std::uint64_t transitions() const = 0;
};

/// The daemon for the site's topology; none if this build has no such. The site has [modbus]. Errors: hal::InputError.
/// Source: DESIGN.md, decision 1.
std::unique_ptr<AnyDaemon> make_daemon(const hal::SiteFile& site, const hal::PointMap& points,
                                       const DaemonOptions& options, hal::StopFlag stop);

}  // namespace airside::edge
