#include "tools/run/training/residual_training.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>

#include "hal/text/input_error.hpp"
#include "tools/run/control_loop.hpp"

namespace airside::tools {

namespace {

using Net = ResidualNetwork;
using Matrix = Eigen::MatrixXf;

/// Weights as matrices over one array, in the order of ResidualNetwork behind mean and scale: a row a unit, bias last.
struct Weights {
  Eigen::VectorXf flat = Eigen::VectorXf::Zero(Net::weights);
  using Map = Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  static constexpr int second_at = (Net::inputs + 1) * Net::first;
  static constexpr int third_at = second_at + (Net::first + 1) * Net::second;
  Map first() { return {flat.data(), Net::first, Net::inputs + 1}; }
  Map second() { return {flat.data() + second_at, Net::second, Net::first + 1}; }
  Map third() { return {flat.data() + third_at, 1, Net::second + 1}; }
};

void draw(Weights& w, SplitMix64& random) {
  for (auto layer : {w.first(), w.second(), w.third()}) {
    const float bound = 1.0f / std::sqrt(static_cast<float>(layer.cols() - 1));
    for (Eigen::Index i = 0; i < layer.size(); ++i) {
      layer.data()[i] = bound * static_cast<float>(2 * random.uniform() - 1);
    }
  }
}

/// Columns are samples; the last row is 1, for the bias.
Matrix with_ones(const Matrix& a) {
  Matrix out(a.rows() + 1, a.cols());
  out.topRows(a.rows()) = a;
  out.bottomRows(1).setOnes();
  return out;
}

Matrix leaky(const Matrix& y) { return y.cwiseMax(0.01f * y); }
Matrix slope(const Matrix& y) { return (y.array() > 0).select(Matrix::Ones(y.rows(), y.cols()), 0.01f); }

/// Mean Huber loss / huber_k, and its gradient.
void gradient(Weights& w, const Matrix& z, const Eigen::RowVectorXf& target, float huber_k, Weights& g) {
  const Matrix x = with_ones(z);
  const Matrix y1 = w.first() * x, a1 = with_ones(leaky(y1));
  const Matrix y2 = w.second() * a1, a2 = with_ones(leaky(y2));
  const Eigen::RowVectorXf residual = (w.third() * a2).row(0) - target;
  const Matrix d3 = (residual.array() / huber_k).max(-1.0f).min(1.0f).matrix() / static_cast<float>(z.cols());
  const Matrix d2 = (w.third().leftCols(Net::second).transpose() * d3).cwiseProduct(slope(y2));
  const Matrix d1 = (w.second().leftCols(Net::first).transpose() * d2).cwiseProduct(slope(y1));
  g.third() = d3 * a2.transpose();
  g.second() = d2 * a1.transpose();
  g.first() = d1 * x.transpose();
}

struct Scale {
  Eigen::VectorXf mean, sd;

  explicit Scale(std::span<const ResidualSample> samples) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(Net::inputs), square = sum;
    for (const ResidualSample& s : samples) {
      const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXf>(s.x.data(), Net::inputs).cast<double>();
      sum += x;
      square += x.cwiseAbs2();
    }
    const auto n = static_cast<double>(samples.size());
    const Eigen::VectorXd variance = square / n - (sum / n).cwiseAbs2();
    mean = (sum / n).cast<float>();
    sd = (variance.cwiseMax(0).cwiseSqrt().array() + 1e-6).matrix().cast<float>();
  }
};

struct Adam {
  Eigen::VectorXf m = Eigen::VectorXf::Zero(Net::weights), v = m;
  int steps = 0;

  void step(Weights& w, const Weights& g, double rate, double decay) {
    ++steps;
    m += 0.1f * (g.flat - m);
    v += 0.001f * (g.flat.cwiseAbs2() - v);
    const auto r = static_cast<float>(rate);
    const float m_scale = 1.0f / (1.0f - std::pow(0.9f, static_cast<float>(steps)));
    const float v_scale = 1.0f / (1.0f - std::pow(0.999f, static_cast<float>(steps)));
    w.flat *= 1.0f - r * static_cast<float>(decay);
    w.flat.array() -= r * m_scale * m.array() / ((v_scale * v).array().sqrt() + 1e-8f);
  }
};

/// From a 25th of the height to the height at 0.3, and down to nothing, along cosines.
double rate_at(double share, double height) {
  const auto cosine = [](double from, double to, double at) {
    return to + (from - to) * (1 + std::cos(std::numbers::pi * at)) / 2;
  };
  constexpr double rise = 0.3;
  return share < rise ? cosine(height / 25, height, share / rise) : cosine(height, 0, (share - rise) / (1 - rise));
}

void shuffle(std::vector<std::size_t>& order, SplitMix64& random) {
  for (std::size_t i = order.size() - 1; i > 0; --i) {
    std::swap(order[i], order[static_cast<std::size_t>(random.below(static_cast<std::uint32_t>(i + 1)))]);
  }
}

}  // namespace

