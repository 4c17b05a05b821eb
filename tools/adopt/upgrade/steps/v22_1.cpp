// What EnergyPlus 22.1 changed in the input of 9.6.

#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Change changes_22_1[] = {
    insert("PythonPlugin:SearchPaths", 4),
};

}  // namespace

Step step_to_22_1() { return {"9.6", "22.1", changes_22_1}; }

}  // namespace airside::tools::upgrade
