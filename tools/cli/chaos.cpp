// airside chaos: a proxy in front of any Modbus/TCP server that answers as broken and hostile peers do.

#include <fmt/format.h>

#include <cmath>
#include <csignal>
#include <cstdio>

#include "hal/modbus/plant_clock.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "tools/chaos/chaos_proxy.hpp"
#include "tools/cli/command.hpp"
#include "tools/run/options/option_checks.hpp"

namespace airside::tools {

namespace {

volatile std::sig_atomic_t chaos_stop_requested = 0;
extern "C" void request_chaos_stop(int) { chaos_stop_requested = 1; }

/// What reached the server, one line a written value: the proof that nothing unsafe did.
class WriteRecord {
 public:
  explicit WriteRecord(const std::string& path) : file_(std::fopen(path.c_str(), "w")) {
    if (file_ == nullptr) {
      throw hal::InputError("--writes " + path, "a file that cannot be written", "a writable path", "choose another");
    }
    fmt::print(file_, "exchange,t_s,unit,fc,addr,asked,forwarded,taken,fault\n");
  }
  ~WriteRecord() { std::fclose(file_); }
  WriteRecord(const WriteRecord&) = delete;
  WriteRecord& operator=(const WriteRecord&) = delete;

  void add(const ChaosExchange& e) {
    const ChaosRequest& r = e.request;
    if ((r.function != 6 && r.function != 16) || e.forwarded.empty()) return;
    const std::size_t at = r.function == 6 ? 10 : 13;
    for (int i = 0; i < r.count && at + 2 * static_cast<std::size_t>(i) + 1 < e.forwarded.size(); ++i) {
      const std::size_t k = at + 2 * static_cast<std::size_t>(i);
      fmt::print(file_, "{},{:.6f},{},{},{},{},{},{},{}\n", r.number, r.t_s, e.asked[6], r.function, r.addr + i,
                 hal::get16(&e.asked[k]), hal::get16(&e.forwarded[k]), e.taken() ? 1 : 0, text_of(e.fault.kind));
    }
    std::fflush(file_);
  }

 private:
  std::FILE* file_;
};

struct ChaosCommand {
  int listen_port = 0;
  std::string address = "127.0.0.1", to, script, ready_file, writes_file;
  std::vector<std::string> faults;
  std::optional<std::uint64_t> seed;
  double seconds = 0;
  bool as_json = false, quiet = false;

  ChaosSettings settings() const {
    ChaosSettings s;
    s.listen = address;
    s.port = listen_port;
    const std::size_t colon = to.rfind(':');
    int port = 0;
    if (colon != std::string::npos && to.find_first_not_of("0123456789", colon + 1) == std::string::npos &&
        to.size() - colon <= 6 && to.size() - colon > 1) {
      port = std::stoi(to.substr(colon + 1));
    }
    if (port < 1 || port > 65535) {
      throw hal::InputError("--to", "\"" + to + "\"", "HOST:PORT of the true server, as 10.0.0.5:502", "correct it");
    }
    s.to_host = to.substr(0, colon);
    s.to_port = port;
    if (!script.empty()) {
      const ChaosScript read = parse_chaos_script(hal::read_text_file(script, "a fault script"), script);
      s.rules = read.rules;
      s.seed = read.seed.value_or(s.seed);
    }
    for (std::size_t i = 0; i < faults.size(); ++i) {
      s.rules.push_back(parse_chaos_fault(faults[i], "--fault " + faults[i], 1'000'000 + static_cast<int>(i)));
    }
    s.seed = seed.value_or(s.seed);
    return s;
  }

