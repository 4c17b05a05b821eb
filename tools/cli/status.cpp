// airside status: the box's status.json in plain sentences.

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "airside/fault.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/storage/store_error.hpp"
#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double old_after_s = 900;  ///< the box writes every 6 min

/// status.json of a file, a state folder or a site file.
fs::path snapshot_of(const std::string& given) {
  fs::path path = given;
  std::error_code unseen;
  // A folder of `airside init`, where somebody means the site.
  if (!fs::exists(path / "status.json", unseen) && fs::exists(path / "site.toml", unseen)) path /= "site.toml";
  if (path.extension() == ".toml") path = hal::read_site_file(path.string(), hal::site_rules()).state_dir;
  std::error_code ignored;
  if (path.extension() != ".json" || fs::is_directory(path, ignored)) path /= "status.json";
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (failed == std::errc::permission_denied || (fs::exists(status) && ::access(path.c_str(), R_OK) != 0)) {
    throw hal::InputError(path.string(), "no permission to read it", "a status that this user may read",
                          "run it as root, as the user airside, or as a member of the group airside");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw hal::InputError(path.string(), "no regular file", "the status that airsided writes every 6 min",
                          "take it away; airsided writes a new one with its next row");
  }
  if (!fs::exists(status)) {
    throw hal::InputError(path.string(), "no such file", "the status that airsided writes every 6 min",
                          "give its state folder or site file, and see that airsided runs (systemctl status airsided)");
  }
  return path;
}

/// The object's members, with a complaint instead of an exception of the JSON library.
class Snapshot {
 public:
  explicit Snapshot(const fs::path& path) : path_(path.string()), object_(sim::read_json(path)) {
    if (!object_.is_object()) refuse("", object_.dump().substr(0, 40), "one JSON object");
    for (const char* name : {"time", "site", "state", "fault", "storage"}) text(name);
    for (const char* name : {"cycles", "rejected_updates", "replay_transitions", "generation"}) count(name);
  }

  std::string text(const char* name) const {
    const json& v = member(name);
    if (!v.is_string()) refuse(name, v.dump(), "a text");
    return v.get<std::string>();
  }
  /// Nothing for null.
  std::optional<double> number(const char* name) const { return number(name, member(name)); }
  /// Nothing for null, and where an older daemon has no such member.
  std::optional<double> optional_number(const char* name) const {
    return object_.contains(name) ? number(name) : std::nullopt;
  }
  std::uint64_t count(const char* name) const {
    const json& v = member(name);
    if (!v.is_number_unsigned()) refuse(name, v.dump(), "a count");
    return v.get<std::uint64_t>();
  }
  bool flag(const char* name) const {
    const json& v = member(name);
    if (!v.is_boolean()) refuse(name, v.dump(), "true or false");
    return v.get<bool>();
  }
  std::vector<std::optional<double>> numbers(const char* name) const {
    const json& v = member(name);
    if (!v.is_array()) refuse(name, v.dump(), "a list of numbers");
    std::vector<std::optional<double>> out;
    for (const json& entry : v) out.push_back(number(name, entry));
    return out;
  }
  const json& object() const { return object_; }

 private:
  [[noreturn]] void refuse(const char* name, const std::string& found, const char* expected) const {
    throw hal::InputError(*name == '\0' ? path_ : path_ + ": " + name, found, expected,
                          "wait for airsided to write it anew, within 6 min; it replaces the file whole");
  }
  const json& member(const char* name) const {
    const auto at = object_.find(name);
    if (at == object_.end()) refuse(name, "nothing", "a status of airsided with this member");
    return *at;
  }
  std::optional<double> number(const char* name, const json& v) const {
    if (v.is_null()) return {};
    if (!v.is_number()) refuse(name, v.dump(), "a number or null");
    return v.get<double>();
  }

  std::string path_;
  json object_;
};

std::string span_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  if (seconds < 172800) return fmt::format("{:.0f} h", seconds / 3600);
  return fmt::format("{:.0f} days", seconds / 86400);
}

double age_s(const fs::path& path) {
  return std::chrono::duration<double>(fs::file_time_type::clock::now() - fs::last_write_time(path)).count();
}