std::vector<ResidualSample> residual_samples(const Site& site, const ControlRun& run) {
  std::vector<ResidualSample> out;
  for (std::size_t i = 0; i + 1 < run.cycles.size(); ++i) {
    const CycleSample &begin = run.cycles[i], &end = run.cycles[i + 1];
    if (begin.residual_features.empty() || !std::isfinite(end.head_error_k)) continue;
    if (end.time.seconds - begin.time.seconds != control_cycle(site.settings).seconds()) continue;
    ResidualSample& sample = out.emplace_back();
    std::ranges::copy(begin.residual_features, sample.x.begin());
    sample.error_k = static_cast<float>(end.head_error_k);
  }
  return out;
}

std::string bytes_of(std::span<const ResidualSample> samples) {
  return {reinterpret_cast<const char*>(samples.data()), samples.size_bytes()};
}

std::vector<ResidualSample> samples_from(std::string_view bytes) {
  std::vector<ResidualSample> out(bytes.size() / sizeof(ResidualSample));
  if (!out.empty()) std::memcpy(out.data(), bytes.data(), out.size() * sizeof(ResidualSample));
  return out;
}

ResidualScore score_of(const ResidualNetwork& network, std::span<const ResidualSample> samples) {
  double square = 0, left_square = 0, size = 0, left = 0;
  for (const ResidualSample& s : samples) {
    ResidualFeatures f;
    std::ranges::copy(s.x, f.x.begin());
    const double e = static_cast<double>(s.error_k), d = e - network.forecast_k(f);
    square += e * e;
    left_square += d * d;
    size += std::abs(e);
    left += std::abs(d);
  }
  return {samples.size(), 1 - left_square / square, left / size};
}

ResidualNetwork train_residual(std::span<const ResidualSample> samples, const ResidualTraining& training,
                               const OnProgress& progress) {
  const auto batch = static_cast<std::size_t>(training.batch);
  if (samples.size() < batch) {
    throw hal::InputError("residual samples", fmt::format("{}", samples.size()),
                          fmt::format("at least {}", training.batch), "simulate more days, rooms or seeds");
  }
  const Scale scale(samples);
  SplitMix64 random(training.seed);
  Weights w, g;
  draw(w, random);
  Adam adam;
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const std::size_t steps = samples.size() / batch;
  Matrix z(Net::inputs, training.batch);
  Eigen::RowVectorXf target(training.batch);
  for (int epoch = 0; epoch < training.epochs; ++epoch) {
    shuffle(order, random);
    for (std::size_t step = 0; step < steps; ++step) {
      for (std::size_t k = 0; k < batch; ++k) {
        const ResidualSample& s = samples[order[step * batch + k]];
        const auto column = static_cast<Eigen::Index>(k);
        const Eigen::Map<const Eigen::VectorXf> x(s.x.data(), Net::inputs);
        z.col(column) = (x - scale.mean).cwiseQuotient(scale.sd).cwiseMax(-Net::clip).cwiseMin(Net::clip);
        target(column) = std::clamp(s.error_k, -1.0f, 1.0f);
      }
      gradient(w, z, target, static_cast<float>(training.huber_k), g);
      const double share = (epoch + static_cast<double>(step) / static_cast<double>(steps)) / training.epochs;
      adam.step(w, g, rate_at(share, training.learning_rate), training.weight_decay);
    }
    if (progress) progress((epoch + 1.0) / training.epochs);
  }
  std::vector<float> all;
  all.insert(all.end(), scale.mean.begin(), scale.mean.end());
  all.insert(all.end(), scale.sd.begin(), scale.sd.end());
  all.insert(all.end(), w.flat.begin(), w.flat.end());
  ResidualNetwork network;
  network.take(all);
  return network;
}

bool has_residual(const BlobBytes& blob) {
  BlobHeader header;
  std::memcpy(&header, blob.data(), sizeof header);
  return header.residual_parameters != 0;
}

BlobBytes with_residual(const Site& site, const BlobBytes& blob, const ResidualNetwork& network,
                        const std::string& provenance) {
  BlobBytes out;
  for_topology_of(site, [&]<class T>(T) {
    auto payload = std::make_unique<SitePayload<T>>();
    payload->site = shape_of<T>(site);
    payload->cycle = control_cycle(site.settings);
    const BlobHeader header = hal::decode_blob<T>(blob, site.file.scope, "blob", *payload);
    payload->residual = network;
    payload->provenance.fill('\0');
    provenance.copy(payload->provenance.data(), payload->provenance.size() - 1);
    BlobHeader fresh;
    fresh.created_s = header.created_s;
    out.resize(WeightBlob<T>::size(*payload));
    WeightBlob<T>::encode(fresh, *payload, out);
  });
  return out;
}

}  // namespace airside::tools
