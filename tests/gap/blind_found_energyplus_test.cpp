// Effects hidden in EnergyPlus rooms by other objects than the library's, found by the workflow on the EnergyPlus twin.
// One case with few effects always; AIRSIDE_HIDDEN_ENERGYPLUS=DIR hides 28 effects at three times the noise, half of
// them with feedback, judges them with the whole library, prints a line as each is judged and expects 20 to be found,
// one of each kind of channel among them (half an hour of one core; DIR keeps cases, runs and table).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "gap/needs_engine.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/json/json_file.hpp"
#include "support/test_folder.hpp"
#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/case/case_loader.hpp"
#include "tools/gap/surrogate/asked_model.hpp"

namespace airside::tools::gap {
namespace {

namespace fs = std::filesystem;

std::vector<sim::Effect> effects_of(const std::set<std::string>& names) {
  auto effects = sim::load_effects(sim::find_effects());
  if (!names.empty()) std::erase_if(effects, [&names](const sim::Effect& e) { return !names.contains(e.name); });
  return effects;
}

BlindPlan plan_of_hidden(const std::vector<std::string>& kinds, int days) {
  BlindPlan plan;
  plan.engine = BlindEngine::energyplus;
  plan.single = static_cast<int>(kinds.size());
  plan.kinds = kinds;
  plan.ratio = 3;
  plan.window = 3;
  plan.days = days;
  plan.seed = 11;
  plan.jobs = 1;
  return plan;
}

/// A case's answer beside its verdict.
struct Judged {
  std::string truth, channel;
  bool feedback = false, first = false, in_class = false;
  double room_temp = 0;  ///< of the closed loop: what the rooms' temperatures alone show, over the noise
  VerdictKind verdict = VerdictKind::none;

