#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/gap/explain/day_stretch.hpp"
#include "tools/gap/explain/flux.hpp"
#include "tools/gap/explain/interval_text.hpp"

namespace airside::tools::gap {

namespace {

constexpr double sd_95 = 1.96;

/// A known quantity, one value a bin; NaN where unknown.
struct KnownSeries {
  std::string name;
  bool weather = false;
  Eigen::VectorXd value;
};

Eigen::VectorXd without_mean_day(Eigen::VectorXd x, Eigen::Index first) {
  const Eigen::VectorXd day = mean_day(x, first);
  for (Eigen::Index t = 0; t < x.size(); ++t) x(t) -= day(t % bins_per_day);
  return x;
}

double variance_of(const Eigen::VectorXd& x, Eigen::Index first) {
  const auto tail = x.tail(x.size() - first).array();
  return (tail - tail.mean()).square().mean();
}

/// NaN where one of them never changes.
double correlation_of(const Eigen::VectorXd& x, const Eigen::VectorXd& y, Eigen::Index first) {
  const auto a = x.tail(x.size() - first).array(), b = y.tail(y.size() - first).array();
  const double vx = variance_of(x, first), vy = variance_of(y, first);
  if (!(vx > 1e-12) || !(vy > 1e-12)) return std::numeric_limits<double>::quiet_NaN();
  return ((a - a.mean()) * (b - b.mean())).mean() / std::sqrt(vx * vy);
}

/// What a zone's heat is compared with.
std::vector<KnownSeries> known_series(const sim::Recording& recording, Eigen::Index bins, const sim::Channels& channels,
                                      int zone) {
  std::vector<KnownSeries> list;
  const auto add = [&](const char* name, bool weather, auto&& value_of_row) {
    KnownSeries s{name, weather, Eigen::VectorXd::Zero(bins)};
    for (Eigen::Index t = 0; t < bins; ++t) {
      for (int r = 0; r < rows_per_bin; ++r)
        s.value(t) += value_of_row(static_cast<std::size_t>(t * rows_per_bin + r)) / rows_per_bin;
      if (!std::isfinite(s.value(t))) s.value(t) = t > 0 ? s.value(t - 1) : 0;
    }
    list.push_back(std::move(s));
  };
  const auto row = [&](std::size_t i) -> const sim::RecordedRow& { return recording.rows[i]; };
  const auto mean = [](const std::vector<double>& x) {
    double sum = 0;
    for (const double v : x) sum += v / static_cast<double>(x.size());
    return sum;
  };
  add("outdoor temperature", true, [&](std::size_t i) { return row(i).outdoor_temp_degc; });
  add("sun", true, [&](std::size_t i) { return recording.station->at(recording.time(i)).global_horizontal_w_m2; });
  add("rain", true, [&](std::size_t i) { return row(i).rain; });
  add("working hours", false, [&](std::size_t i) {
    const double hour = recording.time(i).second_of_day() / 3600.0;
    return recording.time(i).weekday() < 5 && hour >= 8 && hour < 18 ? 1.0 : 0.0;
  });
  add("supply setpoint", false, [&](std::size_t i) { return row(i).setpoint_degc; });
  if (zone < channels.rooms) {
    add("its box open", false, [&](std::size_t i) { return row(i).vav_on[static_cast<std::size_t>(zone)]; });
    if (channels.fcus > 0) add("fan coils on", false, [&](std::size_t i) { return mean(row(i).fcu_on); });
  } else {
    const auto fcu = static_cast<std::size_t>(zone - channels.rooms);
    add("its fan coil on", false, [&](std::size_t i) { return row(i).fcu_on[fcu]; });
    add("boxes open", false, [&](std::size_t i) { return mean(row(i).vav_on); });
  }
  return list;
}

std::string joined(const std::vector<std::string>& words, const char* last) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 == words.size() ? last : ", ") + words[i];
  return text;
}

