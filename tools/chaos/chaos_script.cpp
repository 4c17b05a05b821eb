#include "tools/chaos/chaos_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "airside/splitmix64.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools {
namespace {

constexpr double drawn = std::numeric_limits<double>::quiet_NaN();
constexpr double forever = 1e9;

constexpr std::array<ChaosKindRule, 25> kinds = {{
    {"late", ChaosKind::late, "the true answer, s seconds late", {{{"s", 3, 0, 3600}}}},
    {"duplicate", ChaosKind::duplicate, "the true answer, `times` times", {{{"times", 2, 2, 100}}}},
    {"unit", ChaosKind::unit, "the answer of the unit `by` further on", {{{"by", drawn, 1, 255}}}},
    {"transaction",
     ChaosKind::transaction,
     "the answer to the transaction `by` further on",
     {{{"by", drawn, 1, 65535}}}},
    {"protocol", ChaosKind::protocol, "an answer of protocol `id`", {{{"id", drawn, 1, 65535}}}},
    {"function", ChaosKind::function, "the answer of the function `by` further on", {{{"by", drawn, 1, 127}}}},
    {"trickle", ChaosKind::trickle, "the true answer, a byte each `gap` seconds", {{{"gap", 0.1, 0.001, 60}}}},
    {"endless",
     ChaosKind::endless,
     "an answer announced as 254 bytes long whose bytes trickle for ever",
     {{{"gap", 0.05, 0.001, 60}}}},
    {"truncate", ChaosKind::truncate, "the first `bytes` of the answer, then silence", {{{"bytes", drawn, 1, 260}}}},
    {"length", ChaosKind::length, "an answer whose length field says `says`", {{{"says", drawn, 0, 65535}}}},
    {"trailing", ChaosKind::trailing, "the true answer with `bytes` more behind it", {{{"bytes", 2, 1, 10000}}}},
    {"reset", ChaosKind::reset, "the first `bytes` of the answer, then RST", {{{"bytes", 0, 0, 260}}}},
    {"fin", ChaosKind::fin, "the first `bytes` of the answer, then FIN", {{{"bytes", drawn, 0, 260}}}},
    {"halfopen", ChaosKind::half_open, "this connection takes everything and answers nothing any more", {}},
    {"drop", ChaosKind::drop, "the request never reaches the server", {}},
    {"mute", ChaosKind::mute, "the request reaches the server, its answer is lost", {}},
    {"exception", ChaosKind::exception, "exception `code` instead of the server's answer", {{{"code", 4, 0, 255}}}},
    {"clamp",
     ChaosKind::clamp,
     "a written register is confirmed, and forwarded within low..high (raw, unsigned)",
     {{{"low", 0, 0, 65535}, {"high", 65535, 0, 65535}}}},
    {"alter",
     ChaosKind::alter,
     "a written register is confirmed, and forwarded with `add` on it (raw)",
     {{{"add", -100, -65535, 65535}}}},
    {"swallow", ChaosKind::swallow, "a write is confirmed and never forwarded", {}},
    {"flood", ChaosKind::flood, "random bytes without end, or for s seconds", {{{"s", forever, 0, forever}}}},
    {"noise", ChaosKind::noise, "`bytes` random bytes instead of the answer", {{{"bytes", drawn, 1, 100000}}}},
    {"refuse",
     ChaosKind::refuse,
     "all connections reset, and none taken for s seconds: the server restarts",
     {{{"s", 2, 0, 3600}}}},
    {"swap",
     ChaosKind::swap,
     "in answers to reads the two registers from `addr` on stand exchanged, `pairs` times",
     {{{"addr", 0, 0, 65535}, {"pairs", 1, 1, 62}}}},
    {"set",
     ChaosKind::set,
     "in answers to reads register `addr` shows `value` (raw)",
     {{{"addr", 0, 0, 65535}, {"value", 65535, 0, 65535}}}},
}};

std::string known_faults() {
  std::string names;
  for (const ChaosKindRule& k : kinds) names += fmt::format("{}{}", names.empty() ? "" : ", ", k.name);
  return names;
}

/// The place of a complaint, and the complaint.
struct ScriptPlace {
  std::string where;
  [[noreturn]] void complain(const std::string& found, const std::string& expected, const std::string& remedy) const {
    throw hal::InputError(where, found, expected, remedy);
  }
};

double script_number(const ScriptPlace& place, std::string_view key, std::string_view text, double min, double max) {
  double value = 0;
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || at != text.data() + text.size() || !(value >= min && value <= max)) {
    place.complain(fmt::format("{}={}", key, text), fmt::format("a number from {} to {}", min, max),
                   "correct the number");
  }
  return value;
}