/// What airsided does, as far as its status tells: a word for programs, an exit code for scripts.
struct Condition {
  const char* word;
  int exit_code;
};
constexpr Condition running{"running", 0}, stopped{"stopped", 3}, stale{"stale", 4}, alarmed{"alarm", 5};

/// A status from the future is as old as one from the past: a clock was set.
bool is_old(double age) { return std::abs(age) > old_after_s; }

Condition condition_of(const Snapshot& s, double age) {
  if (s.object().value("stopped", json(false)) == json(true)) return stopped;
  if (is_old(age)) return stale;
  const json alarms = s.object().value("alarms", json::array());
  return alarms.is_array() && !alarms.empty() ? alarmed : running;
}

std::string state_text(const Snapshot& s, const Condition& condition) {
  const std::string state = s.text("state"), fault = s.text("fault"), signal = s.text("fault_signal");
  const bool runs = condition.exit_code == running.exit_code || condition.exit_code == alarmed.exit_code;
  const auto tense = [runs](const char* now, const char* then) { return runs ? now : then; };
  std::string text;
  if (condition.exit_code == stopped.exit_code) {
    text = "airsided has stopped in order, at " + s.text("stopped_at") +
           " of the site's clock; nothing is written to the AHU since.\nThe last row: ";
  }
  if (condition.exit_code == stale.exit_code) {
    text = "This is old: airsided writes every 6 min, so it is not running or cannot write.\nThe last row: ";
  }
  if (runs && fault == "no reading" && state != "release") {
    return text + "The AHU does not answer; what is written does not arrive. Look at cable, power, address and port.";
  }
  const std::string first_row = s.object().value("first_row", "");
  if (runs && !first_row.empty()) text = "airsided has started; its first row is at " + first_row + ". ";
  text += state == "learn"     ? tense("It controls and goes on learning", "It controlled and went on learning")
          : state == "run"     ? tense("It controls with frozen weights", "It controlled with frozen weights")
          : state == "expert"  ? tense("It follows the expert's schedule", "It followed the expert's schedule")
          : state == "release" ? tense("It writes nothing: the AHU is released to its own control",
                                       "It wrote nothing: the AHU was released to its own control")
                               : "Its state is \"" + state + '"';
  if (s.text("reason") != "none") text += ": " + s.text("why") + " (" + s.text("way_out") + ")";
  if (fault != "none") return text + ". Fault: " + fault + (signal.empty() ? "." : " at " + signal + '.');
  return text + "; no fault.";
}

/// Every alarm that is up, with the time since when; empty without any.
std::string alarms_text(const Snapshot& s) {
  std::string text;
  for (const json& alarm : s.object().value("alarms", json::array())) {
    if (!alarm.is_object() || !alarm.contains("reason") || !alarm.contains("since")) continue;
    text += (text.empty() ? "Alarms: " : "; ") + alarm.value("reason", "") + " since " + alarm.value("since", "");
  }
  return text.empty() ? text : text + '.';
}

std::string shadows_text(const Snapshot& s) {
  const auto expert = s.number("expert_setpoint_degc"), g36 = s.number("g36_setpoint_degc");
  if (!expert || !g36) return "";
  std::string text = fmt::format("Now the schedule would set {:.2f} degC, Guideline 36 {:.2f} degC.", *expert, *g36);
  const auto ours = s.number("mean_error_k"), schedule = s.number("schedule_mean_error_k");
  if (ours && schedule && *schedule > 0) {
    text += fmt::format(
        " In the last working hours the rooms' mean was {:.2f} K off; under the schedule it would have been {:.2f} K.",
        *ours, *schedule);
  }
  return text;
}

std::string pushed_text(const Snapshot& s) {
  const std::string state = s.text("pushed_weights"), refusal = s.text("pushed_refusal");
  std::string text =
      state == "none" ? "No weights have been pushed" : "Pushed weights " + s.text("pushed_crc") + ": " + state;
  const bool waits = refusal == text_of(Fault::state_invalid);  // no copy of the weights before can be written
  if (refusal == text_of(Fault::no_way_back)) {
    text += "; the weights before cannot be read, so there is no rollback to them";
  } else if (refusal != "none") {
    text += waits ? "; a blob waits in the inbox: " : "; the last blob was refused: ";
    text += refusal + " (" + s.text("pushed_refusal_field") + ")";
  }
  return text + '.';
}

