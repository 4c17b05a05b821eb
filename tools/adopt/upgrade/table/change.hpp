#pragma once
// What a new version of EnergyPlus changed in an object type: the rows of the tables in steps/.

#include <span>

#include "tools/adopt/upgrade/table/idf_text.hpp"

namespace airside::tools::upgrade {

/// A word of the old version and its successor.
struct Word {
  const char* from;
  const char* to;
};

enum class ChangeKind {
  insert,     ///< fields before `field`, with the text `text` or empty; where a field is one of `words`, with its `to`
  remove,     ///< the field
  retype,     ///< the object has the type `text`
  words,      ///< a field that is one of `words`, without case; field 0 is every field
  parts,      ///< a field that holds one of `words`
  fill,       ///< an empty field means `text`, which a new default would hide
  rename,     ///< epJSON alone: the key `name` is `text`
  refuse,     ///< the object needs more than a table says; `text` is what
  refuse_if,  ///< where the field holds the first of `words`, or where it is not empty
};

/// One row. Fields count from 1 in an IDF, and have a name in epJSON. Rows of one type follow one another: a number is
/// right after the rows before it.
struct Change {
  ChangeKind kind;
  const char* type;
  int field = 0;
  int count = 1;
  const char* name = "";
  const char* text = "";
  std::span<const Word> words = {};
};

constexpr Change insert(const char* type, int field, int count = 1, const char* name = "", const char* text = "") {
  return {ChangeKind::insert, type, field, count, name, text, {}};
}
constexpr Change insert_by(const char* type, int field, const char* name, const char* text,
                           std::span<const Word> list) {
  return {ChangeKind::insert, type, field, 1, name, text, list};
}
constexpr Change remove(const char* type, int field, const char* name) {
  return {ChangeKind::remove, type, field, 1, name, "", {}};
}
constexpr Change retype(const char* type, const char* to) { return {ChangeKind::retype, type, 0, 1, "", to, {}}; }
constexpr Change words(const char* type, int field, const char* name, std::span<const Word> list) {
  return {ChangeKind::words, type, field, 1, name, "", list};
}
constexpr Change parts(const char* type, int field, const char* name, std::span<const Word> list) {
  return {ChangeKind::parts, type, field, 1, name, "", list};
}
constexpr Change fill(const char* type, int field, const char* name, const char* text) {
  return {ChangeKind::fill, type, field, 1, name, text, {}};
}
constexpr Change rename(const char* type, const char* name, const char* to) {
  return {ChangeKind::rename, type, 0, 1, name, to, {}};
}
constexpr Change refuse(const char* type, const char* why) { return {ChangeKind::refuse, type, 0, 1, "", why, {}}; }
constexpr Change refuse_if(const char* type, int field, const char* name, std::span<const Word> held, const char* why) {
  return {ChangeKind::refuse_if, type, field, 1, name, why, held};
}

/// An object that cannot be brought to a newer version.
struct Refusal {
  std::string type, name, why;
  int line = 0;
  std::string from = {}, to = {};  ///< the step
};

/// From one version to the next.
struct Step {
  const char* from;
  const char* to;
  std::span<const Change> changes;
  /// What no row can say, done before the rows; null where there is nothing.
  void (*whole)(IdfText&, std::vector<Refusal>&) = nullptr;
  /// Types whose epJSON changed in its shape: an epJSON that has one is refused.
  std::span<const char* const> whole_types = {};
};

}  // namespace airside::tools::upgrade
