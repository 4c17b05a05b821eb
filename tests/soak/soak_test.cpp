// The real daemon for years of simulated time, over real sockets and files, with a fault every ten cycles: of the bus,
// of sensors, of hands on the setpoint, of the box.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>

#include "airside/splitmix64.hpp"
#include "airside/supervision/schedule.hpp"
#include "hal/points/register_codec.hpp"
#include "sim/faults/faulty_model.hpp"
#include "support/bench.hpp"
#include "support/default_cycle.hpp"
#include "support/sanitized.hpp"
#include "tools/chaos/chaos_proxy.hpp"
#include "tools/run/served_plant.hpp"

namespace airside::soak {
namespace {

using closed_loop::Bench;
using closed_loop::Child;
using sim::FaultKind;

constexpr int expert_days = 5;
constexpr int fault_every_cycles = 10;
constexpr double settled_h = 1.5;  ///< after a fault, until a cycle counts as undisturbed again

/// What a process holds.
struct Held {
  double resident_kib = 0;
  int descriptors = 0, threads = 0, files = 0;
  double files_kib = 0;
};

Held held_by(int pid, const std::filesystem::path& folder) {
  Held held;
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) held.resident_kib = std::atof(line.c_str() + 6);
    if (line.starts_with("Threads:")) held.threads = std::atoi(line.c_str() + 8);
  }
  std::error_code ignored;
  for ([[maybe_unused]] const auto& d : std::filesystem::directory_iterator(fmt::format("/proc/{}/fd", pid), ignored)) {
    ++held.descriptors;
  }
  for (const char* part : {"state", "log", "inbox"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder / part, ignored)) {
      ++held.files;
      held.files_kib += static_cast<double>(entry.file_size(ignored)) / 1024;
    }
  }
  return held;
}

/// A site on the bench whose bus, sensors and daemon can all be disturbed.
class SoakSite {
 public:
  SoakSite(int days, std::uint64_t seed)
      : days_(days),
        bench_({.name = "soak", .plant = closed_loop::rc_room("301-real"), .expert_days = expert_days, .days = days}),
        trial_(bench_.trial()),
        begun_(tools::prepare(trial_)),
        model_(*begun_.model, {}),
        server_(trial_.site.points, {.listen = hal::TcpListen{"127.0.0.1", 0}}),
        served_(model_, server_, 0, begun_.until),
        proxy_(proxy_settings(server_.port(), seed), [this](const tools::ChaosExchange& e) { look(e); }),
        draw_(seed),
        next_fault_s_(model_.time().seconds + fault_every_cycles * cycle_s) {
    write_site();
    start();
  }

  /// Serves until the plant's time is over.
  void run() {
    while (restarts < 3) {
      server_.serve_once(0.05);
      served_.step();
      step();
      const std::optional<int> code = daemon_->wait(0);
      if (code == 0) return;  // the last day is over
      if (!code) continue;
      ++restarts;
      start();
    }
  }

  std::uint64_t cycles = 0, faults = 0, kills = 0, unsafe = 0, writes = 0, restarts = 0;
  double outside_sum_k = 0, outside_count = 0, all_sum_k = 0, all_count = 0;
  std::vector<CivilTime> outside;  ///< working cycles that count as undisturbed
  std::vector<std::pair<std::uint64_t, Held>> samples;
  std::map<std::string, int> by_kind;
  const tools::Trial& trial() const { return trial_; }
  const Bench& bench() const { return bench_; }

 private:
  static tools::ChaosSettings proxy_settings(int port, std::uint64_t seed) {
    tools::ChaosSettings settings;
    settings.to_port = port;
    settings.seed = seed;
    return settings;
  }

  void write_site() const {
    std::ifstream in(bench_.file("site.toml"));
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto put = [&text](const std::string& from, const std::string& to) {
      const std::size_t at = text.find(from);
      ASSERT_NE(at, std::string::npos) << from;
      text.replace(at, from.size(), to);
    };
    put("port = 502", fmt::format("port = {}", proxy_.port()));
    put("deadline_s = 10.0", "deadline_s = 0.1");
    put("max_files = 400", "max_files = 20");
    text += "[inbox]\ndir = \"inbox\"\n";
    std::ofstream(bench_.file("site.toml")) << text;
  }

  void start() { daemon_ = bench_.start_daemon(false, {"--stall", "1000"}); }

