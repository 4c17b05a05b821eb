#include "tools/gap/report/gap_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tools/gap/model/stretches.hpp"
#include "tools/gap/report/gap_page.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/run/run_facts.hpp"

namespace airside::tools {

namespace {

/// A row that says nothing is left out.
bool ever_measured(const Eigen::MatrixXd& residual, int channel) {
  return std::any_of(residual.col(channel).begin(), residual.col(channel).end(),
                     [](double x) { return std::isfinite(x); });
}

std::string versions_of(const gap::GapRun& run) {
  return run_facts(run.request.source.engine == "energyplus", "").engine + ", " + program_text();
}

void add_facts(const GapPage& page, ReportInput& input) {
  const auto period = [](const gap::Window& window, const gap::CleanLog& log) -> std::string {
    if (window.measured.rows() == 0) return "none: the twin's parameters are what their priors have";
    const gap::Span span = gap::span_of(window.recording);
    return fmt::format("{}: {} to {}, {}", log.place, date_text(span.from), date_text({span.to.seconds - 1}),
                       days_text(window.measured.rows() / gap::bins_per_day));
  };
  input.command = page.run.request.command;
  input.facts = {{"site", page.run.request.site},
                 {"model", page.run.request.source.engine + " " + page.run.request.source.model},
                 {"weather", page.run.request.source.weather},
                 {"reference", period(page.run.loaded.data.reference, page.run.loaded.logs.reference)},
                 {"measured", period(page.run.loaded.data.test, page.run.loaded.logs.measured)},
                 {"effects tried", std::to_string(page.run.responses.test.candidates.size() / 2)},
                 {"versions", versions_of(page.run)}};
  if (page.run.patched) {
    input.facts.push_back({"model before", gap::model_digest(page.run.patched->before)});
    input.facts.push_back({"model after", gap::model_digest(page.run.patched->after)});
  }
}

}  // namespace

GapPage::GapPage(const gap::GapRun& of)
    : run(of), at(of.channels()), first(std::min<Eigen::Index>(gap::bins_per_day, of.residual_given.rows())) {
  for (int c = 0; c < at.count(); ++c) {
    if (ever_measured(of.residual_given, c)) shown.push_back(c);
  }
  const auto news = [](const Eigen::MatrixXd& of_verdict, const Eigen::MatrixXd& plain) {
    Eigen::MatrixXd all = plain;
    if (of_verdict.rows() != plain.rows() || of_verdict.cols() != plain.cols()) return all;
    for (Eigen::Index c = 0; c < all.cols(); ++c)
      if (of_verdict.col(c).array().isFinite().any()) all.col(c) = of_verdict.col(c);
    return all;
  };
  news_before = news(of.verdict.residual_before, of.residual_before);
  news_after = news(of.verdict.residual_after, of.residual_after);
}

std::string as_sentence(std::string text) {
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

/// "room 1", "FCU room 2", "power 1": what people call a channel.
std::string channel_title(const sim::Channels& at, int c) {
  if (!at.grain.empty() && !at.grain[static_cast<std::size_t>(c)].title.empty())
    return at.grain[static_cast<std::size_t>(c)].title;
  if (c < at.fcu_temp()) return fmt::format("room {}", c + 1);
  if (c < at.mau_temp()) return fmt::format("FCU room {}", c - at.fcu_temp() + 1);
  if (c == at.mau_temp()) return "MAU outlet";
  if (c == at.supply_temp()) return "supply";
  if (c < at.fcu_duty()) return fmt::format("power {}", c - at.power() + 1);
  if (c < at.damper()) return fmt::format("FCU duty {}", c - at.fcu_duty() + 1);
  return fmt::format("damper {}", c - at.damper() + 1);
}

std::string effect_title(const GapPage& page, const std::string& id) {
  for (const gap::Candidate& candidate : page.run.responses.test.candidates) {
    if (candidate.at.id() == id) return candidate.at.text();
  }
  return id == "other" ? "something that no effect is" : id;
}

std::string with_titles(const GapPage& page, const std::string& text) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    shown += effect_title(page, text.substr(at, end - at));
    if (end < text.size()) shown += ' ';
    at = end + 1;
  }
  return shown;
}

std::string channel_unit(const sim::Channels& at, int c) {
  const std::string unit = at.unit(c);
  return unit == "-" || unit.empty() ? "share" : unit;
}

ReportInput make_gap_report(const gap::GapRun& run) {
  const GapPage page(run);
  const gap::Span span = gap::span_of(run.loaded.data.test.recording);
  ReportInput input;
  input.title = verdict_title(page);
  input.subtitle = fmt::format("{}: {} against its log of {} to {}, weather {}, {}", run.request.site,
                               run.loaded.engine->description(), date_text(span.from), date_text({span.to.seconds - 1}),
                               std::filesystem::path(run.request.source.weather).filename().string(), versions_of(run));
  input.headline = verdict_text(page);
  for (const auto add : {add_figures, add_posteriors, add_findings, add_continued, add_suspicions, add_experiments,
                         add_heat, add_clean_up, add_maps, add_curves, add_ranking, add_locked_days, add_guideline,
                         add_ledger, add_model, add_retraining, add_facts}) {
    add(page, input);
  }
  return input;
}

}  // namespace airside::tools
