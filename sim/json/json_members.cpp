#include "sim/json/json_members.hpp"

#include "hal/text/input_error.hpp"

namespace airside::sim {

namespace {

constexpr bool is_blank(char letter) { return letter == ' ' || letter == '\n' || letter == '\r' || letter == '\t'; }

class MemberScan {
 public:
  MemberScan(std::string_view text, const std::string& place) : text_(text), place_(place) {}

  std::vector<JsonMember> members() {
    std::vector<JsonMember> found;
    expect('{');
    if (skip_blanks() == '}') return found;
    for (;;) {
      const std::string_view quoted = string();
      expect(':');
      found.push_back({quoted.substr(1, quoted.size() - 2), value()});
      if (skip_blanks() == '}') return found;
      expect(',');
    }
  }

 private:
  [[noreturn]] void refuse() const {
    const bool ended = at_ >= text_.size();
    throw hal::InputError(place_, ended ? "an end within an object" : "text that is no JSON object",
                          "a whole JSON object", "copy or install the file again");
  }
  /// The next letter that is no blank; 0 at the end.
  char skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  void expect(char letter) {
    if (skip_blanks() != letter) refuse();
    ++at_;
  }
  /// With its quotes.
  std::string_view string() {
    if (skip_blanks() != '"') refuse();
    const std::size_t begin = at_, size = text_.size();
    const char* const letters = text_.data();
    for (std::size_t i = begin + 1; i < size; ++i) {
      if (letters[i] == '"') return text_.substr(begin, (at_ = i + 1) - begin);
      if (letters[i] == '\\') ++i;
    }
    at_ = size;
    refuse();
  }
  std::string_view value() {
    const char first = skip_blanks();
    const std::size_t begin = at_;
    if (first == '"') return string();
    if (first != '{' && first != '[') {
      while (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != ',' && text_[at_] != '}') ++at_;
      if (at_ >= text_.size() || at_ == begin) refuse();
      return text_.substr(begin, at_ - begin);
    }
    const char* const letters = text_.data();
    const std::size_t size = text_.size();
    int depth = 0;
    for (std::size_t i = begin; i < size; ++i) {
      const char letter = letters[i];
      if (letter == '"') {
        for (++i; i < size && letters[i] != '"'; ++i) {
          if (letters[i] == '\\') ++i;
        }
      } else if (letter == '{' || letter == '[') {
        ++depth;
      } else if ((letter == '}' || letter == ']') && --depth == 0) {
        return text_.substr(begin, (at_ = i + 1) - begin);
      }
    }
    at_ = size;
    refuse();
  }

  std::string_view text_;
  const std::string& place_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<JsonMember> json_members(std::string_view text, const std::string& place) {
  return MemberScan(text, place).members();
}

}  // namespace airside::sim