  /// Between two requests: faults begin and end by the plant's clock.
  void step() {
    const CivilTime now = model_.time();
    if (now == seen_) return;
    seen_ = now;
    if (now.seconds >= bus_until_s_) proxy_.use({});
    if (starts_cycle(now)) {
      ++cycles;
      score(now);
      if (cycles % sample_every() == 0) samples.emplace_back(cycles, held_by(daemon_->pid(), bench_.file("")));
    }
    if (hand_back_at_s_ != 0 && now.seconds >= hand_back_at_s_) {
      hand_back_at_s_ = 0;
      std::ofstream(bench_.file("inbox") / "hand-back");
    }
    if (now.seconds >= next_fault_s_) {
      next_fault_s_ += fault_every_cycles * cycle_s;
      disturb(now);
      served_.publish();
    }
  }

  std::uint64_t sample_every() const { return std::max<std::uint64_t>(20, static_cast<std::uint64_t>(days_) * 4); }

  void score(CivilTime now) {
    if (!in_working_hours(trial_.site.settings, now)) return;
    const auto& rooms = begun_.model->sensors().room_temp_degc;
    double mean = 0;
    for (const double s : rooms) mean += s / static_cast<double>(rooms.size());
    const double error = std::abs(mean - trial_.site.settings.target_degc);
    all_sum_k += error;
    ++all_count;
    if (now.seconds < disturbed_until_s_) return;
    outside_sum_k += error;
    ++outside_count;
    outside.push_back(now);
  }

  void disturb(CivilTime now) {
    ++faults;
    double for_h = 0.3 * (1 + draw_.below(3));
    const std::uint32_t kind = draw_.below(100);
    std::string name = "kill";
    const bool may_kill = cycles > static_cast<std::uint64_t>(days_) * cycles_per_day * 9 / 10;
    if (kind < 8 && may_kill) {
      // In the last tenth only: a process that is killed shows no growth.
      daemon_->signal(SIGKILL);
      (void)daemon_->wait(10);
      ++kills;
      start();
    } else if (kind < 60) {
      name = disturb_bus(now, for_h);
    } else if (kind < 90) {
      name = disturb_sensor(for_h);
    } else {
      name = "hand";
      model_.begin(FaultKind::setpoint_by_hand, 0, -1, 19 + 7 * draw_.uniform());
      hand_back_at_s_ = now.seconds + 2 * cycle_s;  // an operator who has done what he wanted
      for_h = 1.2;
    }
    ++by_kind[name];
    disturbed_until_s_ = now.seconds + static_cast<std::int64_t>((for_h + settled_h) * 3600);
  }

  std::string disturb_bus(CivilTime now, double for_h) {
    static constexpr const char* kinds[] = {"late:s=0.15",
                                            "duplicate",
                                            "unit",
                                            "transaction",
                                            "protocol",
                                            "function",
                                            "trickle:gap=0.02",
                                            "endless:gap=0.02",
                                            "truncate",
                                            "length",
                                            "trailing",
                                            "reset",
                                            "fin",
                                            "halfopen",
                                            "drop",
                                            "mute",
                                            "exception:code=1",
                                            "exception:code=2",
                                            "exception:code=4",
                                            "exception:code=6",
                                            "exception:code=11",
                                            "flood:s=0.05",
                                            "noise",
                                            "refuse:s=0.05"};
    const char* kind = kinds[draw_.below(std::size(kinds))];
    const std::string text =
        std::string(kind) + (std::string(kind).find(':') == std::string::npos ? ":" : ",") + "p=0.04";
    proxy_.use({tools::parse_chaos_fault(text, "soak", 1)});
    bus_until_s_ = now.seconds + static_cast<std::int64_t>(for_h * 3600);
    return std::string(kind).substr(0, std::string(kind).find(':'));
  }

  std::string disturb_sensor(double for_h) {
    const int signals = trial_.site.counts.signals(), rooms = trial_.site.counts.vavs;
    const int any = static_cast<int>(draw_.below(static_cast<std::uint32_t>(signals)));
    const int room = static_cast<int>(draw_.below(static_cast<std::uint32_t>(rooms)));
    switch (draw_.below(5)) {
      case 0: model_.begin(FaultKind::not_a_number, for_h, any, 0); return "no number";
      case 1: model_.begin(FaultKind::set_to, for_h, any, 1e6); return "out of range";
      case 2: model_.begin(FaultKind::stuck, for_h, room, 0); return "stuck";
      case 3: model_.begin(FaultKind::offset, for_h, room, 20); return "far from the others";
      default: model_.begin(FaultKind::all_stuck, for_h, -1, 0); return "device repeats";
    }
  }

