#include "tools/run/training/transfer.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/text/input_error.hpp"
#include "tools/run/control_loop.hpp"

namespace airside::tools {

BlobBytes fine_tune(const Site& site, const BlobBytes& source, const std::vector<hal::LogRow>& rows,
                    const FineTuneOptions& options, const OnProgress& progress) {
  BlobBytes out;
  for_topology_of(site, [&]<class T>(T) {
    auto controller = make_controller<T>(site, site.settings, options.seed);
    double gain = site.settings.head_gain_prior, gain_sd = site.settings.head_gain_prior_sd;
    if (source.empty()) {
      SplitMix64 init(options.seed);
      controller->draw_weights(init);
      controller->start(scaler_of<T>(site, rows));
    } else {
      auto payload = std::make_unique<SitePayload<T>>();
      payload->site = shape_of<T>(site);
      hal::decode_blob<T>(source, site.file.scope, "source blob", *payload);
      take_payload<T>(*controller, *payload);
      if (payload->head_states != 0) {
        gain = controller->learning().head.gain(site.settings);
        gain_sd = std::max(0.1, 2 * controller->learning().head.gain_sd());
      }
    }
    controller->reset_head(gain, gain_sd);
    read_history<T>(site, *controller, rows, HistoryReader<T>::Head::learn);
    if (controller->replay().size() == 0) {
      throw hal::InputError("log", fmt::format("{} rows without one 18-min stretch of constant setpoint", rows.size()),
                            "at least four successive 6-min rows under one setpoint", "log some days of the schedule");
    }
    for (int i = 0; i < options.steps; ++i) {
      (void)controller->train_step();
      if (progress && i % 50 == 49) progress((i + 1.0) / options.steps);
    }
    out = blob_of<T>(*controller, options.provenance, rows.back().time);
  });
  return out;
}

}  // namespace airside::tools
