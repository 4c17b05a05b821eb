#include "tools/gap/explain/flux.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

namespace airside::tools::gap {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A symmetric matrix of equal blocks, of which only those beside the diagonal are not zero.
struct BlockBand {
  std::vector<MatrixXd> diagonal;  ///< [i]: block i, i
  std::vector<MatrixXd> below;     ///< [i]: block i + 1, i

  BlockBand(std::size_t blocks, Index size)
      : diagonal(blocks, MatrixXd::Zero(size, size)), below(blocks - 1, MatrixXd::Zero(size, size)) {}
  Index size() const { return diagonal[0].rows(); }
};

/// Its factor: D_0 = A_00, D_i = A_ii - A_i,i-1 D_i-1^-1 A_i-1,i.
class BlockBandFactor {
 public:
  explicit BlockBandFactor(const BlockBand& a) : size_(a.size()) {
    for (std::size_t i = 0; i < a.diagonal.size(); ++i) {
      MatrixXd d = a.diagonal[i];
      if (i > 0) d -= a.below[i - 1] * step_[i - 1].transpose();
      factor_.emplace_back(d);
      if (i + 1 < a.diagonal.size()) step_.push_back(factor_[i].solve(a.below[i].transpose()).transpose());
    }
  }

  MatrixXd solve(MatrixXd x) const {
    const auto block = [&](std::size_t i) { return x.middleRows(static_cast<Index>(i) * size_, size_); };
    for (std::size_t i = 1; i < factor_.size(); ++i) block(i) -= step_[i - 1] * block(i - 1);
    for (std::size_t i = 0; i < factor_.size(); ++i) block(i) = factor_[i].solve(block(i)).eval();
    for (std::size_t i = factor_.size() - 1; i-- > 0;) block(i) -= step_[i].transpose() * block(i + 1);
    return x;
  }

  /// Diagonal of the inverse.
  VectorXd inverse_diagonal() const {
    VectorXd out(size_ * static_cast<Index>(factor_.size()));
    MatrixXd last;
    for (std::size_t i = factor_.size(); i-- > 0;) {
      MatrixXd here = factor_[i].solve(MatrixXd::Identity(size_, size_));
      if (i + 1 < factor_.size()) here += step_[i].transpose() * last * step_[i];
      out.segment(static_cast<Index>(i) * size_, size_) = here.diagonal();
      last = std::move(here);
    }
    return out;
  }

 private:
  Index size_;
  std::vector<Eigen::LLT<MatrixXd>> factor_;  // of D_i
  std::vector<MatrixXd> step_;                // A_i+1,i D_i^-1
};

class HeatInversion {
 public:
  HeatInversion(const Engine& engine, const Window& window, const ReferenceFit& fit, const Responses& responses,
                const Changes& fitted, int jobs, const HeatRules& rules)
      : engine_(engine),
        window_(window),
        fit_(fit),
        fitted_(fitted),
        jobs_(jobs),
        rules_(rules),
        bins_(window.measured.rows()),
        temps_(engine.channels().mau_temp()),
        kept_(counted_bins(bins_)),
        missing_(window.measured),
        normal_(static_cast<std::size_t>(bins_ / memory_bins), memory_bins * temps_),
        penalty_(normal_) {
    missing_.rightCols(missing_.cols() - temps_).setConstant(std::numeric_limits<double>::quiet_NaN());
    structural_ = fit.structural(responses);
    nuisance_ = temperatures_of(nuisance_directions(fit, responses, kept_, missing_, rules.nuisance));
    inner_ = nuisance_.transpose() * nuisance_ + MatrixXd::Identity(nuisance_.cols(), nuisance_.cols());
    inner_factor_.compute(inner_);
  }

  UnknownHeat run() {
    simulate_pulses();
    make_responses();
    make_matrices();
    const MatrixXd residual = window_.measured - base_ - structural_;
    choose_smoothing(whitened(residual));
    for (int i = 0; i < rules_.refinements; ++i) {
      // What the pulses' sum does not know: slow masses, fan coils that switch, boxes that close, the days before.
      const MatrixXd heat = as_bins(solution_);
      const MatrixXd real =
          binned(engine_.simulate(fitted_, heated(window_.recording, heat)), engine_.channels()) - base_;
      MatrixXd corrected = residual;
      corrected.leftCols(temps_) -= real.leftCols(temps_);
      solve(whitened(corrected) + response_to(solution_));
    }
    return result();
  }

 private:
  static constexpr Index memory_bins =
      24;  // half a day: whitened responses are short, and real simulations do the rest

