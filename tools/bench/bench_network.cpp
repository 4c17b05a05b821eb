// airside-bench: how long a decision, an optimiser step and a whole cycle take, one JSON line a measurement:
// {"name","batch","threads","median_us","min_us","max_us","p90_us","runs","rss_mb","shape","topology"}.

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "airside/learning/replay_ring.hpp"
#include "airside/network/learner.hpp"
#include "tools/bench/bench_cycle.hpp"
#include "tools/bench/fma_peak.hpp"
#include "tools/bench/stopwatch.hpp"

namespace airside::tools {
namespace {

volatile float sink = 0;  // what is computed must be seen to be used

void measure_peak(const Stopwatch& watch) {
  const auto nothing = [] {};
  if (cpu_has(KernelKind::avx512)) {
    watch.measure(
        {.name = "fma_peak/avx512", .flops = 2 * fma_peak_count_avx512}, [] { sink = fma_peak_avx512(); }, nothing,
        0.2);
  }
  if (cpu_has(KernelKind::avx2)) {
    watch.measure(
        {.name = "fma_peak/avx2", .flops = 2 * fma_peak_count_avx2}, [] { sink = fma_peak_avx2(); }, nothing, 0.2);
  }
}

/// One network of a site's shape with a full ring of random transitions; what the site lacks is 0.
template <Topology Topo>
struct Bench {
  using Ring = ReplayRing<Topo, float>;
  std::unique_ptr<NetworkWeights<Topo, float>> weights = std::make_unique<NetworkWeights<Topo, float>>();
  std::unique_ptr<Learner<Topo, float>> learner = std::make_unique<Learner<Topo, float>>();
  std::unique_ptr<NetworkScratch<Topo, float>> scratch = std::make_unique<NetworkScratch<Topo, float>>();
  std::unique_ptr<PackedWeights<Topo, float>> packed = std::make_unique<PackedWeights<Topo, float>>();
  std::unique_ptr<Ring> ring = std::make_unique<Ring>();
  SplitMix64 generator{1};
  Shape site;

  Bench(const Kernels<float>& kernels, const Shape& shape) : site(shape) {
    initialise_uniform(*weights, generator, site);
    learner->reset(*weights);
    scratch->kernels = kernels;
    scratch->site = site;
    pack(*weights, kernels, *packed);
    for (int r = 0; r < replay_capacity; ++r) {
      typename Ring::Row row{};
      for (std::size_t i = 0; i < row.size(); ++i) {
        const int signal = static_cast<int>(i) % Layout<Topo>::inputs;
        const bool has = signal == Layout<Topo>::setpoint || is_present<Topo>(site, signal);
        if (has) row[i] = static_cast<float>(1.7 * generator.symmetric());
      }
      ring->push(row);
    }
  }

  Measured of(const std::string& name, int batch, double flops = 0) const {
    return {.name = name, .batch = batch, .flops = flops, .shape = site, .topology = Topo::name};
  }

  void decide(const Stopwatch& watch, const std::string& prefix, int candidates) {
    constexpr std::size_t signals = Layout<Topo>::signals;
    std::vector<float> setpoints;
    for (int i = 0; i < candidates; ++i) setpoints.push_back(static_cast<float>(i) * 0.05F - 1.5F);
    std::vector<RoomForecast<Topo, float>> forecasts(setpoints.size());
    watch.measure(of(prefix + "/decide", candidates), [&] {
      forecast_candidates(*packed, std::span<const float, signals>(ring->slot(0).data(), signals),
                          std::span<const float>(setpoints), *scratch, std::span<RoomForecast<Topo, float>>(forecasts));
      sink = forecasts.back().short_term[0];
    });
  }

  /// Forecasts and reconstruction of rows that share nothing: what a graph of another library computes.
  void graph(const Stopwatch& watch, const std::string& prefix, int rows) {
    using L = Layout<Topo>;
    auto& a = scratch->act;
    watch.measure(of(prefix + "/graph", rows), [&] {
      for (int r = 0; r < rows; ++r) {
        const float* const row = ring->slot(r).data();
        std::copy_n(row, L::signals, a.input_s.row(r));
        std::copy_n(row + L::rooms, L::exogenous + 1, a.input_a.row(r));
      }
      tile_forward(scratch->kernels, *packed, rows, a);
      decode(scratch->kernels, *packed, rows, a, scratch->short_term, scratch->deviation);
      layer_forward(scratch->kernels, *packed, Layer::dec, rows, a.joint.row(0), share_width,
                    scratch->reconstruction.row(0), TileOutputs<Topo, float>::width);
      sink = scratch->reconstruction.row(rows - 1)[0];
    });
  }

  /// All work: weights as they were drawn, which violate the constraint nearly everywhere and do not move, and samples
  /// that are in no memory.
  void step(const Stopwatch& watch, const std::string& prefix, int batch) {
    LearnerSettings<Topo> settings;
    settings.adam.learning_rate = 0;
    const double flops = std::is_same_v<Topo, FiveZone> ? batch * 2.0 * 178368 : 0;
    const BatchView<Topo, float> rows{ring->slot(0).data(), nullptr, batch};
    watch.measure(of(prefix + "/step", batch, flops),
                  [&] { sink = static_cast<float>(learner->step(*weights, rows, settings, *scratch).total); });
  }

