#include "hal/text/foreign_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "hal/text/input_error.hpp"

namespace airside::hal {
namespace {

struct Mark {
  std::string_view begins, found, remedy;
};

constexpr const char* as_utf8 = "save it as UTF-8; a spreadsheet calls that CSV UTF-8, with commas";
constexpr const char* page_remedy = "download the file itself: a server sent a page instead, such as one to sign in";
constexpr std::array marks = {
    Mark{"\xFF\xFE", "text in UTF-16, not text in UTF-8", as_utf8},
    Mark{"\xFE\xFF", "text in UTF-16, not text in UTF-8", as_utf8},
    Mark{"\x1F\x8B", "bytes that are not text: a file that gzip packed", "unpack it with gunzip"},
    Mark{"PK", "bytes that are not text: a workbook or a zip archive", "export the sheet as plain CSV, or unpack it"},
    Mark{"version https://git-lfs", "a pointer of Git LFS instead of the file", "fetch the file with git lfs pull"},
    Mark{"<!doctype html", "a web page", page_remedy},
    Mark{"<html", "a web page", page_remedy},
};

bool begins(std::string_view text, std::string_view with) {
  return text.size() >= with.size() && std::equal(with.begin(), with.end(), text.begin(), [](char a, char b) {
           return a == b || a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
         });
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view value_of(std::string_view line) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return {};
  const std::size_t from = line.find_first_not_of(" \t", equals + 1);
  return from == std::string_view::npos ? std::string_view() : line.substr(from);
}

bool is_decimal_comma(std::string_view value) {
  std::size_t at = 0;
  while (at < value.size() && (is_digit(value[at]) || value[at] == '-')) ++at;
  return at > 0 && at + 1 < value.size() && value[at] == ',' && is_digit(value[at + 1]);
}

bool is_flag_of_people(std::string_view value) {
  const std::string_view word = value.substr(0, value.find_first_of(" \t#"));
  return std::ranges::any_of(std::array<std::string_view, 6>{"yes", "no", "on", "off", "true", "false"},
                             [&](std::string_view flag) { return word.size() == flag.size() && begins(flag, word); });
}

}  // namespace

void refuse_foreign_text(std::string_view bytes, const std::string& place, const std::string& expected) {
  const std::size_t from = bytes.find_first_not_of(" \t\r\n");
  const std::string_view text = from == std::string_view::npos ? std::string_view() : bytes.substr(from);
  for (const Mark& mark : marks) {
    if (begins(text, mark.begins)) {
      throw InputError(place, std::string(mark.found), expected, std::string(mark.remedy));
    }
  }
}

void refuse_other_separator(std::string_view header, const std::string& place) {
  if (header.find(',') != std::string_view::npos) return;
  const bool tabs = header.find('\t') != std::string_view::npos;
  if (!tabs && header.find(';') == std::string_view::npos) return;
  throw InputError(place, tabs ? "columns separated by tabs" : "columns separated by `;`", "columns separated by `,`",
                   "export with comma as separator and point as decimal mark");
}

std::string remedy_of_toml(std::string_view line, std::string_view said) {
  const auto has = [&](std::string_view text) { return line.find(text) != std::string_view::npos; };
  const std::string_view value = value_of(line);
  if (said.find("utf-8") != std::string_view::npos) return "save the file as UTF-8";
  if (said.find("redefine") != std::string_view::npos) {
    return "it is there twice: keep one of the two, with all keys below it";
  }
  if (has("<<<<<<<") || has("=======") || has(">>>>>>>"))
    return "settle the merge of two versions and take its marks out";
  if (has("\xE2\x80\x9C") || has("\xE2\x80\x9D") || has("\xE2\x80\x9E")) return "write straight double quotes";
  if (said.find("escape") != std::string_view::npos) return "write the path with / instead of \\";
  if (is_decimal_comma(value)) return "write the decimal mark as a point";
  if (is_flag_of_people(value)) return "write true or false, in small letters";
  if (value.empty() && std::ranges::count(line, ',') > 1) return "give the site's .toml file; this line is one of CSV";
  return "correct the line; texts and times stand in double quotes";
}

}  // namespace airside::hal
