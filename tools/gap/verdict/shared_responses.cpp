#include "tools/gap/verdict/shared_responses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <stdexcept>

#include "hal/storage/digest64.hpp"
#include "tools/gap/inference/structure_ensemble.hpp"

namespace airside::tools::gap {

namespace {

std::uint64_t digest_of(const sim::Recording& recording, bool weather) {
  std::vector<double> all{static_cast<double>(recording.from.seconds), static_cast<double>(recording.rows.size())};
  for (const sim::RecordedRow& row : recording.rows) {
    all.push_back(row.setpoint_degc);
    all.insert(all.end(), row.vav_on.begin(), row.vav_on.end());
    all.insert(all.end(), row.fcu_on.begin(), row.fcu_on.end());
    if (weather) {
      all.push_back(row.outdoor_temp_degc);
      all.push_back(row.rain);
      all.insert(all.end(), row.zone_heat_kw.begin(), row.zone_heat_kw.end());
    }
  }
  return hal::digest64(std::as_bytes(std::span(all)));
}

double difference_of(const sim::Recording& a, const sim::Recording& b) {
  if (a.rows.size() != b.rows.size() || a.from != b.from) return std::numeric_limits<double>::infinity();
  const auto switched = [](const std::vector<double>& x, const std::vector<double>& y) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += std::abs(x[i] - y[i]);
    return sum;
  };
  double sum = 0;
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    const sim::RecordedRow &x = a.rows[i], &y = b.rows[i];
    sum += std::abs(x.setpoint_degc - y.setpoint_degc) + switched(x.vav_on, y.vav_on) + switched(x.fcu_on, y.fcu_on);
  }
  return sum;
}

/// Likely places by a ranking, none twice.
std::vector<std::string> shortlist(const Verdict& screen, const Responses& responses) {
  std::vector<std::string> places;
  for (const Score& score : screen.ranking) {
    if (std::ssize(places) == shortlist_places || !(score.log_likelihood_ratio > 0)) break;
    places.push_back(responses.candidates[score.candidate].at.id());
  }
  return places;
}

}  // namespace

std::uint64_t command_digest(const sim::Recording& recording) { return digest_of(recording, false); }
std::uint64_t recording_digest(const sim::Recording& recording) { return digest_of(recording, true); }

std::size_t most_usual(const std::vector<const CaseData*>& cases) {
  if (cases.empty()) throw std::invalid_argument("no case to choose from");
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    double sum = 0;
    for (const CaseData* other : cases) {
      // Windows of another length are no measure of how usual this one is.
      const double both = difference_of(cases[i]->reference.recording, other->reference.recording) +
                          difference_of(cases[i]->test.recording, other->test.recording);
      sum += std::min(both, 1e6);
    }
    if (sum < least) {
      least = sum;
      best = i;
    }
  }
  return best;
}

SharedResponses::SharedResponses(const Engine& engine, Library library, const sim::Recording& recording, int jobs,
                                 const std::function<void()>& done)
    : library_(std::move(library)),
      responses_(simulate_responses(engine, library_, recording, true, jobs, done)),
      commands_(command_digest(recording)),
      all_(recording_digest(recording)) {}

void SharedResponses::draw_buildings(const Engine& engine, const sim::Recording& recording, int buildings, int jobs,
                                     const std::function<void()>& done) {
  if (buildings > 0)
    responses_.buildings = drawn_buildings(engine, {}, responses_.base, recording, buildings, jobs, done);
}

SharedResponses::Borrowed SharedResponses::borrowed(const Engine& engine, const sim::Recording& recording) const {
  Borrowed out{responses_, command_digest(recording) == commands_};
  if (recording_digest(recording) == all_) return out;
  const sim::ChannelTable base = engine.simulate({}, recording);
  if (binned(base, engine.channels()).rows() != responses_.base.rows())
    throw std::invalid_argument("responses of a window as long");
  out.responses.base = binned(base, engine.channels());
  for (Parameter& p : out.responses.parameters) {
    if (engine.only_shows(*p.at.effect))
      p.response = shown_response(engine, base, {p.at, p.at.effect->null_value + p.prior_sd});
  }
  for (Candidate& c : out.responses.candidates) {
    if (engine.only_shows(*c.at.effect)) c.response = shown_response(engine, base, {c.at, c.probe});
  }
  return out;
}

void SharedResponses::again(const Engine& engine, const sim::Recording& recording,
                            const std::vector<std::string>& places, Responses& responses, int jobs) const {
  std::vector<std::size_t> chosen;
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < responses.candidates.size(); ++i) {
    const Candidate& c = responses.candidates[i];
    if (engine.only_shows(*c.at.effect) || std::find(places.begin(), places.end(), c.at.id()) == places.end()) continue;
    chosen.push_back(i);
    tasks.push_back({{{c.at, c.probe}}, &recording});
  }
  const auto tables = simulate_all(engine, tasks, jobs);
  for (std::size_t k = 0; k < chosen.size(); ++k)
    responses.candidates[chosen[k]].response = binned(tables[k], engine.channels()) - responses.base;
  for (Parameter& p : responses.parameters) {
    if (std::find(places.begin(), places.end(), p.at.id()) == places.end() || !engine.spares_runs()) continue;
    const Eigen::MatrixXd between = response_between_probes(library_, p.at, responses.candidates, engine.channels());
    if (between.size() > 0) p.response = between;
  }
}

WindowResponses SharedWindows::of(const Engine& engine, const CaseData& data, const Rules& rules, int jobs) const {
  auto reference = reference_.borrowed(engine, data.reference.recording);
  auto test = test_.borrowed(engine, data.test.recording);
  WindowResponses out{std::move(reference.responses), std::move(test.responses)};
  if (reference.own_commands && test.own_commands) return out;
  // A ranking is all that is asked of this analysis: nothing can be found.
  Rules ranking_only = rules;
  ranking_only.log_likelihood_limit = std::numeric_limits<double>::max();
  ranking_only.most_effects = ranking_only.rivals = 0;
  const auto places = shortlist(analyse(engine, data, out, ranking_only), out.test);
  if (!reference.own_commands) reference_.again(engine, data.reference.recording, places, out.reference, jobs);
  if (!test.own_commands) test_.again(engine, data.test.recording, places, out.test, jobs);
  return out;
}

}  // namespace airside::tools::gap
