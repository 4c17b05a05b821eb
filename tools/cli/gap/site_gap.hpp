#pragma once
// The gap workflow on one site, from its options to its folder: what `airside gap run` and Python's airside.gap()
// share.

#include <optional>
#include <string>
#include <vector>

#include "tools/cli/gap/gap.hpp"
#include "tools/cli/gap/gap_output.hpp"
#include "tools/gap/run/gap_run.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

struct SiteGap : GapOptions {
  std::string site_path, map, measured, reference, twin, plant, room, weather, out = "gap-report", apply, keep_run,
                                                                               cache;
  std::vector<std::string> patches, tries;
  std::string measured_room, currency = "EUR";
  double price = 0;
  int reference_days = 0, seeds = 5, pretrain_days = 31, control_days = 7;
  std::optional<int> buildings;
  bool no_reference = false, best_guess = false, findings_only = false, no_duties = false, sun_on_site = false,
       retrain = false;

  /// Errors: hal::InputError for options that do not go together, and of a site file or mapping.
  gap::GapRequest request() const;
  /// Refuses places that cannot be written and, with --retrain, rooms that do not exist, before an hour of simulations
  /// ends there.  Errors: hal::InputError.
  void check_places(const gap::GapRequest& asked) const;
  /// The effects that are searched.  Errors: hal::InputError.
  std::vector<sim::Effect> searched() const;

  struct Finished {
    gap::GapRun run;
    nlohmann::json json;  ///< what --json prints
    RunFacts facts;
  };
  /// Writes report, verdict, patch and ledger; retrains where that was asked for.
  /// Errors: hal::InputError.
  Finished finish(gap::GapRun run) const;
  /// Refuses a verdict that leaves --apply or --retrain without a patched twin.  Errors: hal::InputError.
  void check_patched(const gap::GapRun& run) const;

 private:
  std::string again() const;
  void choose_model(gap::CaseDescription& c, const Site& site) const;
  Site the_site() const;
  gap::RetrainRequest retrain_request() const;
  void check_rooms(const gap::GapRequest& asked) const;
};

}  // namespace airside::tools
