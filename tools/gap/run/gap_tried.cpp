// A user's suspicions beside nothing and beside what was found.

#include <fmt/format.h>

#include "tools/gap/run/gap_run.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

PeriodErrors errors_in(const GapRun& run, const Eigen::MatrixXd& residual, Eigen::Index first, Eigen::Index last) {
  const sim::Channels at = run.channels();
  const Eigen::MatrixXd& measured = run.loaded.data.test.measured;
  const ChannelErrors errors = errors_of(residual, first, last);
  return {joint_rmse(errors, 0, at.mau_temp() + 1), joint_rmse(errors, at.power(), at.fcu_duty()),
          guideline_14_room_temp(measured, residual, at, first, last),
          guideline_14_power(measured, residual, at, first, last)};
}

json errors_json(const PeriodErrors& e) {
  return {{"temp_rmse_k", finite_json(e.temp_rmse_k)},
          {"power_rmse_kw", finite_json(e.power_rmse_kw)},
          {"room_temp_cv_rmse_percent", finite_json(e.room_temp.cv_rmse_percent)},
          {"power_cv_rmse_percent", finite_json(e.power.cv_rmse_percent)}};
}

json both_periods_json(const GapRun& run, const Eigen::MatrixXd& residual) {
  return {{"fitted_days", errors_json(fitted_errors(run, residual))},
          {"locked_days", errors_json(locked_errors(run, residual))}};
}

json suspicion_json(const GapRun& run, const Suspicion& s) {
  const TriedEffect& t = s.tried;
  const MagnitudeInterval interval = interval_of(t.best);
  json rivals = json::array(), alike = json::array();
  for (const Rival& r : t.rivals) rivals.push_back({{"id", r.at.id()}, {"gain", r.log_likelihood_ratio}});
  for (const sim::EffectAt& at : t.cannot_tell_from) alike.push_back(at.id());
  return {{"id", t.asked.at.id()},
          {"text", t.asked.at.text()},
          {"magnitude", t.asked.magnitude},
          {"unit", t.asked.at.effect->unit},
          {"answer", text_of(t.answer)},
          {"sentence", sentence_of(t)},
          {"gain", t.log_likelihood_ratio},
          {"gain_if_true", t.expected},
          {"gain_limit", t.log_likelihood_limit},
          {"gain_over_nothing", t.over_nothing},
          {"gain_of_what_was_found", t.found},
          {"locked_gain", t.locked},
          {"locked_gain_if_true", t.locked_expected},
          {"best",
           {{"magnitude", t.best.magnitude},
            {"sd", finite_json(t.best.sd)},
            {"interval", {interval.low, interval.high}},
            {"gain", t.best.log_likelihood_ratio}}},
          {"rivals", rivals},
          {"class", alike},
          {"without", both_periods_json(run, run.residual_before)},
          {"with", both_periods_json(run, s.residual)},
          {"found", run.verdict.findings.empty() ? json() : both_periods_json(run, run.residual_after)}};
}

std::string errors_text(const PeriodErrors& e) {
  return fmt::format("{:.2f} K, {:.1f} %, {:.2f} kW, {:.1f} %", e.temp_rmse_k, e.room_temp.cv_rmse_percent,
                     e.power_rmse_kw, e.power.cv_rmse_percent);
}

std::string row_text(const GapRun& run, const std::string& name, double gain, const Eigen::MatrixXd& residual) {
  return fmt::format("  {:<28} {:>7.0f}   {:<32} {}\n", name, gain, errors_text(fitted_errors(run, residual)),
                     errors_text(locked_errors(run, residual)));
}

}  // namespace

PeriodErrors fitted_errors(const GapRun& run, const Eigen::MatrixXd& residual) {
  return errors_in(run, residual, bins_per_day, run.locked_from());
}

PeriodErrors locked_errors(const GapRun& run, const Eigen::MatrixXd& residual) {
  return errors_in(run, residual, run.locked_from(), residual.rows());
}

json suspicions_json(const GapRun& run) {
  json list = json::array();
  for (const Suspicion& s : run.suspicions) list.push_back(suspicion_json(run, s));
  return list;
}

std::string suspicions_text(const GapRun& run) {
  std::string text;
  for (const Suspicion& s : run.suspicions) {
    const TriedEffect& t = s.tried;
    const MagnitudeInterval interval = interval_of(t.best);
    text += fmt::format("tried {}: {}\n", title_of(t), sentence_of(t));
    text += fmt::format("  {:<28} {:>7}   {:<32} {}\n", "", "gain", "fitted days: CV(RMSE)", "locked days: CV(RMSE)");
    text += row_text(run, "nothing", 0, run.residual_before);
    text += row_text(run, title_of(t), t.over_nothing, s.residual);
    if (!run.verdict.findings.empty()) text += row_text(run, "what was found", t.found, run.residual_after);
    text += fmt::format("  the size that fits best: {:.3g}{} ({:.3g} to {:.3g}; nothing would be {:.3g})\n",
                        t.best.magnitude, unit_suffix(*t.best.at.effect), interval.low, interval.high,
                        t.best.at.effect->null_value);
  }
  return text;
}

}  // namespace airside::tools::gap
