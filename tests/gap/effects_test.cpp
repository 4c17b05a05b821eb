// The library of effects: files that lie are refused, what is loaded does what it says, on the RC room to the sign,
// on the twin's model as a patch.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "gap/effects_expected.hpp"
#include "gap/effects_library.hpp"
#include "hal/text/input_error.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/json/json_file.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::sim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using tools::gap::RcEngine;

const Json& twin_model() {
  static const Json model = read_json(fs::path(AIRSIDE_SOURCE_DIR) / "sim" / "models" / "twin.epJSON");
  return model;
}

/// An effect of one file, made of the keys given.
Effect effect_of(const Json& file, const std::string& name = "one") {
  const RunFolder folder;
  std::ofstream(folder.path() / (name + ".json")) << file;
  return load_effects(folder.path()).front();
}

Json good_file() {
  return {{"title", "something"},
          {"unit", "1"},
          {"null", 1},
          {"low", 0.5},
          {"high", 2},
          {"probe", {0.8, 1.2}},
          {"looks_like", "something"},
          {"confirm", "somehow"},
          {"rc", Json::array({{{"field", "chiller_cop"}, {"by", "multiply"}}})}};
}

// The loader.

TEST(EffectFile, EveryKeyOfAGoodFileIsRead) {
  Json file = good_file();
  file["place"] = "vav";
  file["least"] = 0.8;
  file["prior_sd"] = 0.1;
  file["candidate"] = false;
  file["rc"] = Json::array({{{"field", "vav_flow_calibration"}, {"by", "multiply"}, {"factor", 2}, {"offset", -1}}});
  file["energyplus"] = Json::array({{{"type", "Lights"},
                                     {"name", "{zone} Lights"},
                                     {"field", "watts_per_floor_area"},
                                     {"by", "add"},
                                     {"lowest", 0},
                                     {"highest", 50}},
                                    {{"loop", "damper"}, {"by", "raise"}}});
  file["common"] = Json::array({{{"sensor", "room_temp"}, {"by", "drift"}}});
  const Effect e = effect_of(file);
  EXPECT_EQ(e.name, "one");
  EXPECT_EQ(e.place, PlaceKind::vav);
  EXPECT_EQ(e.least, 0.8);
  EXPECT_TRUE(e.plausible(0.7) && e.plausible(1.3));
  EXPECT_FALSE(e.plausible(0.9) || e.plausible(1));
  EXPECT_TRUE(effect_of(good_file()).plausible(1)) << "no such bound";
  EXPECT_EQ(e.prior_sd, 0.1);
  EXPECT_FALSE(e.candidate);
  ASSERT_EQ(e.rc.size(), 1u);
  EXPECT_EQ(e.rc[0].factor, 2);
  EXPECT_EQ(e.rc[0].offset, -1);
  ASSERT_EQ(e.energyplus.size(), 2u);
  EXPECT_EQ(e.energyplus[0].lowest, 0);
  EXPECT_EQ(e.energyplus[0].highest, 50);
  EXPECT_EQ(e.energyplus[1].on, EffectOp::On::loop);
  EXPECT_EQ(e.common[0].by, By::drift);
  EXPECT_TRUE(e.on_rc && e.on_energyplus);
}

TEST(EffectFile, AnEngineWithoutChangesHasNoSuchEffect) {
  const Effect rc_alone = effect_of(good_file());
  EXPECT_TRUE(rc_alone.on_rc);
  EXPECT_FALSE(rc_alone.on_energyplus);
  Json file = good_file();
  file["rc"] = nullptr;
  file["common"] = Json::array({{{"clock", "hours"}, {"by", "add"}}});
  EXPECT_FALSE(effect_of(file).on_rc);
  EXPECT_TRUE(effect_of(file).on_energyplus);
}

struct Broken {
  const char* what;
  std::function<void(Json&)> breaks;
  const char* key;  ///< that the complaint's place ends with
};

