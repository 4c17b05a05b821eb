#include "tools/adopt/upgrade/rows.hpp"

#include <algorithm>
#include <unordered_map>

namespace airside::tools::upgrade {

namespace {

std::string upper_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return out;
}

bool holds(const std::string& text, const char* part) {
  return upper_case(text).find(upper_case(part)) != std::string::npos;
}

/// A field that is one of the words; returns whether it changed.
bool exchange_words(std::string& field, std::span<const Word> list) {
  const auto word = std::ranges::find_if(list, [&](const Word& w) { return IdfText::same(field, w.from); });
  if (word == list.end()) return false;
  field = word->to;
  return true;
}

bool exchange_parts(std::string& field, std::span<const Word> list) {
  for (const Word& word : list) {
    const auto at = upper_case(field).find(upper_case(word.from));
    if (at == std::string::npos) continue;
    field.replace(at, std::string_view(word.from).size(), word.to);
    return true;
  }
  return false;
}

/// A row done to one field.
bool in_field(std::string& field, const Change& row) {
  switch (row.kind) {
    case ChangeKind::words: return exchange_words(field, row.words);
    case ChangeKind::parts: return exchange_parts(field, row.words);
    default: return false;
  }
}

bool refuses(const std::string& field, const Change& row) {
  return row.words.empty() ? !field.empty() : holds(field, row.words.front().from);
}

/// Fields `row.field`, or all of them for 0; those that are there.
template <typename Do>
bool any_field(IdfObject& object, const Change& row, Do&& one) {
  bool any = false;
  for (std::size_t at = 0; at < object.fields.size(); ++at) {
    if (row.field != 0 && at + 1 != static_cast<std::size_t>(row.field)) continue;
    any = one(object.fields[at]) || any;
  }
  return any;
}

/// What an inserted field holds.
const char* inserted_text(IdfObject& object, const Change& row) {
  for (const Word& word : row.words) {
    if (std::ranges::any_of(object.fields, [&](const std::string& f) { return IdfText::same(f, word.from); }))
      return word.to;
  }
  return row.text;
}

/// Returns whether the object changed.
bool apply_row(IdfObject& object, const Change& row, const Step& step, std::vector<Refusal>& refused) {
  const auto refusal = [&] {
    refused.push_back({object.type, object.name(), row.text, object.line, step.from, step.to});
    return false;
  };
  switch (row.kind) {
    case ChangeKind::insert: return object.insert(row.field, row.count, inserted_text(object, row));
    case ChangeKind::remove: return object.remove(row.field);
    case ChangeKind::retype: object.type = row.text; return true;
    case ChangeKind::words:
    case ChangeKind::parts: return any_field(object, row, [&](std::string& field) { return in_field(field, row); });
    case ChangeKind::fill:
      if (!object.field(row.field).empty()) return false;
      object.set(row.field, row.text);
      return true;
    case ChangeKind::rename: return false;
    case ChangeKind::refuse: return refusal();
    case ChangeKind::refuse_if:
      return any_field(object, row, [&](std::string& field) { return refuses(field, row); }) && refusal();
  }
  return false;
}

using nlohmann::json;

/// Each text under `name` of an object and its lists, or every text for an empty name.
template <typename Do>
bool any_text(json& fields, const std::string& name, Do&& one) {
  bool any = false;
  for (auto& [key, value] : fields.items()) {
    if (value.is_structured()) {
      any = any_text(value, name, one) || any;
    } else if (value.is_string() && (name.empty() || key == name)) {
      any = one(value.template get_ref<std::string&>()) || any;
    }
  }
  return any;
}

bool rename_key(json& fields, const char* name, const char* to) {
  bool any = false;
  if (fields.is_object()) {
    if (const auto at = fields.find(name); at != fields.end()) {
      json value = *at;
      fields.erase(at);
      fields[to] = std::move(value);
      any = true;
    }
  }
  for (auto& [key, value] : fields.items()) {
    if (value.is_array() || fields.is_array()) any = (value.is_structured() && rename_key(value, name, to)) || any;
  }
  return any;
}

bool set_missing(json& fields, const Change& row) {
  if (*row.name == '\0' || *row.text == '\0' || fields.contains(row.name)) return false;
  const char* text = row.text;
  for (const Word& word : row.words) {
    if (any_text(fields, "", [&](const std::string& field) { return IdfText::same(field, word.from); })) text = word.to;
  }
  char* end = nullptr;
  const double number = std::strtod(text, &end);
  if (*end == '\0') {
    fields[row.name] = number;
  } else {
    fields[row.name] = text;
  }
  return true;
}

bool apply_row(json& fields, const Change& row, bool& refused) {
  switch (row.kind) {
    case ChangeKind::insert:
    case ChangeKind::fill: return set_missing(fields, row);
    case ChangeKind::remove: return fields.erase(row.name) > 0;
    case ChangeKind::words:
    case ChangeKind::parts: return any_text(fields, row.name, [&](std::string& field) { return in_field(field, row); });
    case ChangeKind::rename: return rename_key(fields, row.name, row.text);
    case ChangeKind::refuse: refused = true; return false;
    case ChangeKind::refuse_if:
      refused = any_text(fields, row.name, [&](std::string& field) { return refuses(field, row); });
      return false;
    case ChangeKind::retype: return true;
  }
  return false;
}

/// An object type of an epJSON, whatever its case; null where there is none.
std::string type_of(const json& model, const char* type) {
  for (const auto& [key, objects] : model.items()) {
    if (IdfText::same(key, type)) return key;
  }
  return {};
}

void apply_row(json& model, const Change& row, const Step& step, std::vector<Refusal>& refused,
               ChangedObjects& changed) {
  const std::string type = type_of(model, row.type);
  if (type.empty() || !model[type].is_object()) return;
  const std::string after = row.kind == ChangeKind::retype ? row.text : type;
  for (auto& [name, fields] : model[type].items()) {
    if (!fields.is_object()) continue;
    bool refusal = false;
    const bool touched = apply_row(fields, row, refusal);
    if (refusal) refused.push_back({type, name, row.text, 0, step.from, step.to});
    if (!touched) continue;
    auto known = changed.extract({type, name});
    std::vector<std::string> versions = known.empty() ? std::vector<std::string>() : known.mapped();
    if (versions.empty() || versions.back() != step.to) versions.emplace_back(step.to);
    changed[{after, name}] = std::move(versions);
  }
  if (after == type) return;
  model[after].update(model[type]);
  model.erase(type);
}

}  // namespace

