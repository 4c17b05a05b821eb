#pragma once
// What a person types for the register of a signal: the short form, and how it is shown again.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/site/ask/init_answers.hpp"

namespace airside::tools {

bool is_written_signal(std::string_view name);

/// Takes a register alone, such as 40, or `4:40:int16:0.1:0:big:2`: function, register, type, scale, offset, word
/// order, registers from one to the next; what is empty or left out is as `airside init` has it. Returns what is wrong,
/// "" where nothing is.
std::string take_register(const std::string& answer, std::string_view name, SignalAnswer& out);

/// Takes one of `types` for the signal `name`, in capitals too. Returns what is wrong.
std::string take_type(const std::string& answer, std::string_view name, const std::vector<std::string>& types,
                      std::optional<std::string>& type);

/// big or little, or a word for them: abcd, cdab, swapped. Returns what is wrong.
std::string take_word_order(const std::string& answer, std::optional<std::string>& order);

/// The whole answer in the form that take_register() takes; `-` where the signal is absent.
std::string short_form(const SignalAnswer& whole, int count);

/// In words, of a whole answer: "holding register 40, int16, scale 0.01, offset 0". `count`: signals of the kind.
std::string register_in_words(const SignalAnswer& whole, int count);

}  // namespace airside::tools
