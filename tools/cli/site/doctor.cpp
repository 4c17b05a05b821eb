// airside doctor: what is missing on this machine, or for a site, with the line that fixes it.

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/storage/etc_folder.hpp"
#include "hal/system/version.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "hal/weights/key_ring.hpp"
#include "sim/json/json_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/probe/connection.hpp"
#include "tools/cli/site/doctor.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

constexpr double old_status_s = 900;  ///< the box writes every 6 min

/// The daemon's own files beside the logs: state, its two copies, status, inbox.
constexpr double state_mb = 32;

bool is_in_path(const char* program) {
  const char* path = std::getenv("PATH");
  std::string_view left = path != nullptr ? path : "";
  while (!left.empty()) {
    const std::size_t end = left.find(':');
    const fs::path file = fs::path(left.substr(0, end)) / program;
    if (::access(file.c_str(), X_OK) == 0) return true;
    left.remove_prefix(end == std::string_view::npos ? left.size() : end + 1);
  }
  return false;
}

/// The folder itself, or the one in which it would be made.
fs::path nearest_folder(const fs::path& folder) {
  std::error_code ignored;
  fs::path at = fs::absolute(folder, ignored);
  while (!at.empty() && !fs::exists(at, ignored) && at != at.parent_path()) at = at.parent_path();
  return at;
}

class Doctor {
 public:
  explicit Doctor(std::vector<DoctorFinding>& out) : out_(out) {}

  void look_at_machine() {
    ok("program", hal::version_line("airside"));
    timex clock{};
    if (::adjtimex(&clock) < 0) {
      advise("clock", "cannot be asked", "timedatectl");
    } else if ((clock.status & STA_UNSYNC) != 0) {
      advise("clock", "not kept in step with a time server; the schedule follows it", "sudo timedatectl set-ntp true");
    } else {
      ok("clock", "kept in step with a time server");
    }
    if (is_in_path("airsided")) {
      ok("daemon", "airsided is installed");
    } else {
      advise("daemon", "no airsided in the PATH: this is no box, or it is not installed",
             "sudo apt install ./airsided_*.deb");
    }
  }

  void look_at_site(const std::string& path) {
    site_ = hal::shell_word(path);
    std::optional<hal::SiteFile> site;
    if (!tries("site", [&] {
          site = hal::read_site_file(path, hal::site_rules());
          return fmt::format("\"{}\", {}", site->name, site->topology);
        })) {
      return;
    }
    folder("state", site->state_dir, state_mb);
    folder("log", site->log_dir, site->log_max_files * site->log_max_file_mb);
    folder("inbox", site->inbox_dir, 1);
    weights(*site);
    if (!site->modbus) {
      advise("bus", "no [modbus]: the site is only simulated", "airside init --help");
      return;
    }
    points(*site);
    bus(*site);
    daemon(*site);
  }

 private:
  void ok(const char* what, std::string found) { out_.push_back({what, DoctorState::ok, std::move(found), ""}); }
  void advise(const char* what, std::string found, std::string remedy) {
    out_.push_back({what, DoctorState::advice, std::move(found), std::move(remedy)});
  }
  void miss(const char* what, std::string found, std::string remedy) {
    out_.push_back({what, DoctorState::missing, std::move(found), std::move(remedy)});
  }

  void refused(const char* what, const hal::InputError& e) {
    miss(what, fmt::format("{}: found {}; expected {}", e.place(), e.found(), e.expected()), e.remedy());
  }

  /// Runs `look`, which returns what it found; a complaint of a reader is a finding too.
  template <class Look>
  bool tries(const char* what, Look&& look) {
    try {
      ok(what, look());
      return true;
    } catch (const hal::InputError& e) {
      refused(what, e);
    }
    return false;
  }

  void folder(const char* what, const std::string& dir, double needs_mb) {
    const fs::path at = nearest_folder(dir);
    std::error_code ignored;
    if (fs::exists(dir, ignored) && !fs::is_directory(dir, ignored)) {
      miss(what, dir + " is no folder", fmt::format("mv {} {}.old", hal::shell_word(dir), hal::shell_word(dir)));
      return;
    }
    if (hal::is_below_etc(dir)) {
      miss(what, dir + " is below /etc, which airsided.service may not write",
           fmt::format("write dir = \"{}\" in [{}] of {}", hal::folder_of_box(what), what, site_));
      return;
    }
    if (::access(at.c_str(), W_OK | X_OK) != 0) {
      miss(what, fmt::format("{} cannot be written by this user", at.string()),
           fmt::format("sudo chown airside: {}, or run this as airside: sudo -u airside airside doctor {}",
                       hal::shell_word(at.string()), site_));
      return;
    }
    struct statvfs room {};
    struct statfs kind {};
    constexpr long tmpfs = 0x01021994;
    if (::statfs(at.c_str(), &kind) == 0 && kind.f_type == tmpfs && std::string_view(what) == "state") {
      advise(what, dir + " is in memory: what is learned is lost with the power", "name a folder on a disk in [state]");
      return;
    }
    if (::statvfs(at.c_str(), &room) == 0) {
      const double free_mb = static_cast<double>(room.f_bavail) * static_cast<double>(room.f_frsize) / 1e6;
      if (free_mb < needs_mb) {
        advise(what, fmt::format("{} has {:.0f} MB free, {:.0f} MB may be needed", dir, free_mb, needs_mb),
               "free some, or set max_files and max_file_mb in [log]");
        return;
      }
      ok(what, fmt::format("{}, {:.0f} MB free", dir, free_mb));
      return;
    }
    ok(what, dir);
  }

