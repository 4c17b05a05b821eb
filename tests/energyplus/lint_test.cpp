#include <unistd.h>

#include <fstream>

#include "energyplus/engine.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/json/merge_patch.hpp"

namespace airside::sim {
namespace {

using nlohmann::json;

/// A schema in the engine's own form, so that the rules are tested where no engine is installed.
class SmallSchema {
 public:
  SmallSchema() : path_(std::filesystem::path(testing::TempDir()) / ("airside-schema-" + std::to_string(getpid()))) {
    std::ofstream(path_) << R"({"properties": {
      "Zone": {"name": {"reference": ["ZoneNames"]}, "patternProperties": {"^.*$": {"type": "object",
        "properties": {"x_origin": {"type": "number"}, "multiplier": {"type": "integer", "minimum": 1}}}}},
      "People": {"name": {"reference": ["PeopleNames"]}, "patternProperties": {"^.*$": {"type": "object",
        "properties": {
          "zone_name": {"type": "string", "object_list": ["ZoneNames"]},
          "method": {"type": "string", "enum": ["", "People", "People/Area"]},
          "number_of_people": {"anyOf": [{"type": "number", "minimum": 0.0},
                                         {"type": "string", "enum": ["Autosize"]}]},
          "fraction_radiant": {"type": "number", "exclusiveMinimum": 0, "maximum": 1.0},
          "steps": {"type": "array", "items": {"type": "object", "required": ["hour"],
                    "properties": {"hour": {"type": "number"}}}}},
        "required": ["zone_name"]}}},
      "Building": {"patternProperties": {".*": {"type": "object", "properties": {}}}},
      "GlobalGeometryRules": {"patternProperties": {".*": {"type": "object", "properties": {}}}},
      "Version": {"patternProperties": {".*": {"type": "object", "properties": {}}}},
      "RunPeriod": {"patternProperties": {".*": {"type": "object", "properties": {}}}},
      "Timestep": {"patternProperties": {".*": {"type": "object", "properties": {}}}}}})";
  }
  ~SmallSchema() { std::filesystem::remove(path_); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

const std::filesystem::path& small_schema() {
  static const SmallSchema schema;
  return schema.path();
}

json whole_model() {
  return json::parse(R"({"Building": {"b": {}}, "GlobalGeometryRules": {"g": {}}, "Version": {"v": {}},
    "RunPeriod": {"r": {}}, "Timestep": {"t": {}}, "Zone": {"Interior 1": {"x_origin": 0, "multiplier": 1}},
    "People": {"p": {"zone_name": "interior 1", "method": "People/Area", "number_of_people": 4,
                     "fraction_radiant": 0.3, "steps": [{"hour": 7}]}}})");
}

std::string first(const json& model, LintScope scope = LintScope::whole) {
  const auto complaints = epjson_complaints(model, small_schema(), {"model.epJSON", scope});
  return complaints.empty() ? "" : complaints.front().what();
}

std::string with(const char* patch) { return first(merge_patched(whole_model(), json::parse(patch), "patch")); }

void expect_parts(const std::string& message, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
}

TEST(EpjsonLint, PassesAModelThatFitsTheSchema) { EXPECT_EQ(first(whole_model()), ""); }

TEST(EpjsonLint, FindsAMisspeltFieldAndSuggestsTheRightOne) {
  expect_parts(with(R"({"People": {"p": {"fraction_radiat": 0.5}}})"),
               {"model.epJSON", "People / p / fraction_radiat", "'fraction_radiant'"});
}

TEST(EpjsonLint, FindsAnUnknownObjectType) { expect_parts(with(R"({"Peolpe": {"p": {}}})"), {"Peolpe", "'People'"}); }

TEST(EpjsonLint, FindsAWrongType) {
  expect_parts(with(R"({"Zone": {"Interior 1": {"x_origin": "0"}}})"), {"x_origin", "a number"});
  expect_parts(with(R"({"Zone": {"Interior 1": {"multiplier": 1.5}}})"), {"multiplier", "an integer"});
  expect_parts(with(R"({"Zone": {"Interior 1": 3}})"), {"Zone / Interior 1", "an object of fields"});
}

