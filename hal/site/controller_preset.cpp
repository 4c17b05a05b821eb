#include "hal/site/controller_preset.hpp"

#include <array>
#include <cstddef>

#include "airside/presets.hpp"
#include "airside/repaired_settings.hpp"

namespace airside::hal {
namespace {

struct PresetEntry {
  const char* name;
  ControllerSettings (*settings)();
};
/// In the order of ControllerPreset.
constexpr std::array<PresetEntry, 3> presets{{
    {"product", product_settings},
    {"paper", paper_settings},
    {"paper-repaired", paper_repaired_settings},
}};

const PresetEntry& entry_of(ControllerPreset preset) { return presets[static_cast<std::size_t>(preset)]; }

}  // namespace

const char* name_of(ControllerPreset preset) { return entry_of(preset).name; }
ControllerSettings settings_of(ControllerPreset preset) { return entry_of(preset).settings(); }

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const PresetEntry& e : presets) names.emplace_back(e.name);
  return names;
}

ControllerPreset preset_named(std::string_view name) {
  for (std::size_t i = 0; i < presets.size(); ++i) {
    if (name == presets[i].name) return static_cast<ControllerPreset>(i);
  }
  return ControllerPreset::product;
}

}  // namespace airside::hal
