#include "tools/gap/verdict/workflow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/gap/verdict/decision.hpp"
#include "tools/gap/verdict/finding_judge.hpp"
#include "tools/gap/verdict/locked_days.hpp"

namespace airside::tools::gap {

namespace {

bool is_sure(const Finding& f) { return f.why_not.empty(); }

class Analysis {
 public:
  Analysis(const FittedCase& c, const EffectSearch& search) : c_(c), search_(search), now_(search.unpatched()) {}

  /// With what was found, once it has run.
  const Refit& model() const { return now_; }

  Verdict run(const std::function<void(const Outlook&)>& look) {
    v_.fit = c_.fit;
    v_.nulls = c_.nulls;
    v_.buildings = c_.ensemble.rooms;
    v_.buildings_add_alone = c_.ensemble.adds_alone;
    v_.buildings_add = c_.ensemble.adds;
    v_.residual_before = v_.residual_after = c_.refitter.unmoved_residual({});
    v_.ranking = Selection(now_.tangent->evidence()).scores(c_.refitter.effective(now_));
    if (!v_.ranking.empty()) {
      v_.best_log_likelihood_ratio = v_.ranking.front().log_likelihood_ratio;
      v_.log_likelihood_limit = c_.limit(v_.ranking.front().candidate);
    }
    const auto look_ahead = [&](const Refit& now) {
      if (!look) return;
      Outlook outlook = outlook_of(c_, now, search_.explained(now));
      outlook.searching = true;
      if (now.chosen.empty()) alike_ = outlook.alike;
      outlook.alike = alike_;
      look(outlook);
    };
    look_ahead(now_);
    std::optional<TooSmall> too_small;
    now_ = search_.forward(too_small, look_ahead);
    v_.findings = findings_of(c_, search_, now_);
    if (c_.posterior_decides())
      follow_posteriors();
    else
      drop_weak_findings();
    set_residual_ratio();
    const bool more_needed = std::ssize(now_.chosen) == c_.rules.most_effects && search_.better(now_).has_value();
    if (c_.posterior_decides())
      decide(more_needed);
    else if (!v_.findings.empty())
      judge_findings(more_needed);
    else if (too_small && !something_left())
      judge_too_small(*too_small);
    else
      judge_nothing_found(too_small);
    if (!v_.findings.empty()) v_.log_likelihood_limit = v_.findings.front().log_likelihood_limit;
    return std::move(v_);
  }

 private:
  /// Of the best single effect, by linear responses.
  double over_limit() const {
    return v_.log_likelihood_limit > 0 ? v_.best_log_likelihood_ratio / v_.log_likelihood_limit : 0;
  }
  bool something_left() const { return v_.residual_ratio > v_.residual_ratio_limit; }

  void set_model(Refit model) {
    now_ = std::move(model);
    v_.findings = findings_of(c_, search_, now_);
  }

  /// The least of those that are neither sure nor large beside the others: more likely their shape than an effect.
  std::optional<std::size_t> weak_finding() const {
    if (v_.findings.size() < 2) return std::nullopt;
    const auto least = std::min_element(v_.findings.begin(), v_.findings.end(), [](const Finding& a, const Finding& b) {
      return a.log_likelihood_ratio < b.log_likelihood_ratio;
    });
    const double large = c_.rules.further_share * search_.explained(now_);
    if (is_sure(*least) || least->log_likelihood_ratio >= std::max(large, least->log_likelihood_limit))
      return std::nullopt;
    return static_cast<std::size_t>(least - v_.findings.begin());
  }

  void drop_weak_findings() {
    for (auto weak = weak_finding(); weak; weak = weak_finding()) set_model(search_.without(now_, *weak));
    // One effect after another: what the last one adds must help on days that nobody looked at.
    while (now_.chosen.size() > 1) {
      const Refit& fewer = search_.without(now_, now_.chosen.size() - 1);
      if (c_.refitter.predicted(now_, fewer).log_likelihood_ratio > 0) break;
      set_model(fewer);
    }
  }