TEST(EpjsonLint, FindsAChoiceThatIsNotOffered) {
  expect_parts(with(R"({"People": {"p": {"method": "Peple/Area"}}})"), {"Peple/Area", "'People/Area'"});
  expect_parts(with(R"({"People": {"p": {"number_of_people": "Autosise"}}})"), {"Autosise", "'Autosize'"});
  EXPECT_EQ(with(R"({"People": {"p": {"number_of_people": "Autosize"}}})"), "");
}

TEST(EpjsonLint, FindsNumbersOutOfBounds) {
  expect_parts(with(R"({"People": {"p": {"fraction_radiant": 1.5}}})"), {"1.5", "of at most 1.0"});
  expect_parts(with(R"({"People": {"p": {"fraction_radiant": 0}}})"), {"above 0"});
  expect_parts(with(R"({"People": {"p": {"number_of_people": -2}}})"), {"-2", "at least 0"});
}

TEST(EpjsonLint, FindsAMissingFieldInAWholeModelOnly) {
  const char* lacking = R"({"People": {"q": {"method": "People"}}})";
  expect_parts(with(lacking), {"People / q", "'zone_name'"});
  EXPECT_EQ(first(json::parse(lacking), LintScope::patch), "");
}

TEST(EpjsonLint, FindsANameThatNothingDefines) {
  expect_parts(with(R"({"People": {"p": {"zone_name": "Interior 11"}}})"),
               {"Interior 11", "ZoneNames", "'Interior 1'"});
}

TEST(EpjsonLint, LooksIntoArrays) {
  expect_parts(with(R"({"People": {"p": {"steps": [{"hour": 7}, {"huor": 8}]}}})"), {"steps[1] / huor", "'hour'"});
}

TEST(EpjsonLint, LetsAPatchRemoveThings) {
  EXPECT_EQ(first(json::parse(R"({"People": {"p": null}, "Zone": {"z": {"x_origin": null}}})"), LintScope::patch), "");
}

TEST(EpjsonLint, CountsWhatElseIsWrong) {
  const json bad = merge_patched(whole_model(), json::parse(R"({"People": {"p": {"a": 1, "b": 2, "c": 3}}})"), "p");
  expect_parts(message_of([&bad] {
                 lint_epjson(bad, small_schema(), {"model.epJSON", LintScope::whole});
               }),
               {"2 more"});
}

TEST(EpjsonLint, PassesTheTwinAndEveryRoom) {
  AIRSIDE_NEEDS_ENGINE();
  const auto schema = find_energyplus().schema;
  std::vector<std::string> names = energyplus_room_names();
  names.insert(names.end(), {"tuning_0", "tuning_199"});
  for (const auto& name : names) {
    const EnergyPlusOptions options = energyplus_room(name);
    for (const auto& patch : options.patches) {
      for (const auto& complaint : epjson_complaints(patch.content, schema, {patch.name, LintScope::patch}))
        ADD_FAILURE() << complaint.what();
    }
    EnergyPlusOptions unchecked = options;
    unchecked.lint = false;
    for (const auto& complaint : epjson_complaints(compose_model(unchecked, schema), schema, {name, LintScope::whole}))
      ADD_FAILURE() << complaint.what();
  }
}

TEST(EpjsonLint, FindsMistakesInRealPatchesBeforeTheEngineStarts) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusOptions options = one_day();
  options.patches.push_back(
      {"mine.json", json::parse(R"({"People": {"Interior 1 People": {"people_per_floor_aera": 0.2}}})")});
  expect_parts(message_of([&options] { EnergyPlusPlant plant(options); }),
               {"mine.json", "people_per_floor_aera", "'people_per_floor_area'"});
  options.patches.back().content =
      json::parse(R"({"People": {"Interior 1 People": {"number_of_people_schedule_name": "Interior 1 Ocupancy"}}})");
  expect_parts(message_of([&options] { EnergyPlusPlant plant(options); }), {"Interior 1 Ocupancy", "ScheduleNames"});
}

}  // namespace
}  // namespace airside::sim
