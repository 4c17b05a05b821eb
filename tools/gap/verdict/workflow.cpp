#include "tools/gap/verdict/workflow.hpp"

#include <algorithm>

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
    now_ = search_.forward(look_ahead);
    v_.findings = findings_of(c_, search_, now_);
    follow_posteriors();
    set_residual_ratio();
    decide(std::ssize(now_.chosen) == c_.rules.most_effects && search_.better(now_).has_value());
    v_.moved = now_.moved;
    if (!v_.findings.empty()) v_.log_likelihood_limit = v_.findings.front().log_likelihood_limit;
    return std::move(v_);
  }

 private:
  void set_model(Refit model) {
    now_ = std::move(model);
    v_.findings = findings_of(c_, search_, now_);
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
    if (!v_.findings.empty()) check_locked_days();
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
    check_locked_days();
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
    v_.residual_ratio_limit = c_.residual_ratio_of_chance() + c_.constants().shape_share * explained;
  }

  /// The model with what was found against the one without.
  void check_locked_days() {
    v_.residual_after = c_.refitter.unmoved_residual(now_.chosen);
    v_.locked = locked_days(c_, v_.residual_before, v_.residual_after);
    const Predicted predicted = c_.refitter.predicted(now_, search_.unpatched());
    v_.locked.log_likelihood_ratio = predicted.log_likelihood_ratio;
    v_.locked.predicted_log_likelihood_ratio = predicted.expected;
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
