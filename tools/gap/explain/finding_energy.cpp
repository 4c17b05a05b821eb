#include "tools/gap/explain/finding_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

FindingEnergy energy_of(const Finding& finding, const Eigen::MatrixXd& with, const Eigen::MatrixXd& without,
                        const sim::Channels& channels) {
  constexpr double hours_per_day = 24;
  FindingEnergy energy;
  const Eigen::Index bins = with.rows() - bins_per_day;  // the first day remembers an unknown start
  for (int c = channels.power(); c < channels.fcu_duty(); ++c) {
    energy.by_meter.push_back(hours_per_day * (with.col(c) - without.col(c)).tail(bins).mean());
    energy.total += energy.by_meter.back();
    energy.without += hours_per_day * without.col(c).tail(bins).mean();
  }
  const double null = finding.at.effect->null_value, size = finding.magnitude - null;
  const MagnitudeInterval interval = interval_of(finding);
  const double one = size == 0 ? energy.total : energy.total * (interval.low - null) / size;
  const double other = size == 0 ? energy.total : energy.total * (interval.high - null) / size;
  energy.low = std::min(one, other);
  energy.high = std::max(one, other);
  return energy;
}

std::string sentence_of(const FindingEnergy& energy, const Price& price) {
  if (energy.by_meter.empty() || !energy.is_sure()) return "";
  const double sign = energy.total < 0 ? -1 : 1;
  const double low = sign * (sign < 0 ? energy.high : energy.low), high = sign * (sign < 0 ? energy.low : energy.high);
  std::string text = fmt::format("it takes {:.1f} kWh a day {} ({:.1f} to {:.1f})", std::abs(energy.total),
                                 sign < 0 ? "less" : "more", low, high);
  if (price.per_kwh > 0) text += fmt::format(", {:.2f} {}", price.per_kwh * std::abs(energy.total), price.currency);
  return text;
}

nlohmann::json json_of(const FindingEnergy& energy, const Finding& finding, const sim::Channels& channels,
                       const Price& price) {
  nlohmann::json by_meter = nlohmann::json::object();
  for (std::size_t i = 0; i < energy.by_meter.size(); ++i)
    by_meter[channels.name(channels.power() + static_cast<int>(i))] = energy.by_meter[i];
  nlohmann::json j = {{"id", finding.at.id()},
                      {"kwh_per_day", energy.total},
                      {"interval", {energy.low, energy.high}},
                      {"without_kwh_per_day", energy.without},
                      {"by_meter", by_meter},
                      {"cost_per_day", nullptr}};
  if (price.per_kwh > 0) j["cost_per_day"] = {{"cost", price.per_kwh * energy.total}, {"currency", price.currency}};
  return j;
}

}  // namespace airside::tools::gap
