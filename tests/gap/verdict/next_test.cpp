// airside gap next: an ambiguous verdict, the proposed test done on the simulated room, and the verdict drawn anew.

#include <gtest/gtest.h>

#include <algorithm>

#include "gap/gap_desk.hpp"
#include "hal/text/civil_text.hpp"
#include "sim/rc/rc_plant.hpp"
#include "tools/gap/explain/test_plan.hpp"
#include "tools/gap/model/log_window.hpp"
#include "tools/gap/model/stretches.hpp"

namespace airside::tools::gap {
namespace {

constexpr const char* next_words =
    "--site site.toml --measured measured.csv --reference reference.csv --effects effects";

/// A leaky room, seen for a week: a leak and a thin wall look nearly alike.
class LeakyDesk : public Desk {
 public:
  static constexpr int days = 8;
  static constexpr std::uint64_t seed = 3;

  LeakyDesk() : effects_(sim::load_effects(sim::find_effects())) {
    sim::write_epw(path("w.epw").string(), *weather_, 2023);
    write("site.toml",
          "[site]\nname = \"Leaky\"\ntopology = \"5vav-5fcu-2power\"\n[twin]\nmodel = \"rc\"\n"
          "weather = \"w.epw\"\n");
    fs::create_directory(path("effects"));
    for (const char* name : {"gain_base", "gain_occupied", "occupancy_shift", "infiltration", "envelope_u",
                             "thermal_mass", "vav_flow", "supply_sensor_offset"}) {
      fs::copy_file(sim::find_effects() / (std::string(name) + ".json"),
                    path("effects") / (std::string(name) + ".json"));
    }
    MeasuredRun run{sim::civil_midnight(2023, 7, 3), days, seed, false, 0};
    log("reference.csv", measure(whole_, weather_, run));
    run.start.seconds += days * seconds_per_day;
    ++run.seed;
    const std::vector<hal::LogRow> rows = measure(leaky_, weather_, run);
    log("measured.csv", rows);
    recording_ = window_of(rows, channels, weather_, "measured").recording;
    run.start.seconds += days * seconds_per_day;
    run.days = 4;
    ++run.seed;
    log("following.csv", measure(leaky_, weather_, run));
    run.start.seconds += 8 * seconds_per_day;
    ++run.seed;
    log("after_pause.csv", measure(leaky_, weather_, run));
  }

  /// The log of the test on the leaky room, `later` days after those on which it was proposed.
  void do_test(const std::string& name, const std::string& file, int later = 7) const {
    const auto plans = test_plans(channels, {});
    const auto plan = std::find_if(plans.begin(), plans.end(), [&](const TestPlan& p) { return p.name == name; });
    ASSERT_NE(plan, plans.end()) << name;
    const auto commands = test_recording(recording_, *plan);
    ASSERT_TRUE(commands);
    sim::Recording done = commands->recording;
    done.from.seconds += later * seconds_per_day;
    sim::RcPlant plant(leaky_, weather_, {done.from.seconds - 3 * seconds_per_day}, 91);
    plant.follow(std::make_shared<const sim::Recording>(done), !plan->fcu_command);
    const MeasuredRun how{done.from, 5, 91, false, 0};
    std::vector<hal::LogRow> rows;
    while (plant.time() < done.to()) {
      const CivilTime t = plant.time();
      const double setpoint = done.at(t).setpoint_degc;
      plant.set_setpoint(setpoint);
      if (!(t < done.from)) rows.push_back(measured_row(plant.sensors(), t, setpoint, how));
      plant.advance_to({t.seconds + row_s});
    }
    log(file, rows);
  }

  void log(const std::string& name, const std::vector<hal::LogRow>& rows) const {
    hal::LogWriter writer(path(name).string(), {"", 5, 5, 2}, false);
    for (const hal::LogRow& row : rows) writer.append(row);
    writer.close();
  }

  /// The same days under another sky, and of a smaller room.
  void other_sites(const std::string& elsewhere, const std::string& small) const {
    const MeasuredRun run{sim::civil_midnight(2023, 7, 19), 4, seed, false, 0};
    log(elsewhere, measure(leaky_, sim::synthetic_weather(seed + 20), run));
    hal::LogWriter writer(path(small).string(), {"", 3, 0, 1}, false);
    for (const hal::LogRow& row : measure(small_room(), weather_, run)) writer.append(row);
    writer.close();
  }
  void append(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary | std::ios::app) << text;
  }
  const sim::Recording& recording() const { return recording_; }

