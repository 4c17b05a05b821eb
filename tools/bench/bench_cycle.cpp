#include "tools/bench/bench_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "airside/controller/instances.hpp"
#include "airside/presets.hpp"
#include "airside/splitmix64.hpp"
#include "airside/supervision/limits.hpp"

namespace airside::tools {

namespace {

/// A controller on a made-up site whose zones, dampers and meter answer to the setpoint.
template <Topology T>
class CycleBench {
 public:
  CycleBench(const Shape& shape, const Kernels<float>& kernels) : shape_(shape) {
    ControllerSettings s = product_settings();
    s.objective = Objective::band;
    s.shape = shape;
    controller_->configure(s, default_limits<T>(), kernels, 1);
  }

  /// The rows before the next cycle, the first of which ends the last one.
  void rows() {
    for (int k = 0; k < band_cycle.rows; ++k) {
      t_.seconds += row_s;
      now_ = reading();
      if (!band_cycle.starts(t_)) controller_->observe(t_, now_);
    }
  }
  void cycle() {
    const auto pending = controller_->decide(t_, now_);
    setpoint_degc_ = pending.command.setpoint_degc();
    controller_->absorb(pending, Applied{setpoint_degc_});
  }
  /// Whether the setpoints are the objective's own.
  bool acts() const {
    return controller_->decision().mode == ControlMode::learn &&
           controller_->cycle().band.is_ready(controller_->settings().demand);
  }

 private:
  Reading<T> reading() {
    Reading<T> r;
    r.time = t_;
    const double hour = t_.second_of_day() / 3600.0, sun = std::sin((hour - 9) * 0.2618);
    const auto noise = [&] { return 0.05 * random_.symmetric(); };
    double flow = 0;
    for (int i = 0; i < shape_.vavs; ++i) {
      r.value(i) = 23.5 + 0.3 * sun + noise();
      r.zone_setpoint_degc(i) = 23.5;
      r.damper(i) = std::clamp(0.5 + 0.3 * sun + 0.05 * (setpoint_degc_ - 14) + noise(), 0.1, 1.0);
      flow += r.damper(i) / shape_.vavs;
    }
    for (int i = shape_.vavs; i < Layout<T>::signals; ++i) {
      const SignalKind kind = signal_id<T>(i).kind;
      if (is_status(kind)) r.value(i) = kind == SignalKind::rain ? 0 : 1;
      if (kind == SignalKind::fcu_temp) r.value(i) = 24 + noise();
      if (kind == SignalKind::power) r.value(i) = 3 + 8 * flow * flow * flow + noise();
      if (kind == SignalKind::mau_temp) r.value(i) = 18 + sun + noise();
      if (kind == SignalKind::outdoor_temp) r.value(i) = 22 + 6 * sun + noise();
    }
    r.setpoint_degc = r.supply_temp_degc = setpoint_degc_;
    return r;
  }

  Shape shape_;
  SplitMix64 random_{1};
  CivilTime t_{18000 * seconds_per_day};
  double setpoint_degc_ = 14;
  std::unique_ptr<Controller<T>> controller_ = std::make_unique<Controller<T>>();
  Expected<Reading<T>> now_ = tl::unexpected(Fault::no_reading);
};

template <Topology T>
void measure_band(const Stopwatch& watch, const Kernels<float>& kernels, const std::string& prefix,
                  const Shape& shape) {
  CycleBench<T> bench(shape, kernels);
  for (int k = 0; k < 3 * band_cycle.per_day(); ++k) {  // until the objective acts on what it has learned
    bench.rows();
    bench.cycle();
  }
  if (!bench.acts()) throw std::runtime_error("bench: the objective band does not act, so its time says nothing");
  watch.measure(
      {.name = prefix + "/cycle_band", .batch = 1, .shape = shape, .topology = T::name}, [&] { bench.cycle(); },
      [&] { bench.rows(); });
}

}  // namespace

void measure_cycles(const Stopwatch& watch, const Kernels<float>& kernels, const std::string& prefix) {
  measure_band<UpTo8>(watch, kernels, prefix, {5, 0, 1});
  measure_band<UpTo32>(watch, kernels, prefix, {12, 0, 1});
  measure_band<UpTo32>(watch, kernels, prefix, {32, 0, 1});
}

}  // namespace airside::tools
