#pragma once
// Completion of the command line in bash and zsh, from the commands and options that the program really has.

#include <CLI/CLI.hpp>
#include <string>

namespace airside::tools {

/// A script for bash that completes commands, options, and values where an option takes one of a list.
std::string bash_completion(const CLI::App& app);
/// The same for zsh, with each description beside its word.
std::string zsh_completion(const CLI::App& app);

}  // namespace airside::tools
