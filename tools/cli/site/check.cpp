// airside check: everything a site names, read and checked before it is needed.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "airside/topology.hpp"
#include "hal/site/site_log.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/key_ring.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "tools/cli/blob/blob_facts.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/site/check_twin.hpp"
#include "tools/cli/site/findings.hpp"
#include "tools/cli/site/site_signals.hpp"
#include "tools/cli/site/site_warnings.hpp"
#include "tools/run/run_facts.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

/// What is wanted, and what it needs beyond room temperatures and the setpoint.
std::string objective_facts(const hal::SiteFile& f, const ControllerSettings& s) {
  if (f.objective == Objective::mean) {
    const std::string held =
        f.held.rule == HoldRule::mean ? "" : fmt::format(" (hold {} of the rooms)", text_of(f.held.rule));
    return fmt::format("objective mean: holds {} degC{} by a decision every {} min", f.room_temp_degc, held,
                       f.cycle_min);
  }
  return fmt::format(
      "objective band: least energy with each zone within {} K of its setpoints, from damper_n, zone_setpoint_n, "
      "supply_temp, outdoor_temp and power_1; learned on the box, without weights",
      s.demand.band_k);
}

std::string site_facts(const hal::SiteFile& f) {
  const ControllerSettings s = hal::controller_settings(f);
  const int candidates = static_cast<int>(std::lround((s.action_max_degc - s.action_min_degc) / s.action_step_k)) + 1;
  return fmt::format(
      "\"{}\", scope of its weights \"{}\", topology {}, {}, working hours {} to {}{}, preset {} with {} overrides, "
      "{} candidate setpoints "
      "from {} to {} degC, {}",
      f.name, f.scope, f.topology, objective_facts(f, s), hal::clock_text(f.work_start_s),
      hal::clock_text(f.work_end_s), f.weekday_only ? " on weekdays" : "", hal::name_of(f.preset), f.overrides.size(),
      candidates, s.action_min_degc, s.action_max_degc,
      f.modbus ? "Modbus " + (f.modbus->transport == hal::ModbusTransport::tcp
                                  ? fmt::format("TCP {}:{}", f.modbus->host, f.modbus->port)
                                  : fmt::format("RTU {}", f.modbus->device))
               : "simulated only (no [modbus])");
}

/// Facts of a map that is in order; else all that is wrong with it in `complaints`.
std::string points_facts(Findings& out, const std::string& path, const hal::TopologyCounts& counts,
                         const hal::SiteFile* site, std::vector<hal::InputError>& complaints) {
  const hal::PointMap map = hal::PointMap::load(path, complaints);
  const hal::StandIns stand_ins = site != nullptr ? site->stand_ins : hal::StandIns{};
  // First: a stand-in, which the topology's complaint advises, is no remedy for what the objective needs.
  if (site != nullptr && complaints.empty()) hal::refuse_contradiction(*site, map);
  for (const hal::InputError& e : map.topology_complaints(counts.vavs, counts.fcus, counts.powers, stand_ins)) {
    complaints.push_back(e);
  }
  if (!complaints.empty()) return {};
  const auto writable =
      std::count_if(map.points().begin(), map.points().end(), [](const auto& p) { return p.writable(); });
  for (std::string& text : warnings_of(map)) out.warn("points", path, std::move(text));
  return fmt::format("{} points for {}, {} of them writable, {} beyond the topology, fingerprint {:016x}",
                     map.points().size(), counts.name, writable, map.extras().size(), map.fingerprint());
}

std::string log_facts(const std::string& path, const hal::TopologyCounts& counts) {
  const hal::Log log = hal::read_log(path, counts);
  const hal::LogSummary& s = log.summary;
  std::string text = fmt::format("{} rows from {} to {}", s.rows, hal::civil_text(s.first), hal::civil_text(s.last));
  if (s.gaps.empty()) return text + ", no gap";
  return text + fmt::format(", {} gaps with {} rows missing, the first after {} (line {})", s.gaps.size(),
                            s.missing_rows, hal::civil_text(s.gaps.front().from), s.gaps.front().line);
}

