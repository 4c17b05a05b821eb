#pragma once
// The few functions of EnergyPlus's C interface that the worker calls, opened at run time from
// libenergyplusapi.so. The declarations are our own, so that the project builds without the engine.

#include <string>

namespace airside::sim {

using EngineState = void*;
using EngineCallback = void (*)(EngineState);

struct EngineApi {
  EngineState (*stateNew)();
  void (*stateDelete)(EngineState);
  void (*setConsoleOutputState)(EngineState, int);
  void (*setEnergyPlusRootDirectory)(EngineState, const char*);
  void (*registerErrorCallback)(EngineState, void (*)(int, const char*));
  void (*callbackBeginZoneTimestepBeforeSetCurrentWeather)(EngineState, EngineCallback);
  void (*callbackEndOfZoneTimeStepAfterZoneReporting)(EngineState, EngineCallback);
  int (*energyplus)(EngineState, int, const char*[]);
  void (*requestVariable)(EngineState, const char*, const char*);
  int (*apiDataFullyReady)(EngineState);
  int (*getVariableHandle)(EngineState, const char*, const char*);
  double (*getVariableValue)(EngineState, int);
  int (*getMeterHandle)(EngineState, const char*);
  double (*getMeterValue)(EngineState, int);
  int (*getActuatorHandle)(EngineState, const char*, const char*, const char*);
  void (*setActuatorValue)(EngineState, int, double);
  int (*kindOfSim)(EngineState);
  int (*warmupFlag)(EngineState);
  int (*month)(EngineState);
  int (*dayOfMonth)(EngineState);
  int (*hour)(EngineState);
  int (*zoneTimeStepNum)(EngineState);
  int (*isRaining)(EngineState);
  char* (*listAllAPIDataCSV)(EngineState);
};

/// Opens the engine with RTLD_LOCAL: its exports include names as common as `data`, zlib's and expat's.
/// Errors: std::runtime_error with the loader's message, or naming the function that the library lacks.
EngineApi open_engine(const std::string& library);

}  // namespace airside::sim
