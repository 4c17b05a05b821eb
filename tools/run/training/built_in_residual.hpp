#pragma once
// The residual network that pretrained weights carry.

#include "airside/forecast/residual_forecaster.hpp"

namespace airside::tools {

/// Learned from made-up RC rooms and EnergyPlus twins together, in all conditions that each plant knows; `airside
/// residual` gives one for the user's own rooms.  Source: docs/forecasting.md, "A network that is worth its weights".
ResidualNetwork built_in_residual();

}  // namespace airside::tools