  void run() const {
    const ChaosSettings chosen = settings();
    std::optional<WriteRecord> writes;
    if (!writes_file.empty()) writes.emplace(writes_file);
    std::signal(SIGTERM, request_chaos_stop);
    std::signal(SIGINT, request_chaos_stop);
    ChaosProxy proxy(chosen, [&](const ChaosExchange& e) {
      if (writes) writes->add(e);
      if (!quiet && e.fault.kind != ChaosKind::none) fmt::print(stderr, "{}\n", describe(e));
    });
    fmt::print(stderr, "chaos between {}:{} and {}, {} rules, seed {}\n", address, proxy.port(), to,
               chosen.rules.size(), chosen.seed);
    if (!ready_file.empty()) {
      std::FILE* f = std::fopen(ready_file.c_str(), "w");
      if (f == nullptr) {
        throw hal::InputError("--ready " + ready_file, "a file that cannot be written", "a writable path",
                              "choose another");
      }
      fmt::print(f, "{}:{}\n", address, proxy.port());
      std::fclose(f);
    }
    const std::int64_t end_ns = seconds > 0 ? hal::monotonic_ns() + hal::to_ns(seconds) : INT64_MAX;
    hal::sleep_until_ns(end_ns, hal::StopFlag(&chaos_stop_requested));
    const ChaosCounters c = proxy.counters();
    if (as_json) {
      nlohmann::json by_fault = nlohmann::json::object();
      for (const auto& [name, count] : c.by_fault) by_fault[name] = count;
      const nlohmann::json all = {{"exchanges", c.exchanges}, {"connections", c.connections},
                                  {"faults", c.faults},       {"writes_taken_by_the_server", c.writes_forwarded},
                                  {"seed", chosen.seed},      {"by_fault", by_fault}};
      fmt::print("{}\n", all.dump());
      return;
    }
    fmt::print("{} exchanges on {} connections, {} faults, {} writes taken by the server\n", c.exchanges, c.connections,
               c.faults, c.writes_forwarded);
    for (const auto& [name, count] : c.by_fault) fmt::print("  {:<12} {}\n", name, count);
  }
};

std::string fault_list() {
  std::string text = "Faults (a parameter without a number is drawn anew each time):\n";
  for (const ChaosKindRule& k : chaos_kinds()) {
    std::string name = k.name;
    for (const ChaosParam& p : k.params) {
      if (p.name == nullptr) continue;
      name += fmt::format("{}{}", name == k.name ? ":" : ",", p.name);
      if (std::isfinite(p.otherwise) && p.otherwise < 1e9) name += fmt::format("={}", p.otherwise);
    }
    text += fmt::format("  {:<24} {}\n", name, k.what);
  }
  return text;
}

}  // namespace

void add_chaos(CLI::App& app) {
  auto self = std::make_shared<ChaosCommand>();
  CLI::App* c = app.add_subcommand(
      "chaos",
      "stand between a Modbus/TCP client and its server, and answer as broken and hostile peers do.\n"
      "  airside serve --room 301-real --port 1502\n"
      "  airside chaos --listen 1503 --to 127.0.0.1:1502 --fault late:p=0.05,s=3 --fault reset:p=0.05\n"
      "then point airsided, or any other client, at port 1503. The same seed, rules and requests give the same\n"
      "faults. Each fault is a line on standard error. It runs until a signal stops it (Ctrl-C).");
  c->add_option("--listen", self->listen_port, "port to listen at, 0 for any")->check(CLI::Range(0, 65535));
  c->add_option("--address", self->address, "address to listen at")->capture_default_str();
  c->add_option("--to", self->to, "HOST:PORT of the true server")->required();
  c->add_option("--script", self->script, "fault script (docs/formats.md, \"Bus fault script\")");
  c->add_option(
       "--fault", self->faults,
       "a fault and when, as late:p=0.1,s=3 or exception:on=write,code=4. Conditions: p=PROBABILITY,\n"
       "n=EXCHANGE or n=FROM..TO (from 1), t=FROM..TO (s), on=read|write, fc=FUNCTION, at=ADDRESS, wider=COUNT")
      ->allow_extra_args(false);
  c->add_option("--seed", self->seed, "of all draws (default: the script's, else 1)")->check(seed_check());
  c->add_option("--seconds", self->seconds, "stop by itself after so long")->check(CLI::Range(0.0, 1e8));
  c->add_option("--writes", self->writes_file, "CSV of every register value that reached the server");
  c->add_option("--ready", self->ready_file, "write the address to this file once it listens");
  c->add_flag("--quiet", self->quiet, "no line for each fault");
  c->add_flag("--json", self->as_json, "print counters as one JSON object at the end");
  c->footer(fault_list());
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
