#include "tools/gap/tried/tried_effect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

namespace {

constexpr int most_rivals = 4;  // in the asked effect's stead

class Trial {
 public:
  Trial(const Analysed& a, const sim::EffectChange& asked)
      : c_(a.fitted), none_(a.search.unpatched()), rest_(rest_of(a, asked.at)) {
    t_.asked = asked;
    t_.found = none_.cost - a.model.cost;
    found_ = a.verdict.findings;
    std::erase_if(found_, [&](const Finding& f) { return f.at.id() == asked.at.id(); });
  }

  TriedEffect run() {
    const Chosen chosen = chosen_of(t_.asked);
    t_.log_likelihood_limit = c_.limit(chosen.candidate);
    const Refit held = with(rest_, chosen);
    t_.log_likelihood_ratio = rest_.cost - held.cost;
    t_.over_nothing = none_.cost - (rest_.chosen.empty() ? held : with(none_, chosen)).cost;
    t_.expected = expected_of(chosen);
    const Predicted locked = c_.refitter.predicted(held, rest_);
    t_.locked = locked.log_likelihood_ratio;
    t_.locked_expected = locked.expected;
    fit_size(held, chosen);
    if (std::max(t_.log_likelihood_ratio, t_.best.log_likelihood_ratio) >= t_.log_likelihood_limit) add_rivals();
    answer();
    return std::move(t_);
  }

 private:
  /// What was found of other effects.
  static const Refit& rest_of(const Analysed& a, const sim::EffectAt& at) {
    for (std::size_t i = 0; i < a.model.chosen.size(); ++i) {
      if (a.fitted.candidate(a.model.chosen[i]).at.id() == at.id()) return a.search.without(a.model, i);
    }
    return a.model;
  }

  /// In the direction of the nearer probe.
  Chosen chosen_of(const sim::EffectChange& asked) const {
    const auto& candidates = c_.responses.test.candidates;
    Chosen chosen{candidates.size(), 0, true};
    double nearest = 0;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const double null = asked.at.effect->null_value, span = candidates[k].probe - null;
      const double steps = (asked.magnitude - null) / span, far = std::abs(asked.magnitude - candidates[k].probe);
      if (candidates[k].at.id() != asked.at.id() || steps <= 0) continue;
      if (chosen.candidate < candidates.size() && far >= nearest) continue;
      chosen = {k, steps, true};
      nearest = far;
    }
    if (chosen.candidate < candidates.size()) return chosen;
    // Both probes are on the other side.
    chosen.candidate =
        static_cast<std::size_t>(std::find_if(candidates.begin(), candidates.end(),
                                              [&](const Candidate& k) { return k.at.id() == asked.at.id(); }) -
                                 candidates.begin());
    const double null = asked.at.effect->null_value;
    chosen.steps = (asked.magnitude - null) / (candidates.at(chosen.candidate).probe - null);
    return chosen;
  }

  /// Parameters, and magnitudes of what was found, fitted beside the effect as it is asked.
  Refit with(const Refit& base, const Chosen& chosen) const {
    std::vector<Chosen> all = base.chosen;
    all.push_back(chosen);
    return c_.refitter.about_itself(c_.refitter.refit(c_.refitter.at(all, base.moved, base.tangent), base.tangent));
  }

  double expected_of(const Chosen& chosen) const {
    std::vector<Chosen> all = rest_.chosen;
    all.push_back(chosen);
    const Refit unfitted = c_.refitter.at(all, rest_.moved, rest_.tangent);
    const Eigen::VectorXd d = c_.refitter.whiten(rest_.residual) - c_.refitter.whiten(unfitted.residual);
    return beside(rest_, rest_.chosen.size()).times(d).dot(d);
  }

  /// The size that fits best, to either side.
  void fit_size(const Refit& held, const Chosen& asked) {
    const Selection selection = beside(rest_, rest_.chosen.size());
    const std::vector<Score> scores = selection.scores(c_.refitter.effective(rest_));
    const auto own = std::find_if(scores.begin(), scores.end(), [&](const Score& s) {
      return c_.responses.test.candidates[s.candidate].at.id() == t_.asked.at.id();
    });
    Score score;
    score.candidate = own == scores.end() ? asked.candidate : own->candidate;
    Refit best = c_.refitter.about_itself(c_.refitter.add(rest_, score, rest_.tangent));
    if (held.cost < best.cost) {  // from the size that was asked, which the linear way may not have met
      std::vector<Chosen> all = held.chosen;
      all.back().held = false;
      Refit from_asked = c_.refitter.refit(c_.refitter.at(all, held.moved, held.tangent), held.tangent);
      if (from_asked.cost < best.cost) best = std::move(from_asked);
    }
    const Candidate& candidate = c_.candidate(best.chosen.back());
    const sim::Effect& effect = *candidate.at.effect;
    t_.best.at = t_.asked.at;
    t_.best.magnitude = c_.refitter.magnitude(best.chosen.back());
    t_.best.log_likelihood_ratio = rest_.cost - best.cost;
    t_.best.log_likelihood_limit = t_.log_likelihood_limit;
    const double norm = selection.dot(best.chosen.back().candidate, best.chosen.back().candidate);
    t_.best.share = c_.rules.magnitude_share;
    t_.best.sd = std::hypot((candidate.probe - effect.null_value) / std::sqrt(std::max(1e-12, norm)),
                            t_.best.share * (t_.best.magnitude - effect.null_value));
  }

