#pragma once
// A served device, the chaos proxy before it, and the real link and plant as its client: one row of the matrix at a
// time is done to them.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "airside/supervision/envelope.hpp"
#include "fault_matrix/modbus_exchange.hpp"
#include "hal/modbus/plant.hpp"
#include "hal/modbus/wire.hpp"
#include "support/modbus_fixture.hpp"
#include "tools/chaos/chaos_proxy.hpp"

namespace airside::fault_matrix {

using tools::ChaosExchange;
using tools::ChaosKind;

inline std::vector<tools::ChaosRule> rules_of(const std::string& script) {
  return tools::parse_chaos_script(script, "test").rules;
}

inline hal::PointMap room_map(const std::string& from = "", const std::string& to = "") {
  std::string csv = hal::default_point_map(5, 5, 2);
  if (!from.empty()) csv.replace(csv.find(from), from.size(), to);
  return hal::PointMap::parse(csv, "points.csv");
}

/// A command of this setpoint, through the only maker of commands.
inline Command command_of(double setpoint_degc) {
  ControllerSettings settings;
  settings.limit_min_degc = 8;
  settings.limit_max_degc = 32;
  settings.limit_change_k = 30;
  settings.round_k = 0.01;
  return SafetyEnvelope(settings).limit(setpoint_degc, std::nan(""), setpoint_degc);
}

class ChaosDesk {
 public:
  using L = Layout<FiveZone>;
  static constexpr double deadline_s = 0.6;
  /// Beyond a deadline, on a machine that is busy with other things.
  static constexpr double busy_s = 0.5;

  explicit ChaosDesk(const std::string& script = "", double backoff_s = 0.0, const hal::PointMap& points = room_map(),
                     const hal::PointMap& device = room_map())
      : map(points),
        served(device, {hal::TcpListen{}, 1}),
        proxy(settings_to(served.server().port(), script), [this](const ChaosExchange& e) { note(e); }),
        link(link_to(proxy.port(), backoff_s)),
        plant(map, link) {
    hal::ModbusServer& server = served.server();
    for (const hal::Point& p : device.points()) {
      if (p.fc == 4 && p.name != "map_fingerprint") server.set(p.name, value_of(p));
    }
    server.set("setpoint", 21.0);
    served.start();
  }

  /// A sane value that differs from point to point.
  static double value_of(const hal::Point& p) {
    if (p.name == "clock_s") return 86400;
    if (p.unit == "degc") return 20.0 + 0.1 * p.addr;
    return p.unit == "kw" ? 3.3 + p.addr : 1.0;
  }
  /// Whether a reading shows what the device has, but for signal `lost`, which must be invalid.
  void expect_right(const Expected<Reading<FiveZone>>& reading, int lost = -1) const {
    ASSERT_TRUE(reading) << text_of(reading.error());
    for (int i = 0; i < L::signals; ++i) {
      const hal::Point& p = map.at(hal::point_name(signal_id<FiveZone>(i)));
      if (i == lost) {
        EXPECT_TRUE(std::isnan(reading->value[i])) << p.name;
      } else {
        EXPECT_EQ(reading->value[i], hal::rounded(p, value_of(p))) << p.name;
      }
    }
  }
  /// Nothing is disturbed: twenty rows of right values, one connection, no complaint, and writes that arrive.
  void expect_undisturbed() {
    for (int i = 0; i < 20; ++i) {
      expect_right(plant.sense());
      const double wish = 21.0 + 0.1 * i;
      const Expected<Applied> applied = plant.actuate(command_of(wish));
      ASSERT_TRUE(applied);
      EXPECT_NEAR(applied->setpoint_degc, wish, 1e-9);
      EXPECT_TRUE(plant.beat());
    }
    const hal::LinkCounters& c = link.counters();
    EXPECT_EQ(c.connects, 1U);
    EXPECT_EQ(c.timeouts + c.bad_frames + c.wrong_ids + c.exceptions, 0U);
    EXPECT_FALSE(plant.map_refused() || plant.gateway_failed() || plant.other_device());
    EXPECT_EQ(plant.order_doubted(), nullptr);
    EXPECT_EQ(link.backoff_left_s(), 0.0);
  }

  std::vector<ChaosExchange> exchanges() const {
    const std::scoped_lock lock(mutex_);
    return seen_;
  }
  template <class Wanted>
  std::size_t count(const Wanted& wanted) const {
    const std::vector<ChaosExchange> all = exchanges();
    return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), wanted));
  }
  std::size_t writes_taken() const {
    return count([](const ChaosExchange& e) { return e.request.writes() && e.taken(); });
  }
  /// How long `act` takes, s.
  template <class Act>
  static double seconds(const Act& act) {
    const std::int64_t start_ns = hal::monotonic_ns();
    act();
    return hal::testing_peers::seconds_since(start_ns);
  }

 private:
  static tools::ChaosSettings settings_to(int port, const std::string& script) {
    tools::ChaosSettings s;
    s.to_port = port;
    s.rules = rules_of(script);
    return s;
  }
  static hal::LinkSettings link_to(int port, double backoff_s) {
    hal::LinkSettings s = hal::testing_peers::tcp_settings(port, deadline_s);
    s.backoff_first_s = backoff_s;
    s.backoff_max_s = 4 * backoff_s;
    return s;
  }
  void note(const ChaosExchange& e) {
    const std::scoped_lock lock(mutex_);
    seen_.push_back(e);
  }

  mutable std::mutex mutex_;
  std::vector<ChaosExchange> seen_;

 public:
  hal::PointMap map;
  hal::testing_peers::ServerThread served;
  tools::ChaosProxy proxy;
  hal::ModbusLink link;
  hal::ModbusPlant<FiveZone> plant;
};

}  // namespace airside::fault_matrix
