// A release that says for how long: it ends by itself, and a restart does not begin it anew.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "hal/weights/mailbox.hpp"
#include "support/test_folder.hpp"
#include "weights/trial_rig.hpp"

namespace airside::weights {
namespace {

namespace fs = std::filesystem;

class TimedRelease : public ::testing::Test {
 protected:
  void put(const std::string& name, const std::string& text) { std::ofstream(folder.file(name)) << text; }
  bool is_empty() const { return fs::is_empty(folder.c_str()); }

  hal::TestFolder folder{"release_time"};
  hal::Mailbox box{std::string(folder.c_str())};
  std::array<std::byte, 1000> blob{};
};

TEST_F(TimedRelease, AReleaseMayHaveATimeWhichARestartDoesNotBeginAnew) {
  put("release", "4\n");
  hal::Mail mail = box.collect(blob);
  EXPECT_TRUE(mail.release);
  EXPECT_GT(mail.release_s, 4 * 3600 - 60);
  EXPECT_LE(mail.release_s, 4 * 3600);
  box.finish(true);
  fs::last_write_time(folder.file("release"), fs::file_time_type::clock::now() - std::chrono::hours(3));
  box.tell_anew();
  mail = box.collect(blob);
  EXPECT_TRUE(mail.release);
  EXPECT_NEAR(static_cast<double>(mail.release_s), 3600, 60);
  fs::last_write_time(folder.file("release"), fs::file_time_type::clock::now() - std::chrono::hours(5));
  box.tell_anew();
  EXPECT_EQ(box.collect(blob).release_s, -1) << "over while nobody looked";
  const std::array<timespec, 2> of_1970{{{1000, 0}, {1000, 0}}};
  ASSERT_EQ(::utimensat(AT_FDCWD, folder.file("release").c_str(), of_1970.data(), 0), 0);
  box.tell_anew();
  EXPECT_EQ(box.collect(blob).release_s, 4 * 3600) << "written before the clock was set";
  fs::last_write_time(folder.file("release"), fs::file_time_type::clock::now() + std::chrono::hours(50));
  box.tell_anew();
  EXPECT_EQ(box.collect(blob).release_s, 4 * 3600) << "never more than was asked for, whatever the clock says";
}

TEST_F(TimedRelease, AReleaseWhoseTimeIsOverGoesAndAnotherOneStays) {
  put("release", "1");
  (void)box.collect(blob);
  box.end_release();
  box.finish(true);
  EXPECT_TRUE(is_empty());
  put("release", "1");
  (void)box.collect(blob);
  box.end_release();
  fs::remove(folder.file("release"));
  put("release", "24");
  box.finish(true);
  EXPECT_FALSE(is_empty()) << "it came in the place of the one that is over";
  EXPECT_GT(box.collect(blob).release_s, 3600);
}

TEST_F(TimedRelease, AReleaseThatIsOverAndGoneIsNoHarm) {
  put("release", "1");
  (void)box.collect(blob);
  box.end_release();
  fs::remove(folder.file("release"));
  box.finish(true);
  EXPECT_TRUE(is_empty());
  put("release", "2");
  EXPECT_TRUE(box.collect(blob).release) << "the next one is a release like any other";
  box.finish(true);
  EXPECT_FALSE(is_empty()) << "and stays until a hand-back or its end";
}

TEST_F(TimedRelease, AReleaseThatSaysAnythingElseHasNoEndOfItsOwn) {
  for (const char* text : {"", "\n", "0", "169", "-1", "4 h", "soon", "4.5", "99999999", " 4"}) {
    put("release", text);
    box.tell_anew();
    const hal::Mail mail = box.collect(blob);
    EXPECT_TRUE(mail.release) << text;
    EXPECT_EQ(mail.release_s, 0) << text;
  }
  EXPECT_EQ(hal::Mailbox::hours_of("168"), 168);
  EXPECT_EQ(hal::Mailbox::hours_of("4\r\n"), 4) << "as an editor of another system ends a line";
  EXPECT_EQ(hal::Mailbox::hours_of(""), 0);
  EXPECT_FALSE(hal::Mailbox::hours_of("0"));
}

class ReleasedTrial : public Trial {
 protected:
  void release(const std::string& hours) { std::ofstream(folder.file("inbox") / "release") << hours; }
  bool asked() const { return fs::exists(folder.file("inbox") / "release"); }
  CivilTime last_row() const { return {rig.now.seconds - row_s}; }
  /// What keeps the AHU released from this row on; the mode follows with the next decision.
  Reason reason() const { return rig.controller->cycle().mode_arbiter.gravest(last_row()); }
};

TEST_F(ReleasedTrial, EndsWithTheFirstRowAfterItsTimeAndTakesItsFileAway) {
  release("1");
  row();
  ASSERT_EQ(reason(), Reason::released_by_hand);
  EXPECT_NEAR(static_cast<double>(trial->release_ends().seconds - last_row().seconds), 3600, 30);
  rows(9);
  EXPECT_EQ(reason(), Reason::released_by_hand);
  EXPECT_TRUE(asked()) << "it stays as long as it holds";
  rows(1);
  EXPECT_NE(reason(), Reason::released_by_hand);
  EXPECT_FALSE(asked());
  EXPECT_EQ(trial->release_ends().seconds, 0);
}

TEST_F(ReleasedTrial, LastsAsLongWhereTheClockIsSetMeanwhile) {
  release("1");
  rows(3);
  for (const std::int64_t set_s : {std::int64_t{20'000} * seconds_per_day, std::int64_t{-6} * seconds_per_hour}) {
    rig.now.seconds += set_s;
    row();
    EXPECT_EQ(reason(), Reason::released_by_hand) << set_s;
    EXPECT_NEAR(static_cast<double>(trial->release_ends().seconds - last_row().seconds), 3600 - 3 * row_s, row_s + 30);
  }
  rows(9);
  EXPECT_NE(reason(), Reason::released_by_hand);
  EXPECT_FALSE(asked());
}

TEST_F(ReleasedTrial, IsNotBegunAnewByARestart) {
  release("1");
  rows(8);
  fs::last_write_time(folder.file("inbox") / "release", fs::file_time_type::clock::now() - std::chrono::minutes(49));
  open();
  row();
  EXPECT_EQ(reason(), Reason::released_by_hand);
  EXPECT_NEAR(static_cast<double>(trial->release_ends().seconds - last_row().seconds), 660, 30);
  rows(2);
  EXPECT_NE(reason(), Reason::released_by_hand);
  EXPECT_FALSE(asked());
}

TEST_F(ReleasedTrial, IsOverAtOnceWhereItsTimePassedWhileNobodyLooked) {
  release("1");
  row();
  fs::last_write_time(folder.file("inbox") / "release", fs::file_time_type::clock::now() - std::chrono::hours(2));
  open();
  row();
  EXPECT_NE(reason(), Reason::released_by_hand);
  EXPECT_FALSE(asked());
}

TEST_F(ReleasedTrial, EndsNothingElse) {
  release("1");
  row();
  rig.controller->hold(Reason::two_masters, last_row(), 0);
  rows(10);
  EXPECT_EQ(reason(), Reason::two_masters) << "that waits for a person";
  EXPECT_FALSE(asked());
}

TEST_F(ReleasedTrial, ALaterReleaseWithoutATimeHasNoEnd) {
  release("1");
  row();
  fs::remove(folder.file("inbox") / "release");
  release("");
  row();
  EXPECT_EQ(trial->release_ends().seconds, 0);
  rows(30);
  EXPECT_EQ(reason(), Reason::released_by_hand);
  wish("hand-back");
  row();
  EXPECT_NE(reason(), Reason::released_by_hand);
  EXPECT_FALSE(asked());
}

}  // namespace
}  // namespace airside::weights
