#pragma once
// One simulated run from its options to figures and files: what `airside simulate` and Python's airside.simulate()
// share.

#include <functional>
#include <string>
#include <vector>

#include "tools/cli/command.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {

/// What a method left behind, and the schedule's days before it.
struct SimulatedRun {
  ControlRun control;
  Metrics metrics;
  std::vector<hal::LogRow> history;
  std::string plant;  ///< its description
};

struct Simulation {
  SiteOptions site;
  PlantChoice plant;
  int expert_days = 5, days = 14, steps = 3000;
  std::string method = "ours", weights, history, log, history_log, faults;
  bool transfer = false;
  bool steps_given = false;  ///< not the default

  /// All that is read and checked before anything is computed.
  struct Ready {
    Trial trial;
    RunFacts facts;
    BlobBytes blob;
    std::vector<hal::LogRow> history;  ///< of `history`; empty: none was given
  };
  /// `chosen`: the site, which may have given `plant` its twin. `compare`: further methods that will run.
  /// Errors: hal::InputError.
  Ready make_ready(const Site& chosen, const std::vector<std::string>& compare = {}) const;

  /// Errors: as prepare() and run_method().
  SimulatedRun run(const Ready& ready, const std::string& name, const OnProgress& progress) const;

  /// run() of `method`, its logs written. The place of each is tried before the run that is to fill it; a log of
  /// made-up weather has that beside it as NAME.epw.
  struct Recorded {
    SimulatedRun run;
    std::string weather;  ///< file that was written; "": none
  };
  /// `begin` is called when all places have been tried; it gives what run() shows its progress with.
  Recorded run_recorded(const Ready& ready, const std::function<OnProgress()>& begin) const;

  /// First and last controlled day, as 2021-08-06.
  struct Days {
    std::string from, to;
  };
  /// Errors: hal::InputError for a start that is no date.
  Days controlled_days() const;

  /// What --json prints of it.
  nlohmann::json json_of(const Ready& ready, const SimulatedRun& run) const;

 private:
  void check_start(Objective objective, bool engine) const;
  void check_places(const Site& s) const;
  std::vector<hal::LogRow> read_typed(const Site& s, bool engine) const;
  void refuse_repeated(const std::vector<std::string>& compare) const;
  void refuse_unheeded(const std::vector<std::string>& compare, bool engine) const;
  std::string weather_to_write(const Site& s) const;
};

}  // namespace airside::tools
