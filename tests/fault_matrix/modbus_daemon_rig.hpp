#pragma once
// The real daemon, the chaos proxy, and `airside serve` on the RC plant behind it: what a row of the matrix does to a
// day of control.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "fault_matrix/modbus_exchange.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/modbus/wire.hpp"
#include "support/bench.hpp"
#include "tools/chaos/chaos_proxy.hpp"

namespace airside::fault_matrix {

/// Every setpoint that reached the server: finite by its type, within limits, one step from what stood there.
class SetpointLedger {
 public:
  SetpointLedger(double min_degc, double max_degc, double step_k) : min_(min_degc), max_(max_degc), step_(step_k) {}

  void note(const tools::ChaosExchange& e) {
    if (!e.taken() || e.request.addr != 0) return;
    if (e.request.function == 3) standing_ = raw(e.answered, 9);
    if (e.request.function != 6 && e.request.function != 16) return;
    const std::size_t at = e.request.function == 6 ? 10 : 13;
    const double asked = raw(e.asked, at);
    ++writes;
    altered += asked != raw(e.forwarded, at);
    const bool way_in = (standing_ < asked && asked < min_) || (standing_ > asked && asked > max_);
    outside += !(way_in || (asked >= min_ - 1e-9 && asked <= max_ + 1e-9));
    if (std::isfinite(standing_)) {
      const double step = std::abs(asked - standing_);
      widest_step_k = std::max(widest_step_k, step);
      too_wide += step > step_ + 1e-9;
    }
    standing_ = raw(e.forwarded, at);
  }

  std::uint64_t writes = 0, altered = 0, outside = 0, too_wide = 0;
  double widest_step_k = 0;

 private:
  static double raw(const std::vector<std::uint8_t>& frame, std::size_t at) {
    if (frame.size() < at + 2) return std::numeric_limits<double>::quiet_NaN();
    return 0.01 * static_cast<std::int16_t>(hal::get16(&frame[at]));
  }
  double min_, max_, step_;
  double standing_ = std::numeric_limits<double>::quiet_NaN();
};

class ChaosLoop {
 public:
  /// `points`: in the map, the first text is replaced by the second. The daemon's map alone where `daemon_only`.
  struct Options {
    std::string name, script = {};
    int days = 1;
    double deadline_s = 2;
    std::uint64_t seed = 1;
    std::string from = {}, to = {};
    bool daemon_only = false;
  };

  explicit ChaosLoop(const Options& options)
      : bench(
            {.name = "chaos_" + options.name, .plant = closed_loop::rc_room(), .expert_days = 1, .days = options.days}),
        ledger(20.0, 26.0, 4.5) {
    const std::string map = text_of("points.csv");
    std::string changed = map;
    if (!options.from.empty()) {
      const std::size_t at = changed.find(options.from);
      if (at == std::string::npos) throw std::runtime_error("no " + options.from);
      changed.replace(at, options.from.size(), options.to);
    }
    if (!options.daemon_only) write("points.csv", changed);
    bench.start_server();
    write("points.csv", changed);
    const std::string where = text_of("ready");
    tools::ChaosSettings settings;
    settings.to_port = std::stoi(where.substr(where.rfind(':') + 1));
    settings.rules = tools::parse_chaos_script(options.script, "test").rules;
    settings.seed = options.seed;
    proxy.emplace(settings, [this](const tools::ChaosExchange& e) { note(e); });
    std::string site = text_of("site.toml");
    replace(site, "port = " + std::to_string(settings.to_port), "port = " + std::to_string(proxy->port()));
    replace(site, "deadline_s = 10.0", "deadline_s = " + std::to_string(options.deadline_s));
    write("site.toml", site);
  }

  /// Runs the daemon to its end, or for `at_most_s`. Returns whether it ended in order.
  bool run(double at_most_s = 200) {
    const auto daemon = bench.start_daemon();
    return daemon->wait(at_most_s) == 0;
  }

  std::string said() const { return text_of("daemon.txt"); }
  bool has_said(const std::string& what) const { return said().find(what) != std::string::npos; }
  nlohmann::json status() const { return bench.status(); }
  bool has_alarm(const std::string& reason) const {
    const nlohmann::json s = status();
    if (!s.contains("alarms")) return false;
    return std::ranges::any_of(s["alarms"], [&](const auto& a) { return a["reason"] == reason; });
  }
  /// Rows of each mode.
  std::map<std::string, std::size_t> modes() const {
    std::map<std::string, std::size_t> counted;
    const hal::Log log = hal::read_log(bench.file("log").string(), hal::counts_of<FiveZone>(), {.keep_missing = true});
    for (const hal::LogRow& row : log.rows) ++counted[row.controller.mode];
    return counted;
  }
  std::vector<tools::ChaosExchange> exchanges() const {
    const std::scoped_lock lock(mutex_);
    return seen_;
  }
  template <class Wanted>
  std::size_t count(const Wanted& wanted) const {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(std::ranges::count_if(seen_, wanted));
  }
  void expect_safe() const {
    EXPECT_EQ(ledger.outside, 0U);
    EXPECT_EQ(ledger.too_wide, 0U) << "widest " << ledger.widest_step_k << " K";
  }
  std::string text_of(const std::string& name) const {
    std::ifstream in(bench.file(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(bench.file(name), std::ios::binary | std::ios::trunc) << text;
  }

 private:
  static void replace(std::string& text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error("no " + from + " in\n" + text);
    text.replace(at, from.size(), to);
  }
  void note(const tools::ChaosExchange& e) {
    const std::scoped_lock lock(mutex_);
    ledger.note(e);
    seen_.push_back(e);
  }

  mutable std::mutex mutex_;
  std::vector<tools::ChaosExchange> seen_;

 public:
  closed_loop::Bench bench;
  SetpointLedger ledger;  ///< look at it after run()
  std::optional<tools::ChaosProxy> proxy;
};

}  // namespace airside::fault_matrix
