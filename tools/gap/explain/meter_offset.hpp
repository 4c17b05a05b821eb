#pragma once
// Where no effect explains the gap: the power that a meter shows beyond the model, when, how much and on which days,
// after the missing heat was put into the zones.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/weather/recording.hpp"
#include "tools/gap/verdict/rules.hpp"

namespace airside::tools::gap {

struct MeterOffsetRules {
  double limit_sd = 6;        ///< below which it is noise: days are few, a peak is looked for ..
  double least_kw = 0.1;      ///< .. and below this nobody would look for it
  double model_share = 0.18;  ///< sd from the twin's other errors, of the amount
};

/// Measured less simulated, in the hours in which the mean day is above half of its peak.
struct MeterOffset {
  int meter = 0;  ///< 0-based
  bool above_noise = false;
  double from_h = 0, to_h = 24;
  double kw = 0, sd_kw = 0;  ///< in those hours
  double kwh_per_day = 0;    ///< of the whole day
  std::string text;          ///< "power 2 is 1.2 ± 0.3 kW above the model between 8 and 18 h"; empty where it is noise
};

/// One a meter. sd^2 = sd_days^2 + (model_share kw)^2, sd_days from how the days differ (DayStretch); a peak is looked
/// for, so that only `limit_sd` of them count.
/// Shape: residual: bins x channels; NaN: not measured.  Units: kW.
std::vector<MeterOffset> meter_offsets(const Eigen::MatrixXd& residual, const sim::Recording& recording,
                                       const sim::Channels& channels, const MeterOffsetRules& rules = {});

/// Those above the noise, largest first, joined; "" where there is none.
std::string text_of(const std::vector<MeterOffset>& offsets);

nlohmann::json json_of(const std::vector<MeterOffset>& offsets, const sim::Channels& channels);

}  // namespace airside::tools::gap