  void add_rivals() {
    const double gain = std::max(t_.log_likelihood_ratio, t_.best.log_likelihood_ratio);
    int tried = 0;
    for (const Score& s : beside(rest_, rest_.chosen.size()).scores(c_.refitter.effective(rest_))) {
      const Candidate& other = c_.responses.test.candidates[s.candidate];
      if (other.at.id() == t_.asked.at.id() || c_.already(rest_, s.candidate)) continue;
      if (++tried > most_rivals) break;
      const Refit in_its_stead = c_.refitter.add(rest_, s, rest_.tangent);
      if (!c_.plausible(in_its_stead)) continue;
      t_.rivals.push_back({other.at, rest_.cost - in_its_stead.cost});
      if (!exceeds(gain, t_.rivals.back().log_likelihood_ratio)) t_.cannot_tell_from.push_back(other.at);
    }
  }

  bool another_size() const {
    const MagnitudeInterval interval = interval_of(t_.best);
    return t_.best.log_likelihood_ratio >= t_.log_likelihood_limit &&
           exceeds(t_.best.log_likelihood_ratio, t_.log_likelihood_ratio) &&
           (t_.asked.magnitude < interval.low || t_.asked.magnitude > interval.high);
  }

  /// Whether it explains nearly as much as what was found, instead of it.
  bool in_place_of_what_was_found() const {
    return !found_.empty() && t_.over_nothing >= t_.log_likelihood_limit && !exceeds(t_.found, t_.over_nothing);
  }

  bool exceeds(double ratio, double of_another) const {
    return ratio - of_another >= sure_excess(ratio, c_.constants());
  }

  bool locked_days_contradict() const {
    Alternative a;
    a.locked = true;
    a.locked_log_likelihood_ratio = t_.locked;
    a.locked_expected = t_.locked_expected;
    return locked_days_veto(a, c_.constants());
  }

  void answer() {
    const double gain = t_.log_likelihood_ratio;
    const bool shows = gain >= t_.log_likelihood_limit;
    const auto say = [this](TriedAnswer is, std::string because) {
      t_.answer = is;
      t_.why = std::move(because);
    };
    if (another_size()) {
      say(TriedAnswer::refused, "not at this size: if it is this effect, it is " + magnitude_text(t_.best));
    } else if (shows && !t_.cannot_tell_from.empty()) {
      say(TriedAnswer::cannot_tell, "it explains much, but so does: " + t_.cannot_tell_from.front().text());
    } else if (shows && locked_days_contradict()) {
      say(TriedAnswer::cannot_tell, "it explains the fitted days, but the locked days contradict it");
    } else if (shows) {
      say(TriedAnswer::supported,
          found_.empty() ? "no other effect explains nearly as much" : "it is needed beside what was found");
    } else if (gain <= -refusal && in_place_of_what_was_found()) {
      say(TriedAnswer::cannot_tell, "it may be there instead of: " + found_.front().at.text());
    } else if (gain <= -refusal) {
      say(TriedAnswer::refused,
          found_.empty() ? "the log is likelier without it" : "the log is likelier without it, beside what was found");
    } else if (t_.expected < t_.log_likelihood_limit) {
      say(TriedAnswer::cannot_tell, "at this size it would not stand out from the noise");
    } else {
      say(TriedAnswer::cannot_tell, "it neither stands out from the noise nor is it missed");
    }
  }

  const FittedCase& c_;
  const Refit& none_;
  const Refit& rest_;
  std::vector<Finding> found_;  // of other effects
  TriedEffect t_;
};

}  // namespace

const char* text_of(TriedAnswer answer) {
  constexpr const char* texts[] = {"for", "against", "cannot tell"};
  return texts[static_cast<int>(answer)];
}

TriedEffect try_effect(const Analysed& analysed, const sim::EffectChange& asked) {
  return Trial(analysed, asked).run();
}

std::string title_of(const TriedEffect& t) {
  return fmt::format("{} = {:g}{}", t.asked.at.id(), t.asked.magnitude, unit_suffix(*t.asked.at.effect));
}

std::string sentence_of(const TriedEffect& t) {
  const std::string log = t.answer == TriedAnswer::cannot_tell ? std::string("the log cannot tell")
                                                               : fmt::format("the log speaks {} it", text_of(t.answer));
  return fmt::format("{}: {} (gain {:.0f}, {:.0f} if it were true, limit {:.0f})", log, t.why, t.log_likelihood_ratio,
                     t.expected, t.log_likelihood_limit);
}

}  // namespace airside::tools::gap
