// The daemon as others see it: it listens on nothing, and its memory is small.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "support/bench.hpp"
#include "support/sanitized.hpp"

namespace airside {
namespace {

namespace fs = std::filesystem;

/// Inodes of the sockets that a process holds, as text.
std::set<std::string> sockets_of(int pid) {
  std::set<std::string> inodes;
  std::error_code ignored;
  for (const auto& descriptor : fs::directory_iterator(fmt::format("/proc/{}/fd", pid), ignored)) {
    const std::string to = fs::read_symlink(descriptor.path(), ignored).string();
    if (to.starts_with("socket:[")) inodes.insert(to.substr(8, to.size() - 9));
  }
  return inodes;
}

/// Lines of /proc/net that show a socket of the process on which others may call: a TCP or Unix socket that listens, or
/// any of UDP or raw.
std::string doors_of(int pid) {
  const std::set<std::string> own = sockets_of(pid);
  std::string doors;
  for (const std::string table : {"tcp", "tcp6", "udp", "udp6", "raw", "raw6"}) {
    std::ifstream in(fmt::format("/proc/{}/net/{}", pid, table));
    for (std::string line; std::getline(in, line);) {
      std::istringstream fields(line);
      std::vector<std::string> field;
      for (std::string one; fields >> one;) field.push_back(one);
      if (field.size() < 10 || !own.contains(field[9])) continue;
      if (!table.starts_with("tcp") || field[3] == "0A") doors += fmt::format("{}: {}\n", table, line);
    }
  }
  std::ifstream in(fmt::format("/proc/{}/net/unix", pid));
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::string address, count, protocol, flags, type, state, inode;
    fields >> address >> count >> protocol >> flags >> type >> state >> inode;
    constexpr unsigned long accepts = 0x10000;  // __SO_ACCEPTCON
    if (own.contains(inode) && (std::strtoul(flags.c_str(), nullptr, 16) & accepts) != 0)
      doors += "unix: " + line + "\n";
  }
  return doors;
}

double kib_of(int pid, const std::string& key) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key + ":")) return std::atof(line.c_str() + key.size() + 1);
  return 0;
}

TEST(DaemonProcess, ListensOnNothingAndKeepsBelowSevenMebibytesOfItsOwn) {
  closed_loop::Bench bench({.name = "process", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 20});
  bench.start_server();
  const auto daemon = bench.start_daemon();
  const double until = closed_loop::now_s() + 200;
  while (bench.logged_rows() < 300 && daemon->running() && closed_loop::now_s() < until) closed_loop::sleep_s(0.005);
  const int pid = daemon->pid();
  const std::string doors = doors_of(pid);
  const std::size_t sockets = sockets_of(pid).size();
  const double peak_kib = kib_of(pid, "VmHWM"), own_kib = kib_of(pid, "RssAnon"), threads = kib_of(pid, "Threads");
  ASSERT_TRUE(daemon->running()) << "looked at too late\n" << daemon->said();
  ASSERT_GE(bench.logged_rows(), 300U) << daemon->said();
  EXPECT_EQ(doors, "");
  EXPECT_GE(sockets, 1U) << "its own connection to the AHU was not seen, so nothing else would be";
  EXPECT_GT(threads, 0);
  std::printf("own %.0f KiB, peak %.0f KiB, %zu sockets, %.0f threads\n", own_kib, peak_kib, sockets, threads);
  EXPECT_GT(own_kib, 1000);
  if (!sanitized) {
    EXPECT_LT(own_kib, 7 * 1024);
    // With pages of its program and of libraries that others share: how many are there is the kernel's choice.
    EXPECT_LT(peak_kib, 14 * 1024);
  }
}

TEST(DaemonProcess, ADoorWouldBeSeen) {
  closed_loop::Bench bench({.name = "door", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 1});
  bench.start_server();
  EXPECT_NE(doors_of(bench.server_pid()), "") << "the served room listens";
}

}  // namespace
}  // namespace airside
