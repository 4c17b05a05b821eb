// Every call to files fails, one after the other, once and for long, with four errnos: the daemon never dies, its
// setpoints are those of an undisturbed one, it says what is wrong, and writes again when the fault is over. And every
// allocation of its start fails: it says so and leaves the state as it was.
//   AIRSIDE_FAIL_EVERY=1       every call and all of EIO, ENOSPC, EROFS, EDQUOT, instead of a sample
//   AIRSIDE_FAIL_HEAP_STEP=n   every n-th allocation (29)
#include <gtest/gtest.h>

#include <cerrno>
#include <nlohmann/json.hpp>

#include "power_loss/daemon_desk.hpp"
#include "power_loss/power_cut.hpp"
#include "support/sanitized.hpp"

namespace airside::power_loss {
namespace {

using closed_loop::from_environment;

constexpr int forever = 1'000'000;

/// One process of the life, from a folder that was kept, and what it does undisturbed.
struct Part {
  const char* name;
  int from, to, after;  ///< rows: where it begins and ends, and where a healthy process goes on to
  std::map<std::int64_t, double> setpoints;
  std::vector<std::string> times;
  long calls = 0;
};

struct Counts {
  int runs = 0, same = 0, other = 0, alarms = 0, resumed = 0, waited = 0;
};

class FailedCalls : public ::testing::Test {
 protected:
  FailedCalls() {
    desk.keep("first");
    learn(parts[0]);
    EXPECT_EQ(desk.run(3).code, 0);
    before_push = desk.setpoints();
    desk.push(1);
    desk.keep("push");
    learn(parts[1]);
    desk.roll_back("push", 3, before_push);
    EXPECT_EQ(desk.run(10).code, 0);
    before_rollback = desk.setpoints();
    desk.wish("rollback");
    desk.keep("rollback");
    learn(parts[2]);
    desk.forget_words();
  }

  static std::vector<std::string> times_of(const std::vector<std::string>& rows) {
    std::vector<std::string> times;
    for (const std::string& row : rows) times.push_back(row.substr(0, row.find(',')));
    return times;
  }
  void begin(const Part& part) {
    if (part.from == 0) {
      desk.reset();
    } else {
      desk.roll_back(part.name, part.from, part.from == 3 ? before_push : before_rollback);
    }
  }
  void learn(Part& part) {
    begin(part);
    const DaemonRun run = desk.run(part.to);
    EXPECT_EQ(run.code, 0) << desk.said();
    part.calls = run.calls;
    EXPECT_EQ(desk.run(part.after).code, 0);
    part.setpoints = desk.setpoints();
    part.times = times_of(desk.rows());
    begin(part);
  }

  /// Calls `at` .. `at + count - 1` fail; then a healthy process goes on.
  void fail(const Part& part, long at, int count, int error, Counts& counts) {
    const std::string where = std::string(part.name) + ", call " + std::to_string(at) + ", " + std::to_string(count) +
                              " times errno " + std::to_string(error);
    desk.forget_words();
    begin(part);
    const DaemonRun run =
        desk.run(part.to, {.fail = std::to_string(at) + ":" + std::to_string(count) + ":" + std::to_string(error)});
    ASSERT_EQ(run.code, 0) << where << "\n" << desk.said();
    const std::string said = desk.said();
    ++counts.runs;
    const bool alarm = said.find("storage failed") != std::string::npos ||
                       said.find("disk full") != std::string::npos || said.find("not writable") != std::string::npos ||
                       said.find("cannot be") != std::string::npos;
    counts.alarms += alarm;
    auto setpoints = desk.setpoints();
    const CivilTime end = desk.time_of(part.to);
    auto want = part.setpoints;
    std::erase_if(want, [&](const auto& pair) { return pair.first >= end.seconds; });
    // Only what could not be read at all, twice and for long, may change control; it is said.
    const bool lost = said.find("no saved generation is whole") != std::string::npos ||
                      said.find("each row tries again") != std::string::npos ||
                      said.find("no way back") != std::string::npos || said.find("weights wait") != std::string::npos ||
                      said.find("the next row tries again") != std::string::npos;
    const bool inbox_away = count > 1 && part.from > 0 && setpoints != want;  // a wish that could not be seen yet
    if (setpoints == want) {
      ++counts.same;
    } else {
      ++counts.other;
      ASSERT_TRUE(lost || inbox_away) << where << "\n" << said;
      for (const auto& [seconds, setpoint] : setpoints) ASSERT_TRUE(setpoint >= 5 && setpoint <= 40) << where;
    }
    const auto status = nlohmann::json::parse(desk.status(), nullptr, false);
    const bool well = status.is_object() && status["storage"] == "ok" &&
                      status["time"] == part.times[static_cast<std::size_t>(part.to) - 1];
    ASSERT_EQ(desk.run(part.after).code, 0) << where;
    const auto times = times_of(desk.rows());
    for (std::size_t i = 1; i < times.size(); ++i) ASSERT_LT(times[i - 1], times[i]) << where;
    ASSERT_NE(desk.status().find("\"storage\":\"ok\""), std::string::npos) << where << "\n" << desk.said();
    if (well && !(count == forever && lost)) {
      // All was well in its last row: that is the one that the next process resumes after.
      const std::string last = "resuming after row " + part.times[static_cast<std::size_t>(part.to) - 1];
      ASSERT_NE(desk.said().find(last), std::string::npos) << where << "\n" << desk.said();
      ++counts.resumed;
    }
    // No copy, or none that can be read now: taken or taken back a row later.
    const bool waits =
        said.find("weights wait") != std::string::npos || said.find("the next row tries again") != std::string::npos;
    counts.waited += waits;
    if (count == 1 && !waits) {
      ASSERT_EQ(setpoints, want) << where << "\n" << said;
    }
  }