  static constexpr sim::Channels channels{5, 5, 2};

 private:
  std::vector<sim::Effect> effects_;
  std::shared_ptr<const sim::Weather> weather_ = sim::synthetic_weather(seed);
  sim::RcRoom whole_ = measured_room(sim::make_room(), seed, false);
  sim::RcRoom leaky_ = hide(whole_, {{"infiltration", 0, 0.5}}, effects_);
  sim::Recording recording_;
};

/// The passive verdict, which every test begins with.
json first_verdict(const LeakyDesk& desk) {
  const Outcome o = desk.run(std::string(next_words) + " --out first --json");
  EXPECT_EQ(o.code, 0) << o.err;
  return json::parse(o.out, nullptr, false);
}

TEST(GapNext, NamesWithTheProposedTestWhatThePassiveDaysCouldNotTellApart) {
  const LeakyDesk desk;
  const json before = first_verdict(desk);
  ASSERT_EQ(before["verdict"], "ambiguous") << before["sentence"];
  const std::string test = before["experiments"][0]["name"];
  desk.do_test(test, "test.csv");
  const Outcome o = desk.run("next first --measured test.csv --test " + test + " --out second --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json after = json::parse(o.out);
  EXPECT_EQ(after["verdict"], "named") << after["sentence"];
  ASSERT_EQ(after["effects"].size(), 1U);
  EXPECT_EQ(after["effects"][0]["id"], "infiltration");
  EXPECT_EQ(after["measured"]["days"], LeakyDesk::days + 5);
  EXPECT_EQ(after["measured"]["from"], before["measured"]["from"]);
  EXPECT_EQ(after["measured"]["to"], "2023-07-26T00:00:00");
  EXPECT_EQ(after["locked_days"]["days"], before["locked_days"]["days"]) << "the same days stay locked away";
  EXPECT_EQ(after["locked_days"]["from"], before["locked_days"]["from"]);

  const json& continued = after["continued"];
  EXPECT_EQ(continued["added"][0]["test"], test);
  EXPECT_EQ(continued["added"][0]["days"], 5);
  EXPECT_EQ(continued["earlier"]["verdict"], "ambiguous");
  ASSERT_GE(continued["candidates"].size(), 2U);
  const json& leak = continued["candidates"][0];
  EXPECT_EQ(leak["id"], "infiltration");
  EXPECT_EQ(leak["gain_before"], before["effects"][0]["gain"]);
  EXPECT_EQ(leak["gain_after"], after["effects"][0]["gain"]);
  EXPECT_GT(leak["gain_after"].get<double>(), leak["gain_before"].get<double>() + 20);

  const std::string page = text_of_file(desk.path("second/index.html"));
  for (const char* promised : {"What the further days have changed", "ambiguous -&gt; named"}) {
    EXPECT_NE(page.find(promised), std::string::npos) << promised;
  }
  EXPECT_EQ(desk.read("first/gap.json"), before) << "the earlier report is left as it was";
}

/// The words behind `airside gap next` in a text, up to the end of its line.
std::string next_command_in(const std::string& text) {
  const std::string begin = "airside gap next ";
  const std::size_t at = text.find(begin);
  return at == std::string::npos ? "" : text.substr(at + begin.size(), text.find('\n', at) - at - begin.size());
}

TEST(GapNext, PrintsCommandsThatCanBeCopiedWhereFoldersHaveABlank) {
  const LeakyDesk desk;
  const TemporaryFolder scratch;
  const auto shell = [&](const std::string& line) {
    return run_program("/bin/sh", {"-c", "exec '" AIRSIDE_BIN_DIR "/airside' gap " + line}, desk.path(""),
                       scratch.path(), 120);
  };
  const Outcome first = shell(std::string(next_words) + " --out 'my gap'");
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_EQ(desk.read("my gap/gap.json")["command"], "airside gap run " + std::string(next_words) + " --out 'my gap'");
  std::string words = next_command_in(first.out);
  ASSERT_TRUE(words.starts_with("'my gap' --measured LOG --test ")) << first.out;
  desk.do_test(words.substr(words.rfind(' ') + 1), "test log.csv");
  words.replace(words.find("LOG"), 3, "'test log.csv'");
  const Outcome second = shell("next " + words + " --out 'my next' --json");
  ASSERT_EQ(second.code, 0) << words << "\n" << second.err;
  EXPECT_EQ(json::parse(second.out)["command"], "airside gap next " + words + " --out 'my next'");
}

TEST(GapNext, GoesOnWithPassiveDaysThatFollowAndWithDaysAfterAPause) {
  const LeakyDesk desk;
  const json before = first_verdict(desk);
  const Outcome follows = desk.run("next first --measured following.csv --out second --json");
  ASSERT_EQ(follows.code, 0) << follows.err;
  const json second = json::parse(follows.out);
  EXPECT_EQ(second["measured"]["days"], LeakyDesk::days + 4);
  EXPECT_TRUE(second["after_curve"]["later"].empty()) << "no seam";
  EXPECT_GT(second["effects"][0]["gain"].get<double>(), before["effects"][0]["gain"].get<double>());
  const Outcome pause = desk.run("next second --measured after_pause.csv --out third --json");
  ASSERT_EQ(pause.code, 0) << pause.err;
  const json third = json::parse(pause.out);
  EXPECT_EQ(third["measured"]["days"], LeakyDesk::days + 8);
  EXPECT_EQ(third["measured"]["to"], "2023-07-31T00:00:00");
  EXPECT_EQ(third["after_curve"]["later"], (json{{{"step", 12 * bins_per_day}, {"from", "2023-07-27T00:00:00"}}}));
  EXPECT_EQ(third["continued"]["added"].size(), 2U);
  EXPECT_EQ(third["effects"][0]["id"], "infiltration") << third["sentence"];
}

TEST(GapNext, ContinuesACaseThatHasNoReport) {
  const LeakyDesk desk;
  fs::create_directories(desk.path("case"));
  desk.write("case/case.json", R"({"format": 1, "engine": "rc", "model": "rc", "weather": "../w.epw",
    "reference": "../reference.csv", "measured": "../measured.csv"})");
  const Outcome o = desk.run("next case --measured following.csv --effects effects --out second --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json after = json::parse(o.out);
  EXPECT_EQ(after["continued"]["earlier"]["verdict"], "ambiguous") << after["continued"].dump(1);
  EXPECT_EQ(after["measured"]["days"], LeakyDesk::days + 4);
}

struct BadNext {
  const char *words, *place, *part;  ///< part of the complaint
};

TEST(GapNext, RefusesMixedUpSitesKnownDaysChangedInputsAndTestsThatWereNotDone) {
  const LeakyDesk desk;
  ASSERT_EQ(first_verdict(desk)["verdict"], "ambiguous");
  desk.other_sites("elsewhere.csv", "small.csv");
  fs::create_directories(desk.path("old"));
  desk.write("old/gap.json", R"({"format": 1, "verdict": "ambiguous"})");
  fs::create_directories(desk.path("empty"));
  const auto before = desk.names();
  for (const BadNext& b : std::vector<BadNext>{
           {"next first --measured elsewhere.csv", "elsewhere.csv", "another site's log"},
           {"next first --measured small.csv", "small.csv", "columns of a 3vav-0fcu-1power room"},
           {"next first --measured measured.csv", "measured.csv", "days that were not judged yet"},
           {"next first --measured reference.csv", "reference.csv", "days that were not judged yet"},
           {"next first --measured following.csv --test day_cold", "following.csv", "no day on which"},
           {"next first --measured following.csv --test day_colt", "--test day_colt", "did you mean day_cold?"},
           {"next first --measured no.csv", "no.csv", "no file"},
           {"next old --measured following.csv", "old/gap.json", "an earlier version wrote it"},
           {"next empty --measured following.csv", "empty", "no gap.json"},
           {"next first --measured following.csv --effects effects", "--effects effects", "for a case alone"},
           {"next first --measured following.csv --out first", "--out first", "the folder of the earlier report"},
       }) {
    const bool out = std::string(b.words).find("--out") != std::string::npos;
    const Outcome o = desk.run(std::string(b.words) + (out ? "" : " --out second") + " --json");
    EXPECT_EQ(o.code, 1) << b.words << "\n" << o.err;
    EXPECT_EQ(o.out, "") << b.words;
    EXPECT_NE(o.err.find(b.place), std::string::npos) << b.words << "\n" << o.err;
    EXPECT_NE(o.err.find(b.part), std::string::npos) << b.words << "\n" << o.err;
    EXPECT_EQ(desk.names(), before) << b.words;
  }
  desk.append("measured.csv", "\n");
  const Outcome changed = desk.run("next first --measured following.csv --out second");
  EXPECT_EQ(changed.code, 1);
  EXPECT_NE(complaint_in(changed.err).found.find("a content of digest64:"), std::string::npos) << changed.err;
  EXPECT_NE(complaint_in(changed.err).expected.find("the measured log that"), std::string::npos) << changed.err;
  fs::remove(desk.path("w.epw"));
  fs::remove(desk.path("second"));
  const Outcome gone = desk.run("next first --measured following.csv --out second");
  EXPECT_NE(complaint_in(gone.err).place.find("w.epw"), std::string::npos) << gone.err;
  EXPECT_EQ(complaint_in(gone.err).found, "nothing") << gone.err;
  EXPECT_FALSE(fs::exists(desk.path("second")));
}

TEST(Stretches, AreLivedThroughOneByOneAndSensorsDriftOnThroughAll) {
  const LeakyDesk desk;
  const sim::Recording& whole = desk.recording();
  const RcEngine rc(sim::make_room());
  const StretchedEngine engine(rc);
  const auto window = [&](std::size_t first_day, std::size_t days) {
    Window w{part_of(whole, first_day * rows_per_day, days * rows_per_day), {}};
    w.measured = binned(rc.simulate({}, w.recording), rc.channels());
    return w;
  };
  const Window late = window(5, 3), early = window(0, 2);
  const Window both = stacked_windows({late, early});
  ASSERT_EQ(both.recording.later.size(), 1U);
  EXPECT_EQ(both.recording.time(3 * rows_per_day).seconds, whole.from.seconds);
  EXPECT_EQ(both.recording.time(2 * rows_per_day).seconds, whole.time(7 * rows_per_day).seconds);
  EXPECT_TRUE(both.measured.middleRows(3 * bins_per_day, bins_per_day).array().isNaN().all());
  EXPECT_TRUE(both.measured.topRows(3 * bins_per_day) == late.measured);
  EXPECT_TRUE(both.measured.bottomRows(bins_per_day) == early.measured.bottomRows(bins_per_day));
  sim::ChannelTable expected(5 * rows_per_day, rc.channels().count());
  expected << rc.simulate({}, late.recording), rc.simulate({}, early.recording);
  EXPECT_TRUE(engine.simulate({}, both.recording) == expected);
  EXPECT_EQ(span_of(both.recording).from.seconds, whole.from.seconds);
  EXPECT_EQ(span_of(both.recording).to.seconds, whole.to().seconds);
  EXPECT_TRUE(part_of(both.recording, 2 * rows_per_day, 2 * rows_per_day).later.front().row == rows_per_day);

  const auto effects = sim::load_effects(sim::find_effects());
  const auto drift =
      std::find_if(effects.begin(), effects.end(), [](const auto& e) { return e.name == "room_sensor_drift"; });
  const sim::EffectChange change{{&*drift, 0}, 0.1};
  const sim::ChannelTable drifted = engine.simulate({change}, both.recording);
  EXPECT_NEAR(drifted(5 * rows_per_day - 1, 0) - expected(5 * rows_per_day - 1, 0), 0.5, 0.02);
}

TEST(TestPlan, WasDoneWhereItsCommandsStandInTheLog) {
  const LeakyDesk desk;
  for (const TestPlan& plan : test_plans(LeakyDesk::channels, {})) {
    const auto test = test_recording(desk.recording(), plan);
    ASSERT_TRUE(test) << plan.name;
    EXPECT_TRUE(was_done(test->recording, plan)) << plan.name;
    EXPECT_FALSE(plan.setpoint_degc && was_done(desk.recording(), plan)) << plan.name;
  }
}

}  // namespace
}  // namespace airside::tools::gap
