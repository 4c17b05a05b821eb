#pragma once
// An IDF as its objects with their fields in order, read without knowing any object type.

#include <string>
#include <string_view>
#include <vector>

namespace airside::tools::upgrade {

/// One object of an IDF.
struct IdfObject {
  std::string type;
  std::vector<std::string> fields;  ///< without the type
  int line = 0;                     ///< where it begins; 0 for one that an upgrade added
  std::vector<std::string> steps;   ///< the versions that changed it

  /// The field of a number from 1; empty where the object ends before it.
  const std::string& field(int number) const;
  /// The field as a number; 0 where it is none.
  double number(int field_number) const;
  /// Writes a field; fields before it become empty where there are none. An empty text behind the end adds nothing.
  void set(int number, const std::string& text);
  /// Puts `count` fields before the field of a number; nothing where the object ends before it and `text` is empty.
  /// Returns whether the object has changed.
  bool insert(int number, int count, const std::string& text = {});
  /// Takes out a field; returns whether it was there.
  bool remove(int number);
  /// Takes off empty fields at the end.
  void trim();
  bool is(std::string_view other_type) const;
  /// Notes that a version has changed it.
  void mark(const std::string& version);
  const std::string& name() const { return field(1); }
};

struct IdfText {
  std::vector<IdfObject> objects;

  /// Of a type, without case; its first field too.
  IdfObject* find(std::string_view type, std::string_view name);
  std::vector<IdfObject*> all(std::string_view type);
  /// Whether two names are one to the engine.
  static bool same(std::string_view a, std::string_view b);
};

/// Errors: hal::InputError at the line of an object that does not end.
IdfText parse_idf(const std::string& text, const std::string& place);

/// One field a line, as ExpandObjects wants it, without comments.
std::string idf_text(const IdfText& idf);

}  // namespace airside::tools::upgrade
