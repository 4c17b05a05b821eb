#pragma once
// Checks of what is typed after an option, for the options of all commands.

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>

namespace airside::tools {

/// For options that take a seed: a whole number from 0 to 2^63 - 1, as site files have it. Without it CLI11 takes a
/// minus sign as a wrap and cuts what is too long.
CLI::Validator seed_check();

/// Refuses options that were given beside something that does not heed them: it must not look as if they had been used.
/// Errors: hal::InputError of the first one.
void refuse_given(const CLI::App& command, std::initializer_list<const char*> options, const std::string& beside,
                  const char* expected, const char* remedy = "leave one of them out");

}  // namespace airside::tools
