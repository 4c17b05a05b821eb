#pragma once
// The report of a control run: what the AHU's rooms did under each method, in the same order every time.

#include <optional>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "tools/report/charts/report_input.hpp"
#include "tools/report/zone_band.hpp"
#include "tools/run/metrics.hpp"

namespace airside::tools {

/// One line of a chart, without its x.
struct NamedValues {
  std::string name;
  std::vector<double> values;
};

/// One method under the same plant, weather, days and seeds as all others.
struct MethodResult {
  enum class Kind {
    ours,      ///< the one the report is about; exactly one
    peer,      ///< competes
    schedule,  ///< the expert's schedule: competes, and is what savings are measured against
    floor,     ///< knows more than a controller can; set apart in tables, left out of the bars
  };
  std::string name;
  Kind kind = Kind::peer;
  std::vector<Metrics> runs;  ///< one a seed, the charted run first
};

/// Everything make_run_report() needs. Optional parts may stay empty; their chart is left out.
struct RunRecord {
  // What was run
  std::string site, plant, weather, seeds, versions, weights_digest, command;
  MetricsSettings metrics;
  std::vector<std::string> room_names;
  std::vector<ReportFact> more_facts;

  // Ours, a value a logged row
  std::vector<CivilTime> row_time;
  std::vector<NamedValues> room_temp_degc;  ///< one a room
  std::vector<double> room_mean_degc;
  std::vector<double> outdoor_degc;
  std::vector<NamedValues> power_kw;
  std::vector<NamedValues> boxes_on;  ///< 1 on, 0 closed; none where the site does not see them, or none ever closed
  std::vector<std::string> mode, reason, fault;  ///< of the controller; empty without its columns
  std::vector<std::string> signal;               ///< that the fault is about, where it can be named

  // Ours, a value a control cycle
  std::vector<CivilTime> cycle_time;
  std::vector<double> setpoint_degc;  ///< applied
  std::vector<double> expert_setpoint_degc;
  std::vector<double> network_setpoint_degc;  ///< proposed by the network alone
  std::vector<double> head_setpoint_degc;     ///< proposed by the room head alone
  std::vector<double> confidence;             ///< 0..1
  std::vector<NamedValues> losses;

  std::optional<ZoneBand> band;  ///< where the objective is "band": judged by zones, not by the rooms' mean
  bool all_electric = true;      ///< false: some meter is of gas or of district energy

  std::vector<MethodResult> methods;
};

/// Header, headline, charts and tables of a run.
/// Errors: hal::InputError when there is not exactly one method of kind ours, or a method without a run.
ReportInput make_run_report(const RunRecord& record);

/// The working hours between two instants, for shading. x in seconds of civil time.
std::vector<ChartBand> working_hours(CivilTime from, CivilTime to, const MetricsSettings& settings);

/// The table of DAE, ME, DARV, CDH, HDH, energy, degree-hours and day 1: mean and spread over each method's runs.
/// `energy` heads the column of the meters' sum.
ReportTable methods_table(const std::vector<MethodResult>& methods, const char* energy = "electricity");

}  // namespace airside::tools
