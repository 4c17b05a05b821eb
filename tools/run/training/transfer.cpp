#include "tools/run/training/transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hal/text/input_error.hpp"
#include "tools/run/control_loop.hpp"

namespace airside::tools {

BlobBytes fine_tune(const Site& site, const BlobBytes& source, std::span<const hal::LogRow> rows,
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
      payload->cycle = control_cycle(site.settings);
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
      throw hal::InputError(
          "log",
          fmt::format("{} rows without one {}-min stretch of constant setpoint", rows.size(), site.settings.cycle_min),
          fmt::format("at least {} successive 6-min rows under one setpoint", control_cycle(site.settings).rows + 1),
          "log some days of the schedule");
    }
    for (int i = 0; i < options.steps; ++i) {
      (void)controller->train_step();
      if (progress && i % 50 == 49) progress((i + 1.0) / options.steps);
    }
    out = blob_of<T>(*controller, options.provenance, rows.back().time);
  });
  return out;
}

namespace {

/// The first row that is held back.
std::size_t held_back_from(std::size_t rows) {
  constexpr auto day = static_cast<std::size_t>(rows_per_day);
  return rows >= 3 * day ? rows - day : rows - rows / 3;
}

/// Error of the head's forecasts on rows that the blob has not seen, while the head learns on.
template <Topology T>
double error_of_forecasts_k(const Site& site, const BlobBytes& blob, std::span<const hal::LogRow> rows) {
  auto controller = make_controller<T>(site, site.settings, 1);
  auto payload = std::make_unique<SitePayload<T>>();
  payload->site = shape_of<T>(site);
  payload->cycle = control_cycle(site.settings);
  hal::decode_blob<T>(blob, site.file.scope, "blob", *payload);
  take_payload<T>(*controller, *payload);
  HistoryReader<T> reader(*controller, HistoryReader<T>::Head::learn);
  for (const hal::LogRow& row : rows) {
    reader.row(hal::reading_of<T>(row, shape_of<T>(site), site.counts.sides), row.setpoint_degc);
  }
  return reader.forecast_error_k();
}

/// The same weights with another provenance.
template <Topology T>
BlobBytes renamed(const Site& site, const BlobBytes& blob, const std::string& provenance, CivilTime end) {
  auto controller = make_controller<T>(site, site.settings, 1);
  auto payload = std::make_unique<SitePayload<T>>();
  payload->site = shape_of<T>(site);
  payload->cycle = control_cycle(site.settings);
  hal::decode_blob<T>(blob, site.file.scope, "source blob", *payload);
  take_payload<T>(*controller, *payload);
  return blob_of<T>(*controller, provenance, end);
}

}  // namespace

double forecast_error_k(const Site& site, const BlobBytes& blob, std::span<const hal::LogRow> rows) {
  double error_k = 0;
  for_topology_of(site, [&]<class T>(T) { error_k = error_of_forecasts_k<T>(site, blob, rows); });
  return error_k;
}

Transferred transfer(const Site& site, const BlobBytes& source, const std::vector<hal::LogRow>& rows,
                     const FineTuneOptions& options, const OnProgress& progress) {
  Transferred out;
  if (!source.empty() && site.settings.head != 0) {
    const std::span all(rows);
    const std::size_t split = held_back_from(all.size());
    const auto half = [&progress](double share) { return progress ? progress(share / 2) : void(); };
    const BlobBytes tuned = fine_tune(site, source, all.first(split), options, half);
    for_topology_of(site, [&]<class T>(T) {
      out.source_error_k = error_of_forecasts_k<T>(site, source, all.subspan(split));
      out.tuned_error_k = error_of_forecasts_k<T>(site, tuned, all.subspan(split));
      out.source_kept = out.source_error_k <= out.tuned_error_k;
      if (out.source_kept)
        out.blob = renamed<T>(site, source, options.provenance + " (kept as it was)", rows.back().time);
    });
    if (out.source_kept) return out;
  }
  const bool compared = std::isfinite(out.tuned_error_k);
  const auto rest = [&](double share) {
    if (progress) progress(compared ? 0.5 + share / 2 : share);
  };
  out.blob = fine_tune(site, source, rows, options, rest);
  return out;
}

}  // namespace airside::tools
