// What EnergyPlus 23.1 changed in the input of 22.2.

#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools::upgrade {

namespace {}  // namespace

Step step_to_23_1() { return {"22.2", "23.1", {}}; }

}  // namespace airside::tools::upgrade
