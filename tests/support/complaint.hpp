#pragma once
// What a table-driven case expects of an InputError: parts of its four texts.

#include <gtest/gtest.h>
#include <string>

#include "hal/text/input_error.hpp"

namespace airside::hal {

struct Complaint {
  const char* place;
  const char* found;
  const char* expected;
  const char* remedy;
};

/// Runs `read` and checks that it throws an InputError whose texts contain those of `want`.
template <class Read>
void expect_complaint(const Complaint& want, Read&& read) {
  try {
    read();
    ADD_FAILURE() << "was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(error.place().find(want.place), std::string::npos) << "place: " << error.place();
    EXPECT_NE(error.found().find(want.found), std::string::npos) << "found: " << error.found();
    EXPECT_NE(error.expected().find(want.expected), std::string::npos) << "expected: " << error.expected();
    EXPECT_NE(error.remedy().find(want.remedy), std::string::npos) << "remedy: " << error.remedy();
  }
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the case edits a text that is not there: " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace airside::hal
