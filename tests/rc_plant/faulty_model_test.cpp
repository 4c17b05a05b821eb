// A fault script does what it says to what is shown, to nothing else, and only while it lasts.

#include "sim/faults/faulty_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "hal/text/input_error.hpp"
#include "rc_plant/rc_fixture.hpp"
#include "support/test_folder.hpp"

namespace airside::sim {
namespace {

const hal::TopologyCounts counts{"5vav-5fcu-2power", 5, 5, 2};

/// The same room twice: one whose faults are scripted, one without.
class FaultyRoom : public ::testing::Test {
 protected:
  void script(FaultScript faults) { faulty = std::make_unique<FaultyModel>(inner, std::move(faults)); }
  void advance(double to_h) {
    const CivilTime t = test::later(test::july, static_cast<int>(to_h * 3600));
    faulty->advance_to(t);
    plain.advance_to(t);
  }
  const Sensors& shown() const { return faulty->sensors(); }
  const Sensors& real() const { return plain.sensors(); }
  static void expect_same(const Sensors& a, const Sensors& b) {
    EXPECT_EQ(a.room_temp_degc, b.room_temp_degc);
    EXPECT_EQ(a.fcu_temp_degc, b.fcu_temp_degc);
    EXPECT_EQ(a.power_kw, b.power_kw);
    EXPECT_EQ(a.supply_temp_degc, b.supply_temp_degc);
    EXPECT_EQ(a.setpoint_degc, b.setpoint_degc);
  }