  void weights(const hal::SiteFile& site) {
    std::error_code ignored;
    if (!site.weights_blob.empty() && !fs::exists(site.weights_blob, ignored)) {
      miss("weights", "no file at " + site.weights_blob,
           fmt::format("airside pretrain --site {} -o {}", site_, hal::shell_word(site.weights_blob)));
    } else if (!site.weights_blob.empty()) {
      ok("weights", site.weights_blob);
    } else if (site.objective == Objective::mean) {
      advise("weights", "none named in [weights]: the schedule runs until some are pushed",
             fmt::format("airside pretrain --site {} -o room.blob, then blob = \"room.blob\" in [weights]", site_));
    }
    tries("keys", [&] {
      const hal::KeyRing keys = hal::KeyRing::load(site.keys_dir);
      return keys.size() > 0 ? hal::describe(keys)
                             : "none in " + site.keys_dir + ": no pushed weights are taken (airside keygen makes one)";
    });
  }

  void points(const hal::SiteFile& site) {
    tries("points", [&] {
      const hal::PointMap map = hal::PointMap::load(site.modbus->points);
      const Shape shape = parse_shape(site.topology.c_str());
      map.check_topology(shape.vavs, shape.fcus, shape.powers, site.stand_ins);
      hal::refuse_contradiction(site, map);
      const std::string points = hal::shell_word(site.modbus->points);
      if (map.find("heartbeat") == nullptr) {
        advise(
            "heartbeat", "no point of that name: an AHU does not notice when the box is gone",
            fmt::format("give it {} in {}, which the AHU watches", site.bacnet ? "an object" : "a register", points));
      } else if (const std::string warning = hal::warning_of(map); !warning.empty()) {
        advise("heartbeat", warning, "correct " + points);
      }
      return fmt::format("{} points in {}", map.points().size(), site.modbus->points);
    });
  }

  void bus(const hal::SiteFile& site) {
    const hal::ModbusSection& m = *site.modbus;
    if (const auto failure = why_no_connection(site)) {
      miss("bus", failure->found, fmt::format("{}; then airside probe {}", failure->remedy, site_));
    } else if (m.transport == hal::ModbusTransport::rtu) {
      ok("bus", m.device);
    } else {
      ok("bus", fmt::format("{}:{} takes a connection", m.host, m.port));
    }
  }

  void daemon(const hal::SiteFile& site) {
    const fs::path status = fs::path(site.state_dir) / "status.json";
    std::error_code ignored;
    if (!fs::exists(status, ignored)) {
      advise("status", "airsided has not run with this site yet",
             fmt::format("airsided --check --site {}; then sudo systemctl enable --now airsided", site_));
      return;
    }
    const double age_s =
        std::chrono::duration<double>(fs::file_time_type::clock::now() - fs::last_write_time(status, ignored)).count();
    if (age_s > old_status_s) {
      advise("status", fmt::format("{} is {:.0f} min old: airsided does not run", status.string(), age_s / 60),
             "systemctl status airsided");
      return;
    }
    try {
      const nlohmann::json said = sim::read_json(status);
      if (said.is_object() && said.value("stopped", nlohmann::json()) == true) {
        advise("status", "airsided has stopped in order", "sudo systemctl start airsided");
      } else {
        ok("status", fmt::format("written {:.0f} s ago", age_s));
      }
    } catch (const hal::InputError& e) {
      refused("status", e);
    }
  }

  std::vector<DoctorFinding>& out_;
  std::string site_;  ///< as it is typed in a shell
};

const char* word_of(DoctorState state) {
  switch (state) {
    case DoctorState::ok: return "ok";
    case DoctorState::advice: return "advice";
    case DoctorState::missing: break;
  }
  return "MISSING";
}

struct DoctorCommand {
  std::string site;
  bool json = false;
  LookAtHost look_at_host = nullptr;

  void run() const {
    std::vector<DoctorFinding> found;
    Doctor doctor(found);
    doctor.look_at_machine();
    if (look_at_host != nullptr) look_at_host(found);
    if (!site.empty()) doctor.look_at_site(site);
    const auto missing = std::ranges::count(found, DoctorState::missing, &DoctorFinding::state);
    if (json) {
      nlohmann::json list = nlohmann::json::array();
      for (const DoctorFinding& f : found)
        list.push_back({{"what", f.what}, {"state", word_of(f.state)}, {"found", f.found}, {"remedy", f.remedy}});
      const nlohmann::json all{{"ok", missing == 0}, {"findings", list}};
      fmt::print("{}\n", all.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
      for (const DoctorFinding& f : found) {
        fmt::print("{:<8} {:<10} {}\n", word_of(f.state), f.what, f.found);
        if (!f.remedy.empty()) fmt::print("{:>19} {}\n", "do:", f.remedy);
      }
    }
    std::fflush(stdout);
    if (missing != 0) throw std::runtime_error(fmt::format("{} of {} things are missing", missing, found.size()));
  }
};

}  // namespace

void add_doctor(CLI::App& app, LookAtHost look_at_host) {
  auto self = std::make_shared<DoctorCommand>();
  self->look_at_host = look_at_host;
  CLI::App* c = app.add_subcommand(
      "doctor",
      "look at this machine, and at all that a site needs of it, and say what is missing, with the line that fixes "
      "it.\n"
      "It changes nothing, and does not speak Modbus: airside probe does. Exit code 1 where something is missing; an\n"
      "advice is none.");
  c->add_option("site", self->site, "site file, such as /etc/airside/site.toml (default: the machine alone)");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
