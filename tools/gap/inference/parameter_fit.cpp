#include "tools/gap/inference/parameter_fit.hpp"

#include <ceres/cost_function.h>
#include <ceres/evaluation_callback.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

namespace airside::tools::gap {

namespace {

constexpr double farthest = 4;  // prior standard deviations

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The model at z and its derivatives, each run once however often Ceres asks.
class FitEvaluator final : public ceres::EvaluationCallback {
 public:
  FitEvaluator(const std::vector<FitParameter>& parameters, const FitModel& model, const Eigen::MatrixXd& measured,
               const std::vector<bool>& kept, const sim::Channels& channels, const FitSettings& settings)
      : parameters_(parameters),
        model_(model),
        measured_(measured),
        kept_(kept),
        channels_(channels),
        settings_(settings) {
    const auto n = static_cast<Eigen::Index>(parameters.size());
    z = lower = upper = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const FitParameter& p = parameter(i);
      lower(i) = std::max(-farthest, p.z_of(p.low));
      upper(i) = std::min(farthest, p.z_of(p.high));
      if (!(lower(i) < upper(i))) upper(i) = lower(i) + 1e-6;
    }
    z = z.cwiseMax(lower).cwiseMin(upper);
  }

  void PrepareForEvaluation(bool jacobians, bool new_point) override {
    if (new_point || at_.size() == 0 || at_ != z) simulate();
    if (jacobians && failure_ == nullptr) differentiate();
    if (failure_ == nullptr) whiten(jacobians);
  }

  /// Later evaluations use this noise.
  void set_noise(NoiseModel noise) {
    noise_ = std::move(noise);
    plain_.resize(0);
  }
  /// Later evaluations count each channel by the spread of its residual, as if a day held this number of independent
  /// values.
  void set_plain(double values_per_day) {
    plain_ = NoiseModel::fit(difference(shown_), channels_).spread().cwiseInverse() *
             std::sqrt(values_per_day / bins_per_day);
  }
  /// Everything at the present z.
  void evaluate() {
    PrepareForEvaluation(true, false);
    rethrow();
  }
  /// The model at the present z; a minimiser may have tried another point last.
  void settle() {
    if (at_.size() == 0 || at_ != z || failed()) simulate();
    rethrow();
  }
  void rethrow() const {
    if (failure_ != nullptr) std::rethrow_exception(failure_);
  }
  bool failed() const { return failure_ != nullptr; }
  const NoiseModel& noise() const { return noise_; }
  const Eigen::MatrixXd& shown() const { return shown_; }
  const Eigen::VectorXd& residual() const { return residual_; }
  const RowMajor& jacobian() const { return jacobian_; }
  int runs() const { return runs_; }

