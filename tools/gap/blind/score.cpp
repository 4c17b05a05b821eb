#include "tools/gap/blind/score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "hal/text/input_error.hpp"

namespace airside::tools::gap {
namespace {

using Json = nlohmann::json;
using hal::InputError;

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

enum class Kind { named, ambiguous, unknown, none, refused };
constexpr std::array<const char*, 5> kind_names{"named", "ambiguous", "unknown", "none", "refused"};
constexpr std::array<const char*, 6> set_names{"single", "null", "real_null", "outside", "pair", "real"};

struct HiddenEffect {
  std::string id;
  double magnitude = not_known;
};

struct SaidEffect {
  std::string id;
  double magnitude = not_known, low = not_known, high = not_known, margin = not_known;
  bool has_interval = false;
  std::vector<std::string> class_ids;
};

struct Locked {
  double before = not_known, after = not_known, floor = not_known, temp_after_k = not_known;
};

/// A case of the key, with what was said about it.
struct Case {
  std::string id, set, engine, workflow;
  std::optional<bool> feedback;
  std::optional<double> ratio;
  std::vector<HiddenEffect> hidden;
  bool answered = false;
  Kind kind = Kind::none;
  std::vector<SaidEffect> effects;
  std::vector<std::string> ranking;
  std::optional<Locked> locked;
};

std::string name_of(const std::string& id) { return id.substr(0, id.find('@')); }

/// A value and where it stands.
class Field {
 public:
  Field(const Json& object, std::string path) : json_(&object), path_(std::move(path)) {}

  [[noreturn]] void refuse(const std::string& expected, const std::string& remedy) const {
    std::string found = json_->is_null() ? "nothing" : json_->dump(-1, ' ', false, Json::error_handler_t::replace);
    if (found.size() > 80) found = json_->is_object() ? "an object" : json_->is_array() ? "a list" : "a long text";
    throw InputError(path_, found, expected, remedy);
  }
  bool has(const char* name) const {
    if (!json_->is_object()) refuse("an object", "put the fields between { and }");
    const auto found = json_->find(name);
    return found != json_->end() && !found->is_null();
  }
  bool mentions(const char* name) const { return json_->is_object() && json_->contains(name); }
  Field at(const char* name) const {
    static const Json nothing;
    return {has(name) ? (*json_)[name] : nothing, path_.empty() ? name : path_ + "." + name};
  }
  std::vector<Field> items() const {
    if (!json_->is_array()) refuse("a list", "put the entries between [ and ]");
    std::vector<Field> list;
    for (std::size_t i = 0; i < json_->size(); ++i) list.emplace_back((*json_)[i], fmt::format("{}[{}]", path_, i));
    return list;
  }
  std::vector<std::pair<std::string, Field>> members() const {
    if (!json_->is_object()) refuse("an object", "put the cases between { and }, each by its name");
    std::vector<std::pair<std::string, Field>> list;
    for (const auto& [name, value] : json_->items()) list.emplace_back(name, Field{value, path_ + "." + name});
    return list;
  }
  std::string text() const {
    if (!json_->is_string()) refuse("a text", "write it in double quotes");
    return json_->get<std::string>();
  }
  double number() const {
    if (!json_->is_number()) refuse("a number", "write it without quotes");
    return json_->get<double>();
  }
  /// null stands for a number that is not finite: JSON has no other way to write one.
  double number_or_null() const { return json_->is_null() ? not_known : number(); }
  bool flag() const {
    if (!json_->is_boolean()) refuse("true or false", "write it without quotes");
    return json_->get<bool>();
  }
  template <std::size_t N>
  std::size_t choice(const std::array<const char*, N>& names) const {
    const std::string word = text();
    for (std::size_t i = 0; i < N; ++i) {
      if (word == names[i]) return i;
    }
    refuse(fmt::format("one of {}", fmt::join(names, ", ")), "correct the word");
  }

