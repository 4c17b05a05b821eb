#include "tools/adopt/upgrade/upgrade.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "hal/text/input_error.hpp"
#include "tools/adopt/upgrade/rows.hpp"
#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools {

namespace {

const std::vector<upgrade::Step>& all_steps() {
  using namespace upgrade;
  static const std::vector<Step> steps = {step_to_9_0(),  step_to_9_1(),  step_to_9_2(),  step_to_9_3(),
                                          step_to_9_4(),  step_to_9_5(),  step_to_9_6(),  step_to_22_1(),
                                          step_to_22_2(), step_to_23_1(), step_to_23_2(), step_to_24_1(),
                                          step_to_24_2(), step_to_25_1(), step_to_25_2()};
  return steps;
}

/// The steps between two versions; empty where the tables do not lead there.
std::span<const upgrade::Step> steps_between(const std::string& from, const std::string& to) {
  const auto& steps = all_steps();
  const auto first = std::ranges::find(steps, from, [](const upgrade::Step& s) { return std::string(s.from); });
  const auto last = std::find_if(first, steps.end(), [&](const upgrade::Step& s) { return s.to == to; });
  if (last == steps.end()) return {};
  return {first, last + 1};
}

/// What else there is of refused types: "; also 3 of Table:OneIndependentVariable".
std::string others(const std::vector<upgrade::Refusal>& refused) {
  std::map<std::string, int> count;
  for (const upgrade::Refusal& r : refused) ++count[r.type];
  std::string text;
  if (const int same = --count[refused.front().type]; same > 0) text += fmt::format("; {} more of this type", same);
  for (const auto& [type, n] : count) {
    if (type != refused.front().type) text += fmt::format("; {} of {}", n, type);
  }
  return text;
}

[[noreturn]] void refuse_upgrade(const std::string& place, const std::vector<upgrade::Refusal>& refused, bool epjson) {
  const upgrade::Refusal& first = refused.front();
  const std::string line = first.line > 0 ? fmt::format(":{}", first.line) : std::string();
  throw hal::InputError(
      fmt::format("{}{}: {} / {}", place, line, first.type, first.name),
      fmt::format("an object of EnergyPlus {} that {} changed beyond the tables of this program: {}{}", first.from,
                  first.to, first.why, others(refused)),
      "objects that the tables bring to the engine's version",
      epjson ? "give the model as an IDF, or upgrade it with the program that wrote it"
             : "name a folder of EnergyPlus's Transition programs with --transitions, or replace the object");
}

using StepsOfType = std::map<std::string, std::pair<int, std::vector<std::string>>>;

void count_object(StepsOfType& types, const std::string& type, const std::vector<std::string>& steps) {
  if (steps.empty()) return;
  auto& [objects, versions] = types[type];
  ++objects;
  for (const std::string& step : steps) {
    if (std::ranges::find(versions, step) == versions.end()) versions.push_back(step);
  }
}

void report(Upgrade& done, StepsOfType& types, const std::string& from, const std::string& to) {
  done.from = from;
  done.to = to;
  done.types.clear();
  for (auto& [type, found] : types) {
    std::ranges::sort(found.second, is_older);
    done.types.push_back({type, found.first, fmt::format("{}", fmt::join(found.second, ", "))});
  }
}

}  // namespace

int Upgrade::objects() const {
  int all = 0;
  for (const UpgradedType& type : types) all += type.objects;
  return all;
}

std::string text_of(const Upgrade& done) {
  if (done.from.empty()) return {};
  return fmt::format("upgraded from EnergyPlus {} to {}: {}", done.from, done.to,
                     done.programs.empty()
                         ? fmt::format("{} object{} of {} type{}", done.objects(), done.objects() == 1 ? "" : "s",
                                       done.types.size(), done.types.size() == 1 ? "" : "s")
                         : "by the Transition programs of " + done.programs);
}

std::string short_version(const std::string& version) {
  const auto first = version.find('.');
  return first == std::string::npos ? version : version.substr(0, version.find('.', first + 1));
}

bool is_older(const std::string& a, const std::string& b) {
  const auto parts = [](const std::string& version) {
    char* end = nullptr;
    const long major = std::strtol(version.c_str(), &end, 10);
    return std::pair(major, *end == '.' ? std::strtol(end + 1, nullptr, 10) : 0);
  };
  return parts(a) < parts(b);
}

std::string oldest_version() { return all_steps().front().from; }

bool tables_lead(const std::string& from, const std::string& to) { return !steps_between(from, to).empty(); }

std::string upgraded_idf(const std::string& text, const std::string& place, const std::string& from,
                         const std::string& to, Upgrade& done) {
  upgrade::IdfText idf = upgrade::parse_idf(text, place);
  std::vector<upgrade::Refusal> refused;
  for (const upgrade::Step& step : steps_between(from, to)) upgrade::apply_step(idf, step, refused);
  if (!refused.empty()) refuse_upgrade(place, refused, false);
  for (upgrade::IdfObject* version : idf.all("Version")) version->set(1, to);
  StepsOfType types;
  for (const upgrade::IdfObject& object : idf.objects) count_object(types, object.type, object.steps);
  report(done, types, from, to);
  return upgrade::idf_text(idf);
}

void upgrade_epjson(nlohmann::json& model, const std::string& place, const std::string& from, const std::string& to,
                    Upgrade& done) {
  std::vector<upgrade::Refusal> refused;
  upgrade::ChangedObjects changed;
  for (const upgrade::Step& step : steps_between(from, to)) upgrade::apply_step(model, step, refused, changed);
  if (!refused.empty()) refuse_upgrade(place, refused, true);
  for (auto& [name, fields] : model["Version"].items()) fields["version_identifier"] = to;
  StepsOfType types;
  for (const auto& [object, steps] : changed) count_object(types, object.first, steps);
  report(done, types, from, to);
}

}  // namespace airside::tools