  /// Effects that the posteriors put in the place of findings, or take out.
  void follow_posteriors() {
    weigh();
    for (int round = 0; round <= c_.rules.most_effects && take_what_is_likelier(); ++round) weigh();
  }

  bool take_what_is_likelier() {
    for (std::size_t i = 0; i < v_.posteriors.size(); ++i) {
      const bool found = i < v_.findings.size();
      switch (instead_of(found ? &v_.findings[i] : nullptr, v_.posteriors[i])) {
        case Instead::nothing_else: continue;
        case Instead::nobody: set_model(search_.without(now_, i)); return true;
        case Instead::another: take_likeliest(i); return true;
      }
    }
    return false;
  }

  /// The likeliest effect of posterior i in the place of finding i, or beside the findings; it comes last.
  void take_likeliest(std::size_t i) {
    const Refit& others = i < v_.findings.size() ? search_.without(now_, i) : now_;
    Score score;
    score.candidate = v_.alternatives[i].list[v_.posteriors[i].effects.front().from].candidate;
    set_model(c_.refitter.about_itself(c_.refitter.add(others, score, others.tangent)));
  }

  /// People are shown what is likeliest where a finding is not sure. One alone: what the others' posteriors say is said
  /// beside the finding that it replaces.
  void show_likeliest() {
    for (std::size_t i = 0; i < v_.findings.size(); ++i) {
      const auto& effects = v_.posteriors[i].effects;
      if (effects.empty() || v_.posteriors[i].sure || effects.front().at.id() == v_.findings[i].at.id()) continue;
      const auto places = std::ssize(v_.findings);
      const auto to_end = [&](auto& of_places) {
        const auto at = of_places.begin() + static_cast<std::ptrdiff_t>(i);
        std::rotate(at, at + 1, of_places.begin() + places);
      };
      take_likeliest(i);
      to_end(v_.posteriors);
      to_end(v_.alternatives);
      return;
    }
  }

  void decide(bool more_needed) {
    show_likeliest();
    for (std::size_t i = 0; i < v_.findings.size(); ++i) tell(v_.findings[i], v_.posteriors[i], v_.alternatives[i]);
    if (!v_.findings.empty()) check_locked_days(now_);
    const Decision decision = decision_of(v_.findings, v_.posteriors, more_needed);
    v_.kind = decision.kind;
    v_.reason = decision.reason;
    if (v_.kind == VerdictKind::named && !std::all_of(v_.findings.begin(), v_.findings.end(), is_sure))
      list_unsure_apart();
  }

  /// The model holds what is named alone, as large as it is beside the other.
  void list_unsure_apart() {
    std::vector<Chosen> named;
    for (std::size_t i = 0; i < v_.findings.size(); ++i) {
      if (is_sure(v_.findings[i])) named.push_back(now_.chosen[i]);
    }
    const auto first_unsure = std::stable_partition(v_.findings.begin(), v_.findings.end(), is_sure);
    v_.unsure.assign(first_unsure, v_.findings.end());
    v_.findings.erase(first_unsure, v_.findings.end());
    now_ = c_.refitter.at(named, now_.moved, now_.tangent);
    check_locked_days(now_);
  }

  void weigh() {
    v_.alternatives.clear();
    v_.posteriors.clear();
    v_.alternatives = alternatives_of(c_, search_, now_);
    for (const Alternatives& tried : v_.alternatives) v_.posteriors.push_back(posterior_of(tried, c_.constants()));
  }

  void set_residual_ratio() {
    v_.residual_ratio = now_.distance / c_.samples() / c_.fit.residual_ratio;
    const double explained = search_.explained(now_) / c_.samples() / c_.fit.residual_ratio;
    v_.residual_ratio_limit = c_.residual_ratio_of_chance() + c_.rules.shape_share * explained;
  }