 private:
  const Json* json_;
  std::string path_;
};

void check_format(const Json& object, const std::string& whose) {
  const bool known = object.is_object() && object.contains("format") && object["format"] == 1;
  if (known) return;
  const std::string found = object.is_object() && object.contains("format") ? object["format"].dump() : "no such field";
  throw InputError(whose + ": format", found, "1", "make the file anew with this version");
}

std::string library_id(const Field& field, const std::map<std::string, double>& null_of) {
  std::string id = field.text();
  if (!null_of.contains(name_of(id))) {
    field.refuse("an effect of the library, alone or with @ and its place",
                 "correct the name, or score with the effects that the verdicts were made with");
  }
  return id;
}

std::size_t hidden_at_least(const std::string& set) { return set == "pair" ? 2 : set.ends_with("null") ? 0 : 1; }

Case read_case(const std::string& id, const Field& field, const std::map<std::string, double>& null_of) {
  Case c;
  c.id = id;
  c.set = set_names[field.at("set").choice(set_names)];
  const bool real = c.set.starts_with("real"), in_library = c.set == "single" || c.set == "pair";
  static constexpr std::array<const char*, 3> engines{"rc", "energyplus", "measured"};
  c.engine = real && !field.has("engine") ? "measured" : engines[field.at("engine").choice(engines)];
  if (field.has("workflow")) c.workflow = field.at("workflow").text();
  if (field.has("feedback")) c.feedback = field.at("feedback").flag();
  if (field.has("ratio")) c.ratio = field.at("ratio").number();
  if (c.set == "single" && !c.ratio) field.at("ratio").number();
  const Field hidden = field.at("hidden");
  const std::size_t least = hidden_at_least(c.set);
  if (least > 0 || field.has("hidden")) {
    for (const Field& one : hidden.items()) {
      const Field id_field = one.at("id"), magnitude = one.at("magnitude");
      HiddenEffect effect{in_library ? library_id(id_field, null_of) : id_field.text(), not_known};
      if (in_library || one.has("magnitude")) effect.magnitude = magnitude.number();
      const auto null = null_of.find(name_of(effect.id));
      if (null != null_of.end() && effect.magnitude == null->second) {
        magnitude.refuse("another number than the effect's null value", "hide more, or move the case to a null set");
      }
      c.hidden.push_back(std::move(effect));
    }
  }
  const bool fits = least == 0 ? c.hidden.empty() : in_library ? c.hidden.size() == least : c.hidden.size() >= least;
  if (!fits) {
    hidden.refuse(fmt::format("{}{} hidden in a case of the set {}", least > 0 && !in_library ? "at least " : "",
                              least == 0   ? "nothing"
                              : least == 1 ? "one effect"
                                           : "two effects",
                              c.set),
                  "correct the set or the list");
  }
  return c;
}

void read_verdict(Case& c, const Field& field, const std::map<std::string, double>& null_of) {
  c.answered = true;
  c.kind = static_cast<Kind>(field.at("verdict").choice(kind_names));
  if (field.has("effects") || c.kind == Kind::named) {
    for (const Field& one : field.at("effects").items()) {
      SaidEffect effect;
      effect.id = library_id(one.at("id"), null_of);
      if (c.kind == Kind::named && !one.mentions("magnitude")) one.at("magnitude").number();
      effect.magnitude = one.at("magnitude").number_or_null();
      effect.margin = one.at("margin").number_or_null();
      if (one.has("interval")) {
        const auto bounds = one.at("interval").items();
        if (bounds.size() != 2) one.at("interval").refuse("two numbers, low and high", "write both");
        effect.low = bounds[0].number_or_null();
        effect.high = bounds[1].number_or_null();
        effect.has_interval = true;
      }
      if (one.has("class")) {
        for (const Field& other : one.at("class").items()) effect.class_ids.push_back(library_id(other, null_of));
      }
      c.effects.push_back(std::move(effect));
    }
    if (c.kind == Kind::named && c.effects.empty()) {
      field.at("effects").refuse("at least one effect", "list what is named, or say another verdict");
    }
  }
  if (field.has("ranking")) {
    for (const Field& one : field.at("ranking").items()) c.ranking.push_back(library_id(one, null_of));
  }
  if (field.has("locked")) {
    const Field locked = field.at("locked");
    c.locked = Locked{locked.at("score_before").number_or_null(), locked.at("score_after").number_or_null(),
                      locked.at("score_floor").number_or_null(), locked.at("temp_rmse_after_k").number_or_null()};
  }
}

std::vector<Case> read_cases(const Json& verdicts, const Json& key, const std::map<std::string, double>& null_of) {
  check_format(key, "answer key");
  check_format(verdicts, "verdicts");
  std::vector<Case> cases;
  std::map<std::string, std::size_t> index_of;
  for (const auto& [id, field] : Field{key, ""}.at("cases").members()) {
    index_of[id] = cases.size();
    cases.push_back(read_case(id, field, null_of));
  }
  for (const Field& field : Field{verdicts, ""}.at("verdicts").items()) {
    const Field id = field.at("case");
    const auto found = index_of.find(id.text());
    if (found == index_of.end()) id.refuse("a case of the answer key", "score with the key of the same drawing");
    if (cases[found->second].answered) id.refuse("one verdict a case", "remove the older one");
    read_verdict(cases[found->second], field, null_of);
  }
  return cases;
}

bool covers(const SaidEffect& said, const HiddenEffect& hidden) {
  return said.id == hidden.id || std::ranges::find(said.class_ids, hidden.id) != said.class_ids.end();
}
bool covers_any(const SaidEffect& said, const Case& c) {
  return std::ranges::any_of(c.hidden, [&](const HiddenEffect& h) { return covers(said, h); });
}
const SaidEffect* said_right(const Case& c, const HiddenEffect& hidden) {
  const auto found = std::ranges::find(c.effects, hidden.id, &SaidEffect::id);
  return found == c.effects.end() ? nullptr : &*found;
}
bool is_right(const SaidEffect& said, const Case& c) {
  return std::ranges::find(c.hidden, said.id, &HiddenEffect::id) != c.hidden.end();
}

bool is_named(const Case& c) { return c.kind == Kind::named; }
bool is_abstained(const Case& c) { return !is_named(c); }
bool is_unknown(const Case& c) { return c.answered && c.kind == Kind::unknown; }
bool guesses(const Case& c) { return c.kind == Kind::named || c.kind == Kind::ambiguous; }

bool is_exact(const Case& c) {
  return is_named(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) { return is_right(e, c); });
}
bool all_exact(const Case& c) {
  return is_named(c) && std::ranges::all_of(c.hidden, [&](const HiddenEffect& h) { return said_right(c, h); });
}
bool in_class(const Case& c) {
  return guesses(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) { return covers_any(e, c); });
}
/// One wide class that holds both is no finding of both.
bool both_in_class(const Case& c) {
  if (!guesses(c)) return false;
  for (std::size_t i = 0; i < c.effects.size(); ++i) {
    for (std::size_t j = 0; j < c.effects.size(); ++j) {
      if (i != j && covers(c.effects[i], c.hidden[0]) && covers(c.effects[j], c.hidden[1])) return true;
    }
  }
  return false;
}
bool in_top_2(const Case& c) {
  const auto first = c.ranking.begin();
  return in_class(c) ||
         std::any_of(first, first + std::min<std::ptrdiff_t>(2, std::ssize(c.ranking)), [&](const std::string& id) {
           return std::ranges::find(c.hidden, id, &HiddenEffect::id) != c.hidden.end();
         });
}
bool is_wrong_name(const Case& c) { return is_named(c) && !in_class(c); }
bool is_wrong_place(const Case& c) {
  return is_wrong_name(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) {
           return std::ranges::any_of(c.hidden, [&](const HiddenEffect& h) { return name_of(h.id) == name_of(e.id); });
         });
}
bool has_extra_name(const Case& c) {
  return is_named(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) { return !covers_any(e, c); });
}
bool has_extra_beside_right(const Case& c) { return in_class(c) && has_extra_name(c); }
bool is_first_by_5(const Case& c) {
  return guesses(c) && !c.effects.empty() && is_right(c.effects[0], c) && c.effects[0].margin >= 5;
}
bool is_locked_near(const Case& c) { return c.locked && c.locked->temp_after_k <= 0.40; }

