#pragma once
// The daemon as an object of the test's own process, so that its heap and its stack can be watched.

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "firmware/edge/daemon.hpp"
#include "hal/site/site_settings.hpp"
#include "support/bench.hpp"

namespace airside::footprint {

/// The daemon in this process on the bench's site, its room served by another.
class DaemonHere {
 public:
  DaemonHere(closed_loop::Bench& bench, std::size_t rows) : bench_(bench) {
    bench_.start_server();
    const hal::SiteFile site = hal::read_site_file(bench_.file("site.toml").string(), hal::site_rules());
    const hal::PointMap points = hal::PointMap::load(site.modbus->points);
    const std::int64_t open =
        bench_.trial().expert_days * std::int64_t{86400} + tools::start_of(bench_.trial().plant).seconds;
    edge::DaemonOptions options;
    options.sync = hal::Sync::full;
    options.until = CivilTime{open + static_cast<std::int64_t>(rows) * row_s};
    daemon_ = edge::make_daemon(site, points, options, hal::StopFlag(&stop_));
  }

  edge::AnyDaemon& daemon() { return *daemon_; }

  /// Runs until some rows are logged: connection, files and the first decisions are made.
  void settle(std::size_t rows) {
    std::thread watcher([this, rows] {
      while (bench_.logged_rows() < rows) closed_loop::sleep_s(0.001);
      stop_ = true;
    });
    EXPECT_EQ(daemon_->run(), 0);
    watcher.join();
    stop_ = false;
  }

 private:
  closed_loop::Bench& bench_;
  std::atomic<bool> stop_{false};
  std::unique_ptr<edge::AnyDaemon> daemon_;
};

}  // namespace airside::footprint
