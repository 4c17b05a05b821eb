#include "tools/adopt/upgrade/table/idf_text.hpp"

#include <algorithm>
#include <cstdlib>

#include "hal/text/input_error.hpp"

namespace airside::tools::upgrade {

namespace {

std::string trimmed(std::string_view text) {
  constexpr const char* blanks = " \t\r\n\f\v\xEF\xBB\xBF";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(blanks) - first + 1));
}

char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

}  // namespace

const std::string& IdfObject::field(int number) const {
  static const std::string none;
  const auto at = static_cast<std::size_t>(number - 1);
  return at < fields.size() ? fields[at] : none;
}

double IdfObject::number(int field_number) const { return std::strtod(field(field_number).c_str(), nullptr); }

void IdfObject::set(int number, const std::string& text) {
  const auto at = static_cast<std::size_t>(number - 1);
  if (at >= fields.size()) {
    if (text.empty()) return;
    fields.resize(at + 1);
  }
  fields[at] = text;
}

bool IdfObject::insert(int number, int count, const std::string& text) {
  const auto at = static_cast<std::size_t>(number - 1);
  if (at >= fields.size()) {
    set(number, text);
    return !text.empty();
  }
  fields.insert(fields.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::size_t>(count), text);
  return true;
}

bool IdfObject::remove(int number) {
  const auto at = static_cast<std::size_t>(number - 1);
  if (at >= fields.size()) return false;
  fields.erase(fields.begin() + static_cast<std::ptrdiff_t>(at));
  return true;
}

void IdfObject::trim() {
  while (!fields.empty() && fields.back().empty()) fields.pop_back();
}

void IdfObject::mark(const std::string& version) {
  if (steps.empty() || steps.back() != version) steps.push_back(version);
}

bool IdfObject::is(std::string_view other_type) const { return IdfText::same(type, other_type); }

bool IdfText::same(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return upper(x) == upper(y); });
}

IdfObject* IdfText::find(std::string_view type, std::string_view name) {
  const auto found =
      std::ranges::find_if(objects, [&](const IdfObject& o) { return o.is(type) && same(o.name(), name); });
  return found == objects.end() ? nullptr : &*found;
}

std::vector<IdfObject*> IdfText::all(std::string_view type) {
  std::vector<IdfObject*> found;
  for (IdfObject& object : objects) {
    if (object.is(type)) found.push_back(&object);
  }
  return found;
}

IdfText parse_idf(const std::string& text, const std::string& place) {
  IdfText idf;
  IdfObject object;
  std::string piece;
  int line = 1, begin = 0;
  bool comment = false, first = true;
  const auto take = [&](bool last) {
    (first ? object.type : object.fields.emplace_back()) = trimmed(piece);
    object.line = begin;
    piece.clear();
    first = false;
    if (!last) return;
    if (!object.type.empty()) idf.objects.push_back(std::move(object));
    object = {};
    first = true;
    begin = 0;
  };
  for (const char c : text) {
    if (c == '\n') {
      ++line;
      comment = false;
    }
    if (comment) continue;
    if (c == '!') {
      comment = true;
    } else if (c == ',' || c == ';') {
      take(c == ';');
    } else {
      if (begin == 0 && static_cast<unsigned char>(c) > ' ') begin = line;
      piece += c;
    }
  }
  if (!first || !trimmed(piece).empty()) {
    throw hal::InputError(place + ":" + std::to_string(begin), "an object that does not end", "a \";\" behind it",
                          "see that the copy is whole");
  }
  return idf;
}

std::string idf_text(const IdfText& idf) {
  std::string text;
  for (const IdfObject& object : idf.objects) {
    text += object.type;
    for (const std::string& field : object.fields) text += ",\n  " + field;
    text += ";\n\n";
  }
  return text;
}

}  // namespace airside::tools::upgrade
