#pragma once
// Where each signal of a site is: one question after the other.

#include <map>
#include <string>

#include "tools/cli/site/ask/init_answers.hpp"
#include "tools/cli/site/ask/questions.hpp"

namespace airside::tools {

/// Asks for all signals that the counts and the objective of `answers` have, and fills `answers.signals`. `former` are
/// the answers that were given before, shown in brackets; it is kept up to date.
/// Errors: Back where the person goes back from the first signal; hal::InputError where the input ends.
void ask_signals(Questions& questions, InitAnswers& answers, std::map<std::string, SignalAnswer>& former);

}  // namespace airside::tools
