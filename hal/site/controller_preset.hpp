#pragma once
// The presets that a site file or a command line may name, and the settings that each begins with.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "airside/settings.hpp"

namespace airside::hal {

enum class ControllerPreset : std::uint8_t { product, paper, paper_repaired };

/// `paper-repaired`, as site files and options have it.
const char* name_of(ControllerPreset preset);
ControllerSettings settings_of(ControllerPreset preset);

/// Every name, in the order of ControllerPreset.
std::vector<std::string> preset_names();
/// The preset of a name that was checked against preset_names(); `product` for any other.
ControllerPreset preset_named(std::string_view name);

}  // namespace airside::hal