const std::vector<Broken>& broken_files() {
  const auto rc = [](Json op) { return [op](Json& f) { f["rc"] = Json::array({op}); }; };
  const auto energyplus = [](Json op) { return [op](Json& f) { f["energyplus"] = Json::array({op}); }; };
  const auto common = [](Json op) { return [op](Json& f) { f["common"] = Json::array({op}); }; };
  static const std::vector<Broken> files = {
      {"no title", [](Json& f) { f.erase("title"); }, ": title"},
      {"title is a number", [](Json& f) { f["title"] = 3; }, ": title"},
      {"no null", [](Json& f) { f.erase("null"); }, ": null"},
      {"null is a text", [](Json& f) { f["null"] = "1"; }, ": null"},
      {"null below low", [](Json& f) { f["null"] = 0.4; }, ": null"},
      {"one probe", [](Json& f) { f["probe"] = {0.8}; }, ": probe"},
      {"probe above high",
       [](Json& f) {
         f["probe"] = {0.8, 3};
       },
       ": probe"},
      {"probe at null",
       [](Json& f) {
         f["probe"] = {0.8, 1};
       },
       ": probe"},
      {"probe twice",
       [](Json& f) {
         f["probe"] = {0.8, 0.8};
       },
       ": probe"},
      {"least beyond high", [](Json& f) { f["least"] = 2.5; }, ": least"},
      {"negative prior", [](Json& f) { f["prior_sd"] = -0.1; }, ": prior_sd"},
      {"prior beyond high", [](Json& f) { f["prior_sd"] = 1.5; }, ": prior_sd"},
      {"unknown place", [](Json& f) { f["place"] = "roof"; }, ": place"},
      {"unknown key", [](Json& f) { f["looks_liek"] = "x"; }, ": looks_liek"},
      {"candidate is a number", [](Json& f) { f["candidate"] = 1; }, ": candidate"},
      {"nobody can confirm it", [](Json& f) { f.erase("confirm"); }, ".json"},
      {"no change", [](Json& f) { f.erase("rc"); }, ".json"},
      {"rc is no list", [](Json& f) { f["rc"] = 4; }, ": rc"},
      {"change is no object", [](Json& f) { f["rc"] = {4}; }, ": rc[0]"},
      {"change without field", rc({{"by", "add"}}), ": rc[0]: field"},
      {"misspelt field", rc({{"field", "chiler_cop"}}), ": rc[0]: field"},
      {"unknown way", rc({{"field", "chiller_cop"}, {"by", "divide"}}), ": rc[0]: by"},
      {"way for sensors alone", rc({{"field", "chiller_cop"}, {"by", "lag"}}), ": rc[0]: by"},
      {"unknown key of a change", rc({{"field", "chiller_cop"}, {"scale", 2}}), ": rc[0]: scale"},
      {"factor is a text", rc({{"field", "chiller_cop"}, {"factor", "2"}}), ": rc[0]: factor"},
      {"facade of no facade", rc({{"field", "solar_factor_{facade}"}}), ": rc[0]: field"},
      {"every place the same",
       [](Json& f) {
         f["place"] = "zone";
         f["rc"] = Json::array({{{"field", "chiller_cop"}}});
       },
       ": rc[0]: field"},
      {"boxes at fan coils",
       [](Json& f) {
         f["place"] = "fcu";
         f["rc"] = Json::array({{{"field", "vav_damper"}}});
       },
       ": rc[0]: field"},
      {"model without name", energyplus({{"type", "Lights"}, {"field", "x"}}), ": energyplus[0]: name"},
      {"model without field", energyplus({{"type", "Lights"}, {"name", "*"}}), ": energyplus[0]: field"},
      {"new is no object", energyplus({{"type", "Lights"}, {"name", "x"}, {"new", 3}}), ": energyplus[0]: new"},
      {"zone of no place", energyplus({{"type", "Lights"}, {"name", "{zone} Lights"}, {"field", "x"}}),
       ": energyplus[0]: name"},
      {"each facade", energyplus({{"type", "Lights"}, {"name", "*"}, {"field", "x"}, {"each", "facade"}}),
       ": energyplus[0]: each"},
      {"magnitude goes nowhere",
       energyplus({{"type", "Lights"}, {"name", "x"}, {"factor", 3}, {"new", {{"watts_per_floor_area", 1}}}}),
       ": energyplus[0]: factor"},
      {"unknown loop", energyplus({{"loop", "dampers"}}), ": energyplus[0]: loop"},
      {"loop of the whole floor at a box",
       [](Json& f) {
         f["place"] = "vav";
         f["rc"] = nullptr;
         f["energyplus"] = Json::array({{{"loop", "supply_lag_s"}}});
       },
       ": energyplus[0]: loop"},
      {"no target", common({{"by", "add"}}), ": common[0]"},
      {"unknown command", common({{"command", "boiler_on"}}), ": common[0]: command"},
      {"clock in minutes", common({{"clock", "minutes"}}), ": common[0]: clock"},
      {"clock multiplied", common({{"clock", "hours"}, {"by", "multiply"}}), ": common[0]: by"},
      {"unknown weather", common({{"weather", "snow"}}), ": common[0]: weather"},
      {"unknown sensor", common({{"sensor", "outdoor_temp"}}), ": common[0]: sensor"},
      {"exchange of one", common({{"sensor", "room_temp"}, {"by", "exchange"}}), ": common[0]: by"},
      {"drifting command", common({{"command", "setpoint"}, {"by", "drift"}}), ": common[0]: by"},
  };
  return files;
}

