#include "sim/rc/rc_floor.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace airside::sim {

double mean_room_temp_after(const RcPlant& plant, double setpoint_degc, Foresight foresight, int ahead_s) {
  RcPlant branch = plant;
  if (foresight == Foresight::frozen) branch.freeze_disturbances();
  if (foresight == Foresight::profile) branch.expect_disturbances();
  branch.set_setpoint(setpoint_degc);
  branch.advance_to({plant.time().seconds + ahead_s});
  return branch.mean_shown_temp_degc();
}

double floor_setpoint(const RcPlant& plant, double target_degc, double lo, double hi, Foresight foresight,
                      int ahead_s) {
  if (!(lo <= hi)) throw std::invalid_argument("floor_setpoint: the lower limit is above the upper one");
  constexpr double tolerance_k = 1e-4;
  const auto miss = [&](double setpoint) {
    return mean_room_temp_after(plant, setpoint, foresight, ahead_s) - target_degc;
  };
  double low = lo, high = hi;
  double miss_low = miss(low), miss_high = miss(high);
  if (miss_low >= 0) return low;
  if (miss_high <= 0) return high;
  // False position with the stale end's miss halved (Illinois): a fan coil that switches makes the curve jump.
  double best = low, best_miss = miss_low;
  int kept = 0;
  for (int i = 0; i < 20 && high - low > 1e-5; ++i) {
    const double guess = low + (high - low) * miss_low / (miss_low - miss_high);
    const double miss_guess = miss(guess);
    if (std::fabs(miss_guess) < std::fabs(best_miss)) {
      best = guess;
      best_miss = miss_guess;
    }
    if (std::fabs(miss_guess) < tolerance_k) break;
    if (miss_guess < 0) {
      low = guess;
      miss_low = miss_guess;
      if (kept == -1) miss_high /= 2;
      kept = -1;
    } else {
      high = guess;
      miss_high = miss_guess;
      if (kept == 1) miss_low /= 2;
      kept = 1;
    }
  }
  return best;
}

double frozen_floor_setpoint(const RcPlant& plant, double target_degc, double lo, double hi) {
  return floor_setpoint(plant, target_degc, lo, hi, Foresight::frozen);
}
double profile_floor_setpoint(const RcPlant& plant, double target_degc, double lo, double hi) {
  return floor_setpoint(plant, target_degc, lo, hi, Foresight::profile);
}
double full_forecast_setpoint(const RcPlant& plant, double target_degc, double lo, double hi) {
  return floor_setpoint(plant, target_degc, lo, hi, Foresight::full);
}

}  // namespace airside::sim
