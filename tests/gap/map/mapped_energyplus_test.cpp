// airside gap --map on a building of others with three room temperatures and one meter, by the hour and in the reader's
// own units: a fault of other objects than the library's is found, and names that are not there are refused.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>

#include "adopt/foreign_models.hpp"
#include "sim/effects/effect.hpp"
#include "sim/energyplus/replay/eso.hpp"
#include "sim/json/json_file.hpp"
#include "sim/weather/weather.hpp"
#include "support/program.hpp"
#include "tools/adopt/model/engine_run.hpp"
#include "tools/adopt/model/foreign_file.hpp"

namespace airside::tools::gap {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* logged_zones[] = {"Core_ZN", "Perimeter_ZN_1", "Perimeter_ZN_3"};
constexpr int logged_days = 8, steps_an_hour = 6;

/// The DOE small office in Chicago as its owner has it: an IDF, a weather file, and logs that the engine itself made.
class OwnersDesk {
 public:
  OwnersDesk()
      : idf_(foreign_models() / "RefBldgSmallOfficeNew2004_Chicago.idf"),
        weather_(foreign_models().parent_path() / "weather" / "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw"),
        model_(read_foreign_model(idf_, install_).content) {
    fs::create_directory(path("effects"));
    for (const char* name : {"chiller_cop", "fan_power", "gain_base", "infiltration", "room_sensor_bias",
                             "setpoint_lag", "outdoor_sensor_bias"}) {
      json effect = sim::read_json(sim::find_effects() / (std::string(name) + ".json"));
      effect.erase("prior_sd");  // runs are dear here: one parameter is enough
      if (std::string(name) == "fan_power") effect["prior_sd"] = 0.08;
      std::ofstream(path("effects") / (std::string(name) + ".json")) << effect;
    }
    write_map("Electricity:HVAC", "Core_ZN");
  }

  fs::path path(const std::string& name) const { return folder_.path() / name; }
  const json& model() const { return model_; }

  void write_map(const std::string& meter, const std::string& core, const std::string& more = "") const {
    std::ofstream out(path("map.toml"));
    out << fmt::format("[model]\nfile = \"{}\"\n[weather]\nfile = \"{}\"\n", idf_.string(), weather_.string())
        << "[log]\ntime = \"Date/Time\"\nformat = \"%m/%d/%Y %H:%M\"\nstep_min = 60\n";
    for (const char* zone : logged_zones) {
      const std::string name = zone == logged_zones[0] ? core : zone;
      out << fmt::format("[[channel]]\ncolumn = \"{} F\"\nzone = \"{}\"\nunit = \"degF\"\n", zone, name);
    }
    const std::string object = meter.starts_with('[') ? "meters = " + meter : "meter = \"" + meter + "\"";
    out << "[[channel]]\ncolumn = \"kWh\"\nkind = \"power\"\nunit = \"kWh\"\n" << object << "\n";
    out << more;
  }

  /// Days of the model, by the hour, with noise of 0.05 K.
  void simulate(json model, int day, unsigned seed, const std::string& log) const {
    prepare(model, day);
    std::ofstream(path("run.epJSON")) << model;
    const EngineRun run =
        run_engine_program(install_.folder / "energyplus",
                           {"-w", weather_.string(), "-d", path("run").string(), "run.epJSON"}, folder_.path());
    if (!run.done) throw std::runtime_error(run.words);
    const sim::EsoFile eso(path("run") / "eplusout.eso", sim::EsoFile::Periods::last);
    std::ofstream out(path(log));
    out << "Date/Time";
    for (const char* zone : logged_zones) out << "," << zone << " F";
    out << ",kWh\n";
    std::mt19937_64 bits(seed);
    std::normal_distribution<double> noise(0, 0.05);
    for (int h = 1; h <= 24 * logged_days; ++h) {
      const std::string t = sim::text_of({sim::civil_midnight(2021, 7, day).seconds + h * 3600LL});
      out << fmt::format("{}/{}/{} {}", t.substr(5, 2), t.substr(8, 2), t.substr(0, 4), t.substr(11, 5));
      const auto end = static_cast<std::size_t>(h * steps_an_hour);
      for (const char* zone : logged_zones) {
        const double degc = eso.of(std::string(zone) + ",Zone Mean Air Temperature")[end - 1] + noise(bits);
        out << fmt::format(",{:.2f}", degc * 1.8 + 32);
      }
      double joule = 0;
      for (std::size_t i = end - steps_an_hour; i < end; ++i) joule += eso.of("Electricity:HVAC")[i];
      out << fmt::format(",{:.4f}\n", joule / 3.6e6);
    }
  }

  Outcome run(const std::vector<std::string>& words) const {
    return run_program("airside", words, folder_.path(), scratch_.path(), 600);
  }