  std::size_t phase_of(Index bin) const {
    const double hour = 24.0 * static_cast<double>(bin % bins_per_day) / bins_per_day;
    const auto away = [hour](double pulse) {
      const double d = std::abs(hour - pulse);
      return std::min(d, 24 - d);
    };
    const auto nearest = std::min_element(rules_.pulse_hours.begin(), rules_.pulse_hours.end(),
                                          [&](double a, double b) { return away(a) < away(b); });
    return static_cast<std::size_t>(nearest - rules_.pulse_hours.begin());
  }

  /// A pulse is in the middle of the window, never on the first day, which is lived through five times.
  Index bin_of_pulse(std::size_t phase) const {
    const Index day = std::max<Index>(1, bins_ / bins_per_day / 2 - 1);
    return day * bins_per_day + std::lround(rules_.pulse_hours[phase] / 24 * bins_per_day);
  }

  void simulate_pulses() {
    std::vector<sim::Recording> recordings;
    for (std::size_t phase = 0; phase < rules_.pulse_hours.size(); ++phase) {
      for (Index zone = 0; zone < temps_; ++zone) {
        MatrixXd pulse = MatrixXd::Zero(bins_, temps_);
        pulse(bin_of_pulse(phase), zone) = rules_.pulse_kw;
        recordings.push_back(heated(window_.recording, pulse));
        recordings.back().rows.resize(
            std::min(recordings.back().rows.size(),
                     static_cast<std::size_t>((bin_of_pulse(phase) + memory_bins) * rows_per_bin)));
      }
    }
    std::vector<Task> tasks{{fitted_, &window_.recording}};
    for (const sim::Recording& recording : recordings) tasks.push_back({fitted_, &recording});
    const auto tables = simulate_all(engine_, tasks, jobs_);
    base_ = binned(tables[0], engine_.channels());
    std::size_t next = 1;
    pulses_.resize(rules_.pulse_hours.size());
    for (std::size_t phase = 0; phase < pulses_.size(); ++phase) {
      const Index first = bin_of_pulse(phase);
      for (Index zone = 0; zone < temps_; ++zone) {
        const MatrixXd table = binned(tables[next++], engine_.channels());
        const Index n = std::min<Index>(memory_bins, table.rows() - first);
        MatrixXd response = MatrixXd::Zero(memory_bins, temps_);
        response.topRows(n) = (table.block(first, 0, n, temps_) - base_.block(first, 0, n, temps_)) / rules_.pulse_kw;
        pulses_[phase].push_back(std::move(response));
      }
    }
  }

  /// Of whitened rows, those of the temperatures: they come first, so later channels are not mixed into them.
  MatrixXd temperatures_of(const MatrixXd& white) const {
    const Index width = missing_.cols(), bins = white.rows() / width;
    MatrixXd out(bins * temps_, white.cols());
    for (Index t = 0; t < bins; ++t) out.middleRows(t * temps_, temps_) = white.middleRows(t * width, temps_);
    return out;
  }
  VectorXd whitened(const MatrixXd& x) const { return temperatures_of(fit_.noise.whiten(x, kept_, missing_)); }

  Index first_row(Index bin) const { return std::max<Index>(0, bin - NoiseModel::order) * temps_; }

  /// Whitened responses of all zones to heat in each bin: rows from first_row(bin), columns zones.
  void make_responses() {
    const Index width = missing_.cols();
    for (Index bin = 0; bin < bins_; ++bin) {
      // Whole days, since noise depends on the time of day; two bins before, since whitening looks back.
      const Index begin = std::max<Index>(0, bin - NoiseModel::order);
      const Index day = begin / bins_per_day * bins_per_day, end = std::min(bins_, bin + memory_bins);
      const std::vector<bool> kept(kept_.begin() + static_cast<std::ptrdiff_t>(day),
                                   kept_.begin() + static_cast<std::ptrdiff_t>(end));
      const MatrixXd missing = missing_.middleRows(day, end - day);
      MatrixXd& out = responses_.emplace_back((end - begin - NoiseModel::order) * temps_, temps_);
      MatrixXd x = MatrixXd::Zero(end - day, width);
      for (Index zone = 0; zone < temps_; ++zone) {
        x.block(bin - day, 0, end - bin, temps_) =
            pulses_[phase_of(bin)][static_cast<std::size_t>(zone)].topRows(end - bin);
        out.col(zone) = temperatures_of(fit_.noise.whiten(x, kept, missing)).bottomRows(out.rows());
      }
    }
  }

