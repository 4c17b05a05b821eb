#include "tools/gap/explain/meter_offset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/gap/explain/day_stretch.hpp"
#include "tools/gap/explain/interval_text.hpp"
#include "tools/gap/model/residual.hpp"

namespace airside::tools::gap {

namespace {

constexpr double meter_sd_95 = 1.96;

MeterOffset offset_of(const Eigen::VectorXd& x, const sim::Recording& recording, int meter,
                      const MeterOffsetRules& rules) {
  const Eigen::VectorXd day = mean_day(x, bins_per_day);
  const DayStretch stretch = active_stretch(day);
  MeterOffset offset;
  offset.meter = meter;
  offset.from_h = stretch.from_h();
  offset.to_h = stretch.to_h();
  for (Eigen::Index bin = 0; bin < bins_per_day; ++bin) {
    if (stretch.holds(bin)) offset.kw += day(bin) / static_cast<double>(stretch.length);
  }
  offset.kwh_per_day = 24 * day.mean();
  const double of_days = sd_of_days(x, recording, stretch.from, stretch.length);
  offset.sd_kw = std::hypot(of_days, rules.model_share * offset.kw);
  offset.above_noise =
      of_days > 0 && std::abs(offset.kw) > rules.limit_sd * of_days && std::abs(offset.kw) > rules.least_kw;
  if (offset.above_noise) {
    offset.text = fmt::format("power {} is {} kW {} the model {} ({:.1f} kWh a day)", meter + 1,
                              with_interval(std::abs(offset.kw), meter_sd_95 * offset.sd_kw),
                              offset.kw < 0 ? "below" : "above", stretch.text(), std::abs(offset.kwh_per_day));
  }
  return offset;
}

}  // namespace

std::vector<MeterOffset> meter_offsets(const Eigen::MatrixXd& residual, const sim::Recording& recording,
                                       const sim::Channels& channels, const MeterOffsetRules& rules) {
  std::vector<MeterOffset> offsets;
  for (int c = channels.power(); c < channels.fcu_duty(); ++c)
    offsets.push_back(offset_of(residual.col(c), recording, c - channels.power(), rules));
  return offsets;
}

std::string text_of(const std::vector<MeterOffset>& offsets) {
  std::vector<const MeterOffset*> order;
  for (const MeterOffset& offset : offsets) {
    if (offset.above_noise) order.push_back(&offset);
  }
  std::sort(order.begin(), order.end(),
            [](const MeterOffset* a, const MeterOffset* b) { return std::abs(a->kw) > std::abs(b->kw); });
  std::string text;
  for (const MeterOffset* offset : order) text += (text.empty() ? "" : "; ") + offset->text;
  return text;
}

nlohmann::json json_of(const std::vector<MeterOffset>& offsets, const sim::Channels& channels) {
  nlohmann::json list = nlohmann::json::array();
  for (const MeterOffset& offset : offsets) {
    list.push_back({{"meter", channels.name(channels.power() + offset.meter)},
                    {"above_noise", offset.above_noise},
                    {"hours", {offset.from_h, offset.to_h}},
                    {"kw", offset.kw},
                    {"sd_kw", offset.sd_kw},
                    {"kwh_per_day", offset.kwh_per_day},
                    {"text", offset.text}});
  }
  return list;
}

}  // namespace airside::tools::gap
