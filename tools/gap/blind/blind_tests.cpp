#include "tools/gap/blind/blind_tests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <span>

#include "hal/log/log_csv.hpp"
#include "hal/text/input_error.hpp"
#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/blind/blind_plan.hpp"
#include "tools/gap/blind/test_commands.hpp"
#include "tools/gap/case/case_format.hpp"
#include "tools/gap/case/case_tests.hpp"
#include "tools/gap/model/parallel.hpp"
#include "tools/run/site.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What the key says of a case, checked.
struct KeyEntry {
  BlindWindow window;
  std::uint64_t seed = 0;
  std::vector<Hidden> hidden;
};

[[noreturn]] void refuse_key(const std::string& place, const std::string& found, const std::string& expected) {
  throw hal::InputError("--key: " + place, found, expected,
                        "give the key that airside gap blind made with these cases");
}

/// "odd_heater@3": outside the library, at zone 3.
Hidden hidden_outside(const std::string& id, double magnitude) {
  const auto mark = id.find('@');
  return {id.substr(0, mark), mark == std::string::npos ? -1 : std::stoi(id.substr(mark + 1)) - 1, magnitude};
}

Hidden hidden_of(const json& one, const BlindSite& site, const std::string& place) {
  const std::string id = one.at("id"), name = id.substr(0, id.find('@'));
  const double magnitude = one.at("magnitude");
  if (std::ranges::find(outside_kinds(), name) != outside_kinds().end()) return hidden_outside(id, magnitude);
  if (const auto kind = site.kinds().find(name); kind != site.kinds().end()) {
    for (const sim::EffectAt& at : kind->second) {
      if (at.id() == id) return {name, at.place, magnitude};
    }
  }
  refuse_key(place, id, "an effect that can be hidden there");
}

/// Tests on one case, from its folder, its verdict and the key.
class CaseTester {
 public:
  CaseTester(const BlindTests& tests, const std::vector<sim::Effect>& effects, const SafetyEnvelope& envelope)
      : tests_(tests), effects_(effects), envelope_(envelope) {
    if (!tests.key.is_object() || !tests.key.contains("cases") || !tests.key.contains("seed"))
      refuse_key("cases", "no \"seed\" and \"cases\"", "an answer key");
    const int total = static_cast<int>(tests.key["cases"].size());
    const std::vector<int> order = in_order_of_name(tests.key["seed"], total);
    for (std::size_t n = 0; n < order.size(); ++n) number_of_[fmt::format("case-{:04}", n + 1)] = order[n];
  }

  /// Errors: as do_blind_tests().
  void require_known(const fs::path& folder) const {
    const std::string name = folder.filename().string();
    if (tests_.key["cases"].contains(name) && number_of_.contains(name)) return;
    refuse_key("cases." + name, "no such case", "every case of " + tests_.folder.string());
  }

  /// Whether the limits let the test be done; its log is written then. Thread-safe.
  bool test(const fs::path& folder, const std::string& name) {
    const CaseDescription c = read_case(folder);
    const hal::TopologyCounts counts = built_in_site(c.topology).counts;
    const sim::Channels channels{counts.vavs, counts.fcus, counts.powers};
    const hal::Log measured = hal::read_log(c.measured_log, counts, {hal::default_log_limits, true});
    const CivilTime start = measured.rows.front().time, end{measured.rows.back().time.seconds + row_s};
    const int days = static_cast<int>((end.seconds - start.seconds + seconds_per_day / 2) / seconds_per_day);
    const BlindSite& site = site_of(c, days);
    const KeyEntry entry = entry_of(folder.filename().string(), site);
    std::vector<CaseTest> done = read_case_tests(folder);
    std::vector<TestDays> planned;
    CivilTime free{start.seconds + days * seconds_per_day};
    for (const CaseTest& one : done) {
      planned.push_back(next_days(named_plan(one.name, channels, effects_), free));
      free = planned.back().to;
    }
    planned.push_back(next_days(named_plan(name, channels, effects_), free));
    const TestDays& last = planned.back();
    const auto commands =
        std::make_shared<const TestCommands>(planned, envelope_, CivilTime{start.seconds + days * seconds_per_day});
    const int lived = static_cast<int>((last.to.seconds - start.seconds) / seconds_per_day);
    const std::vector<hal::LogRow> rows = site.lived_on(entry.hidden, entry.window, entry.seed, lived, commands);
    require_same_room(rows, measured.rows, folder.filename().string());
    const CivilTime from{last.from.seconds - ExperimentRules{}.history_days * seconds_per_day};
    const auto first = std::ranges::find_if(rows, [&](const hal::LogRow& row) { return !(row.time < from); });
    const std::span<const hal::LogRow> logged(first, rows.end());
    if (!was_done(commands_in(logged, channels), last.plan)) return false;
    write(folder, logged, counts, last, std::move(done));
    return true;
  }