/// A blob as the daemon would take it: topology and scope of the site, if there is one.
std::string blob_facts(const std::string& path, const hal::TopologyCounts& counts, const std::string& scope) {
  const BlobFacts f = read_blob_facts(path);
  if (f.refusal) throw *f.refusal;
  if (f.topology != counts.name) {
    throw hal::InputError(path + ": topology_hash", "weights of topology " + f.topology, "the site's " + counts.name,
                          "pretrain with this site file, or correct `topology` in it");
  }
  const std::string own = scope_text(f.header);
  if (f.header.site_scope[0] != '\0' && !scope.empty() && own != scope) {
    throw hal::InputError(path + ": site_scope", "a blob for \"" + own + '"',
                          "this site's scope \"" + scope + "\" or none",
                          "transfer it to this site, or correct `scope` in the site file");
  }
  return fmt::format("{} bytes, digest {}, {} weights for {}, {}, made by: {}", f.bytes, f.digest, f.weights.size(),
                     f.topology, key_text(f.header), f.provenance.empty() ? "unknown" : f.provenance);
}

std::string room_facts(const std::string& path, const hal::TopologyCounts& counts) {
  const sim::RcRoom room = sim::load_room(path);
  if (room.vavs != counts.vavs || room.fcus != counts.fcus || room.powers != counts.powers) {
    throw hal::InputError(
        path + ": vavs, fcus, powers", fmt::format("{}vav-{}fcu-{}power", room.vavs, room.fcus, room.powers),
        "the site's topology " + counts.name, "choose a room of the site's shape, or another topology");
  }
  return fmt::format("room \"{}\", {} VAVs, {} FCUs, {} power meters, {:.0f} m2", room.name, room.vavs, room.fcus,
                     room.powers, std::accumulate(room.floor_area_m2.begin(), room.floor_area_m2.end(), 0.0));
}

json json_of(const std::vector<LackingSignals>& missing) {
  json list = json::array();
  for (const LackingSignals& m : missing) {
    json entry = {{"names", m.names}, {"use", m.use}, {"instead", m.instead}, {"cost", m.cost}};
    if (m.stand_in) entry["stand_in"] = *m.stand_in;
    list.push_back(std::move(entry));
  }
  return list;
}

json json_of(const hal::InputError& e) {
  return {{"place", e.place()}, {"found", e.found()}, {"expected", e.expected()}, {"remedy", e.remedy()}};
}

/// All of them, as far as a person reads.
void print_complaints(const Finding& f) {
  constexpr std::size_t most_shown = 50;
  fmt::print("WRONG  {:<8} {}\n", f.what, f.complaint->what());
  const std::size_t shown = std::min(f.more.size(), most_shown - 1);
  for (std::size_t i = 0; i < shown; ++i) fmt::print("WRONG  {:<8} {}\n", f.what, f.more[i].what());
  if (f.more.size() > shown) fmt::print("       {:<8} and {} more\n", "", f.more.size() - shown);
}

struct CheckCommand {
  std::string air_loop;
  std::string site, topology = "5vav-5fcu-2power", points, twin, weather, room;
  std::vector<std::string> patches, logs, weights;
  bool as_json = false, strict = false, try_site_twin = false;

  bool nothing_named() const {
    return points.empty() && twin.empty() && weather.empty() && room.empty() && patches.empty() && logs.empty() &&
           weights.empty();
  }

