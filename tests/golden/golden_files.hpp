#pragma once
// Reads a folder of golden vectors (data/README.md) and makes again what its generator made from the seeds.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "airside/learning/replay_ring.hpp"
#include "airside/network/learner.hpp"

namespace airside::golden {

using nlohmann::json;

/// Where `given` lies: as it stands if absolute, else from the first of `bases` in which it is a folder.
/// Errors: std::runtime_error for what is no folder, or lacks a file that the project's own has.
inline std::string golden_folder(const std::string& given, const std::vector<std::filesystem::path>& bases) {
  namespace fs = std::filesystem;
  const fs::path own = fs::path(AIRSIDE_SOURCE_DIR) / "tests/golden/data";
  if (given.empty()) return own.string();
  std::string tried;
  for (const fs::path& base : bases) {
    const fs::path there = base / given;  // an absolute `given` replaces the base
    tried += (tried.empty() ? "" : ", ") + there.string();
    if (!fs::is_directory(there)) continue;
    for (const fs::directory_entry& file : fs::directory_iterator(own)) {
      const std::string name = file.path().filename().string();
      if (name == "README.md" || fs::exists(there / name)) continue;
      throw std::runtime_error("AIRSIDE_GOLDEN: found " + there.string() + " without " + name +
                               "; expected a folder of the layout of tests/golden/data; see its README.md");
    }
    return there.string();
  }
  throw std::runtime_error("AIRSIDE_GOLDEN: found \"" + given + "\", which is no folder (tried " + tried +
                           "); expected one with golden vectors; give its absolute path");
}

/// ctest runs tests in the build tree: a relative path is meant from where the person stood, which PWD still says.
inline std::string folder() {
  const char* const given = std::getenv("AIRSIDE_GOLDEN");
  const char* const stood = std::getenv("PWD");
  return golden_folder(given != nullptr ? given : "",
                       {stood != nullptr ? stood : "", std::filesystem::current_path(), AIRSIDE_SOURCE_DIR});
}

inline json read_json(const std::string& name) {
  const std::string path = folder() + "/" + name;
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  return json::parse(in);
}

inline std::vector<double> read_csv(const std::string& name) {
  const std::string path = folder() + "/" + name;
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  std::vector<double> values;
  for (double v = 0; in >> v;) values.push_back(v);
  return values;
}

inline const json& meta() {
  static const json m = read_json("meta.json");
  return m;
}

inline std::uint64_t seed(const std::string& name) { return meta().at("seeds").at(name).get<std::uint64_t>(); }

template <class Scalar>
NetworkWeights<FiveZone, Scalar> weights_of(const std::string& seed_name) {
  NetworkWeights<FiveZone, Scalar> weights;
  SplitMix64 generator(seed(seed_name));
  initialise_golden(weights, generator);
  return weights;
}

/// n samples [S E A S1 E1], contiguous.
inline std::vector<double> make_batch(const std::string& seed_name, int n) {
  constexpr int signals = Layout<FiveZone>::signals;
  SplitMix64 generator(seed(seed_name));
  const std::vector<int> is_status = meta().at("is_status").get<std::vector<int>>();
  const auto status = [&](int j) { return is_status[static_cast<std::size_t>(j)] != 0; };
  std::vector<double> rows;
  for (int k = 0; k < n; ++k) {
    const std::size_t at = rows.size();
    for (int j = 0; j <= signals; ++j)
      rows.push_back(status(j) ? (generator.uniform() < 0.5 ? 0.0 : 1.0) : generator.symmetric() * std::sqrt(3.0));
    for (int j = 0; j < signals; ++j) {
      const double now = rows[at + static_cast<std::size_t>(j)];
      if (j < Layout<FiveZone>::rooms)
        rows.push_back(now + 0.3 * generator.symmetric());
      else if (status(j))
        rows.push_back(generator.uniform() < 0.1 ? 1.0 - now : now);
      else
        rows.push_back(now + 0.2 * generator.symmetric());
    }
  }
  return rows;
}

template <class Scalar>
std::vector<Scalar> as(const std::vector<double>& values) {
  std::vector<Scalar> out(values.size());
  std::transform(values.begin(), values.end(), out.begin(), [](double v) { return static_cast<Scalar>(v); });
  return out;
}

inline LearnerSettings<FiveZone> settings_of_meta() {
  const json& c = meta().at("config");
  LearnerSettings<FiveZone> s;
  s.loss.gamma = c.at("gamma");
  s.loss.weights = {c.at("w_strb"), c.at("w_tdb"), c.at("w_gc"), c.at("w_rc"), c.at("w_rec")};
  const std::vector<double> labels = meta().at("labels").get<std::vector<double>>();
  std::copy(labels.begin(), labels.end(), s.loss.labels.begin());
  s.adam = {c.at("lr"), c.at("b1"), c.at("b2"), c.at("eps")};
  s.sync_every = c.at("sync_every");
  return s;
}

/// |a - b| relative to max(1, |b|).
inline double error_of(double a, double b) { return std::abs(a - b) / std::max(1.0, std::abs(b)); }

/// Largest error of one tensor's sum, absolute sum, maximum and sampled entries.
template <class Values>
double checksum_error(const Values& values, const json& expected) {
  double sum = 0, abs_sum = 0, max_abs = 0;
  for (const auto v : values) {
    const double x = static_cast<double>(v);
    sum += x;
    abs_sum += std::abs(x);
    max_abs = std::max(max_abs, std::abs(x));
  }
  double worst = std::max({error_of(sum, expected.at("sum")), error_of(abs_sum, expected.at("abs_sum")),
                           error_of(max_abs, expected.at("max_abs"))});
  for (std::size_t i = 0; i < expected.at("idx").size(); ++i)
    worst = std::max(
        worst, error_of(static_cast<double>(values[expected.at("idx")[i].get<std::size_t>()]), expected.at("val")[i]));
  return worst;
}

/// Largest checksum error over all tensors, named `enc_s.0.w` and so on, and how many were compared.
template <class Scalar>
double checksum_error(const NetworkWeights<FiveZone, Scalar>& w, const json& expected) {
  double worst = 0;
  for (std::size_t l = 0; l < layer_count; ++l) {
    const std::string name = meta().at("layers")[l][0];
    const LayerShape s = w.layers[l];
    const std::span<const Scalar> flat(w.values);
    const auto part = [&](int at, int n) {
      return flat.subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(n));
    };
    worst = std::max(worst, checksum_error(part(s.weight, s.outputs * s.inputs), expected.at(name + ".w")));
    worst = std::max(worst, checksum_error(part(s.bias, s.outputs), expected.at(name + ".b")));
  }
  return worst;
}