  /// Every setpoint on its way to the AHU.
  void look(const tools::ChaosExchange& e) {
    const hal::Point& point = trial_.site.points.at("setpoint");
    if (!e.request.writes() || e.forwarded.empty() || e.request.addr != point.addr) return;
    const std::size_t at = e.request.function == 16 ? 13 : 10;
    if (e.forwarded.size() < at + 2) return;
    const std::array<std::uint16_t, 1> word{static_cast<std::uint16_t>(e.forwarded[at] << 8U | e.forwarded[at + 1])};
    const Expected<double> value = hal::decode(point, word);
    const ControllerSettings& s = trial_.site.settings;
    ++writes;
    if (!value || *value < s.limit_min_degc - 1e-9 || *value > s.limit_max_degc + 1e-9) ++unsafe;
  }

  int days_;
  Bench bench_;
  tools::Trial trial_;
  tools::Prepared begun_;
  sim::FaultyModel model_;
  hal::ModbusServer server_;
  tools::ServedPlant served_;
  tools::ChaosProxy proxy_;
  SplitMix64 draw_;
  std::unique_ptr<Child> daemon_;
  CivilTime seen_{-1};
  std::int64_t next_fault_s_, bus_until_s_ = 0, disturbed_until_s_ = 0, hand_back_at_s_ = 0;
};

/// DAE of the same working cycles without any fault, by the loop in this process.
double undisturbed_dae_k(const SoakSite& site) {
  tools::Prepared again = tools::prepare(site.trial());
  const tools::BlobBytes blob = tools::read_blob(site.bench().file("weights.blob").string(), site.trial().site);
  const tools::ControlRun run = tools::run_controller(site.trial().site, *again.model, blob, again.history, again.until,
                                                      site.trial().site.file.seed);
  double sum = 0;
  std::size_t k = 0;
  for (const tools::CycleSample& c : run.cycles) {
    if (k == site.outside.size() || c.time != site.outside[k]) continue;
    sum += std::abs(c.room_mean_degc - site.trial().site.settings.target_degc);
    ++k;
  }
  EXPECT_EQ(k, site.outside.size());
  return k > 0 ? sum / static_cast<double>(k) : 0;
}

TEST(Soak, YearsWithAFaultEveryTenCyclesLeaveMemoryFilesAndControlAsTheyWere) {
  const int asked = closed_loop::from_environment("AIRSIDE_SOAK_CYCLES", 400);
  const int days = std::max(2, (asked + cycles_per_day - 1) / cycles_per_day);
  SoakSite site(days, static_cast<std::uint64_t>(closed_loop::from_environment("AIRSIDE_SOAK_SEED", 1)));
  site.run();
  ASSERT_FALSE(site.samples.empty());
  for (const auto& [cycle, held] : site.samples) {
    std::printf("cycle %llu: %.0f KiB resident, %d descriptors, %d threads, %d files, %.0f KiB of files\n",
                static_cast<unsigned long long>(cycle), held.resident_kib, held.descriptors, held.threads, held.files,
                held.files_kib);
  }
  const double dae = site.outside_sum_k / std::max(1.0, site.outside_count);
  const double calm = undisturbed_dae_k(site);
  std::printf(
      "%llu cycles, %llu faults, %llu kills, %llu setpoint writes, %llu unsafe; DAE outside %.4f K, the same "
      "cycles without faults %.4f K, all cycles %.4f K\n",
      static_cast<unsigned long long>(site.cycles), static_cast<unsigned long long>(site.faults),
      static_cast<unsigned long long>(site.kills), static_cast<unsigned long long>(site.writes),
      static_cast<unsigned long long>(site.unsafe), dae, calm, site.all_sum_k / std::max(1.0, site.all_count));
  for (const auto& [name, count] : site.by_kind) std::printf("  %s %d\n", name.c_str(), count);
  EXPECT_EQ(site.unsafe, 0u);
  EXPECT_LT(dae, calm + 0.03) << "control outside the faults is as without them";
  EXPECT_EQ(site.restarts, 0u) << "it died of something: " << site.bench().file("daemon.txt");
  EXPECT_GE(site.cycles + 2, static_cast<std::uint64_t>(days) * cycles_per_day);
  // The first sample is taken after a start-up; later ones may not hold more.
  const Held& first = site.samples.front().second;
  const std::size_t before_kills = site.samples.size() * 9 / 10;
  for (std::size_t i = 1; i < site.samples.size(); ++i) {
    const Held& held = site.samples[i].second;
    EXPECT_LE(held.descriptors, first.descriptors + 1) << "the bus may be connected or not";
    EXPECT_EQ(held.threads, first.threads);
    EXPECT_LE(held.files, 20 + 12);
    if (i < before_kills && !address_sanitized) {  // whose stacks for use after return fill as time goes by
      EXPECT_LE(held.resident_kib, first.resident_kib + 256) << "at sample " << i;
    }
  }
}

}  // namespace
}  // namespace airside::soak