 private:
  /// Sites are made once for an engine, a model and a length.
  const BlindSite& site_of(const CaseDescription& c, int days) {
    const std::lock_guard lock(mutex_);
    auto& site = sites_[fmt::format("{}|{}|{}", c.engine, c.model, days)];
    if (site) return *site;
    BlindSetup setup;
    setup.twin = c.model;
    setup.seed = tests_.key["seed"];
    setup.days = days;
    setup.cache = tests_.cache;
    setup.effects = &effects_;
    for (int w = 0; w < blind_windows; ++w) {
      setup.starts.push_back(start_of_window(w));
      setup.weather.push_back(weather_of_window(tests_.folder, w));
    }
    site = c.engine == "energyplus" ? make_energyplus_site(setup) : make_rc_site(setup);
    return *site;
  }

  KeyEntry entry_of(const std::string& name, const BlindSite& site) const {
    const json& j = tests_.key["cases"][name];
    const std::string place = "cases." + name;
    try {
      KeyEntry entry;
      entry.window = {j.at("window"), j.at("feedback")};
      entry.seed = seed_of_case(tests_.key["seed"], number_of_.at(name));
      for (const json& one : j.at("hidden")) entry.hidden.push_back(hidden_of(one, site, place));
      return entry;
    } catch (const json::exception& e) {
      refuse_key(place, e.what(), "what airside gap blind wrote");
    }
  }

  /// Whoever has another key would test another room.
  static void require_same_room(const std::vector<hal::LogRow>& lived, const std::vector<hal::LogRow>& measured,
                                const std::string& name) {
    constexpr double tolerance = 0.0101;
    std::size_t compared = 0, differ = 0;
    for (std::size_t row = 0; row < std::min(lived.size(), measured.size()); ++row) {
      for (std::size_t k = 0; k < lived[row].value.size(); ++k) {
        const double off = std::abs(lived[row].value[k] - measured[row].value[k]);
        if (!std::isfinite(off)) continue;
        ++compared;
        if (off > tolerance) ++differ;
      }
    }
    if (compared > 0 && 100 * differ <= compared) return;
    refuse_key("cases." + name,
               fmt::format("a room of which {} of {} values are not those of the measured log", differ, compared),
               "the room that the case's log is of");
  }

  static sim::Recording commands_in(std::span<const hal::LogRow> rows, const sim::Channels& channels) {
    sim::Recording recording;
    recording.from = rows.front().time;
    for (const hal::LogRow& row : rows) {
      const auto boxes = row.value.begin() + channels.rooms + channels.fcus, coils = boxes + channels.rooms;
      recording.rows.push_back({row.setpoint_degc, {boxes, coils}, {coils, coils + channels.fcus}});
    }
    return recording;
  }

  static void write(const fs::path& folder, std::span<const hal::LogRow> rows, const hal::TopologyCounts& counts,
                    const TestDays& last, std::vector<CaseTest> done) {
    const std::string file = fmt::format("test-{}.csv", done.size() + 1);
    hal::LogWriter writer((folder / file).string(), counts, false);
    for (const hal::LogRow& row : rows) writer.append(row);
    writer.close();
    done.push_back({last.plan.name, file, last.from});
    write_case_tests(folder, done);
    for (const fs::path& path : {folder / file, folder / "tests.json", folder}) forget_time(path);
  }

