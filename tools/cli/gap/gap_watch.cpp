// airside gap watch: a verdict every night over a box's logs.

#include <fmt/format.h>

#include <map>

#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/gap/gap.hpp"
#include "tools/gap/run/gap_inputs.hpp"
#include "tools/gap/run/watch.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct WatchCommand : GapOptions {
  std::string logs, report, out = "gap-watch.json", cache;
  gap::WatchRules rules;

  using Nights = std::map<std::int64_t, gap::Night>;

  /// That earlier runs judged.
  Nights earlier() const {
    Nights nights;
    if (!fs::exists(out)) return nights;
    const nlohmann::json j = sim::read_json(out);
    if (!j.is_object() || !j.contains("nights") || !j["nights"].is_array()) {
      throw hal::InputError(out, "no list of nights", "what airside gap watch wrote", "name another --out");
    }
    for (const nlohmann::json& one : j["nights"]) {
      const gap::Night night = gap::night_from(one, out);
      nights[night.end.seconds] = night;
    }
    return nights;
  }

  /// Those that are judged again replace the earlier ones.
  std::vector<gap::Night> all_of(Nights nights, const std::vector<gap::Night>& judged) const {
    for (const gap::Night& night : judged) nights[night.end.seconds] = night;
    std::vector<gap::Night> all;
    for (const auto& [end, night] : nights) all.push_back(night);
    gap::set_alarms(all, rules.stands);
    return all;
  }

  void run() const {
    require_writable("--out", out, false);
    Nights before = earlier();
    gap::GapRequest request = gap::earlier_request(report);
    request.jobs = jobs;
    request.cache = cache.empty() ? fs::path(report) / "runs" : fs::path(cache);
    std::vector<sim::Effect> list = sim::load_effects(request.effects);
    if (request.sun_on_site) list = sim::with_sun_on_site(std::move(list));
    Progress bar(fmt::format("{} nights", rules.nights), static_cast<std::uint64_t>(rules.nights));
    const auto judged = gap::judge_nights(request, logs, list, rules, [&bar] { bar.advance(); });
    bar.finish();
    const std::vector<gap::Night> nights = all_of(std::move(before), judged);
    nlohmann::json j{{"format", 1}, {"report", report}, {"days", rules.days}, {"stands", rules.stands}};
    j["nights"] = nlohmann::json::array();
    int alarms = 0;
    for (std::size_t i = 0; i < nights.size(); ++i) {
      j["nights"].push_back(gap::json_of(nights[i]));
      if (nights[i].alarm && (i == 0 || !nights[i - 1].alarm)) ++alarms;
    }
    j["alarm"] = nights.back().alarm;
    j["alarms"] = alarms;
    gap::write_whole_file(out, j.dump(1) + "\n");
    if (json) {
      fmt::print("{}\n", j.dump());
      return;
    }
    for (const auto& night : j["nights"]) {
      fmt::print("{} {:<9} {}{}\n", night["end"].get<std::string>().substr(0, 10), night["verdict"].get<std::string>(),
                 night["alarm"].get<bool>() ? "ALARM: " : "", night["sentence"].get<std::string>());
    }
    fmt::print("{} nights, {} alarm{}; {}\n", nights.size(), alarms, alarms == 1 ? "" : "s",
               nights.back().alarm ? "the last one stands" : "no alarm tonight");
  }
};

}  // namespace

void add_gap_watch(CLI::App& gap) {
  auto self = std::make_shared<WatchCommand>();
  CLI::App* c = gap.add_subcommand(
      "watch", "judge the last days of a box's logs, every night; an alarm where the same name stands for nights");
  c->add_option("logs", self->logs, "folder of daily logs, or one log")->required();
  c->add_option("--report", self->report, "report of airside gap, whose model, weather and reference are used")
      ->required();
  c->add_option("--days", self->rules.days, "each verdict is drawn from")
      ->check(CLI::Range(4, 60))
      ->capture_default_str();
  c->add_option("--nights", self->rules.nights, "how many of the last nights are judged")
      ->check(CLI::Range(1, 366))
      ->capture_default_str();
  c->add_option("--stands", self->rules.stands, "nights in a row with the same name that make an alarm")
      ->check(CLI::Range(1, 30))
      ->capture_default_str();
  c->add_option("-o,--out", self->out, "file that keeps all nights from run to run")->capture_default_str();
  c->add_option("--cache", self->cache, "folder of finished EnergyPlus runs (default: REPORT/runs)");
  self->add_jobs(*c);
  self->add_json(*c);
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
