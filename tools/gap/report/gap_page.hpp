#pragma once
// What the parts of a gap report look at, and the parts.

#include <string>
#include <vector>

#include "tools/gap/run/gap_run.hpp"
#include "tools/report/charts/report_input.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools {

struct GapPage {
  explicit GapPage(const gap::GapRun& of);

  const gap::GapRun& run;
  sim::Channels at;
  Eigen::Index first;      ///< bin after the first day
  std::vector<int> shown;  ///< channels that were ever measured
  /// As the verdict sees them: without what reference days showed already and all drawn buildings have. Channels that
  /// are no evidence are as measured less simulated. Shape: bins x channels.
  Eigen::MatrixXd news_before, news_after;

  bool found() const { return !run.verdict.findings.empty(); }
  Eigen::Index bins() const { return run.residual_given.rows(); }
  long locked_days() const { return static_cast<long>((bins() - run.locked_from()) / gap::bins_per_day); }
  gap::ChannelErrors locked(const Eigen::MatrixXd& residual) const {
    return gap::errors_of(residual, run.locked_from(), bins());
  }
};

inline TableCell number_cell(double value) { return {value, std::nullopt, ""}; }
inline TableCell text_cell(std::string text) { return {std::nullopt, std::nullopt, std::move(text)}; }
/// With a full stop.
std::string as_sentence(std::string text);
/// "room 1", "FCU room 2", "power 1": what people call a channel.
std::string channel_title(const sim::Channels& at, int c);
/// What people call the effect of an id, in the words of the verdict: "flow of box 2 is not what its controller
/// believes" for `vav_flow@2`; the id where no effect of the run has it.
std::string effect_title(const GapPage& page, const std::string& id);
/// The same for every id in a text such as "vav_flow@2 or infiltration".
std::string with_titles(const GapPage& page, const std::string& text);
/// "K", "kW", "share": the unit of a channel as a chart says it.
std::string channel_unit(const sim::Channels& at, int c);

/// The verdict as a title: the effect's own words, "Perhaps: ..." where it is not sure.
std::string verdict_title(const GapPage& page);
/// What a manager reads below it: size and probability, what else it may be, cost, what to do next.
std::string verdict_text(const GapPage& page);
/// "54 % ..." of the title, as a figure of the page.
void add_verdict_figure(const GapPage& page, ReportInput& input);
/// Of a finding by the search that found it; NaN where that search did not list it.
double probability_of(const GapPage& page, const gap::Finding& finding);

// Each adds its blocks, where there is something to show.
void add_figures(const GapPage& page, ReportInput& input);
void add_findings(const GapPage& page, ReportInput& input);
void add_posteriors(const GapPage& page, ReportInput& input);
void add_continued(const GapPage& page, ReportInput& input);
void add_suspicions(const GapPage& page, ReportInput& input);
void add_experiments(const GapPage& page, ReportInput& input);
void add_heat(const GapPage& page, ReportInput& input);
void add_clean_up(const GapPage& page, ReportInput& input);
void add_maps(const GapPage& page, ReportInput& input);
void add_curves(const GapPage& page, ReportInput& input);
void add_ranking(const GapPage& page, ReportInput& input);
void add_locked_days(const GapPage& page, ReportInput& input);
void add_guideline(const GapPage& page, ReportInput& input);
void add_ledger(const GapPage& page, ReportInput& input);
void add_model(const GapPage& page, ReportInput& input);
void add_retraining(const GapPage& page, ReportInput& input);

}  // namespace airside::tools