/// One zone's heat, looked at from all sides.
class HeatDescription {
 public:
  HeatDescription(const UnknownHeat& heat, const sim::Recording& recording, const sim::Channels& channels,
                  const HeatSd& sd_of, const HeatRules& rules, int zone)
      : recording_(recording), sd_of_(sd_of), rules_(rules), x_(heat.heat_kw.col(zone)) {
    z_.zone = zone;
    level();
    day_ = mean_day(x_, first_);
    drivers(channels);
    amounts();
    if (z_.above_noise) describe();
  }
  const ZoneHeat& zone() const { return z_; }
  const Eigen::VectorXd& heat_kw() const { return x_; }

 private:
  Eigen::Index days() const { return x_.size() / bins_per_day; }

  void drivers(const sim::Channels& channels) {
    const Eigen::VectorXd x_days = without_mean_day(x_, first_);
    const double all = variance_of(x_, first_);
    const double left = all > 0 ? std::sqrt(variance_of(x_days, first_) / all) : 0;
    for (const KnownSeries& known : known_series(recording_, x_.size(), channels, z_.zone)) {
      HeatDriver d;
      d.name = known.name;
      d.weather = known.weather;
      d.r = correlation_of(x_, known.value, first_);
      if (!std::isfinite(d.r)) continue;  // it never changed
      const Eigen::VectorXd anomaly = without_mean_day(known.value, first_);
      const double r_days = correlation_of(x_days, anomaly, first_);
      d.r_days = std::isfinite(r_days) ? left * r_days : 0;
      // The clock explains what both do every day alike: weather must show in how days differ.
      d.linked =
          known.weather ? std::abs(d.r) > 0.3 && std::abs(d.r_days) > 0.35 && d.r * d.r_days > 0 : std::abs(d.r) > 0.6;
      d.clearly_not = std::abs(known.weather ? d.r_days : d.r) < 0.2;
      slope(known, known.weather ? anomaly : known.value);
      z_.drivers.push_back(std::move(d));
    }
  }

  /// Takes the prevailing level off where it may be none; what is said then is of changes.
  void level() {
    const Eigen::Index n = x_.size() - first_;
    uniform_ = Eigen::VectorXd::Zero(x_.size());
    uniform_.tail(n).setConstant(1 / static_cast<double>(n));
    z_.mean_sd_kw = sd_of_(z_.zone, uniform_);
    std::vector<double> sorted(x_.begin() + first_, x_.end());
    std::nth_element(sorted.begin(), sorted.begin() + n / 2, sorted.end());
    const double prevailing = sorted[static_cast<std::size_t>(n / 2)];
    levelled_ = std::abs(prevailing) < 3 * z_.mean_sd_kw;
    if (!levelled_) return;
    x_.array() -= prevailing;
    // Better than the median, which lies on the slopes: the mean of the hours at which nothing much happens.
    const Eigen::VectorXd day = mean_day(x_, first_);
    const Eigen::ArrayXd quiet = (day.array().abs() < 0.35 * day.array().abs().maxCoeff()).cast<double>();
    if (quiet.sum() >= bins_per_day / 2.0) x_.array() -= (quiet * day.array()).sum() / quiet.sum();
  }

  double sd_of(const Eigen::VectorXd& weights) const {
    return sd_of_(z_.zone, levelled_ ? weights - weights.sum() * uniform_ : weights);
  }

  void notice(double kw, double sd_kw) {
    if (std::abs(kw) > rules_.limit_sd * sd_kw && std::abs(kw) > rules_.least_kw) z_.above_noise = true;
  }

  /// Heat that comes with something known may have no hours of its own: how much of it is there by a standard
  /// deviation of that?
  void slope(const KnownSeries& known, const Eigen::VectorXd& value) {
    const double variance = variance_of(value, first_);
    if (!known.weather || !(variance > 1e-12)) return;
    Eigen::VectorXd w = Eigen::VectorXd::Zero(value.size());
    const auto count = static_cast<double>(value.size() - first_);
    const double mean = value.tail(value.size() - first_).mean();
    for (Eigen::Index t = first_; t < value.size(); ++t) w(t) = (value(t) - mean) / (count * std::sqrt(variance));
    const double kw = w.dot(x_);
    // A rare thing moves much when it comes, though little on the whole.
    const double when_there = known.name == "rain" ? kw / std::sqrt(variance) : 2 * kw;
    if (known.name == "rain") {
      rain_kw_ = when_there;
      rain_sd_kw_ = std::hypot(sd_of(w) / std::sqrt(variance), rules_.model_share * when_there);
    }
    if (std::abs(kw) > rules_.limit_sd * sd_of(w) && std::abs(when_there) > rules_.least_kw) {
      z_.above_noise = true;
      slope_noticed_ = true;
    }
  }

