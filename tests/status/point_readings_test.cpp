// Wishes for a reading of every point, or for a write, are done once each: not anew where they cannot be taken away,
// and not thrown away where they come while others are done.

#include "firmware/edge/report/point_readings.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/modbus_fixture.hpp"

namespace airside::edge {
namespace {

namespace fs = std::filesystem;
using hal::testing_peers::honest_answer;
using hal::testing_peers::HostilePeer;
using hal::testing_peers::tcp_settings;

/// Only root may remove files of a folder that it has closed to everybody; so it is somebody else for a while.
class AsNobody {
 public:
  AsNobody() : root_(::geteuid() == 0) {
    if (root_) {
      EXPECT_EQ(::seteuid(65534), 0);
    }
  }
  ~AsNobody() {
    if (root_) {
      EXPECT_EQ(::seteuid(0), 0);
    }
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  bool root_;
};

class PointReadingsTest : public testing::Test {
 protected:
  PointReadingsTest() {
    std::string pattern = (fs::temp_directory_path() / "airside_readings_XXXXXX").string();
    EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
    dir_ = pattern;
    for (const fs::path& folder : {inbox(), state()}) {
      fs::create_directory(folder);
      fs::permissions(folder, fs::perms::all);
    }
    fs::permissions(dir_, fs::perms::all);
  }
  ~PointReadingsTest() override { fs::remove_all(dir_); }
  fs::path inbox() const { return dir_ / "inbox"; }
  fs::path state() const { return dir_ / "state"; }
  bool lies(const char* name) const { return fs::exists(inbox() / name); }
  void drop(const char* name) const {
    std::ofstream(inbox() / "new").close();
    fs::rename(inbox() / "new", inbox() / name);
  }

  fs::path dir_;
  const hal::PointMap map_ = hal::PointMap::parse(
      hal::testing_peers::csv_header() + "clock_s,s,4,0,int32,,,1,0,0,2147483647,,,,,,,\n", "points.csv");
  const CivilTime now_{1'780'000'000};
};

TEST_F(PointReadingsTest, AWishThatCannotBeTakenAwayIsDoneOnce) {
  PointReadings readings(map_, inbox().string(), state().string());
  drop(PointReadings::write_wish_name);
  drop(PointReadings::wish_name);
  hal::ModbusLink nowhere(tcp_settings(1));
  {
    fs::permissions(inbox(), fs::perms::others_write | fs::perms::group_write | fs::perms::owner_write,
                    fs::perm_options::remove);
    const AsNobody nobody;
    EXPECT_TRUE(readings.wanted());
    EXPECT_TRUE(readings.take_write_wish());
    readings.read(nowhere, now_, false);
    EXPECT_FALSE(readings.wanted());
    EXPECT_FALSE(readings.take_write_wish()) << "a setpoint would be written at each heartbeat";
    EXPECT_TRUE(fs::exists(state() / PointReadings::file_name));
  }
  ASSERT_TRUE(lies(PointReadings::write_wish_name)) << "it was to stay";
  fs::permissions(inbox(), fs::perms::all);
  drop(PointReadings::write_wish_name);
  EXPECT_TRUE(readings.take_write_wish()) << "that is another one";
  readings.read(nowhere, now_, false);
  EXPECT_FALSE(lies(PointReadings::write_wish_name));
}

TEST_F(PointReadingsTest, AWishThatComesDuringAReadingWaitsForTheNext) {
  const HostilePeer peer([this](HostilePeer& p, int fd) {
    for (auto request = p.request(fd); !request.empty(); request = p.request(fd)) {
      drop(PointReadings::write_wish_name);
      drop(PointReadings::wish_name);
      p.send(fd, honest_answer(request));
    }
  });
  PointReadings readings(map_, inbox().string(), state().string());
  drop(PointReadings::wish_name);
  hal::ModbusLink link(tcp_settings(peer.port()));
  ASSERT_TRUE(readings.wanted());
  EXPECT_FALSE(readings.take_write_wish());
  readings.read(link, now_, true);
  EXPECT_TRUE(lies(PointReadings::wish_name));
  EXPECT_TRUE(lies(PointReadings::write_wish_name)) << "no write was tried for it";
  EXPECT_TRUE(readings.take_write_wish());
  readings.read(link, now_, false);
  EXPECT_FALSE(lies(PointReadings::wish_name));
  EXPECT_FALSE(lies(PointReadings::write_wish_name));
}

}  // namespace
}  // namespace airside::edge