  Eigen::MatrixXd difference(const Eigen::MatrixXd& shown) const {
    Eigen::MatrixXd residual = measured_ - shown;
    for (Eigen::Index t = 0; t < residual.rows(); ++t) {
      if (!kept_[static_cast<std::size_t>(t)]) residual.row(t).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
    return residual;
  }

  Eigen::VectorXd z, lower, upper;  ///< Ceres moves z

 private:
  const FitParameter& parameter(Eigen::Index i) const { return parameters_[static_cast<std::size_t>(i)]; }

  Eigen::MatrixXd run(const Eigen::VectorXd& at) const {
    Eigen::VectorXd values(at.size());
    for (Eigen::Index i = 0; i < at.size(); ++i) values(i) = parameter(i).value(at(i));
    return binned(model_(values), channels_);
  }

  void count_run() {
    ++runs_;
    const double all =
        static_cast<double>(settings_.rounds * settings_.iterations + 2) * static_cast<double>(parameters_.size() + 2);
    if (settings_.progress) settings_.progress(std::min(1.0, runs_ / all));
  }

  void simulate() {
    failure_ = nullptr;
    try {
      shown_ = run(z);
      at_ = z;
      differentiated_ = false;
    } catch (...) {
      failure_ = std::current_exception();
    }
    count_run();
  }

  void differentiate() {
    if (differentiated_) return;
    slopes_.assign(parameters_.size(), {});
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    const auto work = [&] {
      for (std::size_t i = next++; i < slopes_.size(); i = next++) {
        try {
          const auto k = static_cast<Eigen::Index>(i);
          Eigen::VectorXd moved = z;
          const double step = z(k) + settings_.step > upper(k) ? -settings_.step : settings_.step;
          moved(k) = std::clamp(z(k) + step, lower(k), upper(k));
          if (moved(k) == z(k)) {
            slopes_[i] = Eigen::MatrixXd::Zero(shown_.rows(), shown_.cols());
            continue;
          }
          slopes_[i] = (run(moved) - shown_) / (moved(k) - z(k));
          const std::lock_guard lock(mutex);
          count_run();
        } catch (...) {
          const std::lock_guard lock(mutex);
          if (!failure_) failure_ = std::current_exception();
          next = slopes_.size();
        }
      }
    };
    std::vector<std::thread> threads;
    for (int i = 1; i < settings_.jobs; ++i) threads.emplace_back(work);
    work();
    for (auto& thread : threads) thread.join();
    differentiated_ = failure_ == nullptr;
  }

  Eigen::VectorXd whitened(const Eigen::MatrixXd& x) const {
    if (plain_.size() == 0) return noise_.whiten(x, kept_, measured_);
    Eigen::MatrixXd scaled = Eigen::MatrixXd::Zero(x.cols(), x.rows());
    for (Eigen::Index t = 0; t < x.rows(); ++t) {
      if (!kept_[static_cast<std::size_t>(t)]) continue;
      for (Eigen::Index c = 0; c < x.cols(); ++c) {
        if (std::isfinite(x(t, c)) && std::isfinite(measured_(t, c))) scaled(c, t) = plain_(c) * x(t, c);
      }
    }
    return Eigen::Map<const Eigen::VectorXd>(scaled.data(), scaled.size());
  }

  void whiten(bool jacobians) {
    residual_ = whitened(difference(shown_));
    if (!jacobians) return;
    jacobian_.resize(residual_.size(), std::ssize(slopes_));
    for (std::size_t i = 0; i < slopes_.size(); ++i) {
      jacobian_.col(static_cast<Eigen::Index>(i)) = -whitened(slopes_[i]);
    }
  }

  const std::vector<FitParameter>& parameters_;
  const FitModel& model_;
  const Eigen::MatrixXd& measured_;
  const std::vector<bool>& kept_;
  sim::Channels channels_;
  const FitSettings& settings_;
  NoiseModel noise_;
  Eigen::VectorXd plain_;
  Eigen::VectorXd at_;
  Eigen::MatrixXd shown_;
  std::vector<Eigen::MatrixXd> slopes_;
  bool differentiated_ = false;
  Eigen::VectorXd residual_;
  RowMajor jacobian_;
  std::exception_ptr failure_;
  int runs_ = 0;
};

/// One whitened number.
class WhitenedResidual final : public ceres::CostFunction {
 public:
  WhitenedResidual(const FitEvaluator& evaluator, Eigen::Index row) : evaluator_(evaluator), row_(row) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(static_cast<std::int32_t>(evaluator.z.size()));
  }
  bool Evaluate(const double* const*, double* residuals, double** jacobians) const override {
    if (evaluator_.failed()) return false;
    residuals[0] = evaluator_.residual()(row_);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      const auto row = evaluator_.jacobian().row(row_);
      std::copy(row.data(), row.data() + row.size(), jacobians[0]);
    }
    return true;
  }

 private:
  const FitEvaluator& evaluator_;
  Eigen::Index row_;
};

/// z itself: the prior.
class PriorResidual final : public ceres::CostFunction {
 public:
  explicit PriorResidual(int count) {
    set_num_residuals(count);
    mutable_parameter_block_sizes()->push_back(count);
  }
  bool Evaluate(const double* const* z, double* residuals, double** jacobians) const override {
    const int n = num_residuals();
    std::copy(z[0], z[0] + n, residuals);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      std::fill(jacobians[0], jacobians[0] + n * n, 0.0);
      for (int i = 0; i < n; ++i) jacobians[0][i * n + i] = 1;
    }
    return true;
  }
};

