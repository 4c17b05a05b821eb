// airside serve: a simulated room as a Modbus server, for airsided and any other client to control.

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "hal/modbus/server.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "sim/faults/faulty_model.hpp"
#include "tools/cli/command.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/served_plant.hpp"

namespace airside::tools {

namespace {

volatile std::sig_atomic_t stop_requested = 0;
extern "C" void request_serve_stop(int) { stop_requested = 1; }

/// A client with this site file would look for a serial line.
void note_rtu_over_tcp(const Site& s, const std::string& where) {
  if (!s.file.modbus || s.file.modbus->transport != hal::ModbusTransport::rtu) return;
  fmt::print(stderr,
             "airside: note: the transport of {} is rtu; this is Modbus TCP on {}. --pty FILE serves RTU, and FILE is "
             "then the site's device; --port says that TCP is meant\n",
             s.file.path, where);
}

struct ServeCommand {
  SiteOptions site;
  PlantChoice plant;
  int expert_days = 0, days = 31;
  int port = -1;
  std::string listen = "127.0.0.1", pty, ready_file, faults;
  double speed = 0;
  bool json = false;

  void run(const CLI::App& command) {
    const Site s = make_site(site);
    take_site_twin(command, plant, s, TwinUse::when_asked);
    take_scenario_start(command, plant);
    const sim::FaultScript script = faults.empty() ? sim::FaultScript{} : sim::read_fault_script(faults, s.counts);
    const auto model = make_plant(plant, s, expert_days + days);
    say_fallback(run_facts(plant, s));
    const CivilTime start = start_of(plant);
    const CivilTime open{start.seconds + expert_days * std::int64_t{86400}};
    if (expert_days > 0) {
      Progress bar("the schedule's days first", progress_steps);
      (void)run_schedule(s, *model, open, show_progress(bar));
      bar.finish();
      model->advance_to(open);
    }
    hal::ServerSettings settings;
    if (!pty.empty()) {
      settings.listen = hal::PtyListen{pty};
    } else {
      int chosen = port;
      if (chosen < 0)
        chosen = s.file.modbus && s.file.modbus->transport == hal::ModbusTransport::tcp ? s.file.modbus->port : 0;
      settings.listen = hal::TcpListen{listen, chosen};
    }
    if (s.file.modbus) settings.unit = s.file.modbus->unit_id;
    hal::ModbusServer server(s.points, settings);
    sim::FaultyModel faulty(*model, script);
    ServedPlant served(faulty, server, speed, CivilTime{open.seconds + days * std::int64_t{86400}});
    std::signal(SIGTERM, request_serve_stop);
    std::signal(SIGINT, request_serve_stop);
    const std::string where = pty.empty() ? fmt::format("{}:{}", listen, server.port()) : pty;
    if (pty.empty() && port < 0) note_rtu_over_tcp(s, where);
    if (json) {
      const nlohmann::json j = {
          {"plant", model->description()}, {"address", where}, {"from", hal::civil_text(open)}, {"days", days}};
      fmt::print("{}\n", j.dump());
    } else {
      fmt::print("serving {} on {} from {}\n", model->description(), where, hal::civil_text(open));
    }
    std::fflush(stdout);
    if (!ready_file.empty()) {
      hal::StagedFile ready(ready_file);  // who waits for it reads the whole address
      ready.write(where + "\n");
      ready.commit();
    }
    while (stop_requested == 0) {
      server.serve_once(speed > 0 ? 0.02 : 0.2);
      served.step();
    }
    if (!json) fmt::print("stopped at {} after {} requests\n", hal::civil_text(model->time()), server.requests());
  }
};

}  // namespace

void add_serve(CLI::App& app) {
  auto self = std::make_shared<ServeCommand>();
  CLI::App* c = app.add_subcommand(
      "serve",
      "serve a simulated room over Modbus TCP, or RTU on a pseudo-terminal.\n"
      "Without --speed it runs in lockstep: time moves only when a client writes clock_advance_s, as airsided\n"
      "does with `[clock] source = \"plant\"`; so a slow client loses nothing.\n"
      "The room stands for the built one: the site's [twin], a model to train on, is taken where --twin says so.");
  add_site_options(*c, self->site);
  add_plant_options(*c, self->plant, "2021-08-01");
  c->add_option("--expert-days", self->expert_days, "days under the schedule before the server opens")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  c->add_option("--days", self->days, "days that can be controlled")->check(CLI::Range(1, 364))->capture_default_str();
  c->add_option("--port", self->port, "TCP port, 0 for any (default: the site's)")->check(CLI::Range(0, 65535));
  c->add_option("--listen", self->listen, "address to listen on")->capture_default_str();
  c->add_option("--pty", self->pty, "serve RTU on a pseudo-terminal with this symlink, instead of TCP")
      ->excludes("--port");
  c->add_option(
      "--faults", self->faults,
      "CSV of faults of sensors and AHU, hours from the opening (docs/formats.md, \"Faults of a simulated room\")");
  c->add_option("--speed", self->speed, "run freely, N times real time")->check(CLI::Range(0.0, 1e6));
  c->add_option("--ready", self->ready_file, "write the address to this file once the server answers");
  c->add_flag("--json", self->json, "print one JSON object, once the server answers, and nothing else");
  c->callback([self, c] { self->run(*c); });
}

}  // namespace airside::tools