void apply_step(IdfText& idf, const Step& step, std::vector<Refusal>& refused) {
  const std::size_t before = refused.size();
  if (step.whole != nullptr) step.whole(idf, refused);
  for (std::size_t n = before; n < refused.size(); ++n) {
    refused[n].from = step.from;
    refused[n].to = step.to;
  }
  std::unordered_map<std::string, std::vector<const Change*>> rows;
  for (const Change& row : step.changes) rows[upper_case(row.type)].push_back(&row);
  for (IdfObject& object : idf.objects) {
    const auto found = rows.find(upper_case(object.type));
    if (found == rows.end()) continue;
    for (const Change* row : found->second) {
      if (apply_row(object, *row, step, refused)) object.mark(step.to);
    }
  }
}

void apply_step(json& model, const Step& step, std::vector<Refusal>& refused, ChangedObjects& changed) {
  for (const char* shape : step.whole_types) {
    const std::string type = type_of(model, shape);
    if (type.empty() || !model[type].is_object() || model[type].empty()) continue;
    refused.push_back({type, model[type].begin().key(), "its shape in epJSON is another", 0, step.from, step.to});
  }
  // Names first: the other rows have those of the new version.
  for (const bool names : {true, false}) {
    for (const Change& row : step.changes) {
      if ((row.kind == ChangeKind::rename) == names) apply_row(model, row, step, refused, changed);
    }
  }
}

}  // namespace airside::tools::upgrade
