#pragma once
// Verdicts as files: what `airside gap --json` prints and `airside gap score` reads.  Format: docs/formats.md.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/gap/clean_up/clean_up.hpp"
#include "tools/gap/verdict/magnitude.hpp"
#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// Units are in the names; ids as EffectAt::id(). "locked" is null where nothing was found that could help there.
nlohmann::json json_of(const Verdict& verdict, const std::string& name, const Responses& responses,
                       const sim::Channels& channels, const Rules& rules = {});

/// A case whose logs cannot be used: {case, verdict "refused", reason}.
nlohmann::json refused_json(const std::string& name, const std::string& reason);

/// The clean-up table, a row a remark.
nlohmann::json json_of(const CleanLog& log);

/// A number, or null where it is not finite.
nlohmann::json finite_json(double value);

/// One sentence a finding, for people: "flow of box 3 is not what its controller believes: factor 0.71 (0.57 to 0.86);
/// ..".
std::string sentence_of(const Finding& finding);

/// A row for each effect of at least 1 %, six at most, then nothing and something else.
std::string text_of(const Posterior& p, const Alternatives& tried);

/// The verdict in one sentence: "named: ..", "ambiguous: A or B: ..", "unknown: ..", "no gap above the floor". What is
/// not sure beside something named comes last.
std::string sentence_of(const Verdict& verdict);

/// The clean-up table for people: a few values that never came, in many columns, are one row.
std::vector<Remark> shown_remarks(const CleanLog& log);

/// The clean-up table for a terminal: one line a remark, none for a clean log.
std::string text_of(const CleanLog& log);

}  // namespace airside::tools::gap
