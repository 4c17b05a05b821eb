#pragma once
// How large an effect is, and between which sizes it lies.

#include <string>

#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// The 95 % interval of a magnitude, within the effect's bounds.
struct MagnitudeInterval {
  double low = 0, high = 0;
};

/// Of a magnitude at the distance w from its null, with sd s. Of these, e w is due to the twin's other errors (e is
/// `share`), which are as likely to make w larger by a factor as smaller by it; n^2 = s^2 - (e w)^2 is the rest:
///   towards null: hypot(z n, w (1 - exp(-z e))),  away from it: hypot(z n, w (exp(z e) - 1)),  z = 1.96
/// Source: docs/gap-workflow.md, "6. How probable each effect is".
MagnitudeInterval interval_of(const Finding& finding);
MagnitudeInterval interval_of(const Alternative& alternative);

/// "factor 0.64 (0.42 to 0.99)", "2.1 K (1.2 to 3.5)": a magnitude with its interval.
std::string magnitude_text(const Finding& finding);
std::string magnitude_text(const Alternative& alternative);

/// " K", "" where a magnitude is a mere number.
std::string unit_suffix(const sim::Effect& effect);

}  // namespace airside::tools::gap
