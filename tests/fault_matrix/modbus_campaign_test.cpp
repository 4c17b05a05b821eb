// Hostile exchanges by the thousand: how long the longest takes, how long recovery takes, and that no answer is
// believed that is not the server's. CI runs a slice; the figures of docs/verification.md come from longer runs:
//   AIRSIDE_CHAOS_EXCHANGES=n   exchanges of the link (300)
//   AIRSIDE_CHAOS_RECOVERIES=n  faults of up to a minute whose recovery is timed (0: a short one)
//   AIRSIDE_CHAOS_SEED=n        of all draws (1)

#include <cstdio>
#include <cstdlib>
#include <deque>

#include "airside/splitmix64.hpp"
#include "fault_matrix/modbus_rig.hpp"

namespace airside::fault_matrix {
namespace {

int from_environment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<int>(std::strtol(text, nullptr, 10));
}

hal::PointMap many_registers(int registers) {
  std::string csv = hal::testing_peers::csv_header();
  for (int i = 0; i < registers; ++i) {
    csv += "r" + std::to_string(i) + ",,3," + std::to_string(i) + ",uint16,,,1,0,0,65535,,,,on-change,16,,self\n";
  }
  return hal::PointMap::parse(csv, "many");
}

struct Figures {
  std::uint64_t exchanges = 0, answered = 0, failed = 0, false_answers = 0, writes_believed = 0, writes_not_taken = 0;
  double longest_s = 0, longest_away_s = 0;
};

/// Reads and writes at random through the proxy. Each read must show what the server really answered; each write that
/// is confirmed must have been taken.
Figures hammer(int exchanges, double deadline_s, double p, std::uint64_t seed) {
  constexpr int registers = 300;
  hal::testing_peers::ServerThread served(many_registers(registers), {hal::TcpListen{}, 1});
  std::uint16_t tick = 0;
  served.server().refresh([&] {  // no two answers are alike: a stale one shows
    ++tick;
    for (int i = 0; i < registers; i += 50) served.server().set("r" + std::to_string(i), (tick * 7 + i) % 65521);
  });
  served.start();
  tools::ChaosSettings settings;
  settings.to_port = served.server().port();
  settings.rules = rules_of(every_fault(p));
  settings.seed = seed;
  // A thread of the proxy may read a request only after the client has given it up, so what the server said is looked
  // up by request, among the newest.
  std::mutex mutex;
  std::deque<tools::ChaosExchange> newest;
  tools::ChaosProxy proxy(settings, [&](const tools::ChaosExchange& e) {
    const std::scoped_lock lock(mutex);
    if (e.answered.empty()) return;
    newest.push_front(e);
    if (newest.size() > 100) newest.pop_back();
  });
  const auto server_said = [&](int function, int addr, std::span<const std::uint16_t> values) {
    const std::scoped_lock lock(mutex);
    return std::ranges::any_of(newest, [&](const tools::ChaosExchange& e) {
      const auto& shown = function == 16 ? e.forwarded : e.answered;
      bool same = e.request.function == function && e.request.addr == addr && e.taken() &&
                  e.request.count == static_cast<int>(values.size());
      const std::size_t from = function == 16 ? 13 : 9;
      for (std::size_t i = 0; same && i < values.size(); ++i) same = hal::get16(&shown[from + 2 * i]) == values[i];
      return same;
    });
  };
  hal::LinkSettings link_settings = hal::testing_peers::tcp_settings(proxy.port(), deadline_s);
  link_settings.backoff_first_s = 0.001;
  link_settings.backoff_max_s = 0.01;
  hal::ModbusLink link(link_settings);
  SplitMix64 random(seed);
  Figures f;
  std::int64_t well_ns = hal::monotonic_ns();
  while (f.exchanges < static_cast<std::uint64_t>(exchanges)) {
    std::array<std::uint16_t, 120> words{};
    const int count = 51 + static_cast<int>(random.below(static_cast<std::uint32_t>(words.size()) - 51));
    const int addr = static_cast<int>(random.below(static_cast<std::uint32_t>(registers - count)));
    const bool writes = random.uniform() < 0.2;
    for (std::uint16_t& w : words) w = static_cast<std::uint16_t>(random.below(65536));
    const std::span<std::uint16_t> used(words.data(), static_cast<std::size_t>(count));
    const std::int64_t start_ns = hal::monotonic_ns();
    const hal::LinkResult<void> got = writes ? link.write(16, addr, used) : link.read(3, addr, used);
    const std::int64_t end_ns = hal::monotonic_ns();
    if (!got && got.error().error == hal::LinkError::backing_off) {
      hal::sleep_until_ns(end_ns + hal::to_ns(link.backoff_left_s()), {});
      continue;
    }
    ++f.exchanges;
    f.longest_s = std::max(f.longest_s, static_cast<double>(end_ns - start_ns) * 1e-9);
    if (!got) {
      ++f.failed;
      continue;
    }
    f.longest_away_s = std::max(f.longest_away_s, static_cast<double>(end_ns - well_ns) * 1e-9);
    well_ns = end_ns;
    ++f.answered;
    const bool right = server_said(writes ? 16 : 3, addr, used);
    if (writes) {
      ++f.writes_believed;
      f.writes_not_taken += !right;
    } else {
      f.false_answers += !right;
    }
  }
  return f;
}

TEST(ModbusCampaign, EveryHostileExchangeEndsAtItsDeadlineAndNoneIsBelieved) {
  const int exchanges = from_environment("AIRSIDE_CHAOS_EXCHANGES", 300);
  constexpr double deadline_s = 0.1;
  const Figures f =
      hammer(exchanges, deadline_s, 0.02, static_cast<std::uint64_t>(from_environment("AIRSIDE_CHAOS_SEED", 1)));
  std::printf(
      "%llu exchanges, %llu answered, %llu failed; longest %.3f s of a deadline of %.3f s; longest without an answer "
      "%.3f s; %llu false answers believed, %llu of %llu confirmed writes not taken\n",
      static_cast<unsigned long long>(f.exchanges), static_cast<unsigned long long>(f.answered),
      static_cast<unsigned long long>(f.failed), f.longest_s, deadline_s, f.longest_away_s,
      static_cast<unsigned long long>(f.false_answers), static_cast<unsigned long long>(f.writes_not_taken),
      static_cast<unsigned long long>(f.writes_believed));
  EXPECT_EQ(f.false_answers, 0U);
  EXPECT_EQ(f.writes_not_taken, 0U);
  EXPECT_LT(f.longest_s, deadline_s + 1.0) << "a busy machine may add to a deadline";
  EXPECT_GT(f.failed, f.exchanges / 10);
  EXPECT_GT(f.answered, f.exchanges / 10);
}

/// s from the end of `fault`, which lasts for `lasting_s`, to the next answer, of a link that is asked all the time.
double recovery_s(const std::string& fault, double lasting_s, const hal::LinkSettings& as) {
  ChaosDesk desk(fault);
  hal::LinkSettings settings = as;
  settings.address = hal::TcpAddress{"127.0.0.1", desk.proxy.port()};
  hal::ModbusLink link(settings);
  std::array<std::uint16_t, 3> words{};
  const std::int64_t begin_ns = hal::monotonic_ns();
  bool ended = false;
  std::int64_t end_ns = 0;
  while (true) {
    if (!ended && hal::monotonic_ns() >= begin_ns + hal::to_ns(lasting_s)) {
      desk.proxy.use({});
      ended = true;
      end_ns = hal::monotonic_ns();
    }
    if (link.read(4, 0, words) && ended) return static_cast<double>(hal::monotonic_ns() - end_ns) * 1e-9;
    hal::sleep_until_ns(hal::monotonic_ns() + 2'000'000, {});
  }
}

TEST(ModbusCampaign, LinkRecoversAtMostABackOffAndAnExchangeAfterTheFault) {
  const int recoveries = from_environment("AIRSIDE_CHAOS_RECOVERIES", 0);
  hal::LinkSettings settings;  // as the daemon has them
  double lasting_s = 90;
  if (recoveries == 0) {
    settings.exchange_deadline_s = 0.1;
    settings.backoff_first_s = 0.02;
    settings.backoff_max_s = 0.2;
    lasting_s = 0.8;
  }
  const double bound_s = settings.backoff_max_s + settings.exchange_deadline_s;
  EXPECT_LE(hal::LinkSettings{}.backoff_max_s + 10.0, 30.0) << "the longest wait and the longest exchange";
  SplitMix64 random(static_cast<std::uint64_t>(from_environment("AIRSIDE_CHAOS_SEED", 1)));
  const std::vector<std::string> faults = {"halfopen", "reset", "mute", "trickle:gap=0.05", "exception:code=4", "unit"};
  double longest_s = 0;
  for (int i = 0; i < std::max(recoveries, 3); ++i) {
    const std::string& fault = faults[static_cast<std::size_t>(i) % faults.size()];
    const double s = recovery_s(fault, lasting_s * (0.3 + 0.7 * random.uniform()), settings);
    std::printf("%s: recovered after %.2f s\n", fault.c_str(), s);
    longest_s = std::max(longest_s, s);
  }
  std::printf("longest recovery %.2f s\n", longest_s);
  EXPECT_LT(longest_s, bound_s + 1.0);
}

}  // namespace
}  // namespace airside::fault_matrix