  void judge_findings(bool more_needed) {
    check_locked_days(now_);
    if (more_needed) {
      v_.kind = VerdictKind::unknown;
      v_.reason =
          fmt::format("after {} effects another would still gain: something else is missing", c_.rules.most_effects);
    } else if (something_left()) {
      v_.kind = VerdictKind::unknown;
      v_.reason =
          fmt::format("the best effects leave {:.2f} times the noise: something else is missing", v_.residual_ratio);
    } else if (name_the_sure_ones()) {
      v_.kind = VerdictKind::named;
      v_.reason = "the locked days agree";
    } else {
      v_.kind = VerdictKind::ambiguous;
      const auto unsure = std::find_if_not(v_.findings.begin(), v_.findings.end(), is_sure);
      const bool silent =
          v_.locked.predicted_log_likelihood_ratio < c_.rules.locked_log_likelihood &&
          v_.locked.log_likelihood_ratio >= contradiction(c_.rules, v_.locked.predicted_log_likelihood_ratio);
      v_.reason = unsure != v_.findings.end() ? unsure->why_not
                  : silent                    ? "the locked days cannot tell"
                                              : "the locked days do not agree";
    }
  }

  /// Whether something is sure and helps on the locked days by itself. What was found beside it is then listed apart,
  /// and the model holds what is named alone, as large as it is beside the other.
  bool name_the_sure_ones() {
    if (std::all_of(v_.findings.begin(), v_.findings.end(), is_sure)) return locked_days_agree(c_.rules, v_.locked);
    Verdict apart = v_;
    const auto first_unsure = std::stable_partition(apart.findings.begin(), apart.findings.end(), is_sure);
    apart.unsure.assign(first_unsure, apart.findings.end());
    apart.findings.erase(first_unsure, apart.findings.end());
    if (apart.findings.empty()) return false;
    std::vector<Chosen> named;
    for (std::size_t i = 0; i < v_.findings.size(); ++i) {
      if (is_sure(v_.findings[i])) named.push_back(now_.chosen[i]);
    }
    Refit alone = c_.refitter.at(named, now_.moved, now_.tangent);
    if (!holds_beside_others(alone, apart.unsure) || one_explains_all(alone)) return false;
    check_locked_days(alone, apart);
    if (!locked_days_agree(c_.rules, apart.locked)) return false;
    v_ = std::move(apart);
    now_ = std::move(alone);
    return true;
  }

  /// Whether each of the sure ones still gains more than its limit, whatever nearly as good explanation is true of what
  /// is not sure: an effect that explains both makes the sure one superfluous.
  bool holds_beside_others(const Refit& sure, const std::vector<Finding>& unsure) const {
    const std::vector<Score> scores = beside(sure, sure.chosen.size()).scores(c_.refitter.effective(sure));
    for (const Finding& f : unsure) {
      for (const Rival& rival : f.rivals) {
        if (c_.rules.class_ratio * rival.log_likelihood_ratio < f.log_likelihood_ratio) continue;
        const auto score = std::find_if(scores.begin(), scores.end(), [&](const Score& s) {
          return c_.responses.test.candidates[s.candidate].at.id() == rival.at.id();
        });
        if (score == scores.end()) continue;
        const Refit both = c_.refitter.add(sure, *score, sure.tangent);
        for (std::size_t i = 0; i < sure.chosen.size(); ++i) {
          std::vector<Chosen> fewer = both.chosen;
          fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
          const Refit without = c_.refitter.refit(c_.refitter.at(fewer, both.moved, both.tangent), both.tangent);
          if (without.cost - both.cost < c_.limit(sure.chosen[i].candidate)) return false;
        }
      }
    }
    return true;
  }

  /// Whether another effect alone explains nearly as much as all findings, and leaves a sure one nothing.
  bool one_explains_all(const Refit& sure) const {
    const Refit& none = search_.unpatched();
    int tried = 0;
    for (const Score& score : v_.ranking) {
      if (c_.already(now_, score.candidate)) continue;
      if (++tried > c_.rules.first_looks) break;
      const Refit other = c_.refitter.add(none, score, none.tangent);
      if (c_.rules.class_ratio * search_.explained(other) < search_.explained(now_)) continue;
      for (const Chosen& chosen : sure.chosen) {
        Score again;
        again.candidate = chosen.candidate;
        const Refit both = c_.refitter.add(other, again, other.tangent);
        if (other.cost - both.cost < c_.limit(chosen.candidate)) return true;
      }
    }
    return false;
  }

