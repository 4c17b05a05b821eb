#pragma once
// What the search will come to, as far as linear responses show: for how long a person still waits.

#include "tools/gap/verdict/fitted_case.hpp"

namespace airside::tools::gap {

struct Outlook {
  bool searching = false;  ///< the search has begun
  int found = 0;           ///< effects that are in the model
  int more = 0;            ///< that will be
  bool alike = false;      ///< the best of them has a rival that the data hardly tell from it
  bool unknown = false;    ///< something will be left that no effect explains
};

/// From this model on, forward selection by linear responses alone. `explained`: 2 ln likelihood that its effects gain.
/// Cost: no simulation.
Outlook outlook_of(const FittedCase& c, const Refit& now, double explained);
/// As soon as the reference is fitted, in a tangent of the twin itself.  Cost: one simulation.
Outlook first_outlook(const FittedCase& c);

}  // namespace airside::tools::gap
