// The heartbeat between rows: an AHU that waits a minute for it takes over soon after the box is gone, whatever ended
// it, and at once when a person asks for that. The machine's clock runs 60 times as fast here: a row each 6 s, a beat
// each third of a second.

#include <filesystem>

#include "fault_matrix/modbus_daemon_rig.hpp"

namespace airside::fault_matrix {
namespace {

using tools::ChaosExchange;

class HeartbeatDesk : public ::testing::Test {
 protected:
  static constexpr double beat_real_s = 20.0 / 60;

  void open(const std::string& script = "") {
    // Without the plant's clock the daemon keeps its own; the room stands still, which matters to nobody here.
    loop.emplace(ChaosLoop::Options{.name = std::string("beats_") + script.substr(0, 2),
                                    .script = script,
                                    .deadline_s = 0.5,
                                    .from = "clock_s,",
                                    .to = "other_clock_s,"});
    std::string site = loop->text_of("site.toml");
    const std::string plant = "source = \"plant\"";
    site.replace(site.find(plant), plant.size(), "source = \"system\"");
    loop->write("site.toml", site);
    daemon = loop->bench.start_daemon(false, {"--clock-speed", "60", "--until", "2100-01-01T00:00:00"});
    ASSERT_TRUE(within(60, [this] { return loop->bench.logged_rows() >= 1; })) << loop->said();
  }
  static bool within(double seconds, const auto& happened) {
    const double end_s = closed_loop::now_s() + seconds;
    while (!happened()) {
      if (closed_loop::now_s() > end_s) return false;
      closed_loop::sleep_s(0.01);
    }
    return true;
  }
  std::vector<ChaosExchange> beats() const {
    std::vector<ChaosExchange> taken;
    for (const ChaosExchange& e : loop->exchanges()) {
      if (writes_heartbeat(e) && e.taken()) taken.push_back(e);
    }
    return taken;
  }
  static unsigned value_of(const ChaosExchange& beat) { return hal::get16(&beat.asked[10]); }
  void wish(const std::string& name) const {
    std::filesystem::create_directories(loop->bench.file("inbox"));
    loop->write("inbox/" + name, "");
  }

  std::optional<ChaosLoop> loop;
  std::unique_ptr<closed_loop::Child> daemon;
};

TEST_F(HeartbeatDesk, BeatsThreeTimesAMinuteBetweenTwoRows) {
  open();
  const std::size_t begun = beats().size(), rows = loop->bench.logged_rows();
  ASSERT_TRUE(within(60, [&] { return loop->bench.logged_rows() > rows; })) << loop->said();
  const auto seen = beats();
  EXPECT_GE(seen.size() - begun, 9U) << "18 to a row, where the machine has time for them";
  EXPECT_LE(seen.size() - begun, 20U);
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_EQ(value_of(seen[i]), value_of(seen[i - 1]) + 1);
  loop->expect_safe();
}

TEST_F(HeartbeatDesk, StopsWithTheDaemonAndGoesOnWithItsSuccessorBeforeItsFirstRow) {
  open();
  ASSERT_TRUE(within(10, [this] { return beats().size() >= 4; }));
  bool before_a_row = false;
  for (int i = 0; i < 4 && !before_a_row; ++i) {  // a machine that needs a row's time for a start gets another
    const std::size_t seen = loop->bench.logged_rows();
    ASSERT_TRUE(within(60, [&] { return loop->bench.logged_rows() > seen; })) << "so that the next row is far";
    daemon->signal(SIGKILL);
    daemon->wait(10);
    const std::size_t last = beats().size(), rows = loop->bench.logged_rows();
    closed_loop::sleep_s(3 * beat_real_s);
    ASSERT_EQ(beats().size(), last);
    daemon = loop->bench.start_daemon(false, {"--clock-speed", "60", "--until", "2100-01-01T00:00:00"});
    ASSERT_TRUE(within(30, [&] { return beats().size() > last; })) << loop->said();
    before_a_row = loop->bench.logged_rows() == rows;
  }
  EXPECT_TRUE(before_a_row) << loop->said();
  loop->expect_safe();
}

TEST_F(HeartbeatDesk, StopsAtOnceWhenAPersonAsksForRelease) {
  open();
  ASSERT_TRUE(within(10, [this] { return beats().size() >= 4; }));
  const std::size_t rows = loop->bench.logged_rows();
  ASSERT_TRUE(within(60, [&] { return loop->bench.logged_rows() > rows; })) << "so that the next row is far";
  wish("release");
  closed_loop::sleep_s(0.2);  // one that is under way may end
  const std::size_t last = beats().size();
  ASSERT_TRUE(within(60, [&] { return loop->bench.logged_rows() > rows + 2; })) << loop->said();
  EXPECT_EQ(beats().size(), last) << "neither until the row that writes it down nor after";
  EXPECT_EQ(loop->status()["state"], "release");
  wish("hand-back");
  EXPECT_TRUE(within(60, [&] { return beats().size() > last; })) << loop->said();
  EXPECT_TRUE(within(3, [&] { return loop->status()["state"] != "release"; })) << "with the row, not the decision";
}

TEST_F(HeartbeatDesk, SaysBeforeItsFirstRowWhenThatIsDue) {
  bool seen = false;
  for (int i = 0; i < 4 && !seen; ++i) {  // a start just before a row has no time to say so
    open();
    daemon->signal(SIGKILL);
    daemon->wait(10);
    const std::size_t rows = loop->bench.logged_rows();
    daemon = loop->bench.start_daemon(false, {"--clock-speed", "60", "--until", "2100-01-01T00:00:00"});
    (void)within(30, [&] {
      seen = loop->status().value("first_row", "") != "";
      return seen || loop->bench.logged_rows() > rows;
    });
  }
  EXPECT_TRUE(seen) << loop->said();
  EXPECT_TRUE(within(60, [&] { return loop->status()["first_row"] == ""; })) << loop->status();
}

TEST_F(HeartbeatDesk, GoesOnAfterALostConnectionOnceEverythingWasReadAgain) {
  open("on=write at=1 n=40.. p=0.3 reset:bytes=0");
  ASSERT_TRUE(within(60, [this] { return loop->proxy->counters().connections >= 4; })) << loop->said();
  std::uint64_t read_on = 0, verified_on = 0;
  for (const ChaosExchange& e : loop->exchanges()) {
    if (reads_inputs(e) && e.taken()) read_on = e.connection;
    if (e.request.function == 4 && e.request.addr == fingerprint_addr && e.taken()) verified_on = e.connection;
    ASSERT_TRUE(!e.request.writes() || (e.connection == read_on && e.connection == verified_on))
        << "connection " << e.connection;
  }
  const std::size_t many = beats().size();
  EXPECT_TRUE(within(30, [&] { return beats().size() > many + 2; })) << loop->said();
  loop->expect_safe();
}

}  // namespace
}  // namespace airside::fault_matrix
