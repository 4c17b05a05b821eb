#include "tools/study/method/forecast_check.hpp"

#include <cmath>
#include <memory>

#include "airside/network/forward.hpp"
#include "hal/text/input_error.hpp"
#include "tools/run/control_loop.hpp"

namespace airside::tools {

namespace {

constexpr int slope_stride = 10;
constexpr float slope_step = 0.02F;  // scaled; small beside an input's spread, large beside the rounding of float

/// The network alone, in scaled units.
template <Topology T>
class FrozenNetwork {
 public:
  using L = Layout<T>;
  using Inputs = Eigen::Matrix<float, L::signals, 1>;

  FrozenNetwork(const Site& site, const BlobBytes& blob)
      : controller_(make_controller<T>(site, site.settings, 1)),
        scratch_(std::make_unique<NetworkScratch<T, float>>()) {
    auto payload = std::make_unique<SitePayload<T>>();
    payload->site = shape_of<T>(site);
    payload->cycle = control_cycle(site.settings);
    hal::decode_blob<T>(blob, site.file.scope, "weights", *payload);
    take_payload<T>(*controller_, *payload);
    scratch_->kernels = hal::box_kernels();
    pack(controller_->learning().weights, scratch_->kernels, scratch_->packed);
  }

  const Scaler<T>& scaler() const { return controller_->learning().scaler; }

  RoomForecast<T, float> forecast(const Inputs& signals, float setpoint) {
    RoomForecast<T, float> out{};
    forecast_candidates<T, float>(scratch_->packed, std::span<const float, L::signals>(signals.data(), L::signals),
                                  {&setpoint, 1}, *scratch_, {&out, 1});
    return out;
  }

  /// d(sum S')/dX_j, scaled.
  float slope(Inputs signals, float setpoint, int j) {
    float* const input = j < L::signals ? &signals(j) : &setpoint;
    const float at = *input;
    *input = at + slope_step;
    const float above = sum(forecast(signals, setpoint));
    *input = at - slope_step;
    return (above - sum(forecast(signals, setpoint))) / (2 * slope_step);
  }

 private:
  static float sum(const RoomForecast<T, float>& f) {
    float total = 0;
    for (const float s : f.short_term) total += s;
    return total;
  }

  std::unique_ptr<Controller<T>> controller_;
  std::unique_ptr<NetworkScratch<T, float>> scratch_;
};

template <Topology T>
ForecastCheck check_as(const Site& site, const BlobBytes& blob, std::span<const hal::LogRow> rows) {
  using L = Layout<T>;
  FrozenNetwork<T> network(site, blob);
  const Shape shape = shape_of<T>(site);
  ForecastCheck out;
  int slopes = 0, inputs = 0;
  const ControlCycle cycle = control_cycle(site.settings);
  const auto ahead = static_cast<std::size_t>(cycle.rows);
  for (std::size_t i = 0; i + ahead < rows.size(); ++i) {
    const hal::LogRow &now = rows[i], &then = rows[i + ahead];
    if (!cycle.starts(now.time) || then.time.seconds - now.time.seconds != cycle.seconds()) continue;
    const auto value = hal::signals_of<T>(now, shape), later = hal::signals_of<T>(then, shape);
    if (!value.allFinite() || !later.allFinite()) continue;
    const auto scaled = network.scaler().template signals<float>(value);
    const auto setpoint = network.scaler().template setpoint<float>(now.setpoint_degc);
    const auto foreseen = network.forecast(scaled, setpoint);
    for (int r = 0; r < L::rooms; ++r) {
      const auto k = static_cast<std::size_t>(r);
      const double degc =
          network.scaler().room_mean() + network.scaler().room_scale() * static_cast<double>(foreseen.short_term[k]);
      out.mae_k += std::abs(degc - later(r)) / L::rooms;
    }
    if (out.transitions++ % slope_stride != 0) continue;
    ++slopes;
    for (int j = 0; j <= L::signals; ++j) {
      const float slope = network.slope(scaled, setpoint, j);
      ++inputs;
      if (static_cast<double>(slope) * relation_label<T>(j, site.settings.label_vav) < 0) out.violation_share += 1;
      if (j == L::setpoint && slope > 0) out.gain_sign_share += 1;
    }
  }
  if (out.transitions == 0) {
    throw hal::InputError("log", "no whole control cycle", "some hours of rows that are 6 min apart", "log more days");
  }
  out.mae_k /= out.transitions;
  out.violation_share /= inputs;
  out.gain_sign_share /= slopes;
  return out;
}

}  // namespace

ForecastCheck check_forecasts(const Site& site, const BlobBytes& blob, std::span<const hal::LogRow> rows) {
  ForecastCheck out;
  for_topology_of(site, [&]<class T>(T) { out = check_as<T>(site, blob, rows); });
  return out;
}

}  // namespace airside::tools
