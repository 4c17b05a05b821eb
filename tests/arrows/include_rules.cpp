#include "arrows/include_rules.hpp"

#include <regex>
#include <sstream>

namespace airside::arrows {
namespace {

template <class OnLine>
void each_line(const std::string& text, OnLine on_line) {
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) on_line(number, line);
}

std::string place(const std::string& file, int line) { return file + ":" + std::to_string(line) + ": "; }

}  // namespace

Breaches include_breaches(const std::string& folder, const std::string& file, const std::string& text) {
  static const std::regex include(R"(^\s*#\s*include(?:_next)?\s*([<"])([^>"]+)[>"])");
  const std::set<std::string>& allowed = may_include.at(folder);
  Breaches found;
  each_line(text, [&](int number, const std::string& line) {
    std::smatch match;
    if (!std::regex_search(line, match, include)) return;
    const std::string name = match[2];
    const std::string root = name.substr(0, name.find('/'));
    const bool ours = root == "airside" || root == "tests" || may_include.contains(root);
    const bool neighbour = match[1] == "\"" && root == name;  // a private header in the same folder
    if (ours && !allowed.contains(root)) {
      found.push_back(place(file, number) + folder + " includes " + name);
    } else if (name.starts_with("..")) {
      found.push_back(place(file, number) + "include from the project root, not " + name);
    } else if (folder == "lib" && !ours && !neighbour && !lib_headers.contains(name)) {
      found.push_back(place(file, number) + "lib includes " + name);
    }
  });
  return found;
}

Breaches target_breaches(const std::string& folder, const std::string& file, const std::string& text) {
  static const std::regex target(R"(\bairside_(hal|sim|tools|firmware)\b)");
  Breaches found;
  each_line(text, [&](int number, const std::string& line) {
    for (std::sregex_iterator hit(line.begin(), line.end(), target), end; hit != end; ++hit) {
      if (!may_include.at(folder).contains((*hit)[1])) {
        found.push_back(place(file, number) + folder + " names " + hit->str());
      }
    }
  });
  return found;
}

Breaches fast_math_breaches(const std::string& file, const std::string& text) {
  static const std::regex option("-Ofast|-f(fast-math|finite-math-only|unsafe-math-optimizations|associative-math)");
  Breaches found;
  each_line(text, [&](int number, const std::string& line) {
    if (std::regex_search(line, option)) found.push_back(place(file, number) + line);
  });
  return found;
}

}  // namespace airside::arrows
