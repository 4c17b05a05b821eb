#pragma once
// EnergyPlus's own Transition programs, where the user has them: an install's PreProcess/IDFVersionUpdater.

#include <filesystem>
#include <string>

#include "tools/adopt/upgrade/upgrade.hpp"

namespace airside::tools {

/// The folder of Transition programs: `option`, else $AIRSIDE_TRANSITIONS, else that of the engine; empty
/// where there is none. An install's own folder is as good as its folder of programs.
/// Errors: hal::InputError where a folder that was asked for has no Transition programs.
std::filesystem::path transitions_folder(const std::string& option, const std::filesystem::path& engine);

/// An IDF of version `from` as one of `to`, by Transition-V*-to-V* one after the other in a folder of their own.
/// Errors: hal::InputError where no chain of programs leads from one version to the other, or one of them fails.
/// Cost: about 1 s a step.
std::string transitioned_idf(const std::string& text, const std::string& place, const std::string& from,
                             const std::string& to, const std::filesystem::path& programs, Upgrade& done);

}  // namespace airside::tools