struct ScriptRange {
  double from, to;
};
/// `120`, `120..260` or `120..`.
ScriptRange script_range(const ScriptPlace& place, std::string_view key, std::string_view text, double min) {
  const std::size_t dots = text.find("..");
  if (dots == std::string_view::npos) {
    const double only = script_number(place, key, text, min, 1e15);
    return {only, only};
  }
  const double from = script_number(place, key, text.substr(0, dots), min, 1e15);
  const std::string_view rest = text.substr(dots + 2);
  const double to = rest.empty() ? std::numeric_limits<double>::infinity() : script_number(place, key, rest, min, 1e15);
  if (to < from) {
    place.complain(fmt::format("{}={}", key, text), "a range that ends where it begins or later",
                   "exchange the two numbers");
  }
  return {from, to};
}

/// Takes `key=value` where it is a condition. False: it is none.
bool take_condition(const ScriptPlace& place, std::string_view key, std::string_view value, ChaosRule& rule) {
  if (key == "p") {
    rule.p = script_number(place, key, value, 0, 1);
  } else if (key == "n") {
    const ScriptRange r = script_range(place, key, value, 1);
    rule.first = static_cast<std::uint64_t>(r.from);
    if (std::isfinite(r.to)) rule.last = static_cast<std::uint64_t>(r.to);
  } else if (key == "t") {
    const ScriptRange r = script_range(place, key, value, 0);
    if (r.from == r.to) place.complain(fmt::format("t={}", value), "a range, as t=30..45", "give from and to");
    rule.from_s = r.from;
    rule.to_s = r.to;
  } else if (key == "on") {
    if (value != "read" && value != "write") {
      place.complain(fmt::format("on={}", value), "on=read or on=write", "leave the condition out for both");
    }
    rule.on = value == "read" ? ChaosOn::reads : ChaosOn::writes;
  } else if (key == "fc") {
    rule.function = static_cast<int>(script_number(place, key, value, 1, 127));
  } else if (key == "at") {
    rule.addr = static_cast<int>(script_number(place, key, value, 0, 65535));
  } else if (key == "wider") {
    rule.wider = static_cast<int>(script_number(place, key, value, 0, 2000));
  } else {
    return false;
  }
  return true;
}

struct ScriptPair {
  std::string_view key, value;
};
ScriptPair split_pair(const ScriptPlace& place, std::string_view text, const char* expected) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    place.complain(fmt::format("\"{}\"", text.substr(0, 60)), expected, "see `airside chaos --help`");
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// `NAME` or `NAME:key=value,...` into the rule.
void take_fault(const ScriptPlace& place, std::string_view text, ChaosRule& rule) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view name = text.substr(0, colon);
  const auto kind = std::ranges::find_if(kinds, [&](const ChaosKindRule& k) { return name == k.name; });
  if (kind == kinds.end()) {
    place.complain(fmt::format("the fault \"{}\"", name.substr(0, 60)), "one of " + known_faults(), "correct the name");
  }
  rule.fault.kind = kind->kind;
  for (std::size_t i = 0; i < kind->params.size(); ++i) rule.fault.param[i] = kind->params[i].otherwise;
  std::string_view rest = colon < text.size() ? text.substr(colon + 1) : std::string_view{};
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const ScriptPair pair = split_pair(place, rest.substr(0, comma), "parameters as NAME:key=value,key=value");
    rest.remove_prefix(std::min(comma + 1, rest.size()));
    bool taken = false;
    for (std::size_t i = 0; i < kind->params.size() && !taken; ++i) {
      const ChaosParam& p = kind->params[i];
      if (p.name == nullptr || pair.key != p.name) continue;
      rule.fault.param[i] = script_number(place, pair.key, pair.value, p.min, p.max);
      taken = true;
    }
    if (taken || take_condition(place, pair.key, pair.value, rule)) continue;
    std::string params;
    for (const ChaosParam& p : kind->params) {
      if (p.name != nullptr) params += fmt::format("{}, ", p.name);
    }
    place.complain(fmt::format("{}=", pair.key), fmt::format("{}p, n, t, on, fc, at or wider", params),
                   "correct or remove the parameter");
  }
  if (rule.fault.kind == ChaosKind::clamp && rule.fault.param[0] > rule.fault.param[1]) {
    place.complain(fmt::format("low={}, high={}", rule.fault.param[0], rule.fault.param[1]), "low at most high",
                   "exchange them");
  }
}

}  // namespace

