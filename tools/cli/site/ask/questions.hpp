#pragma once
// Questions on a terminal: each answer is checked when it is given, and a wrong one is asked again.

#include <exception>
#include <functional>
#include <istream>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace airside::tools {

/// Nothing where a text is no whole number, or no number, from its beginning to its end.
std::optional<int> whole_of(const std::string& text);
std::optional<double> real_of(const std::string& text);
/// `7:00` or `07:00`. Units: s since midnight.
std::optional<int> time_of(const std::string& text);

std::string in_small_letters(std::string text);

/// What to write instead where a number has a decimal comma or is a fraction: "; write ..."; "" where it is neither.
std::string hint_of_number(const std::string& text);

/// A text cut at each `separator`.
std::vector<std::string> parts_of(const std::string& text, char separator);

/// Thrown by a question whose answer is `back`: the one before is to be asked again.
struct Back : std::exception {};

/// Asks until an answer is right; an empty line takes what is in brackets.
/// Errors of each question: hal::InputError where the input ends; Back.
class Questions {
 public:
  /// `complaint` looks at all answers so far, and says what is wrong with them, "" where nothing is; the answer that
  /// was just given is then asked again.
  Questions(std::istream& in, std::ostream& out, std::function<std::string()> complaint)
      : in_(in), out_(out), complaint_(std::move(complaint)) {}

  void say(const std::string& text) { out_ << text << '\n'; }

  /// `take` returns what is wrong with an answer, "" where it was taken. Without a default an answer must be given.
  /// `help` answers `?`; without it what is wrong with `?` does, which `take` then must refuse.
  void ask(const std::string& question, const std::string& otherwise,
           const std::function<std::string(const std::string&)>& take, const std::string& help = "");

  void whole(const std::string& question, int& value, int least, int most, const std::string& help = "");
  void number(const std::string& question, double& value, double least, double most, const std::string& help = "");
  /// Where `value` is empty there is no default, and `example` is shown.
  void text(const std::string& question, std::string& value, const std::string& example, const std::string& help);
  /// Which of the words, in capitals or small letters, the first being the default; `set` gets its place.
  void choice(const std::string& question, const std::vector<std::string>& words,
              const std::function<void(std::size_t)>& set, const std::string& help = "");

 private:
  /// Sets `value`, and takes it back where there is something wrong with it.
  template <class Value>
  std::string try_value(Value& value, const Value& given) {
    const Value before = value;
    value = given;
    std::string wrong = complaint_();
    if (!wrong.empty()) value = before;
    return wrong;
  }

  std::istream& in_;
  std::ostream& out_;
  std::function<std::string()> complaint_;
};

}  // namespace airside::tools