  /// Calls part(row bin, column bin, values) for the blocks on and below the diagonal of G'G and D2'D2.
  void make_matrices() {
    const auto add = [this](BlockBand& band, Index row, Index column, const MatrixXd& value) {
      const auto i = static_cast<std::size_t>(row / memory_bins), k = static_cast<std::size_t>(column / memory_bins);
      const Index r = row % memory_bins * temps_, c = column % memory_bins * temps_;
      if (i != k) {
        band.below[k].block(r, c, temps_, temps_) += value;
        return;
      }
      band.diagonal[i].block(r, c, temps_, temps_) += value;
      if (row != column) band.diagonal[i].block(c, r, temps_, temps_) += value.transpose();
    };
    for (Index a = 0; a < bins_; ++a) {
      const MatrixXd& ga = responses_[static_cast<std::size_t>(a)];
      for (Index b = a; b < std::min(bins_, a + memory_bins); ++b) {
        const MatrixXd& gb = responses_[static_cast<std::size_t>(b)];
        const Index ahead = first_row(b) - first_row(a), n = std::min(ga.rows() - ahead, gb.rows());
        if (n > 0) add(normal_, b, a, gb.topRows(n).transpose() * ga.middleRows(ahead, n));
      }
    }
    constexpr double stencil[] = {1, -2, 1};
    for (Index bin = 0; bin + 2 < bins_; ++bin) {
      for (Index a = 0; a < 3; ++a) {
        for (Index b = a; b < 3; ++b)
          add(penalty_, bin + b, bin + a, stencil[a] * stencil[b] * MatrixXd::Identity(temps_, temps_));
      }
    }
    across_ = adjoint(nuisance_).transpose();
  }

  /// G u.
  VectorXd response_to(const VectorXd& u) const {
    VectorXd out = VectorXd::Zero(nuisance_.rows());
    for (Index bin = 0; bin < bins_; ++bin) {
      const MatrixXd& g = responses_[static_cast<std::size_t>(bin)];
      out.segment(first_row(bin), g.rows()) += g * u.segment(bin * temps_, temps_);
    }
    return out;
  }
  /// G' r.
  MatrixXd adjoint(const MatrixXd& r) const {
    MatrixXd out(bins_ * temps_, r.cols());
    for (Index bin = 0; bin < bins_; ++bin) {
      const MatrixXd& g = responses_[static_cast<std::size_t>(bin)];
      out.middleRows(bin * temps_, temps_) = g.transpose() * r.middleRows(first_row(bin), g.rows());
    }
    return out;
  }
  /// G' M r.
  VectorXd right_side(const VectorXd& r) const {
    return VectorXd(adjoint(r)) - across_.transpose() * inner_factor_.solve(nuisance_.transpose() * r);
  }

  /// For this smoothing: the factor of A = G'G + lambda D2'D2, and what the marginalised directions change.
  ///   (A - C' S^-1 C)^-1 = A^-1 + A^-1 C' (S - C A^-1 C')^-1 C A^-1
  void factorise() {
    BlockBand sum = normal_;
    const VectorXd root = smoothing_.cwiseSqrt().replicate(memory_bins, 1);
    const auto weighted = [&root](const MatrixXd& p) -> MatrixXd { return root.asDiagonal() * p * root.asDiagonal(); };
    for (std::size_t i = 0; i < sum.diagonal.size(); ++i) {
      sum.diagonal[i] += weighted(penalty_.diagonal[i]);
      sum.diagonal[i].diagonal().array() += 1e-2;  // a heat of 10 kW is a surprise of one standard deviation
      if (i < sum.below.size()) sum.below[i] += weighted(penalty_.below[i]);
    }
    factor_.emplace(sum);
    solved_across_ = factor_->solve(across_.transpose());
    marginal_.compute(inner_ - across_ * solved_across_);
  }
  VectorXd inverse_times(const VectorXd& b) const {
    const VectorXd x = factor_->solve(b);
    return x + solved_across_ * marginal_.solve(across_ * x);
  }

  void solve(const VectorXd& r) {
    solution_ = inverse_times(right_side(r));
    const VectorXd rest = r - response_to(solution_), j = nuisance_.transpose() * rest;
    const double samples = static_cast<double>((r.array() != 0).count());
    residual_ratio_ = (rest.squaredNorm() - j.dot(inner_factor_.solve(j))) / std::max(1.0, samples - freedom_.sum());
  }

