// The top of a gap report: the verdict in words that need no table.

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tools/gap/report/gap_page.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools {

namespace {

constexpr double unknown_probability = std::numeric_limits<double>::quiet_NaN();

std::string capitalised(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string percent_text(double probability) { return number_text(100 * probability, 0) + " %"; }

/// "power of the supply fan (13 %), nothing (5 %)": members of the set but `itself`.
std::string others_text(const gap::Posterior& posterior, const std::string& itself) {
  std::vector<std::string> parts;
  for (const std::string& id : posterior.set) {
    if (id == itself) continue;
    if (id == "nothing" || id == "other") {
      const bool nothing = id == "nothing";
      parts.push_back(fmt::format("{} ({})", nothing ? "nothing at all" : "something that no effect is",
                                  percent_text(nothing ? posterior.nothing : posterior.other)));
      continue;
    }
    for (const gap::EffectProbability& e : posterior.effects)
      if (e.at.id() == id) parts.push_back(fmt::format("{} ({})", e.at.text(), percent_text(e.probability)));
  }
  return fmt::to_string(fmt::join(parts, ", "));
}

/// Size and probability, with its name where the title has not said it.
std::string finding_text(const GapPage& page, const gap::Finding& f) {
  const double probability = probability_of(page, f);
  const bool in_title = f.at.id() == page.run.verdict.findings.front().at.id();
  std::string text =
      in_title ? capitalised(gap::magnitude_text(f)) : capitalised(f.at.text()) + ": " + gap::magnitude_text(f);
  if (std::isfinite(probability)) text += ", with a probability of " + percent_text(probability);
  return text + ".";
}

std::string cost_text(const GapPage& page, std::size_t finding) {
  if (finding >= page.run.energy.size()) return "";
  const std::string energy = gap::sentence_of(page.run.energy[finding], page.run.request.price);
  return energy.empty() ? "" : " " + as_sentence(capitalised(energy));
}

void add_named(const GapPage& page, std::string& text) {
  const gap::Verdict& v = page.run.verdict;
  for (std::size_t i = 0; i < v.findings.size(); ++i) {
    text += (i == 0 ? "" : " ") + finding_text(page, v.findings[i]) + cost_text(page, i) +
            " To confirm it on site: " + as_sentence(v.findings[i].at.effect->confirm);
  }
  for (const gap::Finding& f : v.unsure) text += " Not sure beside it: " + finding_text(page, f);
}

void add_ambiguous(const GapPage& page, std::string& text) {
  const gap::Verdict& v = page.run.verdict;
  const gap::Finding& f = v.findings.front();
  text += finding_text(page, f);
  const std::string others = v.posteriors.empty() ? "" : others_text(v.posteriors.front(), f.at.id());
  if (!others.empty()) text += " These days cannot tell it from " + others + ".";
  if (!f.why_not.empty() && !f.why_not.starts_with("not sure")) text += " " + as_sentence(capitalised(f.why_not));
}

void add_none(const GapPage& page, std::string& text) {
  const gap::Verdict& v = page.run.verdict;
  text += "The log and the model differ by no more than noise and the model's own errors do.";
  const std::string others = v.posteriors.empty() ? "" : others_text(v.posteriors.front(), "nothing");
  if (!others.empty()) text += " Not excluded: " + others + ".";
}

}  // namespace

double probability_of(const GapPage& page, const gap::Finding& finding) {
  for (const gap::Posterior& p : page.run.verdict.posteriors) {
    if (p.effects.empty() || p.effects.front().at.id() != finding.at.id()) continue;
    return p.effects.front().probability;
  }
  return unknown_probability;
}

std::string verdict_title(const GapPage& page) {
  const gap::Verdict& v = page.run.verdict;
  switch (v.kind) {
    case gap::VerdictKind::named: {
      const std::size_t more = v.findings.size() - 1;
      return capitalised(v.findings.front().at.text()) + (more > 0 ? fmt::format(", and {} more", more) : "");
    }
    case gap::VerdictKind::ambiguous: return "Perhaps: " + v.findings.front().at.text();
    case gap::VerdictKind::unknown: return "Something is missing that no effect explains";
    case gap::VerdictKind::none: return "Nothing is missing that noise would not explain";
  }
  return "";
}

std::string verdict_text(const GapPage& page) {
  const gap::GapRun& run = page.run;
  std::string text;
  const auto add = [&text](const std::string& sentence) {
    if (!sentence.empty()) text += " " + as_sentence(capitalised(sentence));
  };
  switch (run.verdict.kind) {
    case gap::VerdictKind::named: add_named(page, text); break;
    case gap::VerdictKind::ambiguous: add_ambiguous(page, text); break;
    case gap::VerdictKind::unknown: text += as_sentence(capitalised(run.verdict.reason)); break;
    case gap::VerdictKind::none: add_none(page, text); break;
  }
  add(gap::other_weather_text(run));
  add(gap::no_reference_text(run));
  if (!run.experiments.empty()) add(gap::sentence_of(run.experiments));
  if (run.heat) add(run.heat->text);
  add(gap::text_of(run.meter_offsets));
  add(gap::continued_text(run));
  return text;
}

void add_verdict_figure(const GapPage& page, ReportInput& input) {
  const gap::Verdict& v = page.run.verdict;
  if (v.posteriors.empty()) {
    input.figures.push_back({gap::text_of(v.kind), "", "verdict", ""});
    return;
  }
  const gap::Posterior& first = v.posteriors.front();
  double probability = first.nothing;
  const char* of = "probability that nothing is missing";
  if (v.kind == gap::VerdictKind::unknown) {
    probability = first.other;
    of = "probability of something that no effect is";
  } else if (page.found()) {
    probability = probability_of(page, v.findings.front());
    of = "probability of the first explanation";
  }
  input.figures.push_back({number_text(100 * probability, 0), "%", of,
                           fmt::format("verdict: {}; a name needs {} of what is not something else",
                                       gap::text_of(v.kind), percent_text(first.name_needs))});
}

}  // namespace airside::tools
