#include "tools/gap/score/score_measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace airside::tools::gap {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

bool covers(const SaidEffect& said, const HiddenEffect& hidden) {
  return said.id == hidden.id || std::ranges::find(said.class_ids, hidden.id) != said.class_ids.end();
}
bool covers_any(const SaidEffect& said, const ScoredCase& c) {
  return std::ranges::any_of(c.hidden, [&](const HiddenEffect& h) { return covers(said, h); });
}
const SaidEffect* said_right(const ScoredCase& c, const HiddenEffect& hidden) {
  const auto found = std::ranges::find(c.effects, hidden.id, &SaidEffect::id);
  return found == c.effects.end() ? nullptr : &*found;
}
bool is_right(const SaidEffect& said, const ScoredCase& c) {
  return std::ranges::find(c.hidden, said.id, &HiddenEffect::id) != c.hidden.end();
}

bool is_abstained(const ScoredCase& c) { return !is_named(c); }
bool is_unknown(const ScoredCase& c) { return c.answered && c.kind == SaidKind::unknown; }
bool guesses(const ScoredCase& c) { return c.kind == SaidKind::named || c.kind == SaidKind::ambiguous; }

bool is_exact(const ScoredCase& c) {
  return is_named(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) { return is_right(e, c); });
}
bool all_exact(const ScoredCase& c) {
  return is_named(c) && std::ranges::all_of(c.hidden, [&](const HiddenEffect& h) { return said_right(c, h); });
}
bool in_class(const ScoredCase& c) {
  return guesses(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) { return covers_any(e, c); });
}
/// One wide class that holds both is no finding of both.
bool both_in_class(const ScoredCase& c) {
  if (!guesses(c)) return false;
  for (std::size_t i = 0; i < c.effects.size(); ++i) {
    for (std::size_t j = 0; j < c.effects.size(); ++j) {
      if (i != j && covers(c.effects[i], c.hidden[0]) && covers(c.effects[j], c.hidden[1])) return true;
    }
  }
  return false;
}
bool in_top_2(const ScoredCase& c) {
  const auto first = c.ranking.begin();
  return in_class(c) ||
         std::any_of(first, first + std::min<std::ptrdiff_t>(2, std::ssize(c.ranking)), [&](const std::string& id) {
           return std::ranges::find(c.hidden, id, &HiddenEffect::id) != c.hidden.end();
         });
}
bool is_wrong_name(const ScoredCase& c) { return is_named(c) && !in_class(c); }
bool is_wrong_place(const ScoredCase& c) {
  return is_wrong_name(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) {
           return std::ranges::any_of(c.hidden, [&](const HiddenEffect& h) { return name_of(h.id) == name_of(e.id); });
         });
}
bool has_extra_name(const ScoredCase& c) {
  return is_named(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) { return !covers_any(e, c); });
}
bool has_extra_beside_right(const ScoredCase& c) { return in_class(c) && has_extra_name(c); }
bool is_first_by_5(const ScoredCase& c) {
  return guesses(c) && !c.effects.empty() && is_right(c.effects[0], c) && c.effects[0].margin >= 5;
}
bool is_locked_near(const ScoredCase& c) { return c.locked && c.locked->temp_after_k <= 0.40; }

/// Which group of a set a target is for.
enum class Aim { no_target, all, ratio_half, ratio_1_up };

struct Measure {
  const char* set;
  const char* name;
  bool (*holds)(const ScoredCase&);
  Aim aim = Aim::no_target;
  Target target = {};
};

constexpr Target at_least(double share) { return {share, true}; }
constexpr Target at_most(double share) { return {share, false}; }

constexpr std::array measures{
    Measure{"single", "exact", is_exact, Aim::ratio_1_up, at_least(0.85)},
    Measure{"single", "class", in_class, Aim::ratio_1_up, at_least(0.95)},
    Measure{"single", "top 2", in_top_2, Aim::ratio_1_up, at_least(0.95)},
    Measure{"single", "wrong name", is_wrong_name, Aim::ratio_half, at_most(0.05)},
    Measure{"single", "wrong place", is_wrong_place},
    Measure{"single", "extra name", has_extra_beside_right},
    Measure{"single", "abstained", is_abstained},
    Measure{"null", "named", is_named, Aim::all, at_most(0.03)},
    Measure{"real_null", "named", is_named, Aim::all, at_most(0.05)},
    Measure{"outside", "unknown", is_unknown, Aim::all, at_least(0.90)},
    Measure{"outside", "wrong name", is_named, Aim::all, at_most(0.05)},
    Measure{"pair", "both", all_exact, Aim::all, at_least(0.70)},
    Measure{"pair", "at least one", is_exact, Aim::all, at_least(0.95)},
    Measure{"pair", "extra name", has_extra_name},
    Measure{"pair", "both in class", both_in_class},
    Measure{"pair", "one in class", in_class},
    Measure{"pair", "abstained", is_abstained},
    Measure{"real", "exact", is_exact},
    Measure{"real", "class", in_class},
    Measure{"real", "first by 5 x", is_first_by_5, Aim::all, at_least(1)},
    Measure{"real", "locked <= 0.40 K", is_locked_near, Aim::all, at_least(1)},
    Measure{"real", "wrong name", is_wrong_name},
};

