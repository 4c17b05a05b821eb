#include "hal/text/toml_section.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include "hal/text/civil_text.hpp"
#include "hal/text/foreign_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/number_text.hpp"
#include "hal/text/unknown_key.hpp"

namespace airside::hal {
namespace {

std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replace, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return small;
}

std::string join(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t fewest = std::max<std::size_t>(2, name.size() / 2) + 1;
  for (const std::string& candidate : known) {
    const std::size_t edits = edits_between(name, candidate);
    if (edits < fewest) {
      fewest = edits;
      nearest = candidate;
    }
  }
  return nearest;
}

std::vector<std::string> near_names(std::string_view name, const std::vector<std::string>& known, std::size_t most) {
  const std::string sought = in_small_letters(name);
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const std::string& candidate : known) {
    const std::string small = in_small_letters(candidate);
    const std::size_t edits = edits_between(sought, small);
    const bool within = !sought.empty() && small.find(sought) != std::string::npos;
    if (within || edits <= std::max<std::size_t>(2, sought.size() / 2)) near.emplace_back(edits, candidate);
  }
  std::ranges::stable_sort(near, {}, [](const auto& one) { return one.first; });
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(most, near.size()); ++i) names.push_back(near[i].second);
  return names;
}

toml::table parse_toml(std::string_view text, const std::string& path) {
  refuse_foreign_text(text, path + ":1:1", "TOML in UTF-8 text");
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    std::string_view line = text;
    for (toml::source_index i = 1; i < at.line; ++i) line.remove_prefix(std::min(line.find('\n'), line.size() - 1) + 1);
    line = line.substr(0, line.find('\n'));
    throw InputError(path + ":" + std::to_string(at.line) + ":" + std::to_string(at.column),
                     "text that is not TOML (" + std::string(error.description()) + ")", "lines such as key = value",
                     remedy_of_toml(line, error.description()));
  }
}

TomlSection::TomlSection(const toml::table* table, std::string name, const std::string& file)
    : table_(table), name_(std::move(name)), file_(file) {}