  /// Something gains more than noise can, but is smaller than such an effect is.
  void judge_too_small(const TooSmall& too_small) {
    set_model(too_small.at);
    set_residual_ratio();
    check_locked_days(now_);
    Finding& f = v_.findings.front();
    f.why_not = why_too_small(f);
    v_.kind = VerdictKind::ambiguous;
    v_.reason = f.why_not;
  }

  static std::string why_too_small(const Finding& f) {
    const sim::Effect& e = *f.at.effect;
    return fmt::format(
        "its gain is {:.1f} x its limit, but at {:.2g} it is too near to {:g}: such an effect is {:g} or {}",
        f.log_likelihood_ratio / f.log_likelihood_limit, f.magnitude, e.null_value, e.least,
        e.least > e.null_value ? "more" : "less");
  }

  void judge_nothing_found(const std::optional<TooSmall>& too_small) {
    const double over = over_limit();
    const std::string first =
        v_.ranking.empty() ? "" : c_.responses.test.candidates[v_.ranking.front().candidate].at.text();
    if (something_left()) {
      v_.kind = VerdictKind::unknown;
      v_.reason =
          fmt::format("the model is wrong by {:.2f} times its noise and no effect explains it", v_.residual_ratio);
      if (too_small) {
        const Finding nearest = findings_of(c_, search_, too_small->at).front();
        v_.reason += fmt::format("; nearest comes: {}, {}", nearest.at.text(), why_too_small(nearest));
      }
    } else if (over >= c_.rules.unconfirmed_ratio) {
      v_.kind = VerdictKind::unknown;
      v_.reason = fmt::format(
          "it looks like this: {}, by {:.1f} x the limit of its gain, but when it is simulated it explains no more "
          "than "
          "noise would",
          first, over);
    } else if (over > 1) {
      v_.kind = VerdictKind::none;
      v_.reason = fmt::format(
          "no gap above the floor when simulated; at first sight there was one like this: {}, {:.1f} x the limit of "
          "its "
          "gain",
          first, over);
    } else {
      v_.kind = VerdictKind::none;
      v_.reason = "no gap above the floor";
    }
  }

  /// This model against the one without effects.
  void check_locked_days(const Refit& model) { check_locked_days(model, v_); }
  void check_locked_days(const Refit& model, Verdict& v) const {
    v.residual_after = c_.refitter.unmoved_residual(model.chosen);
    v.locked = locked_days(c_, v.residual_before, v.residual_after);
    const Predicted predicted = c_.refitter.predicted(model, search_.unpatched());
    v.locked.log_likelihood_ratio = predicted.log_likelihood_ratio;
    v.locked.predicted_log_likelihood_ratio = predicted.expected;
  }

  const FittedCase& c_;
  const EffectSearch& search_;
  Refit now_;  // the model with the findings
  Verdict v_;
  bool alike_ = false;  ///< the best effect had a rival at first sight
};

}  // namespace

const char* text_of(VerdictKind kind) {
  constexpr const char* names[] = {"none", "named", "ambiguous", "unknown"};
  return names[static_cast<int>(kind)];
}

Verdict analyse(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules,
                int jobs, const std::function<void(const Outlook&)>& look,
                const std::function<void(const Analysed&)>& judged) {
  FittedCase c(engine, data, responses, rules, jobs, look ? Refitter::Start::twin : Refitter::Start::reference);
  if (look) {
    look(first_outlook(c));
    c.refitter.simulate_tangent();
  }
  c.draw_buildings();
  const EffectSearch search(c);
  Analysis analysis(c, search);
  const Verdict verdict = analysis.run(look);
  if (judged) judged({c, search, analysis.model(), verdict});
  return verdict;
}

}  // namespace airside::tools::gap
