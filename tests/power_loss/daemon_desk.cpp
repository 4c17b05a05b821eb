#include "power_loss/daemon_desk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "airside/signals.hpp"
#include "hal/points/register_codec.hpp"
#include "hal/text/civil_text.hpp"
#include "sim/simulated_plant.hpp"

namespace airside::power_loss {
namespace {

namespace fs = std::filesystem;

/// Environment of the next child; unset again at the end.
class Environment {
 public:
  void set(const char* name, const std::string& value) {
    if (value.empty()) return;
    ::setenv(name, value.c_str(), 1);
    names_.push_back(name);
  }
  Environment() = default;
  ~Environment() {
    for (const char* name : names_) ::unsetenv(name);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  std::vector<const char*> names_;
};

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

const std::string probe_path = std::string(AIRSIDE_BIN_DIR) + "/libairside_io_probe.so";

}  // namespace

DaemonDesk::DaemonDesk(DeskOptions options)
    : options_(std::move(options)),
      bench_({.name = options_.name,
              .plant = closed_loop::rc_room(),
              .expert_days = options_.expert_days,
              .days = options_.days,
              .in_memory = options_.in_memory}) {
  for (const char* part : {"box", "keys"}) fs::create_directories(file(part));
  if (airside({"keygen", "-o", file("ann").string()}, "") != 0) throw std::runtime_error("keygen: " + said());
  fs::copy(file("ann.pub"), file("keys") / "ann.pub");
  hal::PointMap points = hal::PointMap::load(file("points.csv").string());
  server_ = std::make_unique<hal::ModbusServer>(std::move(points), hal::ServerSettings{});
  server_->on_write([this](const hal::Point& point, double value) { return write(point, value); });
  write_site(server_->port());
  reset();
  thread_ = std::thread([this] { serve(); });
}

DaemonDesk::~DaemonDesk() {
  stop_ = true;
  thread_.join();
}

void DaemonDesk::write_site(int port) const {
  std::ofstream out(file("site.toml"));
  out << fmt::format(
      "[site]\nname = \"Bench\"\ntopology = \"5vav-5fcu-2power\"\nscope = \"Bench\"\n"
      "[controller]\nseed = 7\n[modbus]\ntransport = \"tcp\"\nhost = \"127.0.0.1\"\nport = {}\nunit_id = 1\n"
      "deadline_s = 10.0\npoints = \"points.csv\"\n[clock]\nsource = \"plant\"\n[state]\ndir = \"box/state\"\n"
      "[log]\ndir = \"box/log\"\nmax_files = {}\nmax_file_mb = {}\n{}[weights]\nblob = \"weights.blob\"\n"
      "keys = \"keys\"\n[inbox]\ndir = \"box/inbox\"\n",
      port, options_.max_files, options_.max_file_mb,
      options_.expert_days > 0 ? "[history]\nlog = \"history.csv\"\n" : "");
}

void DaemonDesk::reset() {
  for (const auto& entry : fs::directory_iterator(box())) fs::remove_all(entry.path());
  const std::scoped_lock lock(plant_);
  const tools::Trial trial = bench_.trial();
  model_ = tools::prepare(trial).model;
  open_ = model_->time();
  setpoints_.clear();
  publish();
}

void DaemonDesk::keep(const std::string& name) {
  fs::remove_all(file(name));
  fs::copy(box(), file(name), fs::copy_options::recursive);
}

void DaemonDesk::roll_back(const std::string& name, int row, const std::map<std::int64_t, double>& setpoints) {
  reset();
  fs::copy(file(name), box(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  const std::scoped_lock lock(plant_);
  const CivilTime last = time_of(row - 1);
  for (const auto& [seconds, setpoint] : setpoints) {
    if (seconds > last.seconds) break;
    model_->advance_to({seconds});
    model_->set_setpoint(setpoint);
    setpoints_[seconds] = setpoint;
  }
  model_->advance_to(last);
  publish();
}

void DaemonDesk::serve() {
  while (!stop_) server_->serve_once(0.02);
}

double DaemonDesk::write(const hal::Point& point, double value) {
  const double taken = std::clamp(value, point.min, point.max);
  const std::scoped_lock lock(plant_);
  if (point.name == "setpoint") {
    setpoints_[model_->time().seconds] = hal::rounded(point, taken);
    model_->set_setpoint(hal::rounded(point, taken));
    publish();
  } else if (point.name == "clock_advance_s") {
    constexpr std::int64_t step_s = 180;
    const std::int64_t wanted = hal::clock_epoch.seconds + static_cast<std::int64_t>(taken);
    const CivilTime reach{model_->time().seconds + (wanted - model_->time().seconds) / step_s * step_s};
    if (reach > model_->time()) {
      model_->advance_to(reach);
      publish();
    }
  }
  return taken;
}

void DaemonDesk::publish() {
  const sim::Sensors& s = model_->sensors();
  const tools::Site site = bench_.trial().site;
  for (int i = 0; i < site.counts.signals(); ++i) {
    const SignalId id = site.counts.signal(i);
    server_->set(hal::point_name(id), sim::sensor_value(s, id));
  }
  server_->set("setpoint", s.setpoint_degc);
  server_->set("supply_temp", s.supply_temp_degc);
  server_->set("clock_s", static_cast<double>(model_->time().seconds - hal::clock_epoch.seconds));
}

DaemonRun DaemonDesk::run(int row, const ProbeOrder& order, bool sync, const std::vector<std::string>& more) {
  Environment environment;
  environment.set("LD_PRELOAD", probe_path);
  environment.set("AIRSIDE_IO_ROOT", box().string());
  environment.set("AIRSIDE_IO_LOG", order.record);
  environment.set("AIRSIDE_IO_KILL", order.kill);
  environment.set("AIRSIDE_IO_FAIL", order.fail);
  environment.set("AIRSIDE_IO_FAIL_EVERY", order.fail_every);
  environment.set("AIRSIDE_IO_COUNT", file("calls").string());
  environment.set("AIRSIDE_ALLOC_FAIL", order.fail_heap);
  environment.set("AIRSIDE_ALLOC_COUNT", file("allocations").string());
  std::vector<std::string> command = {bench_.program("airsided").string(),
                                      "--site",
                                      file("site.toml").string(),
                                      "--until",
                                      hal::civil_text(time_of(row)),
                                      "--backoff",
                                      "0.02",
                                      "--crash-limit",
                                      std::to_string(options_.crash_limit)};
  if (!sync) command.emplace_back("--no-sync");
  command.insert(command.end(), more.begin(), more.end());
  DaemonRun result;
  const double began_s = closed_loop::now_s();
  {
    closed_loop::Child child(command, file("daemon.txt"));
    result.code = child.wait(120).value_or(-1);
  }
  result.seconds = closed_loop::now_s() - began_s;
  std::istringstream counted(text_of(file("calls")));
  std::string how;
  counted >> result.calls >> how >> result.files_early >> result.files_late >> result.threads;
  std::istringstream(text_of(file("allocations"))) >> result.allocations;
  result.killed_by_probe = how == "killed";
  return result;
}

int DaemonDesk::airside(std::vector<std::string> words, const std::string& record) {
  Environment environment;
  if (!record.empty()) {
    environment.set("LD_PRELOAD", probe_path);
    environment.set("AIRSIDE_IO_ROOT", box().string());
    environment.set("AIRSIDE_IO_LOG", record);
  }
  words.insert(words.begin(), bench_.program("airside").string());
  return closed_loop::Child(words, file("daemon.txt")).wait(60).value_or(-1);
}

void DaemonDesk::push(int counter, const std::string& record) {
  const std::string blob = file(fmt::format("signed_{}.blob", counter)).string();
  if (!fs::exists(blob) && airside({"sign", file("weights.blob").string(), "--key", file("ann.key").string(), "-o",
                                    blob, "--counter", std::to_string(counter)},
                                   "") != 0) {
    throw std::runtime_error("sign: " + said());
  }
  if (airside({"push", blob, (box() / "inbox").string()}, record) != 0) throw std::runtime_error("push: " + said());
}

void DaemonDesk::wish(const std::string& name, const std::string& record) {
  if (airside({name, (box() / "inbox").string()}, record) != 0) throw std::runtime_error(name + ": " + said());
}

std::vector<std::string> DaemonDesk::rows() const {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(box() / "log")) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> rows;
  for (const fs::path& path : files) {
    std::ifstream in(path);
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) rows.push_back(line);
  }
  return rows;
}

std::map<std::int64_t, double> DaemonDesk::setpoints() const {
  const std::scoped_lock lock(plant_);
  return setpoints_;
}

std::string DaemonDesk::said() const { return text_of(file("daemon.txt")); }
std::string DaemonDesk::status() const { return text_of(box() / "state" / "status.json"); }

}  // namespace airside::power_loss
