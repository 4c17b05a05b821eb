#pragma once
// What a file is that is no text of the kind that was asked for: a workbook, a web page, text of another encoding.

#include <string>
#include <string_view>

namespace airside::hal {

/// Nothing where `bytes` may be UTF-8 text of the wanted kind.
/// Errors: InputError at `place` for text in UTF-16, archives and workbooks, web pages and pointers of Git LFS, with
/// the way to the file that was meant; `expected` says what that is, such as "a site file in TOML".
void refuse_foreign_text(std::string_view bytes, const std::string& place, const std::string& expected);

/// Nothing where columns of `header`, the first line of a CSV file, are separated by commas.
/// Errors: InputError at `place` for semicolons and tabs.
void refuse_other_separator(std::string_view header, const std::string& place);

/// What to do about `line` of a TOML file, which the parser refused with the words `said`.
std::string remedy_of_toml(std::string_view line, std::string_view said);

}  // namespace airside::hal
