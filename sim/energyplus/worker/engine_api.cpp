#include "sim/energyplus/worker/engine_api.hpp"

#include <dlfcn.h>

#include <stdexcept>

namespace airside::sim {
namespace {

template <class Function>
void find(void* library, const char* name, const std::string& file, Function& function) {
  void* symbol = dlsym(library, name);
  if (symbol == nullptr) {
    throw std::runtime_error(file + ": found no function " + name +
                             "; expected the interface of EnergyPlus 25.2; run tools/setup to install that version");
  }
  function = reinterpret_cast<Function>(symbol);
}

}  // namespace

EngineApi open_engine(const std::string& file) {
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    throw std::runtime_error(file + ": found that it does not load (" + (reason != nullptr ? reason : "unknown") +
                             "); expected the engine of EnergyPlus 25.2 and Debian's libx11-6; run tools/setup");
  }
  EngineApi api{};
#define AIRSIDE_FIND(name) find(library, #name, file, api.name)
  AIRSIDE_FIND(stateNew);
  AIRSIDE_FIND(stateDelete);
  AIRSIDE_FIND(setConsoleOutputState);
  AIRSIDE_FIND(setEnergyPlusRootDirectory);
  AIRSIDE_FIND(registerErrorCallback);
  AIRSIDE_FIND(callbackBeginZoneTimestepBeforeSetCurrentWeather);
  AIRSIDE_FIND(callbackEndOfZoneTimeStepAfterZoneReporting);
  AIRSIDE_FIND(energyplus);
  AIRSIDE_FIND(requestVariable);
  AIRSIDE_FIND(apiDataFullyReady);
  AIRSIDE_FIND(getVariableHandle);
  AIRSIDE_FIND(getVariableValue);
  AIRSIDE_FIND(getMeterHandle);
  AIRSIDE_FIND(getMeterValue);
  AIRSIDE_FIND(getActuatorHandle);
  AIRSIDE_FIND(setActuatorValue);
  AIRSIDE_FIND(kindOfSim);
  AIRSIDE_FIND(warmupFlag);
  AIRSIDE_FIND(month);
  AIRSIDE_FIND(dayOfMonth);
  AIRSIDE_FIND(hour);
  AIRSIDE_FIND(zoneTimeStepNum);
  AIRSIDE_FIND(isRaining);
  AIRSIDE_FIND(listAllAPIDataCSV);
#undef AIRSIDE_FIND
  return api;
}

}  // namespace airside::sim