std::span<const ChaosKindRule> chaos_kinds() { return kinds; }

const char* text_of(ChaosKind kind) {
  for (const ChaosKindRule& k : kinds) {
    if (k.kind == kind) return k.name;
  }
  return "none";
}

ChaosScript parse_chaos_script(std::string_view text, const std::string& file) {
  ChaosScript script;
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view content = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    content = content.substr(0, content.find('#'));
    std::vector<std::string_view> words;
    while (!content.empty()) {
      const std::size_t from = content.find_first_not_of(" \t\r");
      if (from == std::string_view::npos) break;
      content.remove_prefix(from);
      const std::size_t word_end = std::min(content.find_first_of(" \t\r"), content.size());
      words.push_back(content.substr(0, word_end));
      content.remove_prefix(word_end);
    }
    if (words.empty()) continue;
    const ScriptPlace place{fmt::format("{}:{}", file, line)};
    if (words.front() == "seed") {
      std::uint64_t seed = 0;
      const std::string_view value = words.size() == 2 ? words[1] : std::string_view{};
      const auto [at, error] = std::from_chars(value.data(), value.data() + value.size(), seed);
      if (value.empty() || error != std::errc{} || at != value.data() + value.size()) {
        place.complain("a seed that is no number", "seed and a whole number, as `seed 7`", "correct the number");
      }
      script.seed = seed;
      continue;
    }
    ChaosRule rule;
    rule.line = line;
    take_fault(place, words.back(), rule);
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
      const ScriptPair pair = split_pair(place, words[i], "conditions as p=0.1 n=1..9 t=30..45 on=write fc=3 at=0");
      if (!take_condition(place, pair.key, pair.value, rule)) {
        place.complain(fmt::format("the condition \"{}\"", pair.key), "p, n, t, on, fc, at or wider",
                       "correct the name; what belongs to a fault stands behind its colon");
      }
    }
    script.rules.push_back(rule);
  }
  return script;
}

ChaosRule parse_chaos_fault(std::string_view text, const std::string& place, int line) {
  ChaosRule rule;
  rule.line = line;
  take_fault({place}, text, rule);
  return rule;
}

ChaosFault choose_fault(std::span<const ChaosRule> rules, std::uint64_t seed, const ChaosRequest& request) {
  for (const ChaosRule& r : rules) {
    if (request.number < r.first || request.number > r.last) continue;
    if (request.t_s < r.from_s || request.t_s >= r.to_s) continue;
    if (r.on != ChaosOn::any && (r.on == ChaosOn::writes) != request.writes()) continue;
    if (r.function != 0 && r.function != request.function) continue;
    if (request.count <= r.wider) continue;
    if (r.addr >= 0 && (r.addr < request.addr || r.addr >= request.addr + request.count)) continue;
    SplitMix64 outer(seed ^ static_cast<std::uint64_t>(r.line) * 0xD1B54A32D192ED03u);
    SplitMix64 random(outer.next() ^ request.number * 0x8CB92BA72F3D8DD7u);
    random.next();
    if (random.uniform() >= r.p) continue;
    ChaosFault fault = r.fault;
    const auto kind = std::ranges::find_if(kinds, [&](const ChaosKindRule& k) { return k.kind == fault.kind; });
    for (std::size_t i = 0; i < fault.param.size(); ++i) {
      if (!std::isnan(fault.param[i])) continue;
      const ChaosParam& p = kind->params[i];
      fault.param[i] = std::floor(p.min + random.uniform() * (p.max - p.min + 1));
    }
    return fault;
  }
  return {};
}

}  // namespace airside::tools