struct Slice {
  std::string name;
  Aim aim = Aim::no_target;
  std::function<bool(const ScoredCase&)> takes;
};

bool ratio_1_up(const ScoredCase& c) { return c.ratio && *c.ratio >= 1; }

/// Whole groups first, each followed by its parts by engine, feedback, workflow where the cases differ in these.
/// A group that a target is for is there even if no case is in it.
std::vector<Slice> slices_of(const std::vector<const ScoredCase*>& cases, bool by_ratio, bool ratios_have_targets) {
  std::set<double> ratios;
  std::map<std::string, std::function<bool(const ScoredCase&)>> engines, feedbacks, workflows;
  for (const ScoredCase* c : cases) {
    if (c->ratio && by_ratio) ratios.insert(*c->ratio);
    engines["engine " + c->engine] = [e = c->engine](const ScoredCase& x) { return x.engine == e; };
    if (c->feedback) {
      feedbacks[*c->feedback ? "feedback on" : "feedback off"] = [f = *c->feedback](const ScoredCase& x) {
        return x.feedback && *x.feedback == f;
      };
    }
    if (!c->workflow.empty()) {
      workflows["workflow " + c->workflow] = [w = c->workflow](const ScoredCase& x) { return x.workflow == w; };
    }
  }
  std::vector<Slice> slices;
  const auto add = [&](const Slice& group, bool parts) {
    slices.push_back(group);
    if (!parts) return;
    for (const auto* kind : {&engines, &feedbacks, &workflows}) {
      if (kind->size() < 2) continue;
      for (const auto& [name, takes] : *kind) {
        slices.push_back({group.name + ", " + name, Aim::no_target,
                          [whole = group.takes, part = takes](const ScoredCase& c) { return whole(c) && part(c); }});
      }
    }
  };
  if (ratios_have_targets) ratios.insert(0.5);
  const bool grouped = ratios_have_targets || ratios.size() > 1;
  add({"all", Aim::all, [](const ScoredCase&) { return true; }}, !ratios_have_targets);
  if (!grouped) return slices;
  for (const double r : ratios) {
    add({fmt::format("ratio {:g}", r), r == 0.5 ? Aim::ratio_half : Aim::no_target,
         [r](const ScoredCase& c) { return c.ratio && *c.ratio == r; }},
        ratios_have_targets && r < 1);
  }
  if (ratios_have_targets || *ratios.rbegin() >= 1) {
    add({"ratio >= 1", Aim::ratio_1_up, ratio_1_up}, ratios_have_targets);
  }
  return slices;
}

std::optional<Target> target_of(const Slice& slice, Aim aim, Target target) {
  if (aim == Aim::no_target || slice.aim != aim) return std::nullopt;
  return target;
}

/// A figure of a case, and whether something holds for it (not at all: nobody knows).
struct Figure {
  const ScoredCase* of = nullptr;
  std::optional<double> value;
  std::optional<bool> flag;
};

double quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  const double beyond = at - static_cast<double>(low);
  if (beyond == 0 || sorted[low] == sorted[high]) return sorted[low];  // an infinity times or minus itself is no number
  return sorted[low] + beyond * (sorted[high] - sorted[low]);
}

