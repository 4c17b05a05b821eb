#include "tools/study/method/results.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <set>

#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& place, const std::string& field, const std::string& found,
                         const std::string& expected) {
  throw hal::InputError(place + ": " + field, found, expected, "move the file away, or choose another --out");
}

bool is_run(const fs::path& file) {
  const std::string name = file.filename().string();
  return file.extension() == ".json" && std::ranges::any_of(method_rows(), [&name](const MethodRow& row) {
           return name.starts_with(std::string(row.name) + "_");
         });
}

}  // namespace

void check_run(const std::string& place, const nlohmann::json& run, const MethodStudy& study) {
  for (const char* field : {"row", "room", "seed", "study", "figures"}) {
    if (!run.is_object() || !run.contains(field)) refuse(place, field, "nothing", "a run of airside study method");
  }
  if (!run["row"].is_string() || !run["room"].is_string()) refuse(place, "row, room", "no text", "names");
  if (!run["seed"].is_number_unsigned()) refuse(place, "seed", run["seed"].dump(), "a whole number");
  const nlohmann::json expected = study.facts();
  for (const auto& [name, value] : expected.items()) {
    if (!run["study"].contains(name) || run["study"][name] != value) {
      refuse(place, "study." + name, run["study"].value(name, nlohmann::json()).dump(),
             value.dump() + ", as the command has it: runs of one folder share plant, days and steps");
    }
  }
  for (const auto& [name, value] : run["figures"].items()) {
    if (!value.is_number()) refuse(place, "figures." + name, value.dump(), "a number");
  }
  const nlohmann::json daily = run.value("daily_dae_degc", nlohmann::json::array());
  if (!daily.is_array() || !std::ranges::all_of(daily, [](const nlohmann::json& v) { return v.is_number(); })) {
    refuse(place, "daily_dae_degc", daily.dump().substr(0, 40), "a list of numbers");
  }
}

std::vector<fs::path> run_files(const MethodStudy& study) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(study.folder)) {
    if (is_run(entry.path())) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

MethodResults MethodResults::read(const MethodStudy& study) {
  MethodResults out;
  for (const fs::path& file : run_files(study)) {
    const nlohmann::json j = sim::read_json(file);
    check_run(file.string(), j, study);
    out.runs_.push_back(
        {j["row"], j["room"], j["seed"], j["figures"], j.value("daily_dae_degc", std::vector<double>())});
  }
  return out;
}

Spread MethodResults::spread(const std::string& row, const std::string& key, const std::string& room) const {
  std::vector<double> values;
  for (const Run& run : runs_) {
    if (run.row == row && (room.empty() || run.room == room) && run.figures.contains(key))
      values.push_back(run.figures[key]);
  }
  return spread_of(values);
}

std::vector<Spread> MethodResults::daily_dae(const std::string& row, const std::string& room) const {
  std::vector<const std::vector<double>*> runs;
  std::size_t days = SIZE_MAX;
  for (const Run& run : runs_) {
    if (run.row != row || (!room.empty() && run.room != room) || run.daily_dae_degc.empty()) continue;
    runs.push_back(&run.daily_dae_degc);
    days = std::min(days, run.daily_dae_degc.size());
  }
  std::vector<Spread> out;
  for (std::size_t day = 0; !runs.empty() && day < days; ++day) {
    std::vector<double> values;
    for (const auto* run : runs) values.push_back((*run)[day]);
    out.push_back(spread_of(values));
  }
  return out;
}

bool MethodResults::has(const std::string& row) const {
  return std::ranges::any_of(runs_, [&row](const Run& run) { return run.row == row; });
}

int MethodResults::seeds() const {
  std::set<std::uint64_t> all;
  for (const Run& run : runs_) all.insert(run.seed);
  return static_cast<int>(all.size());
}

MethodResults MethodResults::of_seed(std::uint64_t seed) const {
  MethodResults out;
  std::ranges::copy_if(runs_, std::back_inserter(out.runs_), [seed](const Run& run) { return run.seed == seed; });
  return out;
}

std::vector<std::uint64_t> MethodResults::seeds_of(const std::string& row) const {
  std::set<std::uint64_t> all;
  for (const Run& run : runs_) {
    if (run.row == row) all.insert(run.seed);
  }
  return {all.begin(), all.end()};
}

}  // namespace airside::tools