  static void check_site_twin(Findings& out, const hal::SiteFile& file, const hal::TopologyCounts& counts) {
    const hal::TwinSection& named = *file.twin;
    const bool rc = named.model == "rc";
    if (!rc) check_twin(out, named, counts);
    if (rc && !named.patches.empty()) {
      out.refuse("twin", file.path,
                 {file.path + ": twin.patches", "patches on model = \"rc\"", "an epJSON model to patch",
                  "leave the patches out, or name the model"});
    }
    if (!named.weather.empty()) {
      check_weather(out, named.weather, !rc);
    } else {
      out.warn("twin", file.path,
               "no weather in [twin]: " +
                   std::string(rc ? "a made-up year"
                                  : "Tampa's, which comes "
                                    "with EnergyPlus,") +
                   " is taken");
    }
  }

  /// What --twin without a file asks for.
  static void try_twin_of(Findings& out, const hal::SiteFile& file) {
    if (!file.twin || file.twin->model == "rc") {
      out.refuse("twin", file.path,
                 {"--twin", file.twin ? "model = \"rc\"" : "no [twin] in " + file.path,
                  "an epJSON model to run a day of", "name it in [twin], or give --twin FILE"});
      return;
    }
    if (out.failed() == 0) try_twin(out, load_site(file.path));
  }

  Findings look() const {
    Findings out;
    hal::TopologyCounts counts = built_in_site(topology).counts;
    std::string scope;
    std::optional<hal::SiteFile> file;
    const std::string site_path = site.empty() && nothing_named() ? "site.toml" : site;
    if (!site_path.empty()) {
      out.check("site", site_path, [&] {
        file = hal::read_site_file(site_path, hal::site_rules());
        counts = hal::counts_of(parse_shape(file->topology.c_str()));
        scope = file->scope;
        for (std::string& text : warnings_of(*file)) out.warn("site", site_path, std::move(text));
        return site_facts(*file);
      });
    }
    const auto check_points = [&](const std::string& p) {
      out.check_all("points", p, [&](std::vector<hal::InputError>& complaints) {
        return points_facts(out, p, counts, file ? &*file : nullptr, complaints);
      });
    };
    const auto check_log = [&](const char* what, const std::string& p) {
      out.check(what, p, [&] { return log_facts(p, counts); });
    };
    const auto check_blob = [&](const std::string& p) {
      out.check("weights", p, [&] { return blob_facts(p, counts, scope); });
    };
    if (file) {
      hal::PointMap map;
      if (file->modbus) {
        out.check_all("points", file->modbus->points, [&](std::vector<hal::InputError>& complaints) {
          std::string facts = points_facts(out, file->modbus->points, counts, &*file, complaints);
          if (!complaints.empty()) return facts;
          map = hal::PointMap::load(file->modbus->points);
          counts = hal::counts_of(counts, map, file->stand_ins);
          return facts;
        });
      } else {
        const std::string csv = hal::default_point_map(counts.vavs, counts.fcus, counts.powers, file->stand_ins);
        map = hal::PointMap::parse(csv, "built-in");
        counts = hal::counts_of(counts, map, file->stand_ins);
      }
      if (out.failed() == 0) {
        out.check("signals", site_path, [&] {
          out.lacking = missing_signals(*file, map, counts);
          return signal_facts(*file, counts, out.lacking);
        });
      }
      if (!file->weights_blob.empty()) check_blob(file->weights_blob);
      out.check("keys", file->keys_dir, [&] { return hal::describe(hal::KeyRing::load(file->keys_dir)); });
      if (!file->history_log.empty()) check_log("history", file->history_log);
      if (file->twin) check_site_twin(out, *file, counts);
      if (try_site_twin) try_twin_of(out, *file);
    }
    if (!points.empty()) check_points(points);
    for (const std::string& p : weights) check_blob(p);
    for (const std::string& p : logs) check_log("log", p);
    hal::TwinSection bare;
    bare.model = twin;
    bare.patches = patches;
    if (site_path.empty() && patches.empty() && !twin.empty() && (!air_loop.empty() || is_foreign(twin))) {
      check_foreign(out, twin, air_loop, weather);
    } else {
      check_twin(out, bare, counts);
    }
    if (!weather.empty()) check_weather(out, weather, !twin.empty());
    if (!room.empty()) out.check("room", room, [&] { return room_facts(room, counts); });
    return out;
  }

