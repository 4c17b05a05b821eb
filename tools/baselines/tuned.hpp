#pragma once
// What `airside study tune` found, frozen: the gains of the tuned peers, plant by plant. Days and rooms of the search
// are never scored; docs/results.md, "Peers", has the grids and the figures.

#include "tools/baselines/pid.hpp"

namespace airside::tools {

/// Units: integral 1/h; rho, the share of the present error left after one cycle, none.
struct TunedGains {
  PidGains pid;
  double integral_ki_per_h;
  double arx_rho;      ///< two parameters
  double arx_rls_rho;  ///< with exogenous differences
  double mpc_move_weight;
  double mpc_disturbance_share;
};

/// Source: `airside study tune --plant rc`.
inline constexpr TunedGains gains_on_rc{
    .pid = {0.0, 8.0, 0.0},
    .integral_ki_per_h = 8.0,
    .arx_rho = -0.1,
    .arx_rls_rho = -0.1,
    .mpc_move_weight = 0.0003,
    .mpc_disturbance_share = 0.2,
};

/// Source: `airside study tune --plant energyplus`.
inline constexpr TunedGains gains_on_energyplus{
    .pid = {0.05, 8.0, 0.0},
    .integral_ki_per_h = 8.0,
    .arx_rho = 0.0,
    .arx_rls_rho = -0.05,
    .mpc_move_weight = 0.05,
    .mpc_disturbance_share = 0.3,
};

constexpr const TunedGains& tuned_gains(PlantKind plant) {
  return plant == PlantKind::rc ? gains_on_rc : gains_on_energyplus;
}

}  // namespace airside::tools