bool serves_band(const Snapshot& s) { return s.object().value("objective", "") == "band"; }

/// Of the objective "band", which has no target of its own.
std::string zones_text(const Snapshot& s, const std::string& rooms) {
  const auto above = s.number("warmest_zone_above_setpoint_k"), open = s.number("most_open_damper");
  std::string text = rooms.empty() ? "No zone temperature is known now." : fmt::format("Zones: {} degC", rooms);
  if (rooms.empty()) return text;
  if (above)
    text +=
        fmt::format("; the warmest is {:.2f} K {} its own setpoint", std::abs(*above), *above > 0 ? "above" : "below");
  if (open) text += fmt::format("; the most open damper stands at {:.0f} %", 100 * *open);
  return text + '.';
}

std::string rooms_text(const Snapshot& s) {
  std::string rooms;
  for (const auto& value : s.numbers("room_temp_degc")) {
    rooms += (rooms.empty() ? "" : ", ") + (value ? fmt::format("{:.2f}", *value) : std::string("no value"));
  }
  const auto held = s.number("held_degc"), target = s.number("target_degc");
  const std::string rule = s.text("hold");
  const char* of = rule == "weighted" ? "weighted mean" : rule == "middle" ? "middle of warmest and coldest" : "mean";
  if (serves_band(s)) return zones_text(s, rooms);
  if (rooms.empty()) return "No room temperature is known now.";
  if (!held || !target) return fmt::format("Rooms: {} degC; their {} is not known.", rooms, of);
  const double off = *held - *target;
  const std::string side = std::abs(off) < 0.005
                               ? std::string("on the target")
                               : fmt::format("{:.2f} K {} the target", std::abs(off), off > 0 ? "above" : "below");
  return fmt::format("The rooms' {} is {:.2f} degC, {} of {:.2f} degC (rooms: {}).", of, *held, side, *target, rooms);
}

/// What the residual network adds, where it has something to say.
std::string residual_text(const Snapshot& s) {
  const auto forecast = s.optional_number("residual_forecast_k"), share = s.optional_number("residual_share");
  if (!forecast || !share) return "";
  return fmt::format(" The residual network expects {:.2f} K {} than the room head does; {} of it counts.",
                     std::abs(*forecast), *forecast < 0 ? "less" : "more",
                     *share <= 0  ? "none"
                     : *share < 1 ? "half"
                                  : "all");
}

std::string setpoint_text(const Snapshot& s) {
  const auto applied = s.number("setpoint_degc"), network = s.number("network_setpoint_degc");
  const auto head = s.number("head_setpoint_degc"), expert = s.number("expert_setpoint_degc");
  if (!applied) return "The supply-air setpoint is not known.";
  std::string wishes;
  const auto wish = [&wishes](const char* who, const std::optional<double>& value) {
    if (value) wishes += fmt::format("{}{} {:.2f}", wishes.empty() ? "" : ", ", who, *value);
  };
  wish("network", network);
  wish("room head", head);
  wish("schedule", expert);
  std::string text = fmt::format("The supply-air setpoint is {:.2f} degC", *applied);
  if (!wishes.empty()) text += " (proposed: " + wishes + ')';
  if (const auto expected = s.number("expected_held_degc")) {
    text += fmt::format("; it expects them at {:.2f} degC by the end of the cycle", *expected);
    if (const auto error = s.optional_number("expected_error_k")) {
      text += fmt::format(" (lately wrong by {:.2f} K)", *error);
    }
  }
  return text + '.' + residual_text(s);
}

std::string learning_text(const Snapshot& s) {
  std::string text;
  if (serves_band(s)) {
    const std::uint64_t learned = s.count("band_cycles"), needed = s.count("band_ready_cycles");
    return fmt::format(
        "Least energy with every zone in its band: {} cycles learned, {}. {} decisions so far.", learned,
        learned < needed ? fmt::format("the schedule holds until {}", needed) : fmt::format("{} were needed", needed),
        s.count("cycles"));
  }
  if (const auto confidence = s.number("confidence")) {
    text = fmt::format("Confidence in its own forecast is {:.2f} of 1. ", *confidence);
  }
  return text +
         fmt::format("{} decisions so far; {} transitions remembered; {} updates refused by the acceptance gate.",
                     s.count("cycles"), s.count("replay_transitions"), s.count("rejected_updates"));
}