  void amounts() {
    z_.mean_kw = uniform_.dot(x_);
    notice(z_.mean_kw, z_.mean_sd_kw);
    constexpr Eigen::Index width = 4;  // 2 h
    for (Eigen::Index block = 0; block < bins_per_day / width; ++block) {
      const Eigen::VectorXd in = weights_of([&](Eigen::Index bin) { return bin / width == block; });
      notice(in.dot(x_), sd_of(in));
    }
    z_.kwh_per_day = 24 * z_.mean_kw;
    active_hours();
    if (levelled_ && stretch_.length <= bins_per_day * 2 / 3) {  // other hours have none
      const Eigen::VectorXd others = weights_of([&](Eigen::Index bin) {
        return (bin - stretch_.from + 3 + bins_per_day) % bins_per_day >= stretch_.length + 6;
      });
      x_.array() -= others.dot(x_);
      day_ = mean_day(x_, first_);
      z_.mean_kw = uniform_.dot(x_);
      z_.kwh_per_day = 24 * z_.mean_kw;
      active_hours();
    }
    const Eigen::VectorXd active = weights_of([&](Eigen::Index bin) { return stretch_.holds(bin); });
    z_.active_kw = active.dot(x_);
    z_.active_sd_kw = sd_of(active);
    active_days();
    // Whether there is heat was decided by chance alone; how much it is must hold for other errors, too.
    z_.active_sd_kw = with_other_errors(z_.active_kw, z_.active_sd_kw, stretch_.from, stretch_.length);
    z_.mean_sd_kw = with_other_errors(z_.mean_kw, z_.mean_sd_kw, 0, bins_per_day);
  }

  /// Of a mean over a stretch of the day: chance, or how days differ if that is more, and the twin's other errors.
  ///   sd^2 = max(sd_chance, sd_days)^2 + (model_share kw)^2
  double with_other_errors(double kw, double sd_of_chance, Eigen::Index from, Eigen::Index length) const {
    return std::hypot(std::max(sd_of_chance, sd_of_days(x_, recording_, from, length)), rules_.model_share * kw);
  }

  /// Weights of the mean over bins of the day, on all days but the first.
  template <class Which>
  Eigen::VectorXd weights_of(Which&& which) const {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(x_.size());
    for (Eigen::Index t = first_; t < x_.size(); ++t) w(t) = which(t % bins_per_day) ? 1 : 0;
    return w / std::max(1.0, w.sum());
  }

  void active_hours() {
    stretch_ = active_stretch(day_);
    z_.peak_kw = stretch_.peak;
    z_.from_h = stretch_.from_h();
    z_.to_h = stretch_.to_h();
  }

  /// Nights are counted whole: a stretch belongs to the day on which it begins.
  void active_days() {
    double weekday = 0, weekend = 0, weekdays = 0, weekends = 0, present = 0, all = 0;
    for (Eigen::Index d = 1; d < days(); ++d) {
      double sum = 0;
      Eigen::Index n = 0;
      for (Eigen::Index t = d * bins_per_day + stretch_.from;
           t < std::min(d * bins_per_day + stretch_.from + stretch_.length, x_.size()); ++t) {
        sum += x_(t);
        ++n;
      }
      if (n < stretch_.length / 2) continue;
      const double kw = sum / static_cast<double>(n);
      const bool at_weekend = recording_.time(static_cast<std::size_t>(d) * rows_per_day).weekday() >= 5;
      (at_weekend ? weekend : weekday) += kw;
      (at_weekend ? weekends : weekdays) += 1;
      all += 1;
      if (kw * z_.active_kw > 0.5 * z_.active_kw * z_.active_kw) present += 1;
    }
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    z_.weekday_kw = weekdays > 0 ? weekday / weekdays : none;
    z_.weekend_kw = weekends > 0 ? weekend / weekends : none;
    z_.days_share = all > 0 ? present / all : 0;
    days_counted_ = static_cast<int>(all);
  }

