#pragma once
// On which shapes of flow and temperatures the power of an air handler depends: physics, without a coefficient.

#include <algorithm>

namespace airside {

/// What power depends on at one instant.
struct AirState {
  double flow = 0;  ///< share of all dampers open, 0..1
  double supply_degc = 0;
  double room_degc = 0;  ///< mean of the zones
  double outdoor_degc = 0;
  double cold_share = 0;    ///< of the zones that are near where they heat, 0..1
  double cold_boxes_k = 0;  ///< mean over zones of damper (T - T_supply), of those
  double ventilation = 0;   ///< outdoor air that flows in any case, share of all dampers open
};

/// The shapes of one instant, or their mean over a cycle. Linear in the coefficients, so that means may be taken.
struct PowerShapes {
  double flow = 0;        ///< F
  double flow_cubed = 0;  ///< F^3
  double lift = 0;        ///< F (T_room - T_supply) / 10: what the coil gives where outdoor air is a fixed flow
  double lift_warm = 0;   ///< lift (T_out - 25) / 10: a chiller is worse on warm days
  double coil = 0;        ///< with an economizer: F (T_out - T_supply)+ / 10 below room temperature, else lift
  double coil_warm = 0;   ///< coil (T_out - 25) / 10
  double outdoor = 0;     ///< (T_out - 20) / 10: ventilation's load
  double cold_share = 0;  ///< of zones that heat: what they need
  double reheat = 0;      ///< damper (T_room - T_supply) / 10 of those: what the supply air adds to that
  double preheat = 0;     ///< (ventilation (T_room - T_out) / 10 - lift)+: too much cold outdoor air is warmed
};

inline PowerShapes power_shapes(const AirState& a) {
  const double lift_k = a.room_degc - a.supply_degc;
  const double saved_k = std::clamp(a.room_degc - a.outdoor_degc, 0.0, std::max(0.0, lift_k));
  const double warm = (a.outdoor_degc - 25) / 10;
  PowerShapes x;
  x.flow = a.flow;
  x.flow_cubed = a.flow * a.flow * a.flow;
  x.lift = a.flow * lift_k / 10;
  x.lift_warm = x.lift * warm;
  x.coil = a.flow * (lift_k - saved_k) / 10;
  x.coil_warm = x.coil * warm;
  x.outdoor = (a.outdoor_degc - 20) / 10;
  x.cold_share = a.cold_share;
  x.reheat = a.cold_boxes_k / 10;
  x.preheat = std::max(0.0, a.ventilation * (a.room_degc - a.outdoor_degc) / 10 - x.lift);
  return x;
}

/// to += factor x, shape by shape.
inline void add(PowerShapes& to, const PowerShapes& x, double factor = 1) {
  to.flow += factor * x.flow;
  to.flow_cubed += factor * x.flow_cubed;
  to.lift += factor * x.lift;
  to.lift_warm += factor * x.lift_warm;
  to.coil += factor * x.coil;
  to.coil_warm += factor * x.coil_warm;
  to.outdoor += factor * x.outdoor;
  to.cold_share += factor * x.cold_share;
  to.reheat += factor * x.reheat;
  to.preheat += factor * x.preheat;
}

}  // namespace airside
