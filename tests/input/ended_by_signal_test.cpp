// A host program that a signal ends leaves no process running and nothing unfinished behind.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <cctype>
#include <fstream>
#include <functional>

#include "hal/text/staged_file.hpp"
#include "hal/text/staged_folder.hpp"
#include "hal/text/unfinished.hpp"
#include "sim/energyplus/install.hpp"
#include "support/child.hpp"
#include "support/program.hpp"

namespace airside {
namespace {

using closed_loop::Child;
using closed_loop::now_s;
using closed_loop::sleep_s;

constexpr double patience_s = 300;

/// Processes whose parent is `pid`.
std::vector<pid_t> children_of(pid_t pid) {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (!std::isdigit(static_cast<unsigned char>(name.front()))) continue;
    const std::string stat = text_of_file(entry.path() / "stat");
    const std::size_t after_name = stat.rfind(')');
    if (after_name == std::string::npos) continue;
    std::istringstream rest(stat.substr(after_name + 1));
    char state = 0;
    pid_t parent = 0;
    rest >> state >> parent;
    if (parent == pid && state != 'Z') found.push_back(static_cast<pid_t>(std::stol(name)));
  }
  return found;
}

bool becomes_true(const std::function<bool()>& condition) {
  for (const double end_s = now_s() + patience_s; now_s() < end_s; sleep_s(0.02)) {
    if (condition()) return true;
  }
  return false;
}

bool all_gone(const std::vector<pid_t>& pids) {
  return std::all_of(pids.begin(), pids.end(), [](pid_t pid) { return ::kill(pid, 0) != 0; });
}

class EndedBySignal : public testing::TestWithParam<int> {
 protected:
  /// `airside WORDS` in this test's folder, by a shell that becomes it.
  std::vector<std::string> command(const std::string& words) const {
    return {"/bin/sh", "-c",
            "cd " + folder_.path().string() + " && TMPDIR=" + scratch_.path().string() +
                " exec " AIRSIDE_BIN_DIR "/airside " + words};
  }
  fs::path said() const { return said_.path() / "said"; }

