// The progress display on a real pseudo-terminal and in a file.

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tools/run/progress/progress.hpp"

namespace airside::tools {
namespace {

std::string in_a_file(const std::function<void(std::FILE*)>& use) {
  std::FILE* file = std::tmpfile();
  use(file);
  std::rewind(file);
  std::string text;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
  std::fclose(file);
  return text;
}

TEST(Progress, WritesALineEveryTenPercentIntoALog) {
  const std::string text = in_a_file([](std::FILE* out) {
    Progress progress("pretrain", 1000, out);
    for (int i = 0; i < 1000; ++i) progress.advance();
    progress.finish();
    progress.finish();
    progress.advance();
  });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 11);  // started, 10..90 %, done
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_NE(text.find("pretrain: 50 %\n"), std::string::npos);
  EXPECT_NE(text.find("pretrain: done in 0 s\n"), std::string::npos);
}

TEST(Progress, NeverGoesBackOrBeyondItsTotal) {
  const std::string text = in_a_file([](std::FILE* out) {
    Progress progress("run", 10, out);
    progress.set(5);
    progress.set(3);
    progress.advance(~std::uint64_t{0});
  });
  EXPECT_NE(text.find("50 %"), std::string::npos);
  EXPECT_EQ(text.find("30 %"), std::string::npos);
  EXPECT_EQ(text.find("110 %"), std::string::npos);
}

TEST(Progress, SurvivesATaskOfNoSteps) {
  const std::string text = in_a_file([](std::FILE* out) {
    Progress progress("nothing", 0, out);
    progress.finish();
  });
  EXPECT_NE(text.find("done"), std::string::npos);
}

TEST(Progress, RedrawsOneLineOnATerminalWithinItsWidth) {
  int master = 0, slave = 0;
  winsize size{};
  size.ws_col = 60;
  size.ws_row = 20;
  ASSERT_EQ(openpty(&master, &slave, nullptr, nullptr, &size), 0);
  std::FILE* out = fdopen(slave, "w");
  {
    Progress progress("simulate", 4, out);
    for (int i = 0; i < 4; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      progress.advance();
    }
    progress.finish();
  }
  std::string text;  // a terminal hands over what it has, so read until the last line has ended
  while (text.find('\n') == std::string::npos) {
    char buffer[4096];
    const ssize_t count = read(master, buffer, sizeof buffer);
    ASSERT_GT(count, 0);
    text.append(buffer, static_cast<std::size_t>(count));
  }
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);  // only at the end
  EXPECT_NE(text.find("[#"), std::string::npos);
  EXPECT_NE(text.find("left"), std::string::npos);
  std::size_t from = 0;
  for (std::size_t at = text.find('\r'); at != std::string::npos; at = text.find('\r', from)) {
    EXPECT_LE(at - from, 60u + 4u) << text.substr(from, at - from);
    from = at + 1;
  }
  std::fclose(out);
  close(master);
}

TEST(Progress, MayBeAdvancedFromSeveralThreads) {
  const std::string text = in_a_file([](std::FILE* out) {
    Progress progress("campaign", 4000, out);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 1000; ++i) progress.advance();
      });
    }
    for (std::thread& t : threads) t.join();
    progress.finish();
  });
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 11);
}

TEST(Duration, ReadsAsPeopleSayIt) {
  EXPECT_EQ(duration_text(0.2), "0 s");
  EXPECT_EQ(duration_text(59.4), "59 s");
  EXPECT_EQ(duration_text(200), "3 min 20 s");
  EXPECT_EQ(duration_text(7500), "2 h 05 min");
}

}  // namespace
}  // namespace airside::tools