void minimise(FitEvaluator& evaluator, const FitSettings& settings) {
  ceres::Problem::Options options;
  options.evaluation_callback = &evaluator;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::HuberLoss loss(settings.huber);
  ceres::Problem problem(options);
  const auto n = static_cast<int>(evaluator.z.size());
  problem.AddParameterBlock(evaluator.z.data(), n);
  for (int i = 0; i < n; ++i) {
    problem.SetParameterLowerBound(evaluator.z.data(), i, evaluator.lower(i));
    problem.SetParameterUpperBound(evaluator.z.data(), i, evaluator.upper(i));
  }
  problem.AddResidualBlock(new PriorResidual(n), nullptr, evaluator.z.data());
  evaluator.evaluate();
  for (Eigen::Index row = 0; row < evaluator.residual().size(); ++row) {
    if (evaluator.residual()(row) == 0) continue;  // missing
    problem.AddResidualBlock(new WhitenedResidual(evaluator, row), &loss, evaluator.z.data());
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = settings.iterations;
  solver.function_tolerance = 1e-4;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (summary.termination_type == ceres::FAILURE) evaluator.rethrow();
}

/// How much more the gradient's daily sums vary than those of independent residuals.
double inflation_of(const RowMajor& j, const Eigen::VectorXd& weighted, const Eigen::MatrixXd& information,
                    const Eigen::MatrixXd& inverse, Eigen::Index width) {
  const Eigen::Index day = bins_per_day * width, days = (j.rows() + day - 1) / day;
  Eigen::MatrixXd sums(j.cols(), days);
  for (Eigen::Index d = 0; d < days; ++d) {
    const Eigen::Index first = d * day, count = std::min(day, j.rows() - first);
    sums.col(d) = j.middleRows(first, count).transpose() * weighted.segment(first, count);
  }
  sums.colwise() -= sums.rowwise().mean().eval();
  const double expected = (inverse * information).trace();
  return expected > 0 ? std::max(1.0, (inverse * (sums * sums.transpose())).trace() / expected) : 1;
}

}  // namespace

double FitParameter::value(double z) const {
  return std::clamp(logarithmic ? start * std::exp(prior_sd * z) : start + prior_sd * z, low, high);
}

double FitParameter::slope(double z) const { return logarithmic ? prior_sd * value(z) : prior_sd; }

double FitParameter::z_of(double value) const {
  if (!logarithmic) return (value - start) / prior_sd;
  return value > 0 ? std::log(value / start) / prior_sd : -std::numeric_limits<double>::infinity();
}

double ParameterFit::sd(const FitParameter& parameter, Eigen::Index i) const {
  return parameter.slope(z(i)) * std::sqrt(covariance(i, i));
}

ParameterFit fit_parameters(const std::vector<FitParameter>& parameters, const FitModel& model,
                            const Eigen::MatrixXd& measured, const std::vector<bool>& kept,
                            const sim::Channels& channels, const FitSettings& settings) {
  FitEvaluator evaluator(parameters, model, measured, kept, channels, settings);
  const auto fit_noise = [&] { return NoiseModel::fit(evaluator.difference(evaluator.shown()), channels); };
  ParameterFit fit;
  evaluator.settle();
  fit.start = evaluator.shown();
  // What an unfitted model leaves wanders so slowly that whitening would forgive any level: plain residuals come first.
  for (int round = 0; round < settings.rounds; ++round) {
    if (round < settings.plain_rounds) {
      evaluator.set_plain(settings.plain_values_per_day);
    } else {
      evaluator.set_noise(fit_noise());
    }
    minimise(evaluator, settings);
    evaluator.settle();
  }
  evaluator.set_noise(fit_noise());
  evaluator.evaluate();
  fit.z = evaluator.z;
  fit.best = evaluator.shown();
  fit.noise = evaluator.noise();
  const RowMajor& j = evaluator.jacobian();
  const Eigen::VectorXd& r = evaluator.residual();
  const Eigen::VectorXd weight =
      r.unaryExpr([&](double x) { return std::min(1.0, settings.huber / std::max(1e-9, std::abs(x))); });
  const Eigen::MatrixXd information = j.transpose() * weight.asDiagonal() * j;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(j.cols(), j.cols());
  const Eigen::MatrixXd inverse = (information + one).ldlt().solve(one);
  fit.inflation = inflation_of(j, weight.cwiseProduct(r), information, inverse, measured.cols());
  fit.covariance = inverse * (fit.inflation * information + one) * inverse;
  fit.runs = evaluator.runs();
  if (settings.progress) settings.progress(1);
  return fit;
}

}  // namespace airside::tools::gap