  /// Each zone's weight by the evidence: lambda = freedom / |D2 u|^2, freedom the trace of the zone's part of how u
  /// depends on itself through r, estimated with random signs. A zone in which something is switched gets a small one.
  /// Source: MacKay 1992, "Bayesian interpolation".
  void choose_smoothing(const VectorXd& r) {
    constexpr int rounds = 7;
    std::mt19937_64 random(1);
    smoothing_ = VectorXd::Constant(temps_, 300);
    freedom_ = VectorXd::Zero(temps_);
    for (int round = 0; round <= rounds; ++round) {
      factorise();
      for (Index zone = 0; zone < temps_; ++zone) {
        VectorXd sign = VectorXd::Zero(bins_ * temps_);
        for (Index bin = 0; bin < bins_; ++bin) sign(bin * temps_ + zone) = random() % 2 == 0 ? 1 : -1;
        freedom_(zone) = std::max(1.0, sign.dot(inverse_times(right_side(response_to(sign)))));
      }
      solve(r);
      if (round == rounds) return;
      const MatrixXd u = as_bins(solution_);
      for (Index zone = 0; zone < temps_; ++zone) {
        const auto x = u.col(zone);
        const double rough = (x.head(bins_ - 2) - 2 * x.segment(1, bins_ - 2) + x.tail(bins_ - 2)).squaredNorm();
        smoothing_(zone) =
            std::clamp(std::max(1.0, residual_ratio_) * freedom_(zone) / std::max(1e-9, rough), 1.0, 1e6);
      }
    }
  }

  MatrixXd as_bins(const VectorXd& x) const { return Eigen::Map<const MatrixXd>(x.data(), temps_, bins_).transpose(); }

  UnknownHeat result() const {
    const double scale = std::max(1.0, residual_ratio_);
    UnknownHeat heat;
    heat.smoothing.assign(smoothing_.begin(), smoothing_.end());
    heat.residual_ratio = residual_ratio_;
    heat.heat_kw = as_bins(solution_);
    const MatrixXd spread = marginal_.solve(solved_across_.transpose());
    const VectorXd variance =
        factor_->inverse_diagonal() + solved_across_.cwiseProduct(spread.transpose()).rowwise().sum();
    heat.sd_kw = as_bins((scale * variance).cwiseMax(0).cwiseSqrt());
    const auto sd_of = [&](int zone, const VectorXd& weights) {
      VectorXd all = VectorXd::Zero(bins_ * temps_);
      for (Index bin = 0; bin < bins_; ++bin) all(bin * temps_ + zone) = weights(bin);
      return std::sqrt(std::max(0.0, scale * all.dot(inverse_times(all))));
    };
    describe_heat(heat, window_.recording, engine_.channels(), sd_of, rules_);
    return heat;
  }

  const Engine& engine_;
  const Window& window_;
  const ReferenceFit& fit_;
  const Changes& fitted_;
  int jobs_;
  const HeatRules& rules_;
  Index bins_, temps_;  // temps_: one a zone; unknowns are ordered bin by bin, zones within
  std::vector<bool> kept_;
  MatrixXd missing_, structural_, base_;
  BlockBand normal_, penalty_;          // G'G, D2'D2
  MatrixXd nuisance_, inner_, across_;  // J, S = I + J'J, C = J'G
  Eigen::LDLT<MatrixXd> inner_factor_;
  std::vector<std::vector<MatrixXd>> pulses_;  // [phase][zone]: bins x temperatures, of 1 kW in one bin
  std::vector<MatrixXd> responses_;            // [bin]
  std::optional<BlockBandFactor> factor_;
  MatrixXd solved_across_;          // A^-1 C'
  Eigen::LDLT<MatrixXd> marginal_;  // S - C A^-1 C'
  VectorXd solution_;
  VectorXd smoothing_, freedom_;  // of each zone
  double residual_ratio_ = 1;
};

}  // namespace

sim::Recording heated(sim::Recording recording, const MatrixXd& heat_kw) {
  for (std::size_t row = 0; row < recording.rows.size(); ++row) {
    const VectorXd now = heat_kw.row(std::min(static_cast<Index>(row) / rows_per_bin, heat_kw.rows() - 1)).transpose();
    recording.rows[row].zone_heat_kw.assign(now.begin(), now.end());
  }
  return recording;
}

UnknownHeat reconstruct_heat(const Engine& engine, const Window& window, const ReferenceFit& fit,
                             const Responses& responses, const Changes& fitted_parameters, int jobs,
                             const HeatRules& rules) {
  return HeatInversion(engine, window, fit, responses, fitted_parameters, jobs, rules).run();
}

}  // namespace airside::tools::gap
