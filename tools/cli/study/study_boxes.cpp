// airside study boxes: the objective "band" on rooms whose boxes modulate, beside constants and Guideline 36.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/system/version.hpp"
#include "sim/rc/modulating_room.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/metrics.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/study/box_run.hpp"

namespace airside::tools {

namespace {

struct BoxesCommand {
  std::vector<std::string> scenarios;
  std::vector<std::string> starts = {"2021-01-08", "2021-04-08", "2021-07-08", "2021-10-08"};
  int seeds = 3, days = 14;
  bool json = false;

  struct Line {
    std::string name;
    std::vector<BoxFigures> runs;
    Spread spread(double (*figure)(const BoxFigures&)) const {
      std::vector<double> values;
      for (const BoxFigures& f : runs) values.push_back(figure(f));
      return spread_of(values);
    }
  };

  static std::vector<double> constants() {
    std::vector<double> all;
    for (int i = 0; i <= 12; ++i) all.push_back(12 + 0.5 * i);
    return all;
  }

  static CivilTime midnight_of(const std::string& date) {
    PlantChoice choice;
    choice.start = date;
    return start_of(choice);
  }

  std::vector<Line> compare(const std::string& scenario, const std::string& start) const {
    std::vector<Line> lines{{"constant of other days", {}},
                            {"best constant in hindsight", {}},
                            {"guideline-36, 16", {}},
                            {"guideline-36, 18", {}},
                            {"band", {}}};
    for (int seed = 1; seed <= seeds; ++seed) {
      BoxRun run{
          .scenario = scenario, .seed = static_cast<std::uint64_t>(seed), .from = midnight_of(start), .days = days};
      BoxRun other = run;
      other.from.seconds -= 28 * seconds_per_day;
      std::vector<BoxFigures> here, there;
      for (const double degc : constants()) {
        const BoxMethod constant{.degc = degc};
        here.push_back(run_boxes(run, constant));
        there.push_back(run_boxes(other, constant));
      }
      lines[0].runs.push_back(here[best_constant(there)]);
      lines[1].runs.push_back(here[best_constant(here)]);
      lines[2].runs.push_back(run_boxes(run, {.kind = BoxMethod::Kind::guideline36, .degc = 16}));
      lines[3].runs.push_back(run_boxes(run, {.kind = BoxMethod::Kind::guideline36, .degc = 18}));
      lines[4].runs.push_back(run_boxes(run, {.kind = BoxMethod::Kind::band}));
    }
    return lines;
  }

  static nlohmann::json json_of(const Line& line) {
    nlohmann::json runs = nlohmann::json::array();
    for (const BoxFigures& f : line.runs) {
      runs.push_back({{"fan_kwh", f.fan_kwh},
                      {"cooling_kwh", f.cooling_kwh},
                      {"heat_kwh", f.heat_kwh},
                      {"above_degch", f.above_degch},
                      {"below_degch", f.below_degch},
                      {"saturated_h", f.saturated_h},
                      {"setpoint_degc", f.setpoint_degc},
                      {"darv_degc", f.darv_degc}});
    }
    return {{"method", line.name}, {"runs", runs}};
  }

  static void print(const Line& line) {
    const Spread total = line.spread([](const BoxFigures& f) { return f.total_kwh(); });
    const Spread above = line.spread([](const BoxFigures& f) { return f.above_degch; });
    const auto mean = [&](double (*figure)(const BoxFigures&)) { return line.spread(figure).mean; };
    fmt::print(
        "  {:<27} {:7.2f} +- {:5.2f}  {:6.2f} {:6.2f} {:6.2f}   {:5.2f} +- {:4.2f}  {:5.2f}  {:5.1f}  {:5.2f}  "
        "{:4.2f}\n",
        line.name, total.mean, total.sd, mean([](const BoxFigures& f) { return f.fan_kwh; }),
        mean([](const BoxFigures& f) { return f.cooling_kwh; }), mean([](const BoxFigures& f) { return f.heat_kwh; }),
        above.mean, above.sd, mean([](const BoxFigures& f) { return f.below_degch; }),
        mean([](const BoxFigures& f) { return f.saturated_h; }),
        mean([](const BoxFigures& f) { return f.setpoint_degc; }),
        mean([](const BoxFigures& f) { return f.darv_degc; }));
  }

  void run() {
    if (scenarios.empty()) {
      for (const std::string_view name : sim::modulating_scenarios()) scenarios.emplace_back(name);
    }
    for (const std::string& name : scenarios) (void)sim::modulating_room(name, 1);
    nlohmann::json all = nlohmann::json::array();
    if (!json) {
      fmt::print(
          "kWh a day; zone degree-hours a day above setpoint + 0.5 K and below heating setpoint - 0.5 K; "
          "zone-hours a day with an open damper; {} seeds, {} days\n",
          seeds, days);
      fmt::print("  {:<27} {:>16}  {:>6} {:>6} {:>6}   {:>13}  {:>5}  {:>5}  {:>5}  {:>4}\n", "method", "all", "fan",
                 "cool", "heat", "above", "below", "open", "setp", "DARV");
    }
    for (const std::string& scenario : scenarios) {
      for (const std::string& start : starts) {
        const std::vector<Line> lines = compare(scenario, start);
        nlohmann::json methods = nlohmann::json::array();
        if (!json) fmt::print("{}, from {}\n", scenario, start);
        for (const Line& line : lines) {
          if (json)
            methods.push_back(json_of(line));
          else
            print(line);
        }
        if (json) all.push_back({{"scenario", scenario}, {"start", start}, {"methods", methods}});
      }
    }
    if (json)
      fmt::print("{}\n",
                 nlohmann::json{{"seeds", seeds}, {"days", days}, {"commit", hal::commit()}, {"tables", all}}.dump());
  }
};

}  // namespace

void add_study_boxes(CLI::App& study) {
  auto self = std::make_shared<BoxesCommand>();
  CLI::App* c = study.add_subcommand(
      "boxes",
      "rooms whose boxes modulate: the objective \"band\" beside constants and Guideline 36, energy and comfort.\n"
      "Constants are chosen on the days that begin four weeks earlier, and in hindsight.");
  c->add_option("--scenarios", self->scenarios, "humid, mild, reheat, duct, comma-separated (default: all)")
      ->delimiter(',');
  c->add_option("--starts", self->starts, "first scored days, comma-separated")->delimiter(',')->capture_default_str();
  c->add_option("--seeds", self->seeds, "buildings a scenario, each with its own year")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  c->add_option("--days", self->days, "days that are scored")->check(CLI::Range(1, 300))->capture_default_str();
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