  /// As on the box: weights that have learned, and samples drawn from the replay, whose targets are mostly known.
  void learned_step(const Stopwatch& watch, const std::string& prefix, int batch) {
    std::vector<std::uint32_t> index(static_cast<std::size_t>(batch));
    const LearnerSettings<Topo> settings;
    const auto one = [&] {
      ring->sample(generator, index);
      sink = static_cast<float>(learner->step(*weights, ring->view(index), settings, *scratch).total);
    };
    for (int i = 0; i < 300; ++i) one();
    watch.measure(of(prefix + "/learned-step", batch), one);
  }

  void parts(const Stopwatch& watch, const std::string& prefix) {
    std::vector<std::uint32_t> index(1000);
    watch.measure(of(prefix + "/sample", 1000), [&] { sink = static_cast<float>(ring->sample(generator, index)); });
    watch.measure(of(prefix + "/pack", 1), [&] { pack(*weights, scratch->kernels, *packed); });
    if (cpu_has(KernelKind::avx2)) {  // what one row cannot be faster than
      const int whole = static_cast<int>(packed->values.size()) / 64 * 64;
      watch.measure(of(prefix + "/read-weights", 1), [&] { sink = read_all_avx2(packed->values.data(), whole); });
    }
    AdamState<Topo, float> adam;
    watch.measure(of(prefix + "/adam", 1),
                  [&] { adam.update(*weights, scratch->gradient, AdamSettings{}, scratch->kernels); });
  }
};

/// A decision and a small step of another shape.
template <Topology Topo>
void measure_shape(const Stopwatch& watch, const Kernels<float>& kernels, const std::string& prefix,
                   const Shape& shape) {
  const auto bench = std::make_unique<Bench<Topo>>(kernels, shape);
  bench->decide(watch, prefix, 61);
  bench->step(watch, prefix, 32);
}

/// What a capacity class costs: the published room in it, then a full class or a small site in it.
void measure_classes(const Stopwatch& watch, const Kernels<float>& kernels, const std::string& prefix) {
  measure_shape<UpTo8>(watch, kernels, prefix, capacity_of<FiveZone>());
  measure_shape<UpTo8>(watch, kernels, prefix, {8, 8, 2});
  measure_shape<UpTo32>(watch, kernels, prefix, capacity_of<FiveZone>());
  measure_shape<UpTo32>(watch, kernels, prefix, {12, 0, 1});
  measure_shape<UpTo32>(watch, kernels, prefix, {32, 32, 2});
}

}  // namespace
}  // namespace airside::tools

int main(int argc, char** argv) {
  using namespace airside;
  using namespace airside::tools;
  CLI::App app{"Times of decisions, optimiser steps and whole cycles, JSON lines"};
  std::string kernels = "best";
  double budget_s = 1.5;
  bool with_parts = false, peers = false;
  app.add_option("--kernels", kernels, "best, strict, avx2, avx512 or all")
      ->check(CLI::IsMember({"best", "strict", "avx2", "avx512", "all"}));
  app.add_option("--budget", budget_s, "seconds a measurement")->check(CLI::PositiveNumber);
  bool cpu_time = false;
  app.add_flag("--cpu-time", cpu_time, "count the thread's CPU time instead of wall time");
  app.add_flag("--parts", with_parts, "also sampling, packing, reading the weights and Adam alone");
  app.add_flag("--peers", peers, "the published network alone: what tools/bench-peers sets beside other libraries");
  CLI11_PARSE(app, argc, argv);

  const Stopwatch watch(cpu_time ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, budget_s);
  measure_peak(watch);
  for (const KernelKind kind : {KernelKind::strict, KernelKind::avx2, KernelKind::avx512}) {
    const std::string name = text_of(kind);
    if (!cpu_has(kind)) continue;
    if (kernels == "best" ? kind != select_kernels<float>().kind : kernels != "all" && kernels != name) continue;
    const auto bench = std::make_unique<Bench<FiveZone>>(float_kernels(kind), capacity_of<FiveZone>());
    const std::string prefix = "airside_" + name;
    for (const int rows : {1, 46}) bench->graph(watch, prefix, rows);
    for (const int candidates : {1, 46, 61}) bench->decide(watch, prefix, candidates);
    for (const int batch : {32, 128, 1000}) bench->step(watch, prefix, batch);
    for (const int batch : {32, 128, 1000}) bench->learned_step(watch, prefix, batch);
    if (with_parts) bench->parts(watch, prefix);
    if (peers) continue;
    measure_classes(watch, float_kernels(kind), prefix);
    measure_cycles(watch, float_kernels(kind), prefix);
  }
  measure_peak(watch);
  return 0;
}
