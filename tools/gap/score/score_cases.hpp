#pragma once
// Cases of a blind test, read from verdicts and key: what was hidden in each and what was said.

#include <array>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace airside::tools::gap {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// What a verdict says.
enum class SaidKind { named, ambiguous, unknown, none, refused };
constexpr std::array<const char*, 5> kind_names{"named", "ambiguous", "unknown", "none", "refused"};
constexpr std::array<const char*, 6> set_names{"single", "null", "real_null", "outside", "pair", "real"};

struct HiddenEffect {
  std::string id;
  double magnitude = not_known;
};

struct SaidEffect {
  std::string id;
  double magnitude = not_known, low = not_known, high = not_known, margin = not_known;
  bool has_interval = false;
  std::vector<std::string> class_ids;
};

struct SaidLocked {
  double before = not_known, after = not_known, floor = not_known, right = not_known, temp_after_k = not_known;
};

/// How probable each explanation is beside the other findings.
struct SaidPosterior {
  std::vector<std::string> beside, set;                       ///< ids; set: also "nothing", "other"
  std::vector<std::pair<std::string, double>> probabilities;  ///< the same
};

/// A case of the key, with what was said about it.
struct ScoredCase {
  std::string id, set, engine, workflow;
  std::optional<bool> feedback;
  std::optional<double> ratio;
  std::vector<HiddenEffect> hidden;
  bool answered = false;
  SaidKind kind = SaidKind::none;
  std::vector<SaidEffect> effects;
  std::vector<std::string> ranking;
  std::optional<SaidLocked> locked;
  std::vector<std::string> tests;  ///< done on site before this was said
  std::vector<ScoredCase> after;   ///< what was said after the first test, after the second, ..
  std::vector<SaidPosterior> posteriors;
};

/// "vav_flow" of "vav_flow@3".
inline std::string name_of(const std::string& id) { return id.substr(0, id.find('@')); }
inline bool is_named(const ScoredCase& c) { return c.kind == SaidKind::named; }
std::vector<const ScoredCase*> of_set(const std::vector<ScoredCase>& cases, const std::string& set);

/// Errors: as score().
std::vector<ScoredCase> read_cases(const nlohmann::json& verdicts, const nlohmann::json& key,
                                   const std::map<std::string, double>& null_of);

}  // namespace airside::tools::gap
