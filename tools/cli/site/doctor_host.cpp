// What airside doctor looks at on the host: the engine, and what draws a report as a picture.

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <string>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/install.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/site/doctor.hpp"

namespace airside::tools {

void look_at_host(std::vector<DoctorFinding>& out) {
  try {
    const sim::EnergyPlusInstall install = sim::find_energyplus();
    (void)sim::find_energyplus_worker();
    out.push_back({"engine", DoctorState::ok, "EnergyPlus " + sim::version_of(install), ""});
  } catch (const hal::InputError& e) {
    out.push_back({"engine", DoctorState::advice,
                   fmt::format("EnergyPlus: {}; without it rooms are those of the RC plant", e.found()),
                   "tools/setup --for demo"});
  }
  try {
    (void)sim::find_models();
    out.push_back({"models", DoctorState::ok, "the built-in rooms are there", ""});
  } catch (const hal::InputError& e) {
    out.push_back({"models", DoctorState::advice, e.found() + " at " + e.place(), e.remedy()});
  }
}

}  // namespace airside::tools
