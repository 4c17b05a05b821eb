#pragma once
// The one shape of a complaint about input: where, what was found, what was expected, what to do.

#include <stdexcept>
#include <string>

namespace airside::hal {

/// Thrown by every reader of a file or request, before anything has been changed or half-written.
/// what() is "PLACE: found FOUND; expected EXPECTED; REMEDY", PLACE is file:line or file: field.
class InputError : public std::runtime_error {
 public:
  InputError(std::string place, std::string found, std::string expected, std::string remedy)
      : std::runtime_error(place + ": found " + found + "; expected " + expected + "; " + remedy),
        place_(std::move(place)),
        found_(std::move(found)),
        expected_(std::move(expected)),
        remedy_(std::move(remedy)) {}

  const std::string& place() const { return place_; }
  const std::string& found() const { return found_; }
  const std::string& expected() const { return expected_; }
  const std::string& remedy() const { return remedy_; }

 private:
  std::string place_, found_, expected_, remedy_;
};

}  // namespace airside::hal