  RcPlant inner{make_room(), test::hot_weather(), test::july, 3}, plain{inner};
  std::unique_ptr<FaultyModel> faulty;
};

TEST_F(FaultyRoom, WithoutFaultsShowsTheRoom) {
  script({});
  for (int h = 1; h < 30; ++h) {
    faulty->set_setpoint(20 + h % 5);
    plain.set_setpoint(20 + h % 5);
    advance(h);
    expect_same(shown(), real());
    EXPECT_FALSE(faulty->disturbed());
  }
}

TEST_F(FaultyRoom, SensorFaultsChangeTheirSignalWhileTheyLast) {
  const int fcu_2 = 6, power_1 = 20, outdoor = 23;
  script({{FaultKind::not_a_number, 1, 2, 1, 0},
          {FaultKind::offset, 1, 2, fcu_2, -3},
          {FaultKind::set_to, 1, 2, power_1, 1e9},
          {FaultKind::set_to, 1, 2, outdoor, 77},
          {FaultKind::drift, 1, 2, 0, 24}});
  advance(0.9);
  expect_same(shown(), real());
  advance(2);
  EXPECT_TRUE(std::isnan(shown().room_temp_degc[1]));
  EXPECT_EQ(shown().fcu_temp_degc[1], real().fcu_temp_degc[1] - 3);
  EXPECT_EQ(shown().power_kw[0], 1e9);
  EXPECT_EQ(shown().outdoor_temp_degc, 77);
  EXPECT_NEAR(shown().room_temp_degc[0], real().room_temp_degc[0] + 1, 1e-12) << "24 K a day for an hour";
  EXPECT_EQ(shown().room_temp_degc[2], real().room_temp_degc[2]);
  EXPECT_EQ(&faulty->truth(), &inner);
  EXPECT_EQ(inner.sensors().room_temp_degc, real().room_temp_degc) << "the room itself goes on";
  EXPECT_TRUE(faulty->disturbed());
  advance(3.1);
  expect_same(shown(), real());
  EXPECT_TRUE(faulty->disturbed(1));
  EXPECT_FALSE(faulty->disturbed());
}

TEST_F(FaultyRoom, AStuckSignalRepeatsAndAStuckDeviceRepeatsAll) {
  script({{FaultKind::stuck, 0, 3, 0, 0}, {FaultKind::all_stuck, 5, 3, -1, 0}});
  advance(1);
  const double kept = shown().room_temp_degc[0];
  advance(2.9);
  EXPECT_EQ(shown().room_temp_degc[0], kept);
  EXPECT_NE(real().room_temp_degc[0], kept) << "the room must have moved";
  EXPECT_EQ(shown().room_temp_degc[1], real().room_temp_degc[1]);
  advance(5.1);
  const Sensors repeated = shown();
  advance(7);
  expect_same(shown(), repeated);
  EXPECT_NE(shown().power_kw, real().power_kw);
  advance(8);
  expect_same(shown(), real());
}

TEST_F(FaultyRoom, HandsOnTheSetpointActInTheRoom) {
  script({{FaultKind::setpoint_by_hand, 1, 0, -1, 21},
          {FaultKind::setpoint_clamped, 3, 1, -1, 22},
          {FaultKind::setpoint_fought, 5, 1, -1, 19},
          {FaultKind::restarted, 7, 0, -1, 23.5}});
  faulty->set_setpoint(24);
  advance(0.9);
  EXPECT_EQ(shown().setpoint_degc, 24);
  advance(1.1);
  EXPECT_EQ(shown().setpoint_degc, 21);
  EXPECT_EQ(inner.setpoint_degc(), 21);
  faulty->set_setpoint(24);
  advance(2);
  EXPECT_EQ(shown().setpoint_degc, 24) << "once is once";
  advance(3.1);
  faulty->set_setpoint(24);
  EXPECT_EQ(faulty->standing_degc(), 22);
  advance(5.05);
  EXPECT_EQ(faulty->standing_degc(), 19);
  faulty->set_setpoint(24);
  advance(5.4);
  EXPECT_EQ(faulty->standing_degc(), 19) << "again and again";
  advance(6.2);
  faulty->set_setpoint(24);
  advance(6.9);
  EXPECT_EQ(faulty->standing_degc(), 24);
  advance(7.1);
  EXPECT_EQ(inner.setpoint_degc(), 23.5);
}

TEST_F(FaultyRoom, AnIgnoredSetpointIsShownAndReachesTheRoomAfterwards) {
  script({{FaultKind::setpoint_ignored, 1, 1, -1, 0}});
  faulty->set_setpoint(24);
  advance(1.1);
  faulty->set_setpoint(20);
  EXPECT_EQ(shown().setpoint_degc, 20);
  advance(1.9);
  EXPECT_EQ(inner.setpoint_degc(), 24);
  advance(2.2);
  EXPECT_EQ(inner.setpoint_degc(), 20);
}

FaultScript read(const std::string& text) {
  const hal::TestFolder folder("fault_script");
  std::ofstream(folder.file("f.csv")) << text;
  return read_fault_script(folder.file("f.csv").string(), counts);
}

TEST(FaultScriptFile, EveryKindIsRead) {
  std::string text = "# all\nbegin_h,for_h,fault,signal,magnitude\r\n";
  for (const FaultKindText& kind : fault_kinds()) {
    text +=
        std::string("1.5,2,") + kind.name + (kind.on_signal ? ",rain," : ",,") + (*kind.magnitude ? "21" : "") + "\n";
  }
  const FaultScript script = read(text);
  ASSERT_EQ(script.size(), fault_kinds().size());
  for (std::size_t i = 0; i < script.size(); ++i) {
    EXPECT_EQ(script[i].kind, fault_kinds()[i].kind);
    EXPECT_EQ(script[i].begin_h, 1.5);
    EXPECT_EQ(script[i].for_h, 2);
    EXPECT_EQ(script[i].signal, fault_kinds()[i].on_signal ? 24 : -1);
  }
}

TEST(FaultScriptFile, ABrokenOneIsRefusedWithLineAndField) {
  const std::string header = "begin_h,for_h,fault,signal,magnitude\n";
  const std::pair<std::string, std::string> broken[] = {
      {"", "no header"},
      {"hours,fault\n", ":1: header"},
      {header + "1,2,stuck,room_temp_2\n", ":2: cells"},
      {header + "\n# why\nx,2,stuck,room_temp_2,\n", ":4: begin_h"},
      {header + "-1,2,stuck,room_temp_2,\n", ":2: begin_h"},
      {header + "1,nan,stuck,room_temp_2,\n", ":2: for_h"},
      {header + "1,2,sticky,room_temp_2,\n", ":2: fault"},
      {header + "1,2,stuck,room_temp_6,\n", ":2: signal"},
      {header + "1,2,stuck,,\n", ":2: signal"},
      {header + "1,2,all_stuck,rain,\n", ":2: signal"},
      {header + "1,2,offset,rain,\n", ":2: magnitude"},
      {header + "1,2,offset,rain,1 K\n", ":2: magnitude"},
      {header + "1,2,stuck,rain,3\n", ":2: magnitude"},
      {header + "1,2,stuck,\"rain,3\n", ":2"},
  };
  for (const auto& [text, place] : broken) {
    try {
      (void)read(text);
      ADD_FAILURE() << text;
    } catch (const hal::InputError& e) {
      EXPECT_NE(std::string(e.what()).find(place), std::string::npos) << text << "\n" << e.what();
      EXPECT_FALSE(e.remedy().empty());
    }
  }
  EXPECT_THROW(read_fault_script("/nowhere/f.csv", counts), hal::InputError);
}

}  // namespace
}  // namespace airside::sim
