#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_room_file.hpp"

namespace airside::sim {
namespace {

// The complaint about a room file's text; empty if there is none.
std::string complaint(const std::string& json) {
  try {
    parse_room(json, "here.json", "here");
  } catch (const hal::InputError& error) {
    return error.what();
  }
  return "";
}

void expect_complaint(const std::string& json, const std::string& place, const std::string& found) {
  const std::string said = complaint(json);
  EXPECT_EQ(said.find(place + ": found "), 0u) << json << "\n  said: " << said;
  EXPECT_NE(said.find(found), std::string::npos) << json << "\n  said: " << said;
}

TEST(RoomFile, LoadsEveryEmbeddedRoomWithItsOwnSeed) {
  const auto names = room_names();
  EXPECT_GE(names.size(), 13u);
  for (const std::string& name : names) {
    const RcRoom room = load_room(name);
    EXPECT_EQ(room.name, name);
  }
  EXPECT_NE(load_room("701").seed, load_room("701-real").seed);
  EXPECT_NE(load_room("701").seed, load_room("702").seed);
}

TEST(RoomFile, KeepsTheBaseWhereNothingIsSaid) {
  const RcRoom base = load_room("301"), room = load_room("401");
  EXPECT_EQ(room.solar_factor_south, base.solar_factor_south);
  EXPECT_EQ(room.vav_damper, base.vav_damper);
  EXPECT_NE(room.capacity_factor, base.capacity_factor);
}

TEST(RoomFile, OneNumberStandsForAllAndAListForEach) {
  const RcRoom room =
      parse_room(R"({"vav_damper": 0.4, "fcu_flow_m3_s": [0.1, 0.2, 0.3, 0.4, 0.5], "shgc": 0.5})", "x", "x");
  EXPECT_EQ(room.vav_damper, std::vector<double>(5, 0.4));
  EXPECT_EQ(room.fcu_flow_m3_s[4], 0.5);
  EXPECT_EQ(room.shgc, 0.5);
}

TEST(RoomFile, CountsMakeAnotherRoom) {
  const RcRoom room = load_room("suite-3vav");
  EXPECT_EQ(room.vavs, 3);
  EXPECT_EQ(room.fcus, 0);
  EXPECT_EQ(room.powers, 1);
  EXPECT_EQ(room.volume_m3.size(), 3u);
}

TEST(RoomFile, NamesEveryMistake) {
  expect_complaint(R"({"shcg": 0.4})", "here.json: shcg", "unknown field");
  expect_complaint(R"({"shgc": 1.4})", "here.json: shgc", "1.4");
  expect_complaint(R"({"shgc": "0.4"})", "here.json: shgc", "\"0.4\"");
  expect_complaint(R"({"shgc": null})", "here.json: shgc", "null");
  expect_complaint(R"({"shgc": [0.4]})", "here.json: shgc", "[0.4]");
  expect_complaint(R"({"vav_damper": [0.5, 0.5]})", "here.json: vav_damper", "2 values");
  expect_complaint(R"({"vav_damper": [0.5, 0.5, 0.5, 0.5, 2]})", "here.json: vav_damper", "2");
  expect_complaint(R"({"vav_damper": [0.5, 0.5, 0.5, 0.5, "a"]})", "here.json: vav_damper", "\"a\"");
  expect_complaint(R"({"base": "999"})", "here.json: base", "room \"999\"");
  expect_complaint(R"({"base": 701})", "here.json: base", "701");
  expect_complaint(R"({"base": "301", "vavs": 3})", "here.json: vavs, fcus, powers", "counts on base");
  expect_complaint(R"({"vavs": 0})", "here.json: vavs, fcus, powers", "0 VAVs");
  expect_complaint(R"({"vavs": 3.5})", "here.json: vavs", "3.5");
  expect_complaint(R"({"seed": -1})", "here.json: seed", "-1");
  expect_complaint(R"({"room_sensor_zone": [1, 2, 3, 4, 6]})", "here.json: room_sensor_zone", "6");
  expect_complaint(R"({"fcu_forced": 0.5})", "here.json: fcu_forced", "0.5");
  expect_complaint(R"({"occupancy_end_h": 5})", "here.json: occupancy_end_h", "5");
  expect_complaint(R"({"shgc": 0.4, "shgc": 0.5})", "here.json: shgc", "twice");
  expect_complaint(R"([1, 2])", "here.json", "array");
  expect_complaint("{\n\"shgc\": 0.4,\n}", "here.json:3", "no JSON");
  expect_complaint("", "here.json:1", "no JSON");
}

TEST(RoomFile, ReadsAPathAndComplainsOfAMissingOne) {
  const std::string path = testing::TempDir() + "corner-office.json";
  std::ofstream(path) << R"({"base": "702", "window_u_w_m2k": 4.77})";
  const RcRoom room = load_room(path);
  EXPECT_EQ(room.name, "corner-office");
  EXPECT_EQ(room.window_u_w_m2k, 4.77);
  std::remove(path.c_str());
  EXPECT_THROW(load_room(path), hal::InputError);
  EXPECT_THROW(load_room("no-such-room"), hal::InputError);
}

TEST(RoomFields, AreUniqueAndHoldTheDefaults) {
  const auto fields = room_fields();
  EXPECT_GT(fields.size(), 80u);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    EXPECT_EQ(find_room_field(fields[i].name), &fields[i]) << fields[i].name;
    EXPECT_LT(fields[i].lowest, fields[i].highest) << fields[i].name;
  }
  EXPECT_EQ(find_room_field("nonsense"), nullptr);
  EXPECT_NO_THROW(check_room(make_room(64, 64, 2), "biggest"));
  EXPECT_NO_THROW(check_room(make_room(1, 0, 1), "smallest"));
}

TEST(PerturbedRoom, IsRepeatableDistinctAndWithinBounds) {
  const RcRoom base = make_room();
  const RcRoom once = perturbed_room(base, 5), again = perturbed_room(base, 5), other = perturbed_room(base, 6);
  EXPECT_EQ(once.gain_factor, again.gain_factor);
  EXPECT_EQ(once.seed, again.seed);
  EXPECT_NE(once.gain_factor, other.gain_factor);
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const RcRoom room = perturbed_room(base, seed);
    ASSERT_NO_THROW(check_room(room, room.name));
    const double change = std::abs(room.capacity_factor / base.capacity_factor - 1);
    EXPECT_GE(change, 0.10 - 1e-12);
    EXPECT_LE(change, 0.20 + 1e-12);
  }
}

TEST(PerturbedRoom, TuningAndStudySetsShareNoRoom) {
  const auto tuning = tuning_rooms(make_room()), study = study_rooms(make_room(), 24);
  EXPECT_EQ(tuning.size(), 8u);
  EXPECT_EQ(study.size(), 24u);
  for (const RcRoom& a : tuning) {
    for (const RcRoom& b : study) EXPECT_NE(a.seed, b.seed);
  }
}

TEST(RoomFile, RefusesNumbersThatNoDoubleHoldsAndBottomlessBrackets) {
  expect_complaint(R"({"shgc": 1e999})", "here.json", "number overflow");
  const std::string deep = "{\"seed\": " + std::string(200000, '[') + std::string(200000, ']') + "}";
  expect_complaint(deep, "here.json", "brackets in brackets");
  EXPECT_NE(complaint("{\"seed\": " + std::string(90, '[') + std::string(90, ']') + "}").find("a whole number"),
            std::string::npos)
      << "so deep is read, and is no seed";
}

}  // namespace
}  // namespace airside::sim
