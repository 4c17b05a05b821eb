#pragma once
// What each effect and each uncertain parameter would do to the sensors in one window: differences of simulations.

#include <memory>
#include <string>
#include <vector>

#include "tools/gap/model/engine.hpp"
#include "tools/gap/model/residual.hpp"

namespace airside::tools::gap {

/// A stretch of a log, ready for the model.
struct Window {
  sim::Recording recording;
  Eigen::MatrixXd measured;  ///< bins x channels; NaN: missing
};

/// A window as evidence: without supply temperatures of bins in which the coil could not reach its setpoint, by more
/// than 0.3 K for longer than one bin. There it shows every error of the load, a hundred times as large as the noise of
/// a supply that follows; rooms and power tell the same in their own measure.
Window evidence_of(Window window, const sim::Channels& channels);

/// One direction in which a candidate may move, seen from its null: a candidate has two.
struct Candidate {
  sim::EffectAt at;
  double probe = 0;          ///< magnitude at which it was simulated
  Eigen::MatrixXd response;  ///< bins x channels; of the step from null to probe
};

struct Parameter {
  sim::EffectAt at;
  double prior_sd = 0;
  Eigen::MatrixXd response;  ///< bins x channels; of one prior standard deviation
};

/// The lists are the same in every window of one engine.
struct Responses {
  Eigen::MatrixXd base;  ///< bins x channels; the model as it is
  std::vector<Parameter> parameters;
  std::vector<Candidate> candidates;  ///< empty where only parameters were asked for
  /// What buildings that differ show, less `base`; empty: none were drawn about the model as it is.
  std::vector<Eigen::MatrixXd> buildings = {};
};

/// Both periods of a case.
struct CaseData {
  Window reference, test;  ///< no rows: there is no reference period
  bool has_reference() const { return reference.measured.rows() > 0; }
};

/// Responses of the two windows; shared by cases that have the same weather and hours.
struct WindowResponses {
  Responses reference, test;
};

/// An effect that a model cannot have, and why not.
struct NotApplicable {
  std::string id;
  std::string title;  ///< in words, for people
  std::string why;
};

/// Everything that an engine can be asked about.
struct Library {
  std::vector<sim::EffectAt> parameters, candidates;
  std::vector<NotApplicable> not_applicable = {};
};
Library library_of(const Engine& engine, const std::vector<sim::Effect>& effects);

/// How many responses simulate_responses() makes, the model's own run included; done() is called so often.
std::size_t runs_of(const Library& library, bool with_candidates);

/// How many runs simulate_responses() makes of all effects, those that bent probes may ask for left out.
std::size_t simulated_runs(const Engine& engine, const Library& library);

/// What sensors show of a change that Engine::only_shows(): `base` is the run of the model as it is.
/// Shape: bins x channels.
Eigen::MatrixXd shown_response(const Engine& engine, const sim::ChannelTable& base, const sim::EffectChange& change);

/// The response to one prior standard deviation of a parameter whose effect's probes are simulated and enclose it: the
/// parabola's through null and both. Empty where there are none, or these are no line.
/// `candidates`: two a place of the library, in its order.
Eigen::MatrixXd response_between_probes(const Library& library, const sim::EffectAt& at,
                                        const std::vector<Candidate>& candidates, const sim::Channels& channels);

/// Effects that only_shows() cost no run. An engine that spares runs simulates no parameter whose effect's probes are
/// simulated anyway and enclose its standard deviation: its response is the parabola's through null and both probes.
/// Cost: runs_of() simulations on `jobs` threads, at most.
Responses simulate_responses(const Engine& engine, const Library& library, const sim::Recording& recording,
                             bool with_candidates, int jobs, const std::function<void()>& done = {});

}  // namespace airside::tools::gap
