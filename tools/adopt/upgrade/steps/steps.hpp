#pragma once
// The tables, a file a version.

#include <span>

#include "tools/adopt/upgrade/table/change.hpp"

namespace airside::tools::upgrade {

Step step_to_9_0();
Step step_to_9_1();
Step step_to_9_2();
Step step_to_9_3();
Step step_to_9_4();
Step step_to_9_5();
Step step_to_9_6();
Step step_to_22_1();
Step step_to_22_2();
Step step_to_23_1();
Step step_to_23_2();
Step step_to_24_1();
Step step_to_24_2();
Step step_to_25_1();
Step step_to_25_2();

}  // namespace airside::tools::upgrade
