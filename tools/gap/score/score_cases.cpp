#include "tools/gap/score/score_cases.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/text/input_error.hpp"

namespace airside::tools::gap {

namespace {

using Json = nlohmann::json;
using hal::InputError;

/// A value and its place in the file.
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

ScoredCase read_case(const std::string& id, const Field& field, const std::map<std::string, double>& null_of) {
  ScoredCase c;
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

SaidPosterior read_posterior(const Field& field) {
  const auto texts = [](const Field& list) {
    std::vector<std::string> all;
    for (const Field& one : list.items()) all.push_back(one.text());
    return all;
  };
  SaidPosterior p{texts(field.at("beside")), texts(field.at("set")), {}};
  for (const char* rest : {"nothing", "other"}) p.probabilities.emplace_back(rest, field.at(rest).number());
  for (const Field& one : field.at("candidates").items())
    p.probabilities.emplace_back(one.at("id").text(), one.at("probability").number());
  return p;
}

void read_verdict(ScoredCase& c, const Field& field, const std::map<std::string, double>& null_of) {
  c.answered = true;
  c.kind = static_cast<SaidKind>(field.at("verdict").choice(kind_names));
  if (field.has("effects") || c.kind == SaidKind::named) {
    for (const Field& one : field.at("effects").items()) {
      SaidEffect effect;
      effect.id = library_id(one.at("id"), null_of);
      if (c.kind == SaidKind::named && !one.mentions("magnitude")) one.at("magnitude").number();
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
    if (c.kind == SaidKind::named && c.effects.empty()) {
      field.at("effects").refuse("at least one effect", "list what is named, or say another verdict");
    }
  }
  if (field.has("ranking")) {
    for (const Field& one : field.at("ranking").items()) c.ranking.push_back(library_id(one, null_of));
  }
  if (field.has("posterior")) {
    for (const Field& one : field.at("posterior").items()) c.posteriors.push_back(read_posterior(one));
  }
  if (field.has("locked")) {
    const Field locked = field.at("locked");
    c.locked = SaidLocked{locked.at("score_before").number_or_null(), locked.at("score_after").number_or_null(),
                          locked.at("score_floor").number_or_null(),
                          locked.has("score_right") ? locked.at("score_right").number_or_null() : not_known,
                          locked.at("temp_rmse_after_k").number_or_null()};
  }
}

/// Verdicts that were drawn anew after tests stand beside the first.
void read_verdicts_after_tests(ScoredCase& c, const Field& field, const std::map<std::string, double>& null_of) {
  if (!field.has("after_tests")) return;
  ScoredCase untold = c;  // what the key says of it
  untold.effects.clear();
  untold.ranking.clear();
  untold.locked.reset();
  for (const Field& one : field.at("after_tests").items()) {
    ScoredCase later = untold;
    read_verdict(later, one, null_of);
    for (const Field& test : one.at("tests").items()) later.tests.push_back(test.text());
    c.after.push_back(std::move(later));
  }
}

}  // namespace

std::vector<ScoredCase> read_cases(const Json& verdicts, const Json& key,
                                   const std::map<std::string, double>& null_of) {
  check_format(key, "answer key");
  check_format(verdicts, "verdicts");
  std::vector<ScoredCase> cases;
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
    read_verdicts_after_tests(cases[found->second], field, null_of);
  }
  return cases;
}

std::vector<const ScoredCase*> of_set(const std::vector<ScoredCase>& cases, const std::string& set) {
  std::vector<const ScoredCase*> list;
  for (const ScoredCase& c : cases) {
    if (c.set == set) list.push_back(&c);
  }
  return list;
}

}  // namespace airside::tools::gap