void spread(ScoreTable& table, const std::vector<Figure>& figures, const std::string& set, const char* value_name,
            Target value_target, const char* flag_name, std::optional<Target> flag_target) {
  std::vector<const ScoredCase*> cases;
  std::set<std::string> sets;
  for (const Figure& f : figures) {
    cases.push_back(f.of);
    sets.insert(f.of->set);
  }
  auto slices = slices_of(cases, true, false);
  for (const std::string& name : sets) {
    if (sets.size() > 1)
      slices.push_back({"set " + name, Aim::no_target, [name](const ScoredCase& c) { return c.set == name; }});
  }
  for (const Slice& slice : slices) {
    CountRow flags{set, flag_name, slice.name, 0, 0, std::nullopt};
    if (flag_target) flags.target = target_of(slice, Aim::all, *flag_target);
    std::vector<double> values;
    for (const Figure& f : figures) {
      if (!slice.takes(*f.of)) continue;
      if (f.value) values.push_back(*f.value);
      if (f.flag) ++flags.n;
      if (f.flag && *f.flag) ++flags.k;
    }
    std::ranges::sort(values);
    SpreadRow row{set, value_name, slice.name, static_cast<int>(values.size()),
                  0,   0,          0,          target_of(slice, Aim::all, value_target)};
    if (!values.empty()) {
      row.quartile_1 = quantile(values, 0.25);
      row.median = quantile(values, 0.5);
      row.quartile_3 = quantile(values, 0.75);
    }
    if (row.n > 0 || row.target) table.spreads.push_back(row);
    if (flags.n > 0 || flags.target) table.counts.push_back(flags);
  }
}

}  // namespace

void warn(ScoreTable& table, const std::vector<std::string>& ids, const std::string& what) {
  if (ids.empty()) return;
  std::vector<std::string> shown(ids.begin(), ids.begin() + std::min<std::ptrdiff_t>(8, std::ssize(ids)));
  if (shown.size() < ids.size()) shown.emplace_back("...");
  table.warnings.push_back(
      fmt::format("{} {}: {}", ids.size(), ids.size() == 1 ? "case " + what : "cases " + what, fmt::join(shown, ", ")));
}

void count_sets(ScoreTable& table, const std::vector<ScoredCase>& cases) {
  for (const char* set : set_names) {
    const auto members = of_set(cases, set);
    const bool single = std::string(set) == "single", null = std::string(set).ends_with("null");
    for (const Slice& slice : slices_of(members, !null, single)) {
      for (const Measure& m : measures) {
        if (std::string(m.set) != set) continue;
        CountRow row{set, m.name, slice.name, 0, 0, target_of(slice, m.aim, m.target)};
        for (const ScoredCase* c : members) {
          if (!slice.takes(*c)) continue;
          ++row.n;
          row.k += m.holds(*c) ? 1 : 0;
        }
        if (row.n > 0 || row.target) table.counts.push_back(row);
      }
    }
  }
}

void measure_shrink(ScoreTable& table, const std::vector<ScoredCase>& cases) {
  std::vector<Figure> figures, to_right_model;
  std::vector<std::string> unlocked, gapless;
  for (const ScoredCase& c : cases) {
    if (!is_named(c)) continue;
    if (!c.locked || !std::isfinite(c.locked->before) || !std::isfinite(c.locked->floor)) {
      unlocked.push_back(c.id);
      continue;
    }
    const auto [before, after, floor, right, unused] = *c.locked;
    const auto closed = [before = before, after = after](double down_to) {
      return std::isfinite(after) ? std::clamp(1 - (after - down_to) / (before - down_to), -1.0, 1.0) : -1;
    };
    Figure f{&c, std::nullopt, !(after <= before)};
    if (before > floor) {
      f.value = closed(floor);
    } else {
      gapless.push_back(c.id);
    }
    figures.push_back(f);
    if (before > right) to_right_model.push_back({&c, closed(right), std::nullopt});
  }
  spread(table, figures, "named", "gap closed", at_least(0.90), "harm", at_most(0.02));
  if (!to_right_model.empty())
    spread(table, to_right_model, "named", "closed to a right model", at_least(0.90), "", std::nullopt);
  warn(table, unlocked, "named without figures of locked days, left out of gap closed and harm");
  warn(table, gapless, "named without a gap above the floor on locked days, left out of gap closed");
}

void measure_magnitudes(ScoreTable& table, const std::vector<ScoredCase>& cases,
                        const std::map<std::string, double>& null_of) {
  std::vector<Figure> figures;
  std::vector<std::string> without;
  for (const ScoredCase& c : cases) {
    if (!is_named(c)) continue;
    for (const HiddenEffect& h : c.hidden) {
      const SaidEffect* said = said_right(c, h);
      if (!said || std::isnan(h.magnitude)) continue;
      const double error =
          std::fabs(said->magnitude - h.magnitude) / std::fabs(h.magnitude - null_of.at(name_of(h.id)));
      Figure f{&c, std::isnan(error) ? infinite : error, std::nullopt};
      if (said->has_interval)
        f.flag = said->low <= h.magnitude && h.magnitude <= said->high;
      else
        without.push_back(c.id);
      figures.push_back(f);
    }
  }
  spread(table, figures, "right names", "magnitude error", at_most(0.10), "interval covers", std::nullopt);
  warn(table, without, "named right without an interval, left out of interval covers");
}

}  // namespace airside::tools::gap
