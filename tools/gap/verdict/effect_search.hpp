#pragma once
// The search for what is missing: one effect after another, each by real simulation, and back where one has become
// superfluous.

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "tools/gap/verdict/fitted_case.hpp"

namespace airside::tools::gap {

class EffectSearch {
 public:
  /// `c` must outlive it.
  explicit EffectSearch(const FittedCase& c);

  /// The model without effects.
  const Refit& unpatched() const;
  /// Without one of its effects.
  const Refit& without(const Refit& now, std::size_t left_out) const;
  /// With as many effects as Rules::most_effects allows and the data ask for. `look`: called with the model
  /// after each effect.
  Refit forward(const std::function<void(const Refit&)>& look = {}) const;
  /// The model with one more effect, the best of the few most likely ones by real simulation. One that its own limit
  /// keeps out is no candidate here, but stays a rival of whatever gets in.
  std::optional<Refit> better(const Refit& now) const;
  /// The best of Refitter::far() about one of the models above, as many as a round of the search tries.
  const std::vector<Refit>& far(const Refit& now) const;
  /// 2 ln likelihood that the effects of a model gain.
  double explained(const Refit& now) const { return unexplained_ - now.cost; }

 private:
  /// One effect more in the tangent of the model: the best of those that are as large as they are at least.
  std::optional<Refit> tried_out(const Refit& now) const;
  Refit without_superfluous(const Refit& now) const;
  const Refit& refit(const Refit& near) const;

  const FittedCase& c_;
  struct Far {
    double cost = 0;  // of the model that they are about
    std::vector<Refit> best;
  };
  mutable std::map<std::vector<std::size_t>, Refit> refits_;  // by candidates, in the order in which they were found
  mutable std::map<std::vector<std::size_t>, Far> far_;       // the same
  double unexplained_ = 0;                                    // cost of the model without effects
};

}  // namespace airside::tools::gap
