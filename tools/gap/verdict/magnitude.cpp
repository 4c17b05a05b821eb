#include "tools/gap/verdict/magnitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

namespace {

/// A Finding or an Alternative.
template <class Sized>
MagnitudeInterval interval_of_sized(const Sized& of) {
  constexpr double z95 = 1.96;
  const sim::Effect& effect = *of.at.effect;
  const double way = of.magnitude - effect.null_value, far = std::abs(way);
  const double of_twin = of.share * far, noise = z95 * std::sqrt(std::max(0.0, of.sd * of.sd - of_twin * of_twin));
  const double near_null = std::hypot(noise, far * (1 - std::exp(-z95 * of.share)));
  const double away = std::hypot(noise, far * (std::exp(z95 * of.share) - 1));
  return {std::max(effect.low, of.magnitude - (way < 0 ? away : near_null)),
          std::min(effect.high, of.magnitude + (way < 0 ? near_null : away))};
}

template <class Sized>
std::string text_of_sized(const Sized& of) {
  const sim::Effect& effect = *of.at.effect;
  const MagnitudeInterval interval = interval_of(of);
  return fmt::format("{}{:.3g}{} ({:.3g} to {:.3g})", effect.unit == "1" ? "factor " : "", of.magnitude,
                     unit_suffix(effect), interval.low, interval.high);
}

}  // namespace

MagnitudeInterval interval_of(const Finding& finding) { return interval_of_sized(finding); }
MagnitudeInterval interval_of(const Alternative& alternative) { return interval_of_sized(alternative); }

std::string magnitude_text(const Finding& finding) { return text_of_sized(finding); }
std::string magnitude_text(const Alternative& alternative) { return text_of_sized(alternative); }

std::string unit_suffix(const sim::Effect& effect) {
  return effect.unit == "1" || effect.unit == "share" ? "" : " " + effect.unit;
}

}  // namespace airside::tools::gap