std::string link_text(const Snapshot& s) {
  if (s.text("fault") == "no reading") return "";
  const std::uint64_t timeouts = s.count("link_timeouts"), frames = s.count("link_bad_frames");
  const std::uint64_t ids = s.count("link_wrong_ids"), exceptions = s.count("link_exceptions");
  if (timeouts + frames + ids + exceptions == 0) return "The link to the AHU has had no error.";
  return fmt::format("The link to the AHU has had {} timeouts, {} damaged frames, {} foreign answers, {} refusals.",
                     timeouts, frames, ids, exceptions);
}

std::string storage_text(const Snapshot& s) {
  const std::string storage = s.text("storage");
  const std::uint64_t generation = s.count("generation");
  if (storage == "ok") return fmt::format("Storage is in order, generation {}.", generation);
  const std::string text = fmt::format("Storage: {} (generation {})", storage, generation);
  for (int i = 1; i <= static_cast<int>(hal::StoreFault::wrong_kind); ++i) {
    const auto fault = static_cast<hal::StoreFault>(i);
    if (storage == hal::text_of(fault)) return text + "; " + hal::remedy_of(fault) + '.';
  }
  return text + '.';
}

/// The whole text at once, so that a damaged snapshot prints nothing but the complaint.
std::string sentences(const Snapshot& s, double age, const Condition& condition) {
  std::string text = fmt::format("{} ({})\n", s.text("site"), s.text("topology"));
  for (const std::string& line : {state_text(s, condition), alarms_text(s), rooms_text(s), setpoint_text(s),
                                  shadows_text(s), learning_text(s), pushed_text(s)}) {
    if (!line.empty()) text += line + '\n';
  }
  text += storage_text(s) + '\n';
  const std::string clock = s.object().value("clock", json("ok")).get<std::string>();
  if (clock != "ok") text += "The plant's clock, within the last day: " + clock + ".\n";
  const std::string link = link_text(s);
  text += link.empty() ? link : link + '\n';
  text += fmt::format("Written {} ago, at {} of the site's clock.\n", span_text(std::max(0.0, age)), s.text("time"));
  return text;
}

struct StatusCommand {
  std::string path = "/var/lib/airside";
  bool as_json = false;

  void run() const {
    const fs::path file = snapshot_of(path);
    const Snapshot snapshot(file);
    const double age = age_s(file);
    const Condition condition = condition_of(snapshot, age);
    if (as_json) {
      json object = snapshot.object();
      object["condition"] = condition.word;
      object["age_s"] = std::round(age);
      fmt::print("{}\n", object.dump(-1, ' ', false, json::error_handler_t::replace));
    } else {
      fmt::print("{}", sentences(snapshot, age, condition));
    }
    if (condition.exit_code != 0) throw CLI::RuntimeError(condition.exit_code);
  }
};

}  // namespace

std::string status_sentences(const std::string& path) {
  const fs::path file = snapshot_of(path);
  const Snapshot snapshot(file);
  const double age = age_s(file);
  return sentences(snapshot, age, condition_of(snapshot, age));
}

void add_status(CLI::App& app) {
  auto self = std::make_shared<StatusCommand>();
  CLI::App* c = app.add_subcommand("status", "what the box is doing, in plain sentences");
  c->add_option("path", self->path, "status.json, a state folder, or a site file")->capture_default_str();
  c->add_flag("--json", self->as_json,
              "print the status as one JSON object and nothing else, with its age_s, and condition: running, stopped,\n"
              "stale or alarm");
  c->footer(
      "Exit codes: 0 it runs and no alarm is up, 1 no status that can be read, 2 bad command line,\n"
      "3 it has stopped in order, 4 the status is old (more than 15 min): it does not run or cannot write,\n"
      "5 it runs and an alarm is up.");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