std::string TomlSection::full_name(std::string_view key) const {
  if (key.empty()) return name_;
  return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

std::string TomlSection::place(std::string_view key) const {
  std::string place = file_;
  if (table_ != nullptr) {
    toml::source_position at = table_->source().begin;
    const auto entry = table_->find(key);
    if (entry != table_->end()) at = entry->first.source().begin;
    if (at.line > 0) place += ":" + std::to_string(at.line) + ":" + std::to_string(at.column);
  }
  const std::string name = full_name(key);
  return name.empty() ? place : place + ": " + name;
}

std::string TomlSection::found(std::string_view key) const {
  const toml::node* node = table_ == nullptr ? nullptr : table_->get(key);
  if (node == nullptr) return "nothing";
  std::ostringstream text;
  switch (node->type()) {
    case toml::node_type::string: text << "the text \"" << node->ref<std::string>() << '"'; break;
    case toml::node_type::integer: text << node->ref<std::int64_t>(); break;
    case toml::node_type::floating_point: text << number_text(node->ref<double>()); break;
    case toml::node_type::boolean: text << (node->ref<bool>() ? "true" : "false"); break;
    case toml::node_type::table: text << "a table"; break;
    case toml::node_type::array: text << "a list"; break;
    default: text << "a date or time"; break;
  }
  return text.str();
}

void TomlSection::refuse_unfit_name(std::string_view key, const std::string& name) const {
  const bool is_clean = std::ranges::none_of(name, [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == '<' || c == '>' || c == '&' || c == '"';
  });
  if (!is_clean || name.empty()) {
    throw InputError(place(key), "the text \"" + name + "\"", "a name without control characters, <, >, & and quotes",
                     "use letters, digits, spaces and - . , _ / ( )");
  }
  if (name.size() > 64) {
    throw InputError(place(key), std::to_string(name.size()) + " bytes", "at most 64", "shorten the name");
  }
}

void TomlSection::refuse(std::string_view key, const std::string& expected, const std::string& remedy) const {
  throw InputError(place(key), found(key), expected, remedy);
}

const toml::node* TomlSection::take(std::string_view key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  return table_ == nullptr ? nullptr : table_->get(key);
}

TomlSection TomlSection::section(std::string_view key) {
  const toml::node* node = take(key);
  if (node != nullptr && !node->is_table()) {
    refuse(key, "a table", "write it as [" + full_name(key) + "] with its keys below");
  }
  return {node == nullptr ? nullptr : node->as_table(), full_name(key), file_};
}

std::string TomlSection::text(std::string_view key, std::string_view default_value) {
  const toml::node* node = take(key);
  if (node == nullptr) return std::string(default_value);
  if (!node->is_string()) refuse(key, "a text in quotes", "put the value in double quotes");
  return node->ref<std::string>();
}

std::string TomlSection::required_text(std::string_view key, std::string_view example) {
  std::string value = text(key, "");
  if (value.empty()) {
    const std::string example_line = std::string(key) + " = \"" + std::string(example) + "\"";
    if (has(key)) throw InputError(place(key), "an empty text", "a text", "write " + example_line + " or the like");
    refuse(key, "a text", "add " + example_line + (name_.empty() ? "" : " to [" + name_ + "]"));
  }
  return value;
}

double TomlSection::number(std::string_view key, double default_value, double min, double max, std::string_view unit) {
  const toml::node* node = take(key);
  if (node == nullptr) return default_value;
  const std::string expected =
      "a number from " + number_text(min) + " to " + number_text(max) + (unit.empty() ? "" : " " + std::string(unit));
  const auto value = node->is_number() ? node->value<double>() : std::nullopt;
  if (!value) {
    refuse(key, expected,
           node->is_string() ? "write the number without quotes and with a decimal point" : "write one number");
  }
  if (!(*value >= min && *value <= max)) {
    refuse(key, expected, "use a value in that range; the default is " + number_text(default_value));
  }
  return *value;
}

std::int64_t TomlSection::whole(std::string_view key, std::int64_t default_value, std::int64_t min, std::int64_t max) {
  const toml::node* node = take(key);
  if (node == nullptr) return default_value;
  const std::string expected = "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
  if (!node->is_integer()) refuse(key, expected, "write it without quotes and without a decimal point");
  const std::int64_t value = node->ref<std::int64_t>();
  if (value < min || value > max) {
    refuse(key, expected, "use a value in that range; the default is " + std::to_string(default_value));
  }
  return value;
}

int TomlSection::one_of(std::string_view key, int default_value, std::span<const int> numbers) {
  const std::int64_t value = whole(key, default_value, std::ranges::min(numbers), std::ranges::max(numbers));
  if (std::ranges::find(numbers, value) != numbers.end()) return static_cast<int>(value);
  std::string list;
  for (const int number : numbers) list += (list.empty() ? "" : ", ") + std::to_string(number);
  refuse(key, "one of " + list, "take the one that the devices have; it is in their manuals");
}

bool TomlSection::flag(std::string_view key, bool default_value) {
  const toml::node* node = take(key);
  if (node == nullptr) return default_value;
  if (!node->is_boolean()) refuse(key, "true or false", "write true or false without quotes");
  return node->ref<bool>();
}

std::size_t TomlSection::choice(std::string_view key, const std::vector<std::string>& choices,
                                std::size_t default_index) {
  const std::string value = text(key, choices[default_index]);
  const auto at = std::find(choices.begin(), choices.end(), value);
  if (at == choices.end()) {
    const std::string near = nearest_name(value, choices);
    refuse(key, "one of " + join(choices), near.empty() ? "choose one of them" : "did you mean \"" + near + "\"?");
  }
  return static_cast<std::size_t>(at - choices.begin());
}

int TomlSection::time_of_day(std::string_view key, int default_value_s) {
  const toml::node* node = take(key);
  if (node == nullptr) return default_value_s;
  if (const auto time = node->value<toml::time>()) return time->hour * 3600 + time->minute * 60 + time->second;
  const auto seconds = node->is_string() ? parse_time_of_day(node->ref<std::string>()) : std::nullopt;
  if (!seconds) refuse(key, "a time of day from 00:00 to 24:00", "write hours and minutes, such as \"07:00\"");
  return *seconds;
}

std::vector<std::string> TomlSection::text_list(std::string_view key) {
  const toml::node* node = take(key);
  std::vector<std::string> list;
  if (node == nullptr) return list;
  if (!node->is_array()) refuse(key, "a list of texts", "write it as [\"first\", \"second\"]");
  for (const toml::node& item : *node->as_array()) {
    if (!item.is_string()) refuse(key, "a list of texts", "put every item in double quotes");
    list.push_back(item.ref<std::string>());
  }
  return list;
}

std::vector<double> TomlSection::number_list(std::string_view key, double min, double max) {
  const toml::node* node = take(key);
  std::vector<double> list;
  if (node == nullptr) return list;
  const std::string expected = "a list of numbers from " + number_text(min) + " to " + number_text(max);
  if (!node->is_array()) refuse(key, expected, "write it as [1, 1.5, 2]");
  for (const toml::node& item : *node->as_array()) {
    const auto value = item.is_number() ? item.value<double>() : std::nullopt;
    const std::string where = "number " + std::to_string(list.size() + 1) + " of the list";
    if (!value) throw InputError(place(key), where + " is none", expected, "write numbers without quotes");
    if (!(*value >= min && *value <= max)) {
      throw InputError(place(key), where + ": " + number_text(*value), expected, "use a value in that range");
    }
    list.push_back(*value);
  }
  return list;
}

std::vector<std::string> TomlSection::take_all_keys() {
  if (table_ == nullptr) return {};
  std::vector<std::string> keys;
  for (const auto& [key, node] : *table_) keys.emplace_back(key.str());
  known_.insert(known_.end(), keys.begin(), keys.end());
  return keys;
}

void TomlSection::refuse_unknown_keys() const {
  if (table_ == nullptr) return;
  for (const auto& [key, node] : *table_) {
    const std::string_view name = key.str();
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    const std::string near = nearest_name(name, known_);
    throw UnknownKey(place(name), name_, std::string(name), "one of " + join(known_),
                     near.empty() ? "remove it" : "did you mean `" + near + "`?");
  }
}

}  // namespace airside::hal
