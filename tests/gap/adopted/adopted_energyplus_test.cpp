// airside gap on a building that the project did not write, adopted as it is: an effect that was put into it by another
// object than the library's is found first, a building without one gets no name, and what it cannot have is listed.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "adopt/foreign_models.hpp"
#include "sim/effects/effect.hpp"
#include "sim/json/json_file.hpp"
#include "support/program.hpp"

namespace airside::tools::gap {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// One packaged unit of the DOE small office in Chicago, adopted; one room temperature, three meters.
class AdoptedDesk {
 public:
  AdoptedDesk() {
    const fs::path model = foreign_models() / "RefBldgSmallOfficeNew2004_Chicago.idf";
    run({"adopt", model.string(), "--air-loop", "PSZ-AC:1", "-o", "site"});
    fs::create_directory(path("effects"));
    for (const char* name :
         {"chiller_cop", "fan_power", "gain_base", "infiltration", "room_sensor_bias", "solar_gain", "vav_stuck"}) {
      json effect = sim::read_json(sim::find_effects() / (std::string(name) + ".json"));
      effect.erase("prior_sd");  // runs are dear here: one parameter is enough
      if (std::string(name) == "fan_power") effect["prior_sd"] = 0.08;
      std::ofstream(path("effects") / (std::string(name) + ".json")) << effect;
    }
    simulate("2021-07-05", "1", "reference.csv", json::object());
  }

  fs::path path(const std::string& name) const { return folder_.path() / name; }

  /// Eight days under the site's schedule, with further objects in the building.
  void simulate(const char* start, const char* seed, const char* log, const json& hidden) const {
    std::ofstream(path("hidden.json")) << hidden;
    run({"simulate", "--site", "site/site.toml", "--twin", "--patch", "site/twin.patch.json", "hidden.json", "--method",
         "expert", "--start", start, "--seed", seed, "--expert-days", "8", "--days", "1", "--history-log", log});
  }

  json judged(const char* log) const {
    run({"gap", "--site", "site/site.toml", "--measured", log, "--reference", "reference.csv", "--effects", "effects",
         "--out", "out", "--cache", "runs", "--jobs", "1"});
    return sim::read_json(path("out") / "gap.json");
  }

 private:
  void run(const std::vector<std::string>& words) const {
    const Outcome o = run_program("airside", words, folder_.path(), scratch_.path(), 400);
    if (o.code != 0) throw std::runtime_error(words.front() + ": " + o.err);
  }

  TemporaryFolder folder_, scratch_;
};

TEST(AdoptedModel, WornFanIsNamedNothingHasNoNameAndAbsentPartsAreListed) {
  AIRSIDE_NEEDS_FOREIGN_MODELS();
  const AdoptedDesk desk;
  // The library would raise the fan's pressure and power: here its efficiency is lower, at the same pressure.
  constexpr double worse = 1.35;
  const json fan = sim::read_json(desk.path("site") / "twin.patch.json")["Fan:SystemModel"]["PSZ-AC:1_Fan"];
  const double kw = fan["design_electric_power_consumption"];
  desk.simulate("2021-07-14", "7", "measured.csv",
                {{"Fan:SystemModel",
                  {{"PSZ-AC:1_Fan",
                    {{"fan_total_efficiency", 0.53625 / worse}, {"design_electric_power_consumption", kw * worse}}}}}});
  const json found = desk.judged("measured.csv");
  EXPECT_EQ(found["verdict"], "named") << found["sentence"];
  ASSERT_FALSE(found["effects"].empty()) << found["sentence"];
  EXPECT_EQ(found["effects"][0]["id"], "fan_power") << found["sentence"];
  EXPECT_NEAR(found["effects"][0]["magnitude"].get<double>(), worse, 0.03);
  EXPECT_NE(found["own_control"], nullptr);
  std::set<std::string> absent;
  for (const json& n : found["not_applicable"]) absent.insert(n["id"]);
  EXPECT_EQ(absent, (std::set<std::string>{"solar_gain", "vav_stuck"})) << found["not_applicable"];
  for (const json& d : found["detectable"]) {
    if (d["id"] != "fan_power") continue;
    EXPECT_TRUE(d["visible"]) << d;
  }

  desk.simulate("2021-07-14", "6", "quiet.csv", json::object());
  const json quiet = desk.judged("quiet.csv");
  EXPECT_TRUE(quiet["effects"].empty()) << quiet["sentence"];
  EXPECT_EQ(quiet["verdict"], "none") << quiet["sentence"];
}

}  // namespace
}  // namespace airside::tools::gap
