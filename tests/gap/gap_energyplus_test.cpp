// airside gap on an EnergyPlus log: what it says about the patched twin is what plain `energyplus` makes of the files
// that it leaves; and the weights that the patch is worth come from those files too.

#include <gtest/gtest.h>
#include <spawn.h>

#include <cmath>
#include <cstdio>

#include "gap/gap_desk.hpp"
#include "gap/needs_engine.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/replay/eso.hpp"
#include "sim/energyplus/replay/replay_files.hpp"
#include "tools/gap/blind/blind_energyplus.hpp"

namespace airside::tools::gap {
namespace {

/// A folder with what a person has of room 301: a site file, weather, two effects and two logs of an EnergyPlus room
/// in which machines run that the twin does not know.
class EngineDesk {
 public:
  explicit EngineDesk(int days) : effects_(sim::load_effects(sim::find_effects())) {
    sim::write_epw(path("w.epw").string(), *sim::synthetic_weather(5), 2021);
    std::ofstream(path("site.toml")) << "[site]\nname = \"Desk 301\"\ntopology = \"5vav-5fcu-2power\"\n[twin]\nmodel = "
                                        "\"301\"\nweather = \"w.epw\"\n";
    fs::create_directory(path("effects"));
    for (const char* name : {"gain_base", "infiltration"}) {
      const std::string file = std::string(name) + ".json";
      json effect = sim::read_json(sim::find_effects() / file);
      if (file == "gain_base.json") effect.erase("prior_sd");  // one parameter is enough: runs are dear here
      std::ofstream(path("effects") / file) << effect;
    }
    const EnergyPlusRoom room = energyplus_measured_room("301", 3, false);
    MeasuredRun run{sim::civil_midnight(2021, 7, 6), days, 4, false, 0};
    log("reference.csv", measure(room, path("w.epw"), run));
    run.start.seconds += days * seconds_per_day;
    log("measured.csv", measure(hide(room, {{"gain_base", 0, 12}}, effects_, 4), path("w.epw"), run));
  }

  fs::path path(const std::string& name) const { return folder_.path() / name; }
  json read(const std::string& name) const { return sim::read_json(path(name)); }
  Outcome run(const std::string& words) const {
    std::istringstream in("gap " + words);
    return run_program("airside", {std::istream_iterator<std::string>(in), {}}, folder_.path(), scratch_.path(), 300);
  }

 private:
  void log(const std::string& name, const std::vector<hal::LogRow>& rows) const {
    hal::LogWriter writer(path(name).string(), {"", 5, 5, 2}, false);
    for (const hal::LogRow& row : rows) writer.append(row);
    writer.close();
  }

