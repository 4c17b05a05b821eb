// What EnergyPlus 25.1 changed in the input of 24.2.

#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools::upgrade {

namespace {}  // namespace

Step step_to_25_1() { return {"24.2", "25.1", {}}; }

}  // namespace airside::tools::upgrade
