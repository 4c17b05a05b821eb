#include "tools/gap/map/engine_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/energyplus/replay/eso.hpp"
#include "sim/energyplus/replay/own_outputs.hpp"
#include "tools/adopt/model/engine_run.hpp"
#include "tools/gap/model/patched_model.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The model for a Monday of July with the outputs, the dictionaries of all others, and the report of sizes.
json trial_model(const sim::EnergyPlusTwin& twin, const Mapping& mapping) {
  json model = twin.model;
  json& period = model["RunPeriod"];
  period = {{"airside day",
             {{"begin_year", 2021},
              {"begin_month", 7},
              {"begin_day_of_month", 12},
              {"end_year", 2021},
              {"end_month", 7},
              {"end_day_of_month", 12}}}};
  model["Output:VariableDictionary"] = {{"airside dictionary", {{"key_field", "regular"}}}};
  json& variables = model["Output:Variable"] = json::object();
  json& meters = model["Output:Meter"] = json::object();
  for (const sim::ChannelOutput& output : sim::own_outputs(twin)) {
    if (output.kind == sim::ChannelOutput::Kind::meter)
      meters["airside " + output.key] = {{"key_name", output.key}, {"reporting_frequency", "Timestep"}};
    else  // of every object, so that a wrong key is not taken for a wrong variable
      variables["airside " + output.variable] = {
          {"key_value", "*"}, {"variable_name", output.variable}, {"reporting_frequency", "Timestep"}};
  }
  for (const MappedChannel& c : mapping.channels) {
    for (const std::string& meter : c.summed)
      meters["airside " + meter] = {{"key_name", meter}, {"reporting_frequency", "Timestep"}};
  }
  json& files = model["OutputControl:Files"] = json::object();
  for (const char* file :
       {"csv", "mtr", "tabular", "sqlite", "json", "audit", "bnd", "mtd", "shd", "dxf", "zone_sizing", "system_sizing"})
    files["Output Files"][std::string("output_") + file] = "No";
  for (const char* file : {"eso", "eio", "rdd", "mdd"}) files["Output Files"][std::string("output_") + file] = "Yes";
  return model;
}

/// The third field of each line of a dictionary, without its unit.
std::vector<std::string> dictionary(const fs::path& file) {
  std::ifstream in(file);
  std::set<std::string> names;
  for (std::string line; std::getline(in, line);) {
    const auto first = line.find(','), second = line.find(',', first + 1);
    if (line.starts_with('!') || first == std::string::npos || second == std::string::npos) continue;
    const std::string name = line.substr(second + 1);
    names.insert(name.substr(0, name.find(" [")));
  }
  return {names.begin(), names.end()};
}

std::string quoted_near(const std::string& name, const std::vector<std::string>& known) {
  constexpr std::size_t most_near = 5;
  const auto near = hal::near_names(name, known, most_near);
  return near.empty() ? "" : fmt::format("; near it: \"{}\"", fmt::join(near, "\", \""));
}

/// What a channel asks the engine for, for complaints.
struct AskedOutput {
  std::string key, variable;  ///< of a meter the key alone
  std::string place;
  bool summed = false;
};

std::vector<AskedOutput> asked_outputs(const Mapping& m) {
  std::vector<AskedOutput> asked;
  for (const MappedChannel& c : m.channels) {
    const bool node = c.kind == MappedKind::supply_temperature || c.kind == MappedKind::preheated_temperature;
    for (const std::string& meter : c.summed) asked.push_back({meter, "", c.place, true});
    if (!c.meter.empty())
      asked.push_back({c.meter, "", c.place, false});
    else if (node)
      asked.push_back({c.key, "System Node Temperature", c.place, false});
    else if (c.kind == MappedKind::damper)
      asked.push_back({c.key, "Zone Air Terminal VAV Damper Position", c.place, false});
    else if (!c.output.empty())
      asked.push_back({c.key, c.output, c.place, false});
    else if (c.kind == MappedKind::room_temperature)
      asked.push_back({c.zone, "Zone Mean Air Temperature", c.place, false});
  }
  return asked;
}

void require_output(const AskedOutput& asked, const sim::EsoFile& eso, const fs::path& out) {
  const auto& series = eso.series();
  const bool meter = asked.variable.empty();
  const std::string name = engine_upper(meter ? asked.key : asked.key + "," + asked.variable);
  if (const auto found = series.find(name); found != series.end() && !found->second.empty()) return;
  if (meter) {
    throw hal::InputError(asked.place + (asked.summed ? ".meters" : ".meter"),
                          "no meter \"" + asked.key + "\"" + quoted_near(asked.key, dictionary(out / "eplusout.mdd")),
                          "a meter that the engine has for this model", "correct the name");
  }
  std::vector<std::string> keys;
  const std::string behind = "," + engine_upper(asked.variable);
  for (const auto& [known, values] : series) {
    if (known.ends_with(behind)) keys.push_back(known.substr(0, known.size() - behind.size()));
  }
  if (keys.empty()) {
    throw hal::InputError(
        asked.place + ".output",
        "no output variable \"" + asked.variable + "\"" + quoted_near(asked.variable, dictionary(out / "eplusout.rdd")),
        "an output variable that the engine has for this model", "correct the name");
  }
  throw hal::InputError(asked.place + ".key",
                        fmt::format("no \"{}\" among the {} objects of \"{}\"{}", asked.key, keys.size(),
                                    asked.variable, quoted_near(asked.key, keys)),
                        "an object of which the engine reports that variable", "correct the key");
}

}  // namespace

FoundSizes check_outputs(const sim::EnergyPlusTwin& twin, const Mapping& m, const sim::EnergyPlusInstall& install) {
  const sim::RunFolder folder;
  write_whole_file(folder.path() / "model.epJSON", trial_model(twin, m).dump(1) + "\n");
  const EngineRun run = run_engine_program(
      install.folder / "energyplus",
      {"-w", fs::absolute(m.weather).string(), "-d", folder.path().string(), "model.epJSON"}, folder.path());
  if (!run.done) {
    throw hal::InputError(m.model, "a model that does not run: it " + run.words, "a model that EnergyPlus runs",
                          "correct it as the engine says");
  }
  const sim::EsoFile eso(folder.path() / "eplusout.eso", sim::EsoFile::Periods::last);
  for (const AskedOutput& asked : asked_outputs(m)) require_output(asked, eso, folder.path());
  const ModelView view(twin.model, m.model);
  return sizes_of_run(view, folder.path() / "eplusout.eio", install.schema);
}

}  // namespace airside::tools::gap