TEST(EffectFile, BrokenOnesAreRefusedWithFileAndKey) {
  effect_of(good_file());
  for (const Broken& broken : broken_files()) {
    const RunFolder folder;
    const fs::path path = folder.path() / "bad.json";
    Json file = good_file();
    broken.breaks(file);
    std::ofstream(path) << file;
    try {
      load_effects(folder.path());
      ADD_FAILURE() << broken.what << ": was taken";
    } catch (const hal::InputError& error) {
      EXPECT_TRUE(error.place().starts_with(path.string())) << broken.what << ": " << error.what();
      EXPECT_TRUE(error.place().ends_with(broken.key)) << broken.what << ": " << error.what();
      EXPECT_FALSE(error.found().empty() || error.expected().empty() || error.remedy().empty()) << broken.what;
    }
  }
}

TEST(EffectFile, TextsThatAreNoEffectAreRefused) {
  const auto said_of = [](const std::string& name, const std::string& text) {
    const RunFolder folder;
    if (!name.empty()) std::ofstream(folder.path() / name) << text;
    try {
      load_effects(folder.path());
    } catch (const hal::InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  const std::string twice = good_file().dump();
  EXPECT_NE(said_of("bad.json", "{\"title\": ").find("bad.json"), std::string::npos);
  EXPECT_NE(said_of("bad.json", "[1, 2]").find("an object"), std::string::npos);
  EXPECT_NE(said_of("bad.json", "{\"unit\": \"K\", " + twice.substr(1)).find("unit"), std::string::npos);
  EXPECT_NE(said_of("an@effect.json", twice).find("an@effect"), std::string::npos);
  EXPECT_NE(said_of("", "").find("no .json file"), std::string::npos);
  EXPECT_THROW(load_effects("/nowhere/at/all"), hal::InputError);
}

TEST(EffectFile, AUsersFileInACopiedFolderIsLoadedAndPlaced) {
  const RunFolder folder;
  fs::copy(library_folder, folder.path() / "effects", fs::copy_options::recursive);
  Json file = good_file();
  file["title"] = "ceiling fan in zone {n}";
  file["place"] = "zone";
  file["rc"] = Json::array({{{"field", "mass_ua_w_k"}, {"by", "multiply"}}});
  file["energyplus"] =
      Json::array({{{"type", "InternalMass"}, {"name", "{zone} Mass"}, {"field", "surface_area"}, {"by", "multiply"}}});
  std::ofstream(folder.path() / "effects" / "ceiling_fan.json") << file;
  const std::vector<Effect> effects = load_effects(folder.path() / "effects");
  EXPECT_EQ(effects.size(), library().size() + 1);
  const RcEngine engine(make_room());
  const tools::gap::Library instances = tools::gap::library_of(engine, effects);
  std::vector<EffectAt> fans;
  for (const EffectAt& at : instances.candidates) {
    if (at.effect->name == "ceiling_fan") fans.push_back(at);
  }
  ASSERT_EQ(fans.size(), 10u);
  EXPECT_EQ(fans[6].id(), "ceiling_fan@7");
  EXPECT_EQ(fans[6].text(), "ceiling fan in zone 7");
  const EffectChange change[] = {{fans[6], 1.5}};
  EXPECT_EQ(changed_room(make_room(), change).mass_ua_w_k[6], 1.5 * make_room().mass_ua_w_k[6]);
  EXPECT_EQ(model_patch(twin_model(), {}, change),
            (Json{{"InternalMass",
                   {{"Perimeter 2 Mass",
                     {{"surface_area",
                       1.5 * twin_model()["InternalMass"]["Perimeter 2 Mass"]["surface_area"].get<double>()}}}}}}));
}

// Places.

TEST(EffectPlaces, AreThoseOfTheRoom) {
  const std::map<std::string, std::vector<std::string>> ids = {
      {"chiller_cop", {"chiller_cop"}},
      {"solar_gain", {"solar_gain@east", "solar_gain@south", "solar_gain@west"}},
      {"vav_flow", {"vav_flow@1", "vav_flow@2", "vav_flow@3"}},
      {"fcu_degraded", {"fcu_degraded@1", "fcu_degraded@2"}},
      {"gain_zone", {"gain_zone@1", "gain_zone@2", "gain_zone@3", "gain_zone@4", "gain_zone@5"}},
      {"swapped_sensors", {"swapped_sensors@1", "swapped_sensors@2", "swapped_sensors@3"}}};
  for (const auto& [name, expected] : ids) {
    std::vector<std::string> found;
    for (const EffectAt& at : places_of(effect_named(name), {3, 2, 2}, windows)) found.push_back(at.id());
    EXPECT_EQ(found, expected);
  }
  EXPECT_EQ(places_of(effect_named("swapped_sensors"), five, windows).size(), 10u);
  EXPECT_TRUE(places_of(effect_named("fcu_degraded"), {3, 0, 1}, windows).empty());
  EXPECT_EQ((EffectAt{&effect_named("solar_gain"), 2}.text()), "solar gain through the south façade");
  EXPECT_EQ((EffectAt{&effect_named("vav_flow"), 1}.text()), "flow of box 2 is not what its controller believes");
}

TEST(EffectPlaces, PairsCountEveryTwoOnce) {
  for (const int vavs : {2, 3, 5, 8}) {
    std::set<std::pair<int, int>> seen;
    int place = 0;
    for (int a = 0; a < vavs; ++a) {
      for (int b = a + 1; b < vavs; ++b) EXPECT_EQ(vav_pair(place++, vavs), std::pair(a, b));
    }
    EXPECT_EQ(place, vavs * (vavs - 1) / 2);
  }
}

// The library.

TEST(EffectLibrary, HoldsWhatTheWorkflowPromises) {
  std::set<std::string> names;
  for (const Effect& e : library()) {
    names.insert(e.name);
    EXPECT_FALSE(e.looks_like.empty() || e.confirm.empty() || e.unit.empty()) << e.file;
    EXPECT_TRUE(e.on_rc && e.on_energyplus) << e.name << ": one engine only";
  }
  for (const char* name : {"solar_gain",
                           "infiltration",
                           "infiltration_wind",
                           "infiltration_stack",
                           "outdoor_air_flow",
                           "gain_base",
                           "gain_occupied",
                           "gain_after_hours",
                           "gain_weekend",
                           "gain_lunch",
                           "gain_zone",
                           "thermal_mass",
                           "envelope_u",
                           "neighbour_heat",
                           "mixing_across",
                           "mixing_interior",
                           "mixing_perimeter",
                           "duct_heat_gain",
                           "duct_leak",
                           "supply_sensor_offset",
                           "coil_capacity",
                           "setpoint_lag",
                           "mau_capacity",
                           "mau_setpoint",
                           "fcu_degraded",
                           "fcu_runs_unrecorded",
                           "fcu_rests_unrecorded",
                           "vav_stuck",
                           "vav_flow",
                           "room_sensor_bias",
                           "room_sensor_drift",
                           "room_sensor_lag",
                           "room_sensor_jet",
                           "fcu_sensor_bias",
                           "swapped_sensors",
                           "clock_shift",
                           "rain_cooling",
                           "latent_load",
                           "fan_heat",
                           "fan_power",
                           "chiller_cop",
                           "occupancy_shift",
                           "sun_differs",
                           "outdoor_sensor_bias",
                           "humidity_differs"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
  std::set<std::string> expected;
  for (const ExpectedSign& e : expected_signs) expected.insert(std::string(e.effect));
  for (const Effect& e : library()) EXPECT_TRUE(expected.contains(e.name)) << e.name << ": nothing tests what it does";
}

TEST(EffectLibrary, FieldsOfTheRoomExistAtEveryPlace) {
  for (const Effect& e : library()) {
    for (const EffectAt& at : places_of(e, five, {true, true, true, true})) {
      for (const double m : {e.low, e.high, e.probe[0], e.probe[1], e.null_value + e.prior_sd}) {
        const EffectChange change[] = {{at, m}};
        RcRoom room;
        ASSERT_NO_THROW(room = changed_room(make_room(), change)) << at.id();
        EXPECT_NO_THROW(check_room(room, at.id())) << m;
      }
    }
  }
}

TEST(EffectLibrary, PatchesOfTheTwinMergeAtEveryPlaceAndBound) {
  for (const Effect& e : library()) {
    if (!e.on_energyplus) continue;
    for (const EffectAt& at : places_of(e, five, windows)) {
      for (const double m : {e.low, e.high, e.probe[0], e.probe[1], e.null_value + e.prior_sd}) {
        if (at.place > 0 && m != e.probe[0]) continue;
        const EffectChange change[] = {{at, m}};
        Json patch;
        ASSERT_NO_THROW(patch = model_patch(twin_model(), {}, change)) << at.id();
        const bool expected = m != e.null_value && std::any_of(e.energyplus.begin(), e.energyplus.end(),
                                                               [](auto& op) { return op.on == EffectOp::On::model; });
        EXPECT_EQ(!patch.empty(), expected) << at.id() << " at " << m;
        EXPECT_EQ(patch.dump().find('{' + std::string("zone}")), std::string::npos) << patch.dump();
        EXPECT_EQ(patch.dump().find("{n}"), std::string::npos) << patch.dump();
        EXPECT_EQ(patch.dump().find("{m}"), std::string::npos) << patch.dump();
      }
    }
  }
}

// Changes, one by one.

Effect of_op(PlaceKind place, EffectOp op, std::vector<EffectOp> Effect::*list) {
  Effect e;
  e.name = e.file = "made up";
  e.place = place;
  e.null_value = -1e9;
  (e.*list).push_back(std::move(op));
  return e;
}

EffectOp op_on(EffectOp::On on, const std::string& field, By by, double factor = 1, double offset = 0) {
  EffectOp op;
  op.on = on;
  op.field = field;
  op.by = by;
  op.factor = factor;
  op.offset = offset;
  return op;
}

TEST(EffectChange, RoomFieldsByEveryWay) {
  const RcRoom room = make_room();
  const auto cop = [&](By by, double m, double factor = 1, double offset = 0) {
    const Effect e = of_op(PlaceKind::floor, op_on(EffectOp::On::room, "chiller_cop", by, factor, offset), &Effect::rc);
    const EffectChange change[] = {{{&e, 0}, m}};
    return changed_room(room, change).chiller_cop;
  };
  EXPECT_DOUBLE_EQ(cop(By::multiply, 0.5), 1.7);
  EXPECT_DOUBLE_EQ(cop(By::add, 0.5), 3.9);
  EXPECT_DOUBLE_EQ(cop(By::set, 2), 2);
  EXPECT_DOUBLE_EQ(cop(By::raise, 2), 3.4);
  EXPECT_DOUBLE_EQ(cop(By::raise, 4), 4);
  EXPECT_DOUBLE_EQ(cop(By::lower, 2), 2);
  EXPECT_DOUBLE_EQ(cop(By::lower, 4), 3.4);
  EXPECT_DOUBLE_EQ(cop(By::add, 0.5, -2, 1), 3.4);
  EXPECT_DOUBLE_EQ(cop(By::add, 100), find_room_field("chiller_cop")->highest);
}

TEST(EffectChange, RoomListsAtTheirPlace) {
  const RcRoom room = make_room();
  const auto changed_places = [&](PlaceKind kind, int place, const char* field, ListField member) {
    const Effect e = of_op(kind, op_on(EffectOp::On::room, field, By::add, 0.25), &Effect::rc);
    const EffectChange change[] = {{{&e, place}, 1}};
    const RcRoom after = changed_room(room, change);
    std::vector<int> places;
    for (std::size_t i = 0; i < (room.*member).size(); ++i) {
      if ((after.*member)[i] != (room.*member)[i]) places.push_back(static_cast<int>(i));
    }
    return places;
  };
  EXPECT_EQ(changed_places(PlaceKind::vav, 3, "vav_damper", &RcRoom::vav_damper), std::vector<int>{3});
  EXPECT_EQ(changed_places(PlaceKind::fcu, 3, "fcu_capacity_factor", &RcRoom::fcu_capacity_factor),
            std::vector<int>{3});
  EXPECT_EQ(changed_places(PlaceKind::fcu, 3, "gain_factor", &RcRoom::gain_factor), std::vector<int>{8});
  EXPECT_EQ(changed_places(PlaceKind::zone, 6, "gain_factor", &RcRoom::gain_factor), std::vector<int>{6});
  EXPECT_EQ(changed_places(PlaceKind::floor, 0, "vav_damper", &RcRoom::vav_damper), (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST(EffectChange, ChangesComeOneAfterTheOther) {
  const EffectChange both[] = {{{&effect_named("vav_flow"), 1}, 0.5}, {{&effect_named("vav_stuck"), 1}, 0.5}};
  EXPECT_DOUBLE_EQ(changed_room(make_room(), both).vav_flow_calibration[1], 0.25);
  const EffectChange gains[] = {{{&effect_named("gain_zone"), 0}, 2}, {{&effect_named("gain_zone"), 0}, 1.5}};
  const Json patch = model_patch(twin_model(), {}, gains);
  EXPECT_DOUBLE_EQ(patch["Lights"]["Interior 1 Lights"]["watts_per_floor_area"].get<double>(), 27);
}

TEST(EffectChange, CommandsOfBoxesAndFanCoils) {
  const Recording recording = weekend();
  const auto share_on = [&](const Recording& r, bool only_while_off) {
    double on = 0, rows = 0;
    for (std::size_t i = 0; i < r.rows.size(); ++i) {
      if (only_while_off && recording.rows[i].fcu_on[1] > 0) continue;
      EXPECT_TRUE(r.rows[i].fcu_on[1] == 0 || r.rows[i].fcu_on[1] == 1) << "engines know on and off only";
      on += r.rows[i].fcu_on[1];
      rows += 1;
    }
    return on / rows;
  };
  const auto with = [&](By by, double m) {
    const Effect e = of_op(PlaceKind::fcu, op_on(EffectOp::On::command, "fcu_on", by), &Effect::common);
    const EffectChange change[] = {{{&e, 1}, m}};
    const Recording after = changed_recording(recording, change);
    for (std::size_t i = 0; i < after.rows.size(); ++i) {
      EXPECT_EQ(after.rows[i].fcu_on[0], recording.rows[i].fcu_on[0]);
      EXPECT_EQ(after.rows[i].vav_on, recording.rows[i].vav_on);
    }
    return after;
  };
  EXPECT_EQ(share_on(with(By::raise, 1), false), 1);
  EXPECT_NEAR(share_on(with(By::raise, 0.5), true), 0.5, 0.01);
  EXPECT_NEAR(share_on(with(By::raise, 0.2), true), 0.2, 0.01);
  EXPECT_EQ(share_on(with(By::multiply, 0), false), 0);
  EXPECT_NEAR(share_on(with(By::multiply, 0.7), false), 0.7 * share_on(recording, false), 0.01);
  EXPECT_EQ(share_on(with(By::set, 1), false), 1);
  EXPECT_EQ(share_on(with(By::lower, 0), false), 0);
}

TEST(EffectChange, SetpointAsItWasFollowed) {
  Recording recording = weekend();
  for (std::size_t i = 0; i < recording.rows.size(); ++i) recording.rows[i].setpoint_degc = i < 10 ? 20 : 24;
  const auto with = [&](By by, double m) {
    const Effect e = of_op(PlaceKind::floor, op_on(EffectOp::On::command, "setpoint", by), &Effect::common);
    const EffectChange change[] = {{{&e, 0}, m}};
    return changed_recording(recording, change);
  };
  const Recording lagging = with(By::lag, 720);
  EXPECT_DOUBLE_EQ(lagging.rows[9].setpoint_degc, 20);
  EXPECT_NEAR(lagging.rows[11].setpoint_degc, 24 - 4 * std::exp(-2 * 360.0 / 720), 1e-9);
  EXPECT_DOUBLE_EQ(with(By::lag, 0).rows[10].setpoint_degc, 24);
  EXPECT_DOUBLE_EQ(with(By::add, 1).rows[0].setpoint_degc, 21);
  EXPECT_DOUBLE_EQ(with(By::set, 19).rows[40].setpoint_degc, 19);
}

TEST(EffectChange, ClockAndWeather) {
  const Recording recording = weekend();
  const auto with = [&](const char* name, double m) {
    const EffectChange change[] = {{{&effect_named(name), 0}, m}};
    return changed_recording(recording, change);
  };
  // A log that runs ahead by an hour was written an hour before its stamps say.
  EXPECT_EQ(with("clock_shift", 1).from.seconds, recording.from.seconds - 3600);
  EXPECT_EQ(with("clock_shift", -0.51).from.seconds, recording.from.seconds + 10 * 180);
  EXPECT_EQ(with("clock_shift", 1).rows.size(), recording.rows.size());
  // A sensor that reads too much hides a cooler day.
  EXPECT_DOUBLE_EQ(with("outdoor_sensor_bias", 1).rows[7].outdoor_temp_degc, recording.rows[7].outdoor_temp_degc - 1);
  const CivilTime noon{recording.from.seconds + 12 * 3600};
  const WeatherRecord then = recording.station->at(noon);
  const WeatherRecord sunny = with("sun_differs", 1.2).station->at(noon);
  EXPECT_NEAR(sunny.direct_normal_w_m2, 1.2 * then.direct_normal_w_m2, 1e-9);
  EXPECT_NEAR(sunny.diffuse_horizontal_w_m2, 1.2 * then.diffuse_horizontal_w_m2, 1e-9);
  EXPECT_NEAR(sunny.global_horizontal_w_m2, 1.2 * then.global_horizontal_w_m2, 1e-9);
  EXPECT_EQ(sunny.outdoor_temp_degc, then.outdoor_temp_degc);
  EXPECT_NEAR(with("humidity_differs", 0.9).station->at(noon).relative_humidity_pct, 0.9 * then.relative_humidity_pct,
              1e-9);
  EXPECT_LE(with("humidity_differs", 1.5).station->at(noon).relative_humidity_pct, 100);
  EXPECT_EQ(with("humidity_differs", 0.9).station->at(noon).direct_normal_w_m2, then.direct_normal_w_m2);
}

TEST(EffectChange, SensorsByEveryWay) {
  ChannelTable table = ChannelTable::Constant(rows_per_day + 1, five.count(), 25.0);
  table.col(2).tail(rows_per_day).setConstant(26);
  table.col(five.supply_temp()).setConstant(20);
  table.col(0).setConstant(23);
  const auto with = [&](PlaceKind kind, int place, const char* sensor, By by, double m) {
    const Effect e = of_op(kind, op_on(EffectOp::On::sensor, sensor, by), &Effect::common);
    const EffectChange change[] = {{{&e, place}, m}};
    return changed_sensors(table, five, change);
  };
  const auto columns = [&](const ChannelTable& after) {
    std::vector<int> moved;
    for (int c = 0; c < five.count(); ++c) {
      if (after.col(c) != table.col(c)) moved.push_back(c);
    }
    return moved;
  };
  EXPECT_EQ(columns(with(PlaceKind::vav, 2, "room_temp", By::add, 0.5)), std::vector<int>{2});
  EXPECT_EQ(columns(with(PlaceKind::fcu, 2, "fcu_temp", By::add, 0.5)), std::vector<int>{7});
  EXPECT_EQ(columns(with(PlaceKind::floor, 0, "mau_temp", By::add, 0.5)), std::vector<int>{five.mau_temp()});
  EXPECT_EQ(columns(with(PlaceKind::floor, 0, "supply_temp", By::add, 0.5)), std::vector<int>{five.supply_temp()});
  EXPECT_EQ(columns(with(PlaceKind::floor, 0, "power", By::multiply, 2)),
            (std::vector<int>{five.power(), five.power() + 1}));
  EXPECT_DOUBLE_EQ(with(PlaceKind::vav, 2, "room_temp", By::add, 0.5)(0, 2), 25.5);
  EXPECT_DOUBLE_EQ(with(PlaceKind::vav, 2, "room_temp", By::multiply, 2)(0, 2), 50);
  EXPECT_DOUBLE_EQ(with(PlaceKind::vav, 2, "room_temp", By::set, 21)(5, 2), 21);
  EXPECT_DOUBLE_EQ(with(PlaceKind::vav, 2, "room_temp", By::raise, 25.5)(0, 2), 25.5);
  EXPECT_DOUBLE_EQ(with(PlaceKind::vav, 2, "room_temp", By::lower, 25.5)(5, 2), 25.5);
  const ChannelTable drift = with(PlaceKind::vav, 2, "room_temp", By::drift, 0.3);
  EXPECT_DOUBLE_EQ(drift(0, 2), 25);
  EXPECT_NEAR(drift(rows_per_day, 2), 26.3, 1e-9);
  const ChannelTable lag = with(PlaceKind::vav, 2, "room_temp", By::lag, 1200);
  EXPECT_NEAR(lag(3, 2), 26 - std::exp(-3 * 360.0 / 1200), 1e-9);
  const ChannelTable jet = with(PlaceKind::vav, 2, "room_temp", By::jet, 0.1);
  EXPECT_NEAR(jet(0, 2), 24.5, 1e-9);
  // Pair number 1 of five boxes: the first and the third.
  const ChannelTable half = with(PlaceKind::vav_pair, 1, "room_temp", By::exchange, 0.5);
  EXPECT_DOUBLE_EQ(half(5, 0), 24.5);
  EXPECT_DOUBLE_EQ(half(5, 2), 24.5);
  const ChannelTable whole = with(PlaceKind::vav_pair, 1, "room_temp", By::exchange, 1);
  EXPECT_EQ(columns(whole), (std::vector<int>{0, 2}));
  EXPECT_EQ(whole.col(0), table.col(2));
  EXPECT_EQ(whole.col(2), table.col(0));
}

TEST(EffectChange, LoopsOfTheTwin) {
  const RoomLoopOptions loops;
  const auto with = [&](const char* name, int place, double m) {
    const EffectChange change[] = {{{&effect_named(name), place}, m}};
    return changed_loops(loops, change);
  };
  EXPECT_DOUBLE_EQ(with("vav_stuck", 2, 0.5).dampers[2], 0.5 * loops.dampers[2]);
  EXPECT_EQ(with("vav_stuck", 2, 0.5).dampers[1], loops.dampers[1]);
  EXPECT_DOUBLE_EQ(with("vav_stuck", 3, 1.9).dampers[3], 1);
  EXPECT_DOUBLE_EQ(with("supply_sensor_offset", 0, 0.8).supply_bias_k, -0.8);
  EXPECT_DOUBLE_EQ(with("occupancy_shift", 0, 0.5).occupancy_shift_min, 30);
  EXPECT_DOUBLE_EQ(with("gain_occupied", 0, 1.4).occupancy_scale, 1.4);
  EXPECT_DOUBLE_EQ(with("setpoint_lag", 0, 400).supply_lag_s, loops.supply_lag_s + 400);
}

TEST(EffectChange, PatchOfTheModel) {
  const Effect lights = [] {
    EffectOp op = op_on(EffectOp::On::model, "watts_per_floor_area", By::add);
    op.type = "Lights";
    op.name = "Interior * Lights";
    op.lowest = 4;
    op.highest = 12;
    return of_op(PlaceKind::floor, op, &Effect::energyplus);
  }();
  const auto watts = [&](double m) {
    const EffectChange change[] = {{{&lights, 0}, m}};
    const Json patch = model_patch(twin_model(), {}, change);
    EXPECT_EQ(patch.size(), 1u);
    EXPECT_EQ(patch["Lights"].size(), 5u);
    return patch["Lights"]["Interior 4 Lights"]["watts_per_floor_area"].get<double>();
  };
  EXPECT_DOUBLE_EQ(watts(1), 10);
  EXPECT_DOUBLE_EQ(watts(-100), 4);
  EXPECT_DOUBLE_EQ(watts(100), 12);

  // New objects: one a place, with the place and the number filled in, in longer texts too.
  EffectOp op = op_on(EffectOp::On::model, "", By::add, 2);
  op.type = "OtherEquipment";
  op.name = "Heat {n}";
  op.object = {{"zone", "{zone}"}, {"watts", "{m}"}, {"lines", {{{"line", "SET X = {m}"}}}}};
  for (const auto& [each, zone, count] :
       {std::tuple(PlaceKind::fcu, "Perimeter 2", 5u), std::tuple(PlaceKind::vav, "Interior 2", 5u),
        std::tuple(PlaceKind::zone, "Interior 2", 10u)}) {
    op.each = each;
    const Effect e = of_op(PlaceKind::floor, op, &Effect::energyplus);
    const EffectChange change[] = {{{&e, 0}, 1.5}};
    const Json patch = model_patch(twin_model(), {}, change);
    ASSERT_EQ(patch["OtherEquipment"].size(), count);
    EXPECT_EQ(patch["OtherEquipment"]["Heat 2"],
              (Json{{"zone", zone}, {"watts", 3.0}, {"lines", {{{"line", "SET X = 3"}}}}}));
  }
}

TEST(EffectChange, ModelThatCannotTakeItIsRefused) {
  const auto refuse = [](const Json& model, const char* name) {
    const EffectChange change[] = {{{&effect_named(name), 0}, effect_named(name).probe[0]}};
    try {
      model_patch(model, {}, change);
    } catch (const hal::InputError& error) {
      EXPECT_NE(error.place().find(name), std::string::npos) << error.what();
      return std::string(error.found());
    }
    return std::string("taken");
  };
  Json model = twin_model();
  model.erase("Chiller:Electric:EIR");
  EXPECT_NE(refuse(model, "chiller_cop").find("Chiller:Electric:EIR"), std::string::npos);
  model = twin_model();
  model["Chiller:Electric:EIR"]["Chiller"].erase("reference_cop");
  EXPECT_NE(refuse(model, "chiller_cop").find("default"), std::string::npos);
  model["Chiller:Electric:EIR"]["Chiller"]["reference_cop"] = "Autosize";
  EXPECT_NE(refuse(model, "chiller_cop").find("Autosize"), std::string::npos);
}

}  // namespace
}  // namespace airside::sim
