#include "tools/cli/gap/gap_fit.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <thread>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/epw.hpp"
#include "tools/cli/command.hpp"
#include "tools/gap/clean_up/clean_up.hpp"
#include "tools/gap/fit/fit_room.hpp"
#include "tools/gap/model/log_window.hpp"

namespace airside::tools {

namespace {

struct FitCommand {
  SiteOptions site;
  std::string measured, weather, start_room, out = "room.json";
  int locked_days = -1;
  int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  bool json = false;

  sim::RcRoom start(const Site& s) const {
    if (start_room.empty()) return sim::make_room(s.counts.vavs, s.counts.fcus, s.counts.powers);
    sim::RcRoom room = sim::load_room(start_room);
    if (room.vavs != s.counts.vavs || room.fcus != s.counts.fcus || room.powers != s.counts.powers) {
      throw hal::InputError("--start-room " + start_room,
                            fmt::format("{} VAVs, {} FCUs, {} powers", room.vavs, room.fcus, room.powers),
                            fmt::format("{}, {} and {}, as topology {} of the site", s.counts.vavs, s.counts.fcus,
                                        s.counts.powers, s.counts.name),
                            "leave the option out to start from the default room of these counts");
    }
    return room;
  }

  static nlohmann::json json_of(const gap::FittedParameter& p) {
    return {{"field", p.knob.field},
            {"first", p.knob.first},
            {"count", p.knob.count},
            {"text", p.knob.text},
            {"unit", p.prior.unit},
            {"prior", p.prior.start},
            {"prior_sd", p.prior.logarithmic ? p.prior.start * p.prior.prior_sd : p.prior.prior_sd},
            {"logarithmic", p.prior.logarithmic},
            {"estimate", p.estimate},
            {"sd", p.sd},
            {"interval", {p.interval(1.96).first, p.interval(1.96).second}},
            {"told", p.learned}};
  }
  static nlohmann::json json_of(const gap::ChannelFit& c) {
    return {{"channel", c.name},
            {"unit", c.unit},
            {"start_sd", c.start_sd},
            {"fitted_sd", c.fitted_sd},
            {"one_step_sd", c.one_step_sd},
            {"locked_rmse_start", c.locked_start},
            {"locked_rmse", c.locked_rmse}};
  }

  static void print_table(const gap::RoomFit& fit) {
    fmt::print("{:<36} {:<7} {:>9} {:>8} {:>9} {:>8}  from the data\n", "parameter", "unit", "prior", "+- sd",
               "estimate", "+- sd");
    for (const gap::FittedParameter& p : fit.parameters) {
      const double prior_sd = p.prior.logarithmic ? p.prior.start * p.prior.prior_sd : p.prior.prior_sd;
      const auto bar = static_cast<std::size_t>(std::lround(10 * std::clamp(p.learned, 0.0, 1.0)));
      fmt::print("{:<36} {:<7} {:>9.4g} {:>8.2g} {:>9.4g} {:>8.2g}  {:>3.0f} % {}\n", p.prior.name, p.prior.unit,
                 p.prior.start, prior_sd, p.estimate, p.sd, 100 * p.learned, std::string(bar, '='));
    }
    fmt::print("\n{:<20} {:<3} {:>8} {:>8} {:>9} {:>12} {:>8}\n", "residual", "", "start sd", "fit sd", "one step",
               "locked start", "locked");
    for (const gap::ChannelFit& c : fit.channels) {
      if (!std::isfinite(c.fitted_sd)) continue;
      fmt::print("{:<20} {:<3} {:>8.3f} {:>8.3f} {:>9.3f} {:>12.3f} {:>8.3f}\n", c.name, c.unit, c.start_sd,
                 c.fitted_sd, c.one_step_sd, c.locked_start, c.locked_rmse);
    }
  }

  void run() const {
    if (!out.ends_with(".json")) {
      throw hal::InputError("--out " + out, "a name that does not end in .json", "a room file, which is JSON",
                            "name it room.json");
    }
    const Site s = make_site(site);
    const sim::RcRoom from = start(s);
    const auto station = sim::read_epw(weather, {.whole_year = false, .from = {}, .to = {}});
    gap::CleanUpContext context;
    context.place = measured;
    context.counts = s.counts;
    context.station = station;
    const gap::CleanLog log = gap::read_dirty_log(measured, context);
    for (const gap::Remark& r : log.remarks) {
      fmt::print(stderr, "{}: {}, {}: {}\n", measured, text_of(r.defect), text_of(r.action), r.text);
    }
    log.require_usable();
    const gap::Window window = gap::window_of(log.rows, {from.vavs, from.fcus, from.powers}, station, measured);

    Progress bar(fmt::format("fitting {} to {}", from.name, measured), progress_steps);
    gap::RoomFitSettings settings;
    settings.locked_days = locked_days;
    settings.jobs = jobs;
    settings.progress = [&bar](double share) {
      bar.set(static_cast<std::uint64_t>(share * static_cast<double>(progress_steps)));
    };
    const gap::RoomFit fit = gap::fit_room(from, window, measured, settings);
    bar.finish();

    std::ofstream file(out);
    file << gap::room_file_text(fit.room,
                                fmt::format("fitted to {} from {} on, {} days, starting from room {}", measured,
                                            hal::civil_text(window.recording.from), fit.fitted_days, from.name));
    file.flush();
    if (!file) {
      throw hal::InputError("--out " + out, "a file that cannot be written", "a writable path", "choose another");
    }
    if (json) {
      nlohmann::json parameters = nlohmann::json::array(), channels = nlohmann::json::array();
      for (const auto& p : fit.parameters) parameters.push_back(json_of(p));
      for (const auto& c : fit.channels) channels.push_back(json_of(c));
      fmt::print("{}\n", nlohmann::json{{"room", out},
                                        {"start", from.name},
                                        {"fitted_days", fit.fitted_days},
                                        {"locked_days", fit.locked_days},
                                        {"room_temp_locked_rmse_start_k", fit.room_temp_start_k},
                                        {"room_temp_locked_rmse_k", fit.room_temp_k},
                                        {"inflation", fit.inflation},
                                        {"runs", fit.runs},
                                        {"parameters", parameters},
                                        {"channels", channels}}
                             .dump());
      return;
    }
    print_table(fit);
    fmt::print(
        "\n{} days fitted, {} locked away; rooms on the locked days: {:.3f} K with the start room, {:.3f} K with {}\n",
        fit.fitted_days, fit.locked_days, fit.room_temp_start_k, fit.room_temp_k, out);
  }
};

}  // namespace

void add_gap_fit(CLI::App& gap) {
  auto self = std::make_shared<FitCommand>();
  CLI::App* c = gap.add_subcommand("fit", "an RC room from a log, for a site without a model of its building");
  add_site_options(*c, self->site);
  c->add_option("--measured", self->measured, "log, or folder of logs")->required();
  c->add_option("--weather", self->weather, "EPW file that covers the log")->required();
  c->add_option("--start-room", self->start_room,
                "room to start from: a name or a file (default: that of the topology)");
  c->add_option("--locked-days", self->locked_days, "last days that are not fitted but predicted (default: 30 %)")
      ->check(CLI::Range(0, 366));
  c->add_option("--jobs", self->jobs, "simulations at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("-o,--out", self->out, "room file to write")->capture_default_str();
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
