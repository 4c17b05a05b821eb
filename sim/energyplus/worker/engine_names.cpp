#include "sim/energyplus/worker/engine_names.hpp"

#include <sstream>

#include "hal/text/toml_section.hpp"

namespace airside::sim {

void EngineNames::request(const char* variable, const std::string& key) const {
  api_.requestVariable(state_, variable, key.c_str());
}

int EngineNames::variable_if_any(const char* name, const std::string& key) const {
  const int handle = api_.getVariableHandle(state_, name, key.c_str());
  return handle < 0 ? no_handle : handle;
}

int EngineNames::variable(const char* name, const std::string& key) const {
  const int handle = variable_if_any(name, key);
  if (handle == no_handle) throw NameError("no output variable '" + std::string(name) + "' of '" + key + "'");
  return handle;
}

int EngineNames::schedule(const std::string& name) const {
  const int handle = api_.getActuatorHandle(state_, "Schedule:Constant", "Schedule Value", name.c_str());
  if (handle < 0) throw NameError("no schedule to act on, 'Schedule:Constant' named '" + name + "'");
  return handle;
}

int EngineNames::meter(const std::string& name) const {
  const int handle = api_.getMeterHandle(state_, name.c_str());
  if (handle >= 0) return handle;
  std::string text = "no meter '" + name + "'";
  constexpr std::size_t most = 6;
  const std::vector<std::string> near = hal::near_names(name, meters(), most);
  for (std::size_t i = 0; i < near.size(); ++i) text += (i == 0 ? "; near it: '" : ", '") + near[i] + "'";
  throw NameError(text);
}

std::vector<std::string> EngineNames::meters() const {
  std::vector<std::string> names;
  const char* all = api_.listAllAPIDataCSV(state_);
  if (all == nullptr) return names;
  std::istringstream lines{std::string(all)};  // "OutputMeter,NAME,..."; the process ends, so the text is not freed
  constexpr std::string_view mark = "OutputMeter,";
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(mark)) continue;
    const std::size_t end = line.find(',', mark.size());
    names.push_back(line.substr(mark.size(), end == std::string::npos ? end : end - mark.size()));
  }
  return names;
}

}  // namespace airside::sim