  std::vector<sim::Effect> effects_;
  TemporaryFolder folder_, scratch_;
};

/// The engine's own program, and nothing of airside. Returns its exit code.
int plain_energyplus(const fs::path& folder) {
  const std::string program = (sim::find_energyplus().folder / "energyplus").string();
  const std::string command =
      "cd '" + folder.string() + "' && '" + program + "' -w weather.epw -d again model.epJSON > /dev/null 2>&1";
  return std::system(command.c_str());
}

/// Half-hour means of an output over the measured days, read as a person would: rows are 6 min apart, steps 3 min; a
/// row shows the step that ends at its time.
std::vector<double> half_hours(const sim::EsoFile& outputs, const std::string& name, double factor, std::size_t bins) {
  const std::vector<double>& steps = outputs.of(name);
  std::vector<double> means(bins, 0);
  for (std::size_t row = 0; row < 5 * bins; ++row) {
    means[row / 5] += steps.at(static_cast<std::size_t>(sim::replay_lead_days) * 480 + 2 * row - 1) * factor / 5;
  }
  return means;
}

TEST(GapOnEnergyPlus, PlainEnergyPlusGivesTheAfterCurve) {
  AIRSIDE_NEEDS_ENGINE();
  constexpr int days = 3;
  const EngineDesk desk(days);
  const Outcome o = desk.run(
      "--site site.toml --measured measured.csv --reference reference.csv --effects effects --no-duties --best-guess "
      "--keep-run kept --out out --apply patched.epJSON --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json j = json::parse(o.out);
  EXPECT_EQ(j, desk.read("out/gap.json"));
  ASSERT_FALSE(j["effects"].empty()) << j["sentence"];
  EXPECT_EQ(j["effects"][0]["id"], "gain_base") << j["sentence"];

  // What was kept is the model that was applied, with the commands of the log.
  json kept = desk.read("kept/model.epJSON");
  const json patch = desk.read("out/twin-patch.json");
  EXPECT_FALSE(patch.empty());
  json again = kept;
  again.merge_patch(patch);
  EXPECT_EQ(again, kept);
  const json applied = desk.read("patched.epJSON");
  for (const char* zone : {"Interior 1", "Interior 5", "Perimeter 3"}) {
    const std::string name = std::string(zone) + " Base Gain";
    EXPECT_GT(kept["OtherEquipment"][name]["design_level"].get<double>(), 100) << name;
    EXPECT_EQ(kept["OtherEquipment"][name], applied["OtherEquipment"][name]);
  }

  ASSERT_EQ(plain_energyplus(desk.path("kept")), 0);
  const sim::EsoFile outputs(desk.path("kept") / "again" / "eplusout.eso");
  const json& curve = j["after_curve"];
  EXPECT_EQ(curve["from"], "2021-07-09T00:00:00");
  EXPECT_EQ(curve["step_s"], 1800);
  constexpr std::size_t bins = 48 * days;
  const auto compare = [&](const std::string& channel, const std::string& output, double factor) {
    ASSERT_TRUE(curve["channels"].contains(channel)) << channel << " is not in the report";
    const json& shown = curve["channels"][channel];
    const std::vector<double> repeated = half_hours(outputs, output, factor, bins);
    ASSERT_EQ(shown.size(), bins) << channel;
    double most = 0;
    for (std::size_t i = 0; i < bins; ++i) {
      most = std::max(most, std::abs(shown[i].get<double>() - repeated[i]));
    }
    std::printf("  %-20s differs by %.6f at most\n", channel.c_str(), most);
    EXPECT_LT(most, 0.51e-4) << channel << ": more than rounding";  // four decimals are shown
  };
  const sim::Channels at{5, 5, 2};
  for (int i = 0; i < 5; ++i) {
    const std::string n = std::to_string(i + 1);
    compare(at.name(i), "Interior " + n + ",Zone Mean Air Temperature", 1);
    compare(at.name(at.fcu_temp() + i), "Perimeter " + n + ",Zone Mean Air Temperature", 1);
  }
  compare(at.name(at.mau_temp()), "AHU Outside Air Inlet,System Node Temperature", 1);
  compare(at.name(at.supply_temp()), "AHU Supply Fan Outlet,System Node Temperature", 1);
  constexpr double kw_of_joule = 1 / (1000.0 * 180);
  compare(at.name(at.power()), "Electricity:HVAC", kw_of_joule);
  compare(at.name(at.power() + 1), "Electricity:Plant", kw_of_joule);

  // The page draws from the same numbers: measured minus after-curve is what is left.
  EXPECT_LT(j["locked_days"]["after"]["temp_rmse_k"].get<double>(),
            j["locked_days"]["before"]["temp_rmse_k"].get<double>());
}

TEST(GapOnEnergyPlus, RetrainsOnAPatchAsOnTheEffectItself) {
  AIRSIDE_NEEDS_ENGINE();
  TemporaryFolder folder, scratch;
  const sim::EnergyPlusOptions options = sim::energyplus_room("301");
  json model = sim::read_json(sim::find_models() / "twin.epJSON");
  for (const sim::ModelPatch& p : options.patches) model.merge_patch(p.content);
  const auto effects = sim::load_effects(sim::find_effects());
  const auto mass = std::ranges::find(effects, "thermal_mass", &sim::Effect::name);
  const sim::EffectChange change{{&*mass, 0}, 3};
  std::ofstream(folder.path() / "p.json") << sim::model_patch(model, options.names, std::span(&change, 1));
  const auto figures = [&](const std::string& rooms) {
    std::istringstream in("gap retrain --plant energyplus --twin 301 --seeds 1 --pretrain-days 3 --days 1 --json " +
                          rooms);
    const Outcome o =
        run_program("airside", {std::istream_iterator<std::string>(in), {}}, folder.path(), scratch.path());
    EXPECT_EQ(o.code, 0) << o.err;
    return o.code == 0 ? json::parse(o.out)["runs"] : json();
  };
  const json by_file = figures("--patched 301+p.json --measured 301+p.json");
  EXPECT_EQ(by_file, figures("--effect thermal_mass=3 --measured 301"));
  EXPECT_NE(by_file[0]["before"], by_file[0]["after"]);
}

}  // namespace
}  // namespace airside::tools::gap
