#pragma once
// The daemon's wiring for one topology: plant, clock, controller, state, reports. Everything is made in the constructor
// and start(); run() allocates nothing.

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "airside/controller/cycle.hpp"
#include "airside/controller/instances.hpp"
#include "firmware/edge/any_daemon.hpp"
#include "firmware/edge/crash_loop.hpp"
#include "firmware/edge/daemon_state.hpp"
#include "firmware/edge/report/clock_report.hpp"
#include "firmware/edge/report/plant_clock_report.hpp"
#include "firmware/edge/report/point_readings.hpp"
#include "firmware/edge/report/row_report.hpp"
#include "firmware/edge/report/status_snapshot.hpp"
#include "hal/modbus/plant.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/points/signal_limits.hpp"
#include "hal/system/service_manager.hpp"

namespace airside::edge {

template <Topology T>
class Daemon final : public AnyDaemon {
 public:
  Daemon(const hal::SiteFile& site, const hal::PointMap& points, const DaemonOptions& options, hal::StopFlag stop);

  void start() override;
  std::string check() override { return state_.check(); }
  int run() override;

  /// After each row: remember it, show it.
  bool row(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller);

  const Controller<T>& controller() const { return *controller_; }
  [[nodiscard]] std::uint64_t transitions() const override { return controller_->replay().total_pushed(); }

 private:
  /// The AHU, unless a person wants it back: the row that finds his wish comes after its own write.
  struct AskedPlant {
    Daemon* daemon;
    Expected<Reading<T>> sense() const { return daemon->plant_.sense(); }
    Expected<Applied> actuate(const Command& command) const {
      if (daemon->state_.release_waits()) return tl::unexpected(Fault::released);
      return daemon->plant_.actuate(command);
    }
  };

  /// The machine's clock, whose waiting goes on with the heartbeat.
  struct BeatingClock {
    Daemon* daemon;
    CivilTime now() const { return daemon->system_clock_.now(); }
    bool sleep_until(CivilTime t) const {
      return daemon->system_clock_.sleep_until(t, daemon->site_.modbus->heartbeat_s,
                                               [this] { daemon->beat_between_rows(); });
    }
    CivilTime woke() const { return daemon->system_clock_.woke(); }
  };

  CivilTime now() { return plant_clock_ ? plant_clock_->now() : system_clock_.now(); }
  CivilTime run_until_disturbed(CivilTime t, CivilTime end);
  int ended();
  void begin_control(CivilTime t);
  bool report_clock(CivilTime t);
  void report_bus(CivilTime t);
  void beat_between_rows();
  void read_points(CivilTime now, bool answers);
  bool wait_for_plant();
  void note_met(CivilTime t);
  void write_status(CivilTime stopped_at = {});

  hal::SiteFile site_;
  LimitsTable<T> limits_;
  DaemonOptions options_;
  hal::StopFlag stop_;
  hal::ModbusLink link_;
  hal::ModbusPlant<T> plant_;
  hal::SystemClock system_clock_;
  BeatingClock beating_clock_{this};
  AskedPlant asked_plant_{this};
  bool beats_ = false;  ///< as of the last row: the heartbeat goes on
  std::optional<hal::ModbusPlantClock> plant_clock_;
  std::unique_ptr<Controller<T>> controller_;
  DaemonState<T> state_;
  StatusFile status_;
  PointReadings readings_;
  std::array<std::string, static_cast<std::size_t>(Layout<T>::signals)> names_;
  CivilTime next_, last_row_;
  CivilTime first_row_;  ///< where it is still to come
  Reason met_ = Reason::none;
  CivilTime met_since_;
  Expected<Reading<T>> last_sensed_ = tl::unexpected(Fault::no_reading);
  hal::ServiceManager service_;
  CrashLoop crash_loop_;
  ClockReport clock_report_;
  PlantClockReport plant_clock_report_;
  RowReport report_;
};

}  // namespace airside::edge
