#pragma once
// A user's own suspicion: one effect at a given size, asked of the log beside "nothing" and beside what was found.

#include <string>
#include <vector>

#include "tools/gap/verdict/workflow.hpp"

namespace airside::tools::gap {

enum class TriedAnswer { supported, refused, cannot_tell };
/// "for", "against", "cannot tell".
const char* text_of(TriedAnswer answer);

/// Ratios are 2 ln likelihood, by real simulation, parameters fitted on both sides; "over" is over the model with what
/// was found of other effects, which is the one without effects where nothing was.
struct TriedEffect {
  sim::EffectChange asked;
  TriedAnswer answer = TriedAnswer::cannot_tell;
  std::string why;                              ///< the answer's reason, part of a sentence
  double over_nothing = 0;                      ///< of the effect at this size over the model without effects
  double log_likelihood_ratio = 0;              ///< over what was found
  double expected = 0;                          ///< the same, were the effect as large as that
  double log_likelihood_limit = 0;              ///< below which it is noise
  double locked = 0, locked_expected = 0;       ///< the same two on the locked days
  Finding best;                                 ///< the size that fits best, its sd, its ratio over what was found
  std::vector<Rival> rivals;                    ///< other effects in its stead
  std::vector<sim::EffectAt> cannot_tell_from;  ///< those of them that explain nearly as much
  double found = 0;                             ///< of what was found, over the model without effects
};

/// Answer: `supported` where the ratio exceeds the effect's limit, no other effect does nearly as well in its stead,
/// and the locked days do not contradict it; `refused` where the ratio is below -refusal, or another size fits better
/// by sure_excess(); else, and where the effect would not show at that size, `cannot_tell`.
///   expected = d' M d, d what the effect does to the sensors, M the metric in which parameters and findings are free
/// Cost: as Analysis for one effect and its rivals, three tangents.
/// Errors: as Engine::simulate.
TriedEffect try_effect(const Analysed& analysed, const sim::EffectChange& asked);

/// 2 ln likelihood that a log must take from an effect to speak against it.
constexpr double refusal = 10;

/// "vav_flow@2=0.5", as --try takes it.  `effects` must outlive the result.
/// Errors: hal::InputError for no number, an unknown effect, place or one that this model cannot have, and a magnitude
/// that is out of bounds or changes nothing.
sim::EffectChange parse_tried(const std::string& text, const std::vector<sim::Effect>& effects, const Engine& engine);

/// "the log speaks against it: .."
std::string sentence_of(const TriedEffect& tried);
/// "vav_flow@2 = 0.5".
std::string title_of(const TriedEffect& tried);

}  // namespace airside::tools::gap