  TemporaryFolder folder_, scratch_, said_;
};

TEST_P(EndedBySignal, AStudyTakesItsChildrenWithIt) {
  Child study(command("study rooms --plant rc --rooms 301 --seeds 2 --jobs 2 --no-paper --pretrain-days 364 -o s.json"),
              said());
  std::vector<pid_t> children;
  ASSERT_TRUE(becomes_true([&] { return (children = children_of(study.pid())).size() == 2; })) << study.said();
  study.signal(GetParam());
  EXPECT_EQ(study.wait(patience_s), 128 + GetParam()) << study.said();
  // Two of its own waited for them; after SIGKILL the kernel tells them.
  EXPECT_TRUE(becomes_true([&] { return all_gone(children); }));
  EXPECT_TRUE(names_in(folder_.path()).empty());
}

INSTANTIATE_TEST_SUITE_P(Signals, EndedBySignal, testing::Values(SIGINT, SIGTERM, SIGKILL),
                         [](const auto& test) { return std::string(sigabbrev_np(test.param)); });

TEST(EndedQuestions, SayThatNothingWasWritten) {
  const TemporaryFolder folder, said;
  Child asked({"/bin/sh", "-c",
               "cd " + folder.path().string() +
                   " && mkfifo typed && exec " AIRSIDE_BIN_DIR "/airside init site --ask <> typed"},
              said.path() / "said");
  ASSERT_TRUE(becomes_true([&] { return asked.said().find("Name of the room") != std::string::npos; }));
  asked.signal(SIGINT);
  EXPECT_EQ(asked.wait(patience_s), 130) << asked.said();
  EXPECT_NE(asked.said().find("\nstopped; nothing was written\n"), std::string::npos) << asked.said();
  EXPECT_FALSE(fs::exists(folder.path() / "site"));
}

using EndedOnEnergyPlus = EndedBySignal;

TEST_P(EndedOnEnergyPlus, AStudyLeavesNeitherEnginesNorTheirFolders) {
  if (!sim::have_energyplus()) GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed; run tools/setup";
  Child study(command("study rooms --plant energyplus --rooms 301 --seeds 2 --jobs 2 --no-paper --pretrain-days 364 "
                      "-o s.json"),
              said());
  std::vector<pid_t> all;
  ASSERT_TRUE(becomes_true([&] {
    all = children_of(study.pid());
    for (const pid_t child : children_of(study.pid())) {
      for (const pid_t engine : children_of(child)) all.push_back(engine);
    }
    return all.size() == 4;
  })) << study.said();
  study.signal(GetParam());
  EXPECT_EQ(study.wait(patience_s), 128 + GetParam()) << study.said();
  EXPECT_TRUE(becomes_true([&] { return all_gone(all); }));
  EXPECT_TRUE(becomes_true([&] { return names_in(scratch_.path()).empty(); }));
  EXPECT_TRUE(names_in(folder_.path()).empty());
}

INSTANTIATE_TEST_SUITE_P(Signals, EndedOnEnergyPlus, testing::Values(SIGINT, SIGTERM, SIGKILL),
                         [](const auto& test) { return std::string(sigabbrev_np(test.param)); });

using EndedInAFile = EndedBySignal;

TEST_P(EndedInAFile, ALogInTheMakingIsRemovedAndTheOneBeforeStays) {
  std::ofstream(folder_.path() / "y.csv") << "time, of before\n";
  Child run(command("simulate --plant rc --method expert --expert-days 0 --days 300 --log y.csv"), said());
  ASSERT_TRUE(becomes_true([&] { return fs::exists(folder_.path() / "y.csv.part"); })) << run.said();
  run.signal(GetParam());
  EXPECT_EQ(run.wait(patience_s), 128 + GetParam()) << run.said();
  EXPECT_EQ(names_in(folder_.path()), std::set<std::string>{"y.csv"});
  EXPECT_EQ(text_of_file(folder_.path() / "y.csv"), "time, of before\n");
}

/// Runs `work` in a child process that cleans up and that `number` ends then; its exit code as a shell shows it.
int ended_in(int number, const std::function<void()>& work) {
  const pid_t pid = ::fork();
  if (pid == 0) {
    hal::forget_unfinished();
    hal::clean_up_on_signals();
    work();
    ::raise(number);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(pid, &status, 0);
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

TEST_P(EndedInAFile, AHalfMadeFolderIsRemovedWithAllThatLiesInIt) {
  const int code = ended_in(GetParam(), [&] {
    hal::StagedFolder staged(folder_.path() / "rep");
    fs::create_directories(staged.path() / "deep" / "deeper");
    for (int i = 0; i < 500; ++i) std::ofstream(staged.path() / "deep" / std::to_string(i)) << i;
    std::ofstream(staged.path() / "index.html") << "half";
    ::raise(GetParam());
  });
  EXPECT_EQ(code, 128 + GetParam());
  EXPECT_TRUE(names_in(folder_.path()).empty());
}

TEST_P(EndedInAFile, AFolderThatWasThereKeepsWhatItHad) {
  fs::create_directory(folder_.path() / "rep");
  std::ofstream(folder_.path() / "rep" / "index.html") << "of before";
  const int code = ended_in(GetParam(), [&] {
    hal::StagedFolder staged(folder_.path() / "rep");
    std::ofstream(staged.path() / "index.html") << "half";
    ::raise(GetParam());
  });
  EXPECT_EQ(code, 128 + GetParam());
  EXPECT_EQ(names_in(folder_.path()), (std::set<std::string>{"rep", "rep/index.html"}));
  EXPECT_EQ(text_of_file(folder_.path() / "rep" / "index.html"), "of before");
}

TEST_P(EndedInAFile, WhatIsFinishedStays) {
  const int code = ended_in(GetParam(), [&] {
    hal::StagedFile file((folder_.path() / "whole").string());
    file.write("whole");
    file.commit();
    hal::StagedFolder staged(folder_.path() / "rep");
    std::ofstream(staged.path() / "index.html") << "whole";
    staged.commit("index.html");
    ::raise(GetParam());
  });
  EXPECT_EQ(code, 128 + GetParam());
  EXPECT_EQ(names_in(folder_.path()), (std::set<std::string>{"rep", "rep/index.html", "whole"}));
}

INSTANTIATE_TEST_SUITE_P(Signals, EndedInAFile, testing::Values(SIGINT, SIGTERM),
                         [](const auto& test) { return std::string(sigabbrev_np(test.param)); });

TEST(StagedFolder, RemovesWhatAKilledRunHasLeftAndNothingElse) {
  for (const bool there : {false, true}) {
    TemporaryFolder folder;
    const fs::path target = folder.path() / "rep";
    if (there) fs::create_directory(target);
    const int code = ended_in(SIGKILL, [&] {
      hal::StagedFolder staged(target);
      std::ofstream(staged.path() / "gap.json") << "half";
      ::raise(SIGKILL);
    });
    ASSERT_EQ(code, 128 + SIGKILL);
    EXPECT_EQ(std::ssize(names_in(folder.path())), there ? 3 : 2) << "its part, with what lies in it";
    const fs::path other =
        (there ? target / "." : folder.path() / "rep.").string() + std::to_string(::getppid()) + ".part";
    fs::create_directory(other);
    for (const char* kept : {"rep.part", "rep.0x1.part", "rep.1.parts"}) std::ofstream(folder.path() / kept) << "mine";
    {
      hal::StagedFolder staged(target);
      std::ofstream(staged.path() / "index.html") << "whole";
      staged.commit("index.html");
    }
    EXPECT_TRUE(fs::exists(other)) << "of a process that runs";
    fs::remove(other);
    EXPECT_EQ(names_in(folder.path()),
              (std::set<std::string>{"rep", "rep/index.html", "rep.part", "rep.0x1.part", "rep.1.parts"}));
  }
}

TEST(StagedFolder, ReplacesAnEarlierResultAndKeepsWhatIsNotOfIt) {
  TemporaryFolder folder;
  const fs::path target = folder.path() / "rep";
  fs::create_directories(target / "runs");
  for (const char* name : {"index.html", "patch.json", "gap.json", "notes.txt"}) std::ofstream(target / name) << "old";
  hal::StagedFolder staged(target);
  for (const char* name : {"index.html", "gap.json"}) std::ofstream(staged.path() / name) << "new";
  staged.commit("index.html", {"patch.json", "gap.json", "never.json"});
  EXPECT_EQ(names_in(target), (std::set<std::string>{"index.html", "gap.json", "notes.txt", "runs"}));
  EXPECT_EQ(text_of_file(target / "index.html") + text_of_file(target / "gap.json"), "newnew");
  EXPECT_EQ(text_of_file(target / "notes.txt"), "old");
}

TEST(CleanUpOnSignals, AnIgnoredSignalStaysIgnored) {
  TemporaryFolder folder;
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::signal(SIGINT, SIG_IGN);  // as a shell does for a background job
    hal::clean_up_on_signals();
    ::raise(SIGINT);
    ::_exit(7);
  }
  int status = 0;
  ::waitpid(pid, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 7);
}

}  // namespace
}  // namespace airside
