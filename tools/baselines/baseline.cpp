#include "tools/baselines/baseline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "hal/text/input_error.hpp"
#include "tools/baselines/arx.hpp"
#include "tools/baselines/guideline36.hpp"
#include "tools/baselines/mpc.hpp"
#include "tools/baselines/pid.hpp"
#include "tools/baselines/schedule.hpp"
#include "tools/baselines/tuned.hpp"

namespace airside::tools {
namespace {

using Made = std::unique_ptr<BaselineController>;
struct Entry {
  const char* name;
  Made (*make)(const ControllerSettings&, const TunedGains&);
};

Made arx(const ControllerSettings& site, bool exogenous, double rho) {
  ArxSettings settings;
  settings.exogenous = exogenous;
  settings.rho = rho;
  return std::make_unique<ArxBaseline>(site, settings);
}

Made g36(const ControllerSettings& site, const Guideline36Settings& settings, const char* name) {
  return std::make_unique<Guideline36Baseline>(site, settings, name);
}

using S = const ControllerSettings&;
using G = const TunedGains&;
constexpr std::array<Entry, 18> entries = {{
    {"expert", [](S s, G) -> Made { return std::make_unique<ScheduleBaseline>(s); }},
    {"constant-20.5", [](S s, G) -> Made { return std::make_unique<ConstantBaseline>(s, 20.5); }},
    {"constant-22.5", [](S s, G) -> Made { return std::make_unique<ConstantBaseline>(s, 22.5); }},
    {"pid-spec", [](S s, G) -> Made { return std::make_unique<PidBaseline>(s, pid_spec_gains(), "PID, spec gains"); }},
    {"pid-tuned", [](S s, G g) -> Made { return std::make_unique<PidBaseline>(s, g.pid, "PID, tuned"); }},
    {"integral-tuned", [](S s, G g) -> Made { return std::make_unique<IntegralBaseline>(s, g.integral_ki_per_h); }},
    {"varied", [](S s, G g) -> Made { return std::make_unique<VariedBaseline>(s, g.integral_ki_per_h); }},
    {"integral-5", [](S s, G) -> Made { return std::make_unique<IntegralBaseline>(s, 5.0); }},
    {"integral-7", [](S s, G) -> Made { return std::make_unique<IntegralBaseline>(s, 7.0); }},
    {"arx-2", [](S s, G g) -> Made { return arx(s, false, g.arx_rho); }},
    {"arx-rls", [](S s, G g) -> Made { return arx(s, true, g.arx_rls_rho); }},
    {"mpc",
     [](S s, G g) -> Made {
       MpcSettings settings;
       settings.move_weight = g.mpc_move_weight;
       settings.disturbance_share = g.mpc_disturbance_share;
       return std::make_unique<MpcBaseline>(s, settings);
     }},
    {"g36-written-16", [](S s, G) -> Made { return g36(s, guideline36_as_written(16), "G36 as written, 12-16 °C"); }},
    {"g36-written-18", [](S s, G) -> Made { return g36(s, guideline36_as_written(18), "G36 as written, 12-18 °C"); }},
    {"g36-site-i2", [](S s, G) -> Made { return g36(s, guideline36_on_site(s, 2), "G36 on site range, I = 2"); }},
    {"g36-site-i1", [](S s, G) -> Made { return g36(s, guideline36_on_site(s, 1), "G36 on site range, I = 1"); }},
    {"g36-site-i0", [](S s, G) -> Made { return g36(s, guideline36_on_site(s, 0), "G36 on site range, I = 0"); }},
    {"g36-site-airflow",
     [](S s, G) -> Made {
       Guideline36Settings settings = guideline36_on_site(s, 2);
       settings.loop = CoolingLoop::airflow;
       return g36(s, settings, "G36 on site range, airflow proxy");
     }},
}};

}  // namespace

double room_mean_degc(const sim::Sensors& sensors) {
  double sum = 0;
  int count = 0;
  for (const double t : sensors.room_temp_degc) {
    if (!std::isfinite(t)) continue;
    sum += t;
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

double admissible_setpoint_degc(double setpoint_degc, const ControllerSettings& site) {
  const double clamped = std::clamp(setpoint_degc, site.action_min_degc, site.action_max_degc);
  return std::round(clamped / site.round_k) * site.round_k;
}

std::unique_ptr<BaselineController> make_baseline(std::string_view name, const ControllerSettings& site,
                                                  PlantKind plant) {
  for (const Entry& entry : entries) {
    if (name == entry.name) return entry.make(site, tuned_gains(plant));
  }
  std::string known;
  for (const Entry& entry : entries) known += (known.empty() ? "" : ", ") + std::string(entry.name);
  throw hal::InputError("baseline", '"' + std::string(name) + '"', "one of " + known, "choose a name from the list");
}

std::vector<std::string> baseline_names() {
  std::vector<std::string> names;
  for (const Entry& entry : entries) names.emplace_back(entry.name);
  return names;
}

}  // namespace airside::tools