  std::string which_days() const {
    if (z_.days_share >= 0.85) return "on all days";
    const bool both = std::isfinite(z_.weekday_kw) && std::isfinite(z_.weekend_kw);
    if (both && std::abs(z_.weekend_kw) < 0.35 * std::abs(z_.weekday_kw)) return "on working days";
    if (both && std::abs(z_.weekday_kw) < 0.35 * std::abs(z_.weekend_kw)) return "at weekends";
    return fmt::format("on {:.0f} of {} days", z_.days_share * days_counted_, days_counted_);
  }

  void describe() {
    std::vector<std::string> with, without;
    bool weather = false;
    const HeatDriver* rain = nullptr;
    for (const HeatDriver& d : z_.drivers) {
      if (d.linked) with.push_back(fmt::format("{} (r = {:.2f})", d.name, d.r));
      if (d.clearly_not) without.push_back(d.name);
      weather = weather || (d.weather && d.linked);
      if (d.name == "rain" && d.linked) rain = &d;
    }
    const bool by_rain = rain != nullptr && std::all_of(z_.drivers.begin(), z_.drivers.end(), [&](const HeatDriver& d) {
                           return !d.linked || !d.weather || std::abs(d.r_days) <= std::abs(rain->r_days);
                         });
    const double kw = by_rain ? rain_kw_ : z_.active_kw;
    const std::string how_much = with_interval(std::abs(kw), sd_95 * (by_rain ? rain_sd_kw_ : z_.active_sd_kw)) + " kW";
    z_.brief = fmt::format("something {} zone {} ", kw < 0 ? "cools" : "heats", z_.zone + 1);
    z_.brief += by_rain ? fmt::format("when it rains, by about {}", how_much)
                        : fmt::format("{} by about {} ({:.1f} kWh a day) {}", stretch_.text(), how_much,
                                      std::abs(z_.kwh_per_day), which_days());
    std::string& text = z_.text = z_.brief;
    text += weather ? "; driven by the weather" : slope_noticed_ ? "" : "; not weather-driven";
    if (!with.empty()) text += "; it goes with " + joined(with, " and ");
    if (!without.empty()) text += "; it does not go with " + joined(without, " or ");
  }

  static constexpr Eigen::Index first_ = bins_per_day;  // the first day remembers an unknown start
  const sim::Recording& recording_;
  const HeatSd& sd_of_;
  const HeatRules& rules_;
  Eigen::VectorXd x_, day_, uniform_;  // uniform_: weights of the mean
  bool levelled_ = false;
  DayStretch stretch_;
  double rain_kw_ = 0, rain_sd_kw_ = 0;
  int days_counted_ = 0;
  bool slope_noticed_ = false;
  ZoneHeat z_;
};

}  // namespace

void describe_heat(UnknownHeat& heat, const sim::Recording& recording, const sim::Channels& channels,
                   const HeatSd& sd_of, const HeatRules& rules) {
  heat.zones.clear();
  std::vector<const ZoneHeat*> reported;
  for (int zone = 0; zone < heat.heat_kw.cols(); ++zone) {
    const HeatDescription description(heat, recording, channels, sd_of, rules, zone);
    heat.zones.push_back(description.zone());
    heat.heat_kw.col(zone) = description.heat_kw();
  }
  for (const ZoneHeat& zone : heat.zones) {
    if (zone.above_noise) reported.push_back(&zone);
  }
  std::sort(reported.begin(), reported.end(),
            [](const ZoneHeat* a, const ZoneHeat* b) { return std::abs(a->active_kw) > std::abs(b->active_kw); });
  heat.text = reported.empty() ? "no zone has heat above the noise" : reported.front()->brief;
  if (reported.size() < 2) return;
  std::vector<std::string> others;
  for (std::size_t i = 1; i < reported.size(); ++i) others.push_back(std::to_string(reported[i]->zone + 1));
  heat.text += fmt::format("; less in zone{} {}", others.size() > 1 ? "s" : "", joined(others, " and "));
}

}  // namespace airside::tools::gap
