#pragma once
// The workflow every night on a box's logs: a verdict over the last days, and an alarm only where the same name comes
// again and again.

#include <functional>

#include "tools/gap/run/gap_run.hpp"

namespace airside::tools::gap {

struct WatchRules {
  int days = 14;   ///< that each verdict is drawn from
  int nights = 1;  ///< judged, the last ones of the log
  int stands = 3;  ///< nights in a row with the same name, which make an alarm
};

/// A verdict of one night.
struct Night {
  CivilTime end;         ///< the midnight at which its days end
  std::string verdict;   ///< as VerdictKind, or "refused"
  std::string effect;    ///< id of what was found first, "" for nothing
  std::string sentence;  ///< for people
  bool alarm = false;
};

/// Sets `alarm` in every night that ends `stands` successive nights which are named the same; in order of time.
void set_alarms(std::vector<Night>& nights, int stands);

/// Judges the last nights of a log against the reference and the model of an earlier report; a night whose days cannot
/// be used is refused with its reason.  `done`: called after each.
/// Errors: hal::InputError of the log as a whole, and where no night has enough days.
/// Cost: half of run_gap() a night.
std::vector<Night> judge_nights(const GapRequest& request, const std::string& logs,
                                const std::vector<sim::Effect>& effects, const WatchRules& rules,
                                const std::function<void()>& done = {});

nlohmann::json json_of(const Night& night);
/// Errors: hal::InputError for what is none.
Night night_from(const nlohmann::json& j, const std::string& place);

}  // namespace airside::tools::gap
