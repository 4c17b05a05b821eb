// airside-bench: how long a decision and an optimiser step take, one JSON line a measurement:
// {"name","batch","threads","median_us","min_us","max_us","p90_us","runs","rss_mb"}.

#include <sys/resource.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "airside/learning/replay_ring.hpp"
#include "airside/network/learner.hpp"
#include "tools/bench/fma_peak.hpp"

namespace airside::tools {
namespace {

using Topo = FiveZone;

volatile float sink = 0;  // what is computed must be seen to be used

/// CLOCK_MONOTONIC, or the thread's own CPU time where other programs share the cores.
clockid_t bench_clock = CLOCK_MONOTONIC;

double now_us() {
  timespec t{};
  clock_gettime(bench_clock, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

/// Times `work` call by call for about `budget_s` and prints the line. `flops` of one call, 0 if not of interest.
template <class Work>
void measure(const std::string& name, int batch, double budget_s, double flops, const Work& work) {
  const auto once = [&] {
    const double begin = now_us();
    work();
    return now_us() - begin;
  };
  for (int i = 0; i < 5; ++i) once();
  const double guess_us = std::max(0.05, once());
  const int runs = std::clamp(static_cast<int>(budget_s * 1e6 / guess_us), 15, 20000);
  std::vector<double> us(static_cast<std::size_t>(runs));
  for (double& t : us) t = once();
  std::sort(us.begin(), us.end());
  const double median = us[us.size() / 2];
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "{\"name\":\"%s\",\"batch\":%d,\"threads\":1,\"median_us\":%.2f,\"min_us\":%.2f,\"max_us\":%.2f,\"p90_us\":%.2f,"
      "\"runs\":%d,\"rss_mb\":%.1f",
      name.c_str(), batch, median, us.front(), us.back(), us[us.size() * 9 / 10], runs,
      static_cast<double>(usage.ru_maxrss) / 1024.0);
  if (flops > 0)
    std::printf(",\"median_gflops\":%.1f,\"best_gflops\":%.1f", flops / median / 1e3, flops / us.front() / 1e3);
  std::printf("}\n");
  std::fflush(stdout);
}

void measure_peak(double budget_s) {
  if (cpu_has(KernelKind::avx512))
    measure("fma_peak/avx512", 0, budget_s, 2 * fma_peak_count_avx512, [] { sink = fma_peak_avx512(); });
  if (cpu_has(KernelKind::avx2))
    measure("fma_peak/avx2", 0, budget_s, 2 * fma_peak_count_avx2, [] { sink = fma_peak_avx2(); });
}

/// One network with a full ring of random transitions.
struct Bench {
  using Ring = ReplayRing<Topo, float>;
  std::unique_ptr<NetworkWeights<Topo, float>> weights = std::make_unique<NetworkWeights<Topo, float>>();
  std::unique_ptr<Learner<Topo, float>> learner = std::make_unique<Learner<Topo, float>>();
  std::unique_ptr<NetworkScratch<Topo, float>> scratch = std::make_unique<NetworkScratch<Topo, float>>();
  std::unique_ptr<PackedWeights<Topo, float>> packed = std::make_unique<PackedWeights<Topo, float>>();
  std::unique_ptr<Ring> ring = std::make_unique<Ring>();
  SplitMix64 generator{1};

  explicit Bench(const Kernels<float>& kernels) {
    initialise_uniform(*weights, generator);
    learner->reset(*weights);
    scratch->kernels = kernels;
    pack(*weights, kernels, *packed);
    for (int r = 0; r < replay_capacity; ++r) {
      Ring::Row row;
      for (float& x : row) x = static_cast<float>(1.7 * generator.symmetric());
      ring->push(row);
    }
  }

  void decide(const std::string& prefix, int candidates, double budget_s) {
    constexpr std::size_t signals = Layout<Topo>::signals;
    std::vector<float> setpoints;
    for (int i = 0; i < candidates; ++i) setpoints.push_back(static_cast<float>(i) * 0.05F - 1.5F);
    std::vector<RoomForecast<Topo, float>> forecasts(setpoints.size());
    measure(prefix + "/decide", candidates, budget_s, 0, [&] {
      forecast_candidates(*packed, std::span<const float, signals>(ring->slot(0).data(), signals),
                          std::span<const float>(setpoints), *scratch, std::span<RoomForecast<Topo, float>>(forecasts));
      sink = forecasts.back().short_term[0];
    });
  }

  void step(const std::string& prefix, int batch, double budget_s) {
    std::vector<std::uint32_t> index(static_cast<std::size_t>(batch));
    ring->sample(generator, index);
    const LearnerSettings<Topo> settings;
    measure(prefix + "/step", batch, budget_s, batch * 2.0 * 178368,
            [&] { sink = static_cast<float>(learner->step(*weights, ring->view(index), settings, *scratch).total); });
  }

  void parts(const std::string& prefix, double budget_s) {
    std::vector<std::uint32_t> index(1000);
    measure(prefix + "/sample", 1000, budget_s, 0, [&] { sink = static_cast<float>(ring->sample(generator, index)); });
    measure(prefix + "/pack", 1, budget_s, 0, [&] { pack(*weights, scratch->kernels, *packed); });
    AdamState<Topo, float> adam;
    measure(prefix + "/adam", 1, budget_s, 0,
            [&] { adam.update(*weights, scratch->gradient, AdamSettings{}, scratch->kernels); });
  }
};

}  // namespace
}  // namespace airside::tools

int main(int argc, char** argv) {
  using namespace airside;
  using namespace airside::tools;
  CLI::App app{"Times of decisions and optimiser steps, JSON lines"};
  std::string kernels = "best";
  double budget_s = 1.5;
  bool with_parts = false;
  app.add_option("--kernels", kernels, "best, strict, avx2, avx512 or all")
      ->check(CLI::IsMember({"best", "strict", "avx2", "avx512", "all"}));
  app.add_option("--budget", budget_s, "seconds a measurement")->check(CLI::PositiveNumber);
  bool cpu_time = false;
  app.add_flag("--cpu-time", cpu_time, "count the thread's CPU time instead of wall time");
  app.add_flag("--parts", with_parts, "also sampling, packing and Adam alone");
  CLI11_PARSE(app, argc, argv);

  if (cpu_time) bench_clock = CLOCK_THREAD_CPUTIME_ID;
  measure_peak(budget_s / 5);
  for (const KernelKind kind : {KernelKind::strict, KernelKind::avx2, KernelKind::avx512}) {
    const std::string name = text_of(kind);
    if (!cpu_has(kind)) continue;
    if (kernels == "best" ? kind != select_kernels<float>().kind : kernels != "all" && kernels != name) continue;
    const auto bench = std::make_unique<Bench>(float_kernels(kind));
    const std::string prefix = "airside_" + name;
    for (const int candidates : {1, 46, 61}) bench->decide(prefix, candidates, budget_s);
    for (const int batch : {32, 128, 1000}) bench->step(prefix, batch, budget_s);
    if (with_parts) bench->parts(prefix, budget_s);
  }
  measure_peak(budget_s / 5);
  return 0;
}
