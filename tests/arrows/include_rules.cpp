#include "arrows/include_rules.hpp"

#include <algorithm>
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

/// on_include(line number, name, quoted) for each #include.
template <class OnInclude>
void each_include(const std::string& text, OnInclude on_include) {
  static const std::regex include(R"(^\s*#\s*include(?:_next)?\s*([<"])([^>"]+)[>"])");
  each_line(text, [&](int number, const std::string& line) {
    std::smatch match;
    if (std::regex_search(line, match, include)) on_include(number, match[2].str(), match[1] == "\"");
  });
}

std::string place(const std::string& file, int line) { return file + ":" + std::to_string(line) + ": "; }

std::string top_of(const std::string& path) { return path.substr(0, path.find('/')); }

bool is_top(const std::string& name) { return std::find(tops.begin(), tops.end(), name) != tops.end(); }

}  // namespace

Graph read_arrows(const std::string& text, Breaches& breaches) {
  Graph arrows;
  std::string wing;
  each_line(text, [&](int number, const std::string& line) {
    if (line.empty() || line[0] == '#') return;
    std::istringstream words(line);
    std::string word;
    if (line[0] != ' ') {
      words >> wing;
      if (!wing.ends_with(':')) breaches.push_back(place("arrows.txt", number) + "expected WING:, found " + wing);
      wing = wing.substr(0, wing.find(':'));
      if (arrows.contains(wing)) breaches.push_back(place("arrows.txt", number) + wing + " is listed twice");
      arrows[wing];
    }
    while (words >> word) {
      if (word == wing || !arrows.contains(word)) {
        breaches.push_back(place("arrows.txt", number) + wing + " may include only wings listed before it, not " +
                           word);
      } else {
        arrows[wing].insert(word);
      }
    }
  });
  return arrows;
}

std::string wing_of(const std::string& path) {
  const std::string top = top_of(path);
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return "";
  if (top == "airside") return "lib/" + path.substr(0, slash);
  return is_top(top) || top == "tests" ? path.substr(0, slash) : "";
}

std::set<std::string> wings_included(const std::string& wing, const std::string& text) {
  std::set<std::string> wings;
  each_include(text, [&](int, const std::string& name, bool) {
    const std::string other = wing_of(name);
    if (!other.empty() && other != wing) wings.insert(other);
  });
  return wings;
}

Breaches include_breaches(const Graph& arrows, const std::string& wing, const std::string& file,
                          const std::string& text) {
  const auto listed = arrows.find(wing);
  if (listed == arrows.end()) return {file + ": wing " + wing + " is not in tests/arrows/arrows.txt"};
  Breaches found;
  each_include(text, [&](int number, const std::string& name, bool quoted) {
    const std::string other = wing_of(name);
    const bool neighbour = quoted && name.find('/') == std::string::npos;  // a private header in the same folder
    if (name.starts_with("..")) {
      found.push_back(place(file, number) + "include from the project root, not " + name);
    } else if (!other.empty() && other != wing && !listed->second.contains(other)) {
      found.push_back(place(file, number) + wing + " includes " + name);
    } else if (other.empty() && top_of(wing) == "lib" && !neighbour && !lib_headers.contains(name)) {
      found.push_back(place(file, number) + "lib includes " + name);
    }
  });
  return found;
}

Breaches target_breaches(const Graph& arrows, const std::string& folder, const std::string& file,
                         const std::string& text) {
  static const std::regex target(R"(\bairside_(hal|sim|tools|firmware)\b)");
  std::set<std::string> allowed = {folder};
  for (const auto& [wing, others] : arrows) {
    if (top_of(wing) != folder) continue;
    for (const std::string& other : others) allowed.insert(top_of(other));
  }
  Breaches found;
  each_line(text, [&](int number, const std::string& line) {
    for (std::sregex_iterator hit(line.begin(), line.end(), target), end; hit != end; ++hit) {
      if (!allowed.contains((*hit)[1])) found.push_back(place(file, number) + folder + " names " + hit->str());
    }
  });
  return found;
}

std::string arrows_text(const Graph& used, Breaches& breaches) {
  std::string text;
  std::set<std::string> placed, left;
  for (const char* top : tops) {
    for (const auto& [wing, others] : used) {
      if (top_of(wing) == top) left.insert(wing);
    }
    for (bool moved = true; moved;) {
      moved = false;
      for (const std::string& wing : left) {
        const std::set<std::string>& others = used.at(wing);
        if (!std::includes(placed.begin(), placed.end(), others.begin(), others.end())) continue;
        std::string line = wing + ":";
        for (const std::string& other : others) {
          if (line.size() + 1 + other.size() > 120) {
            text += line + "\n";
            line = "   ";
          }
          line += " " + other;
        }
        text += line + "\n";
        placed.insert(wing);
        left.erase(wing);
        moved = true;
        break;
      }
    }
    for (const std::string& wing : left) {
      std::string above;
      for (const std::string& other : used.at(wing)) above += placed.contains(other) ? "" : " " + other;
      breaches.push_back(wing + " includes what includes it, or a higher top folder:" + above);
    }
    left.clear();
  }
  return text;
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
