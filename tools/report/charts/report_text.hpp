#pragma once
// Text and numbers on their way into HTML, SVG and script: escaped once, here.

#include <string>
#include <string_view>
#include <vector>

#include "airside/civil_time.hpp"

namespace airside::tools {

/// For element content and quoted attributes of HTML and SVG. Control characters are dropped, invalid UTF-8 becomes
/// U+FFFD.
std::string escape_markup(std::string_view text);

/// JSON that may stand inside a script element: no '<', '>', '&' or line separator is left in it.
std::string escape_script_json(std::string_view json);

/// Valid UTF-8 with U+FFFD for every broken byte.
std::string valid_utf8(std::string_view text);

/// Lower-case letters, digits and dashes, at most 48, never empty: a part of a file name.
std::string slug(std::string_view text);

/// With thousands apart by thin spaces and a true minus sign; "–" when not finite.
std::string number_text(double value, int decimals);

/// Round numbers that cover [low, high], about `count` of them, in steps of 1, 2 or 5 times a power of ten.
std::vector<double> round_ticks(double low, double high, int count);

// Times as the operator's page has them, in every report:
std::string date_text(CivilTime time);    ///< `2021-08-06`
std::string minute_text(CivilTime time);  ///< `2021-08-06 14:30`
std::string day_text(CivilTime time);     ///< `08-06`, on axes

/// `1 day`, `3 days`.
std::string days_text(long days);

/// A tick with no more decimals than its step needs.
std::string tick_text(double value, double step);

}  // namespace airside::tools
