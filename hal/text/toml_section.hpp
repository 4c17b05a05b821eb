#pragma once
// One table of a TOML file, read key by key: types and ranges are checked at each read, and keys that nobody
// read are refused at the end with the nearest known name.

#include <toml++/toml.h>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace airside::hal {

/// The whole of a TOML text; `path` names it in complaints.
/// Errors: InputError with line and column.
toml::table parse_toml(std::string_view text, const std::string& path);

/// A node of a TOML file with its place for messages.
class TomlSection {
 public:
  /// `name` is the dotted path of the table, "" for the whole file. `table` may be null: everything is a default.
  TomlSection(const toml::table* table, std::string name, const std::string& file);

  bool present() const { return table_ != nullptr; }

  /// The table `key` below this one; not present() when the file has none.
  /// Errors: InputError when the key is not a table.
  TomlSection section(std::string_view key);

  /// Each reads one key and checks it; the default stands when the key is missing.
  /// Errors: InputError.
  std::string text(std::string_view key, std::string_view default_value);
  std::string required_text(std::string_view key, std::string_view example);
  double number(std::string_view key, double default_value, double min, double max, std::string_view unit);
  std::int64_t whole(std::string_view key, std::int64_t default_value, std::int64_t min, std::int64_t max);
  /// A whole number out of a list.
  int one_of(std::string_view key, int default_value, std::span<const int> numbers);
  bool flag(std::string_view key, bool default_value);
  /// One of `choices`; returns its index.
  std::size_t choice(std::string_view key, const std::vector<std::string>& choices, std::size_t default_index);
  /// `07:00` as seconds since midnight.
  int time_of_day(std::string_view key, int default_value_s);
  std::vector<std::string> text_list(std::string_view key);
  std::vector<double> number_list(std::string_view key, double min, double max);

  /// All keys of this table, marked as read.
  std::vector<std::string> take_all_keys();

  /// Refuses the first key that nobody asked for.
  void refuse_unknown_keys() const;

  /// file:line:column: name.key of a key, or of the table when the key is missing.
  std::string place(std::string_view key) const;
  /// What stands at `key`, as a person would say it.
  std::string found(std::string_view key) const;
  [[noreturn]] void refuse(std::string_view key, const std::string& expected, const std::string& remedy) const;
  /// Refuses a name that people are shown with control characters, <, >, & or quotes, or above 64 bytes.
  void refuse_unfit_name(std::string_view key, const std::string& name) const;
  bool has(std::string_view key) const { return table_ != nullptr && table_->contains(key); }

 private:
  const toml::node* take(std::string_view key);
  std::string full_name(std::string_view key) const;

  const toml::table* table_;
  std::string name_;
  const std::string& file_;
  std::vector<std::string> known_;
};

/// The name in `known` with the fewest edits to `name`; empty when none is near.
std::string nearest_name(std::string_view name, const std::vector<std::string>& known);
/// At most `most` names of `known` that are near `name` or contain it, whatever their case, the nearest first.
std::vector<std::string> near_names(std::string_view name, const std::vector<std::string>& known, std::size_t most);

}  // namespace airside::hal