  void run() const {
    if (!air_loop.empty() && (!site.empty() || !patches.empty() || twin.empty())) {
      throw hal::InputError("--air-loop", "given without --twin MODEL, or beside a site or --patch",
                            "a model that somebody else wrote", "leave it out, or give --twin MODEL.idf alone");
    }
    const Findings found = look();
    if (as_json) {
      json list = json::array();
      for (const Finding& f : found.all()) {
        json entry = {{"what", f.what}, {"file", f.file}, {"ok", !f.complaint}};
        if (f.complaint) {
          entry.update(json_of(*f.complaint));
          for (const hal::InputError& e : f.more) entry["more"].push_back(json_of(e));
        } else {
          entry["facts"] = f.facts;
        }
        list.push_back(entry);
      }
      json warnings = json::array();
      for (const Warning& w : found.warnings()) {
        warnings.push_back({{"what", w.what}, {"file", w.file}, {"text", w.text}});
      }
      json all = {{"ok", found.failed() == 0}, {"checked", list}, {"warnings", warnings}};
      if (!found.lacking.empty()) all["missing_signals"] = json_of(found.lacking);
      add_program_to(all);
      fmt::print("{}\n", all.dump(-1, ' ', false, json::error_handler_t::replace));
    } else {
      for (const Finding& f : found.all()) {
        if (f.complaint) {
          print_complaints(f);
        } else {
          fmt::print("ok     {:<8} {}: {}\n", f.what, f.file, f.facts);
        }
      }
    }
    std::fflush(stdout);
    for (const Warning& w : found.warnings()) fmt::print(stderr, "airside: warning: {}: {}\n", w.file, w.text);
    if (found.failed() != 0) {
      throw std::runtime_error(
          fmt::format("{} of {} checked things are not in order{}", found.failed(), found.all().size(),
                      found.complaints() == found.failed() ? "" : fmt::format(", {} complaints", found.complaints())));
    }
    if (strict && !found.warnings().empty()) {
      throw std::runtime_error(fmt::format("{} warnings, and --strict", found.warnings().size()));
    }
  }
};

}  // namespace

void add_check(CLI::App& app) {
  auto self = std::make_shared<CheckCommand>();
  CLI::App* c =
      app.add_subcommand("check",
                         "read everything that a site file names, and anything else given, and say what is in "
                         "order and what is not.\nWhat is in order and seldom meant, such as register 40001, is a "
                         "warning on standard error.");
  c->add_option("site", self->site, "site file (default: site.toml, if nothing else is given)");
  c->add_option("--topology", self->topology, "room shape where no site file says it")
      ->check(a_topology())
      ->capture_default_str();
  c->add_option("--points", self->points, "a point map");
  c->add_option("--weights", self->weights, "weight blobs")->allow_extra_args(false);
  c->add_option("--log", self->logs, "CSV logs, or folders of them")->allow_extra_args(false);
  c->add_option("--twin", self->twin,
                "a model (.idf, .epJSON): without a site, and unless it has airside's own names, all that `airside "
                "adopt` checks before it runs the\nengine; beside a site an epJSON model; without a file, the site's "
                "[twin] runs for a day")
      ->expected(0, 1);
  c->add_option("--air-loop", self->air_loop, "which AirLoopHVAC of --twin, where the model has several");
  c->add_option("--patch", self->patches, "merge patches on the model, in order")->allow_extra_args(false);
  c->add_option("--weather", self->weather, "an EPW file");
  c->add_option("--room-file", self->room, "a room of the RC plant (.json)");
  c->add_flag("--strict", self->strict, "exit code 1 for warnings too");
  c->add_flag("--json", self->as_json, "print one JSON object and nothing else on standard output");
  c->callback([self, c] {
    self->try_site_twin = c->count("--twin") > 0 && self->twin.empty();
    self->run();
  });
}

}  // namespace airside::tools