  bool found() const { return first || in_class; }
};

/// Where a case shows: with feedback in the closed loop, else in the replay by which it was sized.
std::string channel_kind(const nlohmann::json& answer) {
  const nlohmann::json& hidden = answer["hidden"][0];
  if (hidden["id"] == "clock_shift") return "clock";
  std::string kind = hidden["shows_in"];
  double most = 0;
  for (const char* name : {"room_temp", "fcu_temp", "mau_temp", "power", "fcu_duty"}) {
    if (!answer.contains("live") || answer["live"][name]["ratio"].get<double>() <= most) continue;
    most = answer["live"][name]["ratio"];
    kind = name;
  }
  return kind.starts_with("mau")     ? "MAU"
         : kind.starts_with("power") ? "power"
         : kind.starts_with("fcu_d") ? "duty"
                                     : "temperature";
}

Judged judged(const nlohmann::json& answer, const Verdict& verdict, const WindowResponses& responses,
              std::FILE* table) {
  const nlohmann::json& hidden = answer["hidden"][0];
  Judged j;
  j.truth = hidden["id"];
  j.channel = channel_kind(answer);
  j.feedback = answer["feedback"];
  j.verdict = verdict.kind;
  if (answer.contains("live")) j.room_temp = answer["live"]["room_temp"]["ratio"];
  std::string first = "-", others;
  double log_likelihood_ratio = verdict.best_log_likelihood_ratio, magnitude = 0;
  if (!verdict.findings.empty()) {
    const Finding& f = verdict.findings.front();
    first = f.at.id();
    log_likelihood_ratio = f.log_likelihood_ratio;
    magnitude = f.magnitude;
    for (const sim::EffectAt& at : f.cannot_tell_from) {
      others += " " + at.id();
      j.in_class = j.in_class || at.id() == j.truth;
    }
  }
  j.first = first == j.truth;
  std::string best = "-";
  if (!verdict.ranking.empty()) best = responses.test.candidates[verdict.ranking.front().candidate].at.id();
  std::fprintf(table, "%-24s %8.4g x%-5.2f %-8s %-11s rooms %4.2f | %-9s %-24s %8.4g gain %7.0f %s%s%s\n",
               j.truth.c_str(), hidden["magnitude"].get<double>(), hidden["achieved_ratio"].get<double>(),
               j.feedback ? "feedback" : "open", j.channel.c_str(), j.room_temp, text_of(verdict.kind), first.c_str(),
               magnitude, log_likelihood_ratio,
               j.first           ? "first"
               : j.in_class      ? "in the class"
               : best == j.truth ? "first of the ranking"
                                 : "missed",
               others.empty() ? "" : ", class:", others.c_str());
  std::fprintf(table, "  %s; leftover %.2f of %.2f\n", verdict.reason.c_str(), verdict.residual_ratio,
               verdict.residual_ratio_limit);
  std::fflush(table);
  return j;
}

/// Makes the cases unless they are there, and judges them.
std::vector<Judged> judge_all(const BlindPlan& plan, const std::vector<sim::Effect>& effects, const fs::path& folder,
                              bool duties, std::FILE* table) {
  const fs::path cases = folder / "cases", key = folder / "key.json";
  fs::create_directories(folder);
  if (!fs::exists(key)) make_blind_cases(plan, effects, cases, key);
  const nlohmann::json answers = sim::read_json(key)["cases"];
  std::vector<Judged> all;
  for (const fs::path& path : case_folders(cases)) {
    CaseDescription description = read_case(path);
    description.duties = description.duties && duties;
    const LoadedCase c = load_case(description, path.filename().string(), plan.cache);
    AskedModel asked(*c.engine);
    WindowResponses responses = asked.responses(library_of(asked.engine(), effects), c.data, plan.jobs);
    Rules rules;
    rules.buildings = asked.engine().usual_buildings();
    const Verdict verdict = asked.analyse(c.data, responses, rules, plan.jobs);
    all.push_back(judged(answers[c.name], verdict, responses, table));
  }
  return all;
}

/// Feedback holds the rooms: their temperatures show less than the noise, and the clock's error is named all the same.
TEST(HiddenOnEnergyPlus, ClockThatRoomTemperaturesDoNotShowIsNamed) {
  AIRSIDE_NEEDS_ENGINE();
  const hal::TestFolder folder("hidden_ep");
  const auto effects = effects_of({"clock_shift", "mau_setpoint", "gain_occupied"});
  BlindPlan plan = plan_of_hidden({"clock_shift"}, 3);
  plan.rough = true;
  plan.cache = folder.file("runs");
  const auto all = judge_all(plan, effects, folder.file("set"), false, stdout);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_TRUE(all[0].feedback);
  EXPECT_LT(all[0].room_temp, 1);
  EXPECT_TRUE(all[0].first);
  EXPECT_EQ(all[0].verdict, VerdictKind::named);
}

TEST(HiddenOnEnergyPlus, TwentyEffectsAreFoundInEveryKindOfChannel) {
  AIRSIDE_NEEDS_ENGINE();
  const char* folder = std::getenv("AIRSIDE_HIDDEN_ENERGYPLUS");
  if (folder == nullptr) GTEST_SKIP() << "set AIRSIDE_HIDDEN_ENERGYPLUS to a folder to hide 28 effects and find 20";
  // By turns with feedback and without.
  BlindPlan plan = plan_of_hidden({"fcu_degraded",
                                   "chiller_cop",
                                   "clock_shift",
                                   "mau_capacity",
                                   "mau_setpoint",
                                   "gain_occupied",
                                   "fan_power",
                                   "gain_after_hours",
                                   "solar_gain",
                                   "room_sensor_lag",
                                   "gain_zone",
                                   "room_sensor_jet",
                                   "vav_flow",
                                   "vav_stuck",
                                   "room_sensor_bias",
                                   "duct_heat_gain",
                                   "infiltration_wind",
                                   "fcu_rests_unrecorded",
                                   "fcu_runs_unrecorded",
                                   "room_sensor_drift",
                                   "outdoor_air_flow",
                                   "setpoint_lag",
                                   "supply_sensor_offset",
                                   "thermal_mass",
                                   "gain_base",
                                   "duct_leak",
                                   "sun_differs",
                                   "outdoor_sensor_bias"},
                                  10);
  plan.cache = fs::path(folder) / "runs";
  fs::create_directories(plan.cache);
  std::FILE* table = std::fopen((fs::path(folder) / "table.txt").c_str(), "w");
  ASSERT_NE(table, nullptr);
  const auto all = judge_all(plan, effects_of({}), folder, true, table);
  std::fclose(table);
  std::set<std::string> found, with_feedback, channels;
  int unseen = 0;
  for (const Judged& j : all) {
    const std::string effect = j.truth.substr(0, j.truth.find('@'));
    if (!j.found()) continue;
    found.insert(effect);
    channels.insert(j.channel);
    if (j.feedback) with_feedback.insert(effect);
    if (j.feedback && j.room_temp < 1) ++unseen;
  }
  std::printf("%zu of %zu effects found, %zu with feedback, %d of them with nothing in the room temperatures; %s\n",
              found.size(), all.size(), with_feedback.size(), unseen, (std::string(folder) + "/table.txt").c_str());
  EXPECT_GE(found.size(), 20U);
  EXPECT_GE(with_feedback.size(), 8U);
  EXPECT_GE(unseen, 5);
  EXPECT_EQ(channels, (std::set<std::string>{"temperature", "power", "duty", "MAU", "clock"}));
}

}  // namespace
}  // namespace airside::tools::gap