  Outcome gap(const std::string& log) const {
    return run_program("airside",
                       {"gap", "--map", "map.toml", "--measured", log, "--reference", "reference.csv", "--effects",
                        "effects", "--out", "out", "--cache", "runs", "--jobs", "1"},
                       folder_.path(), scratch_.path(), 1500);
  }

 private:
  static void prepare(json& model, int day) {
    for (auto it = model.begin(); it != model.end();) it = it.key().starts_with("Output:") ? model.erase(it) : ++it;
    model.erase("RunPeriodControl:DaylightSavingTime");
    model["Timestep"] = {{"steps", {{"number_of_timesteps_per_hour", steps_an_hour}}}};
    model["RunPeriod"] = {{"days",
                           {{"begin_year", 2021},
                            {"begin_month", 7},
                            {"begin_day_of_month", day},
                            {"end_year", 2021},
                            {"end_month", 7},
                            {"end_day_of_month", day + logged_days - 1}}}};
    for (const char* zone : logged_zones) {
      model["Output:Variable"][zone] = {
          {"key_value", zone}, {"variable_name", "Zone Mean Air Temperature"}, {"reporting_frequency", "Timestep"}};
    }
    model["Output:Meter"]["kWh"] = {{"key_name", "Electricity:HVAC"}, {"reporting_frequency", "Timestep"}};
    json& control = model["SimulationControl"].begin().value();
    control["run_simulation_for_sizing_periods"] = "No";
    control["run_simulation_for_weather_file_run_periods"] = "Yes";
  }

  TemporaryFolder folder_, scratch_;
  sim::EnergyPlusInstall install_ = sim::find_energyplus();
  fs::path idf_, weather_;
  json model_;
};

TEST(MappedModel, ThreeTemperaturesAndOneMeterByTheHourFindAWornFan) {
  AIRSIDE_NEEDS_FOREIGN_MODELS();
  const OwnersDesk desk;
  desk.simulate(desk.model(), 5, 1, "reference.csv");
  // The library would raise pressure and power: here the efficiency is lower, at the same pressure.
  constexpr double worse = 1.35;
  json worn = desk.model();
  for (auto& [type, fans] : worn.items()) {
    if (!type.starts_with("Fan:")) continue;
    for (json& fan : fans) fan["fan_total_efficiency"] = fan["fan_total_efficiency"].get<double>() / worse;
  }
  desk.simulate(worn, 14, 2, "measured.csv");
  const Outcome done = desk.gap("measured.csv");
  ASSERT_EQ(done.code, 0) << done.err;
  const json found = sim::read_json(desk.path("out") / "gap.json");
  EXPECT_NE(found["verdict"], "none") << found["sentence"];
  ASSERT_FALSE(found["effects"].empty()) << found["sentence"];
  EXPECT_EQ(found["effects"][0]["id"], "fan_power") << found["sentence"];
  EXPECT_NEAR(found["effects"][0]["magnitude"].get<double>(), worse, 0.1);
  EXPECT_EQ(found["own_control"].get<std::string>().rfind("No recorded command is played.", 0), 0U);
  EXPECT_EQ(found["map"]["channels"].size(), 4U);
  EXPECT_NE(done.out.find("power 1: column \"kWh\", meter Electricity:HVAC"), std::string::npos) << done.out;
  std::map<std::string, std::string> absent;
  for (const json& n : found["not_applicable"]) absent[n["id"]] = n["why"];
  EXPECT_EQ(absent["outdoor_sensor_bias"], "the log has no outdoor temperature");
  EXPECT_EQ(absent["setpoint_lag"], "no recorded supply setpoint is played");
}

TEST(MappedModel, ALogInWhichNothingIsHiddenGetsNoName) {
  AIRSIDE_NEEDS_FOREIGN_MODELS();
  const OwnersDesk desk;
  desk.write_map(R"(["Fans:Electricity", "Cooling:Electricity"])", "Core_ZN");  // in July there is nothing else
  desk.simulate(desk.model(), 5, 1, "reference.csv");
  desk.simulate(desk.model(), 14, 3, "quiet.csv");
  const Outcome nothing = desk.gap("quiet.csv");
  ASSERT_EQ(nothing.code, 0) << nothing.err;
  const json quiet = sim::read_json(desk.path("out") / "gap.json");
  EXPECT_NE(quiet["verdict"], "named") << quiet["sentence"];
  const double missed_kw = quiet["locked_days"]["given"]["power_rmse_kw"];
  EXPECT_LT(missed_kw, 0.2) << "the sum of two meters is the log's one; its steps were others";
}

/// Energy of an hourly log, in bills of two days.
void write_bills(const OwnersDesk& desk, const std::string& log, const std::string& bills) {
  constexpr int days_a_bill = 2;
  std::ifstream in(desk.path(log));
  std::ofstream out(desk.path(bills));
  out << "from,to,kWh\n";
  std::string line;
  std::getline(in, line);
  std::string from;
  double sum = 0;
  for (int hour = 0; std::getline(in, line); ++hour) {
    const std::string date = fmt::format("2021-07-{:02}", 5 + hour / 24);  // a row stands for the hour before it
    if (hour % (24 * days_a_bill) == 0) from = date;
    sum += std::stod(line.substr(line.rfind(',') + 1));
    if ((hour + 1) % (24 * days_a_bill) != 0) continue;
    out << fmt::format("{},{},{:.2f}\n", from, date, sum);
    sum = 0;
  }
}

TEST(MappedModel, BillsAloneAgreeWithARightModelAndSayWhatTheyCouldShow) {
  AIRSIDE_NEEDS_FOREIGN_MODELS();
  const OwnersDesk desk;
  desk.simulate(desk.model(), 5, 1, "right.csv");
  write_bills(desk, "right.csv", "bills.csv");
  const auto of_bills = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"gap",     "bills",  "bills.csv", "--map", "map.toml", "--effects",
                                   "effects", "--jobs", "2",         "--out", "bills"};
    words.insert(words.end(), more.begin(), more.end());
    return desk.run(words);
  };
  const Outcome right = of_bills({"--json"});
  ASSERT_EQ(right.code, 0) << right.err;
  const json j = json::parse(right.out);
  EXPECT_EQ(j, sim::read_json(desk.path("bills") / "bills.json"));
  EXPECT_LT(std::abs(j["meters"][0]["nmbe_percent"].get<double>()), 4) << "the model's own bills";
  EXPECT_EQ(j["set"][0], "nothing") << j["sentence"];
  EXPECT_EQ(j["meters"][0]["bills"].size(), 4U);
  EXPECT_TRUE(fs::exists(desk.path("bills") / "bills.svg"));
  for (const json& c : j["candidates"]) EXPECT_NE(c["id"], "room_sensor_bias@1") << "sensors show in no bill";
  const Outcome words = of_bills({"--reference", "bills.csv"});
  ASSERT_EQ(words.code, 0) << words.err;
  EXPECT_NE(words.out.find("what these bills could show: "), std::string::npos) << words.out;
  std::ofstream(desk.path("bills.csv")) << "from,to,gas\n";
  const Outcome refused = of_bills({});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("bills.csv:1: header"), std::string::npos) << refused.err;
}