/// Sum of absolute values of tensor `name`.
template <class Scalar>
double abs_sum(const NetworkWeights<FiveZone, Scalar>& w, std::size_t layer, bool bias) {
  const LayerShape s = w.layers[layer];
  const int begin = bias ? s.bias : s.weight;
  const int end = bias ? s.bias + s.outputs : s.bias;
  double sum = 0;
  for (int i = begin; i < end; ++i) sum += std::abs(static_cast<double>(w.values[static_cast<std::size_t>(i)]));
  return sum;
}

template <class Scalar>
BatchView<FiveZone, Scalar> view_of(const std::vector<Scalar>& rows) {
  return {rows.data(), nullptr, static_cast<int>(rows.size()) / Layout<FiveZone>::transition};
}

template <class Scalar>
std::unique_ptr<NetworkScratch<FiveZone, Scalar>> make_scratch(Kernels<Scalar> kernels = strict_kernels<Scalar>()) {
  auto scratch = std::make_unique<NetworkScratch<FiveZone, Scalar>>();
  scratch->kernels = kernels;
  return scratch;
}

/// Every float table that this CPU can run.
inline std::vector<Kernels<float>> all_float_kernels() {
  std::vector<Kernels<float>> all;
  for (const KernelKind kind : {KernelKind::strict, KernelKind::avx2, KernelKind::avx512})
    if (cpu_has(kind)) all.push_back(float_kernels(kind));
  return all;
}

inline double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

}  // namespace airside::golden