/// Which group of a set a target is for.
enum class Aim { no_target, all, ratio_half, ratio_1_up };

struct Measure {
  const char* set;
  const char* name;
  bool (*holds)(const Case&);
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
  std::function<bool(const Case&)> takes;
};

bool ratio_1_up(const Case& c) { return c.ratio && *c.ratio >= 1; }

/// Whole groups first, each followed by its parts by engine, feedback, workflow where the cases differ in these.
/// A group that a target is for is there even if no case is in it.
std::vector<Slice> slices_of(const std::vector<const Case*>& cases, bool by_ratio, bool ratios_have_targets) {
  std::set<double> ratios;
  std::map<std::string, std::function<bool(const Case&)>> engines, feedbacks, workflows;
  for (const Case* c : cases) {
    if (c->ratio && by_ratio) ratios.insert(*c->ratio);
    engines["engine " + c->engine] = [e = c->engine](const Case& x) { return x.engine == e; };
    if (c->feedback) {
      feedbacks[*c->feedback ? "feedback on" : "feedback off"] = [f = *c->feedback](const Case& x) {
        return x.feedback && *x.feedback == f;
      };
    }
    if (!c->workflow.empty()) {
      workflows["workflow " + c->workflow] = [w = c->workflow](const Case& x) { return x.workflow == w; };
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
                          [whole = group.takes, part = takes](const Case& c) { return whole(c) && part(c); }});
      }
    }
  };
  if (ratios_have_targets) ratios.insert(0.5);
  const bool grouped = ratios_have_targets || ratios.size() > 1;
  add({"all", Aim::all, [](const Case&) { return true; }}, !ratios_have_targets);
  if (!grouped) return slices;
  for (const double r : ratios) {
    add({fmt::format("ratio {:g}", r), r == 0.5 ? Aim::ratio_half : Aim::no_target,
         [r](const Case& c) { return c.ratio && *c.ratio == r; }},
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

std::vector<const Case*> of_set(const std::vector<Case>& cases, const std::string& set) {
  std::vector<const Case*> list;
  for (const Case& c : cases) {
    if (c.set == set) list.push_back(&c);
  }
  return list;
}

void count_sets(ScoreTable& table, const std::vector<Case>& cases) {
  for (const char* set : set_names) {
    const auto members = of_set(cases, set);
    const bool single = std::string(set) == "single", null = std::string(set).ends_with("null");
    for (const Slice& slice : slices_of(members, !null, single)) {
      for (const Measure& m : measures) {
        if (std::string(m.set) != set) continue;
        CountRow row{set, m.name, slice.name, 0, 0, target_of(slice, m.aim, m.target)};
        for (const Case* c : members) {
          if (!slice.takes(*c)) continue;
          ++row.n;
          row.k += m.holds(*c) ? 1 : 0;
        }
        if (row.n > 0 || row.target) table.counts.push_back(row);
      }
    }
  }
}

/// A figure of a case, and whether something holds for it (not at all: nobody knows).
struct Figure {
  const Case* of = nullptr;
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
  std::vector<const Case*> cases;
  std::set<std::string> sets;
  for (const Figure& f : figures) {
    cases.push_back(f.of);
    sets.insert(f.of->set);
  }
  auto slices = slices_of(cases, true, false);
  for (const std::string& name : sets) {
    if (sets.size() > 1)
      slices.push_back({"set " + name, Aim::no_target, [name](const Case& c) { return c.set == name; }});
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

void warn(ScoreTable& table, const std::vector<std::string>& ids, const std::string& what) {
  if (ids.empty()) return;
  std::vector<std::string> shown(ids.begin(), ids.begin() + std::min<std::ptrdiff_t>(8, std::ssize(ids)));
  if (shown.size() < ids.size()) shown.emplace_back("...");
  table.warnings.push_back(
      fmt::format("{} {}: {}", ids.size(), ids.size() == 1 ? "case " + what : "cases " + what, fmt::join(shown, ", ")));
}

void measure_shrink(ScoreTable& table, const std::vector<Case>& cases) {
  std::vector<Figure> figures;
  std::vector<std::string> unlocked, gapless;
  for (const Case& c : cases) {
    if (!is_named(c)) continue;
    if (!c.locked || !std::isfinite(c.locked->before) || !std::isfinite(c.locked->floor)) {
      unlocked.push_back(c.id);
      continue;
    }
    const auto [before, after, floor, unused] = *c.locked;
    Figure f{&c, std::nullopt, !(after <= before)};
    if (before > floor) {
      f.value = std::isfinite(after) ? std::clamp(1 - (after - floor) / (before - floor), -1.0, 1.0) : -1;
    } else {
      gapless.push_back(c.id);
    }
    figures.push_back(f);
  }
  spread(table, figures, "named", "gap closed", at_least(0.90), "harm", at_most(0.02));
  warn(table, unlocked, "named without figures of locked days, left out of gap closed and harm");
  warn(table, gapless, "named without a gap above the floor on locked days, left out of gap closed");
}

void measure_magnitudes(ScoreTable& table, const std::vector<Case>& cases,
                        const std::map<std::string, double>& null_of) {
  std::vector<Figure> figures;
  std::vector<std::string> without;
  for (const Case& c : cases) {
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

struct ConfusedCase {
  std::string row, right, said;
  int order = 0;  ///< library, real, outside, nothing
};

ConfusedCase confused(const Case& c) {
  ConfusedCase one;
  if (c.hidden.empty()) {
    one = {c.set == "real_null" ? "nothing (real)" : "nothing", "none", "", 3};
  } else {
    const std::string name = name_of(c.hidden[0].id);
    if (c.set == "outside")
      one = {name + " (outside)", "unknown", "", 2};
    else if (c.set == "real")
      one = {name + " (real)", name, "", 1};
    else
      one = {name, name, "", 0};
  }
  one.said = c.answered ? kind_names[static_cast<std::size_t>(c.kind)] : "no verdict";
  if (is_named(c)) {
    const auto right = std::ranges::find(c.effects, one.right, [](const SaidEffect& e) { return name_of(e.id); });
    one.said = right == c.effects.end() ? name_of(c.effects[0].id) : one.right;
  }
  return one;
}

Confusion confusion_of(const std::vector<Case>& cases, const std::function<bool(const Case&)>& takes) {
  static const std::vector<std::string> abstentions{"ambiguous", "unknown", "none", "refused", "no verdict"};
  const auto is_effect = [](const std::string& word) {
    return std::ranges::find(abstentions, word) == abstentions.end();
  };
  std::vector<ConfusedCase> list;
  std::set<std::pair<int, std::string>> rows;
  std::map<std::string, std::string> right_of;
  std::set<std::string> effects, said;
  for (const Case& c : cases) {
    if (c.set == "pair" || !takes(c)) continue;
    const ConfusedCase one = confused(c);
    rows.insert({one.order, one.row});
    right_of[one.row] = one.right;
    for (const std::string& word : {one.right, one.said}) {
      if (is_effect(word)) effects.insert(word);
    }
    said.insert(one.said);
    list.push_back(one);
  }
  Confusion result;
  if (list.empty()) return result;
  result.said.assign(effects.begin(), effects.end());
  for (const std::string& word : abstentions) {
    const bool rare = word == "refused" || word == "no verdict";
    if (!rare || said.contains(word)) result.said.push_back(word);
  }
  for (const auto& [order, name] : rows) {
    result.hidden.push_back(name);
    result.right.push_back(right_of[name]);
  }
  result.counts.assign(result.hidden.size(), std::vector<int>(result.said.size(), 0));
  const auto index = [](const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  for (const ConfusedCase& one : list) ++result.counts[index(result.hidden, one.row)][index(result.said, one.said)];
  return result;
}

void describe_sets(ScoreTable& table, const std::vector<Case>& cases) {
  static const std::map<std::string, int> planned{{"single", 300}, {"null", 300}, {"real_null", 30},
                                                  {"outside", 60}, {"pair", 100}, {"real", 1}};
  std::vector<std::string> silent, refused;
  for (const char* set : set_names) {
    SetFacts facts;
    facts.set = set;
    facts.planned = planned.at(set);
    for (const Case* c : of_set(cases, set)) {
      ++facts.cases;
      if (!c->answered) {
        ++facts.unanswered;
        silent.push_back(c->id);
      }
      if (c->answered && c->kind == Kind::refused) {
        ++facts.refused;
        refused.push_back(c->id);
      }
      if (c->engine != "energyplus") continue;
      ++facts.energyplus;
      if (c->feedback && *c->feedback) ++facts.energyplus_feedback;
    }
    table.sets.push_back(facts);
  }
  warn(table, silent, "without verdict, counted as abstained");
  warn(table, refused, "refused for what is wrong with the logs, counted as abstained");
}

Json number_json(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

template <class Row>
void add_target(Json& object, const Row& row, double figure) {
  if (!row.target) return;
  object["target"] = {{row.target->at_least ? "at_least" : "at_most", row.target->value}};
  object["met"] = row.n > 0 ? Json(row.target->holds(figure)) : Json(nullptr);
}

Json confusion_json(const Confusion& c) {
  return {{"hidden", c.hidden}, {"right", c.right}, {"said", c.said}, {"counts", c.counts}};
}

std::string target_text(const Target& target) {
  return fmt::format("{} {:g} %", target.at_least ? "≥" : "≤", 100 * target.value);
}

/// Whether the target is met, and whether so few cases can tell.
std::string judged(const CountRow& row) {
  if (row.n == 0) return "no cases";
  const auto [low, high] = row.interval();
  const bool met = row.target->holds(row.share());
  const bool sure = row.target->holds(low) == met && row.target->holds(high) == met;
  return fmt::format("{}{}", met ? "met" : "MISSED", sure ? "" : ", unsure");
}

std::string judged(const SpreadRow& row) {
  if (row.n == 0) return "no cases";
  return row.target->holds(row.median) ? "met" : "MISSED";
}

std::string percent(double share) { return std::isfinite(share) ? fmt::format("{:.1f}", 100 * share) : "–"; }

void write_targets(std::string& text, const ScoreTable& table) {
  text += fmt::format("\nAgainst the targets (%, Wilson 95 % intervals; unsure: the interval reaches across)\n");
  text += fmt::format("  {:<12}{:<18}{:<14}{:>9}{:>9}  {:<16}{:<9}{}\n", "set", "measure", "slice", "cases", "share",
                      "interval", "target", "");
  for (const CountRow& row : table.counts) {
    if (!row.target) continue;
    const auto [low, high] = row.interval();
    text += fmt::format("  {:<12}{:<18}{:<14}{:>9}{:>9}  {:<16}{:<9}{}\n", row.set, row.measure, row.slice,
                        fmt::format("{}/{}", row.k, row.n), row.n > 0 ? percent(row.share()) : "–",
                        row.n > 0 ? fmt::format("{} .. {}", percent(low), percent(high)) : "", target_text(*row.target),
                        judged(row));
  }
  for (const SpreadRow& row : table.spreads) {
    if (!row.target) continue;
    text += fmt::format("  {:<12}{:<18}{:<14}{:>9}{:>9}  {:<16}{:<9}{}\n", row.set, row.measure, "median", row.n,
                        row.n > 0 ? percent(row.median) : "–",
                        row.n > 0 ? fmt::format("{} .. {} *", percent(row.quartile_1), percent(row.quartile_3)) : "",
                        target_text(*row.target), judged(row));
  }
  text += "  * quartiles\n";
}

/// Slices down, measures across, three at a time.
void write_slices(std::string& text, const ScoreTable& table, const std::string& set) {
  std::vector<std::string> slices, columns;
  const auto note = [](std::vector<std::string>& list, const std::string& name) {
    if (std::ranges::find(list, name) == list.end()) list.push_back(name);
  };
  for (const CountRow& row : table.counts) {
    if (row.set != set || row.n == 0) continue;
    note(slices, row.slice);
    note(columns, row.measure);
  }
  for (std::size_t from = 0; from < columns.size(); from += 3) {
    const std::size_t to = std::min(from + 3, columns.size());
    text += fmt::format("\n  {:<34}", set);
    for (std::size_t i = from; i < to; ++i) text += fmt::format("{:>28}", columns[i]);
    text += '\n';
    for (const std::string& slice : slices) {
      std::string line = fmt::format("  {:<34}", slice);
      for (std::size_t i = from; i < to; ++i) {
        const auto row = std::ranges::find_if(table.counts, [&](const CountRow& r) {
          return r.set == set && r.slice == slice && r.measure == columns[i];
        });
        std::string cell;
        if (row != table.counts.end() && row->n > 0) {
          const auto [low, high] = row->interval();
          cell = fmt::format("{} [{}, {}] {}/{}", percent(row->share()), percent(low), percent(high), row->k, row->n);
        }
        line += fmt::format("{:>28}", cell);
      }
      text += line + '\n';
    }
  }
}

void write_confusions(std::string& text, const Confusion& c, const char* which) {
  struct Mistake {
    int count = 0, of = 0;
    std::size_t row = 0, column = 0;
  };
  std::vector<Mistake> mistakes;
  for (std::size_t i = 0; i < c.hidden.size(); ++i) {
    int of = 0;
    for (const int n : c.counts[i]) of += n;
    for (std::size_t j = 0; j < c.said.size(); ++j) {
      if (c.counts[i][j] > 0 && c.said[j] != c.right[i]) mistakes.push_back({c.counts[i][j], of, i, j});
    }
  }
  if (mistakes.empty()) return;
  std::ranges::stable_sort(mistakes, std::greater<>(), &Mistake::count);
  text += fmt::format("\nMost often said instead ({})\n", which);
  for (std::size_t i = 0; i < std::min<std::size_t>(12, mistakes.size()); ++i) {
    const Mistake& m = mistakes[i];
    text += fmt::format("  {:<32} {:<32} {:>4} of {}\n", c.hidden[m.row], c.said[m.column], m.count, m.of);
  }
}

}  // namespace

ScoreTable score(const Json& verdicts, const Json& key, const std::map<std::string, double>& null_of) {
  const std::vector<Case> cases = read_cases(verdicts, key, null_of);
  ScoreTable table;
  describe_sets(table, cases);
  count_sets(table, cases);
  measure_shrink(table, cases);
  measure_magnitudes(table, cases, null_of);
  const auto below_1 = [](const Case& c) {
    return (c.set == "single" || c.set == "outside") && c.ratio && *c.ratio < 1;
  };
  table.confusion = confusion_of(cases, [&](const Case& c) { return !below_1(c); });
  table.confusion_below_1 = confusion_of(cases, below_1);
  return table;
}

Json json_of(const ScoreTable& table) {
  Json object = {{"format", 1},
                 {"sets", Json::array()},
                 {"counts", Json::array()},
                 {"spreads", Json::array()},
                 {"confusion", confusion_json(table.confusion)},
                 {"confusion_below_1", confusion_json(table.confusion_below_1)},
                 {"warnings", table.warnings}};
  for (const SetFacts& s : table.sets) {
    object["sets"].push_back({{"set", s.set},
                              {"cases", s.cases},
                              {"planned", s.planned},
                              {"energyplus", s.energyplus},
                              {"energyplus_feedback", s.energyplus_feedback},
                              {"unanswered", s.unanswered},
                              {"refused", s.refused}});
  }
  for (const CountRow& row : table.counts) {
    const auto [low, high] = row.interval();
    Json one = {{"set", row.set}, {"measure", row.measure}, {"slice", row.slice}, {"k", row.k}, {"n", row.n}};
    one["share"] = row.n > 0 ? Json(row.share()) : Json(nullptr);
    one["interval"] = {low, high};
    add_target(one, row, row.share());
    object["counts"].push_back(one);
  }
  for (const SpreadRow& row : table.spreads) {
    Json one = {{"set", row.set}, {"measure", row.measure}, {"slice", row.slice}, {"n", row.n}};
    const bool any = row.n > 0;
    one["quartile_1"] = any ? number_json(row.quartile_1) : Json(nullptr);
    one["median"] = any ? number_json(row.median) : Json(nullptr);
    one["quartile_3"] = any ? number_json(row.quartile_3) : Json(nullptr);
    add_target(one, row, row.median);
    object["spreads"].push_back(one);
  }
  return object;
}

std::string text_of(const ScoreTable& table) {
  std::string text = "What was tested (planned: a quarter from EnergyPlus, half of that with feedback)\n";
  text += fmt::format("  {:<12}{:>8}{:>9}{:>12}{:>15}{:>17}{:>14}\n", "set", "cases", "planned", "EnergyPlus",
                      "with feedback", "without verdict", "logs refused");
  for (const SetFacts& s : table.sets) {
    text += fmt::format("  {:<12}{:>8}{:>9}{:>12}{:>15}{:>17}{:>14}\n", s.set, s.cases, s.planned, s.energyplus,
                        s.energyplus_feedback, s.unanswered, s.refused);
  }
  write_targets(text, table);
  text += "\nIn parts: % [Wilson 95 % interval] cases\n";
  for (const char* set : set_names) write_slices(text, table, set);
  for (const char* set : {"named", "right names"}) write_slices(text, table, set);
  text += fmt::format("\n  {:<34}{:>16}{:>8}{:>12}{:>12}{:>12}\n", "quartiles, %", "", "n", "25 %", "median", "75 %");
  for (const SpreadRow& row : table.spreads) {
    if (row.n == 0) continue;
    text += fmt::format("  {:<34}{:>16}{:>8}{:>12}{:>12}{:>12}\n", row.slice, row.measure, row.n,
                        percent(row.quartile_1), percent(row.median), percent(row.quartile_3));
  }
  write_confusions(text, table.confusion, "all but ratio < 1");
  write_confusions(text, table.confusion_below_1, "ratio < 1");
  if (!table.warnings.empty()) text += "\nWarnings\n";
  for (const std::string& warning : table.warnings) text += "  " + warning + "\n";
  return text;
}

}  // namespace airside::tools::gap
