#include "sim/weather/synthetic_weather.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/stateless_draw.hpp"

namespace airside::sim {
namespace {

enum WeatherStream : std::uint64_t { cloud_day = 11, cloud_hour, temp_day, rain_hour, humidity_hour, wind_hour };
constexpr double persistence = 0.65;  // of clouds and warm spells, from one day to the next

// Stationary first-order chain with unit variance, day by day.
std::vector<double> day_chain(std::uint64_t seed, std::uint64_t stream) {
  std::vector<double> chain(366);
  const double fresh = std::sqrt(1 - persistence * persistence);
  double state = draw_normal(seed, stream, 0, -1);
  for (std::size_t day = 0; day < chain.size(); ++day) {
    state = persistence * state + fresh * draw_normal(seed, stream, 0, static_cast<std::int64_t>(day));
    chain[day] = state;
  }
  return chain;
}

double between_days(const std::vector<double>& chain, std::size_t day, double share) {
  return chain[day] * (1 - share) + chain[day + 1] * share;
}

}  // namespace

std::shared_ptr<const Weather> synthetic_weather(std::uint64_t seed, const Climate& climate, const std::string& of) {
  using std::numbers::pi;
  const auto clouds = day_chain(seed, cloud_day);
  const auto warmth = day_chain(seed, temp_day);
  const std::int64_t new_year = civil_midnight(2023, 1, 1).seconds;
  const double rain_share = climate.rain_hours_per_year / 8760;

  std::vector<WeatherRecord> records(8760);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const auto hour = static_cast<std::int64_t>(i);
    const std::size_t day = i / 24;
    const double end_h = static_cast<double>(i % 24) + 1;  // records are stamped at their end
    const double day_share = end_h / 24;
    const double cloud_of_day = between_days(clouds, day, day_share);
    const double cloudiness = std::clamp(
        climate.mean_cloudiness + 0.22 * cloud_of_day + 0.14 * draw_normal(seed, cloud_hour, 0, hour), 0.0, 1.0);

    const double season = std::cos(2 * pi * (static_cast<double>(day) + day_share - 201) / 365);
    const double swing =
        climate.daily_swing_k * (1.15 - 0.5 * std::clamp(climate.mean_cloudiness + 0.22 * cloud_of_day, 0.0, 1.0));
    const bool rains = cloudiness > 0.45 && draw_uniform(seed, rain_hour, 0, hour) < rain_share * 2.2;

    WeatherRecord& r = records[i];
    r.outdoor_temp_degc = climate.mean_temp_degc + climate.seasonal_swing_k * season +
                          climate.day_temp_sd_k * between_days(warmth, day, day_share) +
                          swing * std::cos(2 * pi * (end_h - 14.5) / 24) - (rains ? 1.2 : 0.0);
    r.relative_humidity_pct = std::clamp(
        88 - 2.6 * (r.outdoor_temp_degc - climate.mean_temp_degc - climate.seasonal_swing_k * season + swing) +
            (rains ? 8 : 0) + 2 * draw_normal(seed, humidity_hour, 0, hour),
        35.0, 100.0);
    r.wind_speed_m_s =
        std::max(0.3, 2.2 + 1.0 * std::sin(2 * pi * (end_h - 9) / 24) + 0.7 * draw_normal(seed, wind_hour, 0, hour));
    r.rain = rains ? 1.0 : 0.0;
    const double up = sun_at(climate.location, {new_year + hour * 3600 + 1800}).up;
    if (up > 0) {
      const double clear_direct = 950 * std::exp(-0.14 / std::max(up, 0.05));
      const double clear_diffuse = 60 + 60 * up;
      r.direct_normal_w_m2 = clear_direct * std::pow(1 - cloudiness, 1.1);
      r.diffuse_horizontal_w_m2 = up * (clear_diffuse + 260 * cloudiness * (1.2 - cloudiness)) * (rains ? 0.6 : 1.0);
      r.diffuse_horizontal_w_m2 = std::min(r.diffuse_horizontal_w_m2, 420.0);
      r.global_horizontal_w_m2 = r.direct_normal_w_m2 * up + r.diffuse_horizontal_w_m2;
    }
  }
  const std::string kind = climate.mean_temp_degc < 18 ? "temperate" : "hot-humid";
  const std::string whose = of.empty() ? ", seed " + std::to_string(seed) : " " + of;
  return std::make_shared<const Weather>(climate.location, "synthetic " + kind + " year" + whose, 3600, 0,
                                         std::move(records));
}

}  // namespace airside::sim