  const BlindTests& tests_;
  const std::vector<sim::Effect>& effects_;
  SafetyEnvelope envelope_;
  std::map<std::string, int> number_of_;
  std::map<std::string, std::unique_ptr<BlindSite>> sites_;
  std::mutex mutex_;
};

/// Verdicts by the name of their case.
std::map<std::string, json> verdicts_by_case(const json& verdicts) {
  if (!verdicts.is_object() || !verdicts.contains("verdicts") || !verdicts["verdicts"].is_array()) {
    throw hal::InputError("--verdicts", "no list of verdicts", "what airside gap run-cases wrote", "name that file");
  }
  std::map<std::string, json> by_case;
  for (const json& one : verdicts["verdicts"]) by_case[one.value("case", "")] = one;
  return by_case;
}

}  // namespace

WantedTests wanted_tests(const json& verdict, int done, int most_tests) {
  const json judged = verdict.value("after_tests", json::array());
  const json& last = judged.empty() ? verdict : judged.back();
  const std::string kind = last.value("verdict", "");
  std::vector<std::string> did;
  if (!judged.empty()) did = last.value("tests", did);
  if (done > std::ssize(did)) return {{}, "tested, to be judged"};
  if (kind != "ambiguous" && kind != "unknown") return {{}, kind};
  if (done >= most_tests) return {{}, "tested"};
  if (!last.contains("experiments")) {
    if (kind == "unknown") return {{}, kind};
    throw hal::InputError("--verdicts: " + verdict.value("case", ""), "no \"experiments\"",
                          "the tests that the verdict proposes", "judge with airside gap run-cases --propose");
  }
  WantedTests wanted;
  for (const json& one : last["experiments"]) {
    const std::string name = one.at("name");
    const bool again = std::ranges::find(did, name) != did.end();
    const bool helps = one.at("comfortable").get<bool>() && one.at("power").get<double>() >= least_power_of_test;
    if (helps && !again) wanted.names.push_back(name);
  }
  if (wanted.names.empty()) wanted.why_not = last["experiments"].empty() ? "nothing proposed" : "no test helps";
  return wanted;
}

std::vector<TestedCase> do_blind_tests(const BlindTests& tests, const std::vector<sim::Effect>& effects,
                                       const SafetyEnvelope& envelope, const std::function<void()>& done) {
  const std::vector<fs::path> folders = case_folders(tests.folder);
  const std::map<std::string, json> verdicts = verdicts_by_case(tests.verdicts);
  CaseTester tester(tests, effects, envelope);
  std::vector<WantedTests> wanted;
  for (const fs::path& folder : folders) {
    const std::string name = folder.filename().string();
    const auto verdict = verdicts.find(name);
    if (verdict == verdicts.end()) {
      throw hal::InputError("--verdicts: " + name, "no verdict on it", "a verdict on every case",
                            "judge it first: airside gap run-cases --propose --continue");
    }
    tester.require_known(folder);
    const int did = static_cast<int>(read_case_tests(folder).size());
    wanted.push_back(wanted_tests(verdict->second, did, tests.most_tests));
  }
  std::vector<TestedCase> cases(folders.size());
  in_parallel(folders.size(), tests.jobs, [&](std::size_t i) {
    cases[i] = {folders[i].filename().string(), "", wanted[i].why_not};
    for (const std::string& test : wanted[i].names) {
      if (tester.test(folders[i], test)) cases[i].test = test;
      if (!cases[i].test.empty()) break;
    }
    if (cases[i].test.empty() && cases[i].why_not.empty()) cases[i].why_not = "beyond the site's limits";
    if (done) done();
  });
  return cases;
}

}  // namespace airside::tools::gap
