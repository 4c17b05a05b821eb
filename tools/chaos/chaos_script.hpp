#pragma once
// What the chaos proxy does to which exchange: faults by name, and rules that say when. Grammar: docs/formats.md, "Bus
// fault script".

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace airside::tools {

/// What is done to one exchange. The order is that of chaos_kinds().
enum class ChaosKind : std::uint8_t {
  none,
  late,
  duplicate,
  unit,
  transaction,
  protocol,
  function,
  trickle,
  endless,
  truncate,
  length,
  trailing,
  reset,
  fin,
  half_open,
  drop,
  mute,
  exception,
  clamp,
  alter,
  swallow,
  flood,
  noise,
  refuse,
  swap,
  set,
};

/// A parameter of a fault. NaN as default: drawn anew from the seed in each exchange.
struct ChaosParam {
  const char* name = nullptr;
  double otherwise = 0, min = 0, max = 0;
};

struct ChaosKindRule {
  const char* name;
  ChaosKind kind;
  const char* what;  ///< one line for --help
  std::array<ChaosParam, 2> params;
};
/// Every fault that a script may name.
std::span<const ChaosKindRule> chaos_kinds();
const char* text_of(ChaosKind kind);

struct ChaosFault {
  ChaosKind kind = ChaosKind::none;
  std::array<double, 2> param{};  ///< in the order of ChaosKindRule::params
};

enum class ChaosOn : std::uint8_t { any, reads, writes };

/// A fault and when it is done. All conditions must hold.
struct ChaosRule {
  ChaosFault fault;
  double p = 1;             ///< probability
  std::uint64_t first = 1;  ///< exchange numbers, both included
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  double from_s = 0, to_s = std::numeric_limits<double>::infinity();  ///< since the proxy began; `to` excluded
  ChaosOn on = ChaosOn::any;
  int function = 0;  ///< 0: any
  int addr = -1;     ///< an address that the request covers; -1: any
  int wider = 0;     ///< only requests of more registers or bits than this
  int line = 0;      ///< of the script; draws differ from line to line
};

struct ChaosScript {
  std::optional<std::uint64_t> seed;
  std::vector<ChaosRule> rules;  ///< the first that applies is done
};

/// A request as rules see it.
struct ChaosRequest {
  std::uint64_t number = 0;  ///< counted from 1
  double t_s = 0;
  int function = 0, addr = 0, count = 1;
  bool writes() const { return function == 5 || function == 6 || function == 15 || function == 16; }
};

/// Reads a script; `file` stands in messages.
/// Errors: hal::InputError with file:line, what was found, what was expected, what to do.
ChaosScript parse_chaos_script(std::string_view text, const std::string& file);

/// One rule of the command line: `late`, `late:p=0.1,s=2`, `exception:on=write,code=4`.
/// Errors: hal::InputError naming `place`.
ChaosRule parse_chaos_fault(std::string_view text, const std::string& place, int line);

/// The fault of a request: the first rule whose conditions hold and whose draw falls; drawn parameters filled in.
/// The same seed, rules and request always give the same.
ChaosFault choose_fault(std::span<const ChaosRule> rules, std::uint64_t seed, const ChaosRequest& request);

}  // namespace airside::tools