TEST(MappedModel, NamesThatAreNotThereAreRefusedWithTheNearest) {
  AIRSIDE_NEEDS_FOREIGN_MODELS();
  const OwnersDesk desk;
  std::ofstream(desk.path("reference.csv")) << "Date/Time\n";
  const auto said = [&](const std::string& meter, const std::string& core, const std::string& more = "") {
    desk.write_map(meter, core, more);
    const Outcome o = desk.gap("reference.csv");
    EXPECT_EQ(o.code, 1) << o.out;
    return o.err;
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const std::string zone = said("Electricity:HVAC", "Core");
  EXPECT_TRUE(has(zone, "channel[1].zone: found no \"Core\"") && has(zone, "\"Core_ZN\"")) << zone;
  const std::string meter = said("Electricity:HVACs", "Core_ZN");
  EXPECT_TRUE(has(meter, "channel[4].meter: found no meter") && has(meter, "near it: \"Electricity:HVAC\"")) << meter;
  const std::string sum = said(R"(["Fans:Electricity", "Cooling:Elektricity"])", "Core_ZN");
  EXPECT_TRUE(has(sum, "channel[4].meters: found no meter \"Cooling:Elektricity\"")) << sum;
  const std::string schedule =
      said("Electricity:HVAC", "Core_ZN", "[[command]]\ncolumn = \"x\"\nschedule = \"HVACOperationSched\"\n");
  EXPECT_TRUE(has(schedule, "command[1].schedule") && has(schedule, "\"HVACOperationSchd\"")) << schedule;
  const std::string power = "[[channel]]\ncolumn = \"y\"\nkind = \"power\"\n";
  const std::string variable =
      said("Electricity:HVAC", "Core_ZN", power + "output = \"Fan Electricity Rates\"\nkey = \"PSZ-AC:1_Fan\"\n");
  EXPECT_TRUE(has(variable, "channel[5].output") && has(variable, "\"Fan Electricity Rate\"")) << variable;
  const std::string key =
      said("Electricity:HVAC", "Core_ZN", power + "output = \"Fan Electricity Rate\"\nkey = \"PSZ-AC:1 Fan\"\n");
  EXPECT_TRUE(has(key, "channel[5].key") && has(key, "PSZ-AC:1_FAN")) << key;
}

}  // namespace
}  // namespace airside::tools::gap