  DaemonDesk desk{{.name = "fail", .days = 1}};
  std::map<std::int64_t, double> before_push, before_rollback;
  Part parts[3] = {{"first", 0, 8, 12, {}, {}, 0}, {"push", 3, 10, 14, {}, {}, 0}, {"rollback", 10, 16, 20, {}, {}, 0}};
};

TEST_F(FailedCalls, Row32Row33OnceOrForLongChangeNoSetpointAndEndInWrittenState) {
  const bool every = from_environment("AIRSIDE_FAIL_EVERY", 0) != 0;
  const int errors[4] = {EIO, ENOSPC, EROFS, EDQUOT};
  Counts once, some, always;
  int turn = 0;
  for (const Part& part : parts) {
    for (long at = every ? 0 : 5; at < part.calls; at += every ? 1 : 19) {
      for (int error = 0; error < 4; ++error) {
        if (!every && error != turn % 4) continue;
        fail(part, at, 1, errors[error], once);
        if (HasFatalFailure()) return;
        if (every || turn % 2 == 0) fail(part, at, 30, errors[error], some);
        if (HasFatalFailure()) return;
        if (every || turn % 2 == 1) fail(part, at, forever, errors[error], always);
        if (HasFatalFailure()) return;
      }
      ++turn;
    }
  }
  for (const auto& [name, counts] :
       {std::pair("once", once), std::pair("30 times", some), std::pair("always", always)}) {
    std::printf(
        "%s: %d runs, %d with the undisturbed setpoints, %d without, %d said what failed, %d resumed at the end\n",
        name, counts.runs, counts.same, counts.other, counts.alarms, counts.resumed);
    EXPECT_GT(counts.alarms, counts.runs / 4) << name << ": which calls the sample meets differs by build";
  }
  EXPECT_LE(once.other, once.waited);
}

TEST_F(FailedCalls, Row32WithoutAFailureNothingIsSaid) {
  for (const Part& part : parts) {
    desk.forget_words();
    begin(part);
    ASSERT_EQ(desk.run(part.to).code, 0);
    for (const char* word : {"storage", "disk full", "not writable"}) {
      EXPECT_EQ(desk.said().find(word), std::string::npos) << desk.said();
    }
    EXPECT_NE(desk.status().find("\"storage\":\"ok\""), std::string::npos);
  }
}

TEST_F(FailedCalls, Row33AFailedSyncConfirmsNothingThatALaterOneWasNotToldAgain) {
  // Every 7th call fails, syncs among them; what the kernel dropped then is in doubt until it is written again. The
  // power goes anywhere in that.
  const std::string record = desk.file("writes").string();
  desk.reset();
  ASSERT_EQ(desk.run(3, {.record = record}, true).code, 0);
  for (const auto& [every, error, to] :
       {std::tuple(7, EIO, 150), std::tuple(11, ENOSPC, 250), std::tuple(5, EIO, 330)}) {
    const std::string order = std::to_string(every) + ":" + std::to_string(error);
    ASSERT_EQ(desk.run(to, {.record = record, .fail_every = order}, true).code, 0) << desk.said();
  }
  CutOptions options;
  options.states = options.most_states = static_cast<std::uint64_t>(from_environment("AIRSIDE_POWER_CUT_STATES", 3000));
  options.stride = options.states < 100'000 ? 5 : 1;
  if (options.stride > 1) options.most_of_point = 24;
  const CutCounts counts = cut_power(*Trace::read(record), options);
  for (const std::string& finding : counts.findings) ADD_FAILURE() << finding;
  EXPECT_GT(counts.old_generation + counts.new_generation, 1000u);
  std::printf("%llu distinct states among failing calls\n", static_cast<unsigned long long>(counts.distinct));
}

TEST_F(FailedCalls, Row40AnAllocationThatFailsAtTheStartEndsItAndLeavesTheState) {
  if (sanitized) GTEST_SKIP() << "a sanitizer has an allocator of its own, which gives what it is told to refuse";
  const int step = from_environment("AIRSIDE_FAIL_HEAP_STEP", 29);
  const Part& part = parts[1];
  begin(part);
  const long most = desk.run(part.from).allocations;
  ASSERT_GT(most, 100);
  int ended = 0, went_on = 0, before_main = 0, in_parsers = 0;
  for (long at = 0; at < most; at += step) {
    for (const int count : {1, forever}) {
      begin(part);
      desk.forget_words();
      const DaemonRun run = desk.run(part.from, {.fail_heap = std::to_string(at) + ":" + std::to_string(count)});
      const std::string said = desk.said();
      const std::string where = "allocation " + std::to_string(at) + ", " + std::to_string(count) + " times: code " +
                                std::to_string(run.code) + "\n" + said;
      ended += run.code == 1;
      went_on += run.code == 0;
      // The dynamic linker's own, a constructor's before main(), or no memory even to throw with.
      const bool hopeless = run.code == 127 || (run.code == 128 + SIGABRT && (count == forever || at < 60));
      before_main += hopeless;
      // toml++ has promised not to throw where it takes the site's text.
      const bool in_parser = run.code == 128 + SIGABRT && !hopeless;
      in_parsers += in_parser;
      ASSERT_TRUE(run.code == 0 || run.code == 1 || hopeless || in_parser) << where;
      ASSERT_LE(in_parsers, 4) << where;
      ASSERT_TRUE(run.code != 1 || said.find("airsided: ") != std::string::npos) << where;
      ASSERT_EQ(desk.run(part.to).code, 0);
      auto want = part.setpoints;
      std::erase_if(want, [&](const auto& pair) { return pair.first >= desk.time_of(part.to).seconds; });
      ASSERT_EQ(desk.setpoints(), want) << where;
    }
  }
  EXPECT_GT(ended, went_on / 10);
  std::printf(
      "%ld allocations at the start; of the sampled %d ended it with a word, %d did not matter, %d left nothing to "
      "speak with, %d were the parser's\n",
      most, ended, went_on, before_main, in_parsers);
}

TEST_F(FailedCalls, Row40WithoutAFailureTheRowsAllocateNothing) {
  begin(parts[1]);
  const long few = desk.run(parts[1].from + 100).allocations;
  begin(parts[1]);
  const long many = desk.run(parts[1].from + 200).allocations;
  EXPECT_EQ(few, many);
}

TEST(Leaks, Row43ThousandsOfRowsWithFailingCallsLeaveAsManyFilesOpenAndOneThread) {
  DaemonDesk desk({.name = "leaks", .days = 10});
  const DaemonRun run = desk.run(2000, {.fail_every = "13:5"});
  ASSERT_EQ(run.code, 0) << desk.said();
  EXPECT_GT(run.calls, 10'000);
  EXPECT_GT(run.files_early, 10);
  EXPECT_LE(run.files_late, run.files_early + 2) << "one or two are open during a call";
  EXPECT_EQ(run.threads, 1);
  std::printf("%ld calls, every 13th failed: %d files open early, %d late, %d thread\n", run.calls, run.files_early,
              run.files_late, run.threads);
}

TEST(Leaks, Row43WithoutFailingCallsTheSame) {
  DaemonDesk desk({.name = "no_leaks", .days = 10});
  const DaemonRun run = desk.run(2000);
  ASSERT_EQ(run.code, 0) << desk.said();
  EXPECT_GT(run.files_late, 10);
  EXPECT_LE(run.files_late, run.files_early + 2);
  EXPECT_EQ(run.threads, 1);
}

}  // namespace
}  // namespace airside::power_loss
