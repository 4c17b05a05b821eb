#include <cmath>

#include "tools/gap/explain/flux.hpp"

namespace airside::tools::gap {

nlohmann::json json_of(const UnknownHeat& heat, bool series) {
  nlohmann::json zones = nlohmann::json::array();
  const auto number = [](double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(); };
  for (const ZoneHeat& z : heat.zones) {
    nlohmann::json drivers = nlohmann::json::array();
    for (const HeatDriver& d : z.drivers) {
      drivers.push_back(
          {{"name", d.name}, {"r", d.r}, {"r_days", d.r_days}, {"linked", d.linked}, {"clearly_not", d.clearly_not}});
    }
    zones.push_back({{"zone", z.zone + 1},
                     {"above_noise", z.above_noise},
                     {"mean_kw", z.mean_kw},
                     {"mean_sd_kw", z.mean_sd_kw},
                     {"hours", {z.from_h, z.to_h}},
                     {"active_kw", z.active_kw},
                     {"active_sd_kw", z.active_sd_kw},
                     {"peak_kw", z.peak_kw},
                     {"kwh_per_day", z.kwh_per_day},
                     {"weekday_kw", number(z.weekday_kw)},
                     {"weekend_kw", number(z.weekend_kw)},
                     {"days_share", z.days_share},
                     {"drivers", drivers},
                     {"text", z.text}});
  }
  nlohmann::json j = {
      {"text", heat.text}, {"smoothing", heat.smoothing}, {"leftover", heat.residual_ratio}, {"zones", zones}};
  if (!series) return j;
  const auto rounded_series = [](const Eigen::MatrixXd& m) {
    nlohmann::json list = nlohmann::json::array();
    for (Eigen::Index zone = 0; zone < m.cols(); ++zone) {
      nlohmann::json values = nlohmann::json::array();
      for (Eigen::Index t = 0; t < m.rows(); ++t) values.push_back(std::round(1000 * m(t, zone)) / 1000);
      list.push_back(std::move(values));
    }
    return list;
  };
  j["heat_kw"] = rounded_series(heat.heat_kw);
  j["sd_kw"] = rounded_series(heat.sd_kw);
  return j;
}

}  // namespace airside::tools::gap
