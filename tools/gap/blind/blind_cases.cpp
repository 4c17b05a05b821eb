#include "tools/gap/blind/blind_cases.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "hal/text/input_error.hpp"
#include "tools/gap/blind/blind_draw.hpp"
#include "tools/gap/blind/blind_plan.hpp"
#include "tools/gap/blind/blind_site.hpp"
#include "tools/gap/case/case_format.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;

struct MadeCase {
  DrawnCase drawn;
  ShownLive live;
};

class Generator {
 public:
  Generator(const BlindPlan& plan, const std::vector<sim::Effect>& effects, const fs::path& folder,
            std::function<void()> done)
      : plan_(plan), effects_(effects), folder_(folder), done_(std::move(done)) {
    write_window_weather(folder, plan.seed);
    std::map<bool, std::set<BlindWindow>> wanted;
    for (int i = 0; i < plan.total(); ++i) {
      const PlannedCase c = planned_case(plan, i);
      wanted[c.energyplus].insert(c.window);
    }
    for (const auto& [energyplus, some] : wanted) {
      auto& site = energyplus ? energyplus_ : rc_;
      site = energyplus ? make_energyplus_site(setup()) : make_rc_site(setup());
      for (const std::string& kind : plan.kinds) {
        if (!site->kinds().contains(kind))
          throw hal::InputError("the effect " + kind, "that nobody can hide there", "one of airside gap effects",
                                "name another");
      }
      site->prepare({some.begin(), some.end()});
    }
  }

  /// Chooses what is hidden and writes the logs. Thread-safe.
  MadeCase make(int i, const PlannedCase& c, const std::string& name) const {
    const BlindSite& site = c.energyplus ? *energyplus_ : *rc_;
    MadeCase made{drawn_case(plan_, site, i, c), {}};
    std::vector<Hidden> hidden;
    for (const Sized& one : made.drawn.hidden) hidden.push_back(one.hidden);
    const BlindLogs logs = site.live(hidden, c.window, seed_of_case(plan_.seed, i));
    if (c.window.feedback && !hidden.empty()) made.live = site.shown_live(logs, c.window, seed_of_case(plan_.seed, i));
    write(c, folder_ / name, logs, site.counts());
    return made;
  }

 private:
  BlindSetup setup() const {
    BlindSetup setup = setup_of(plan_, effects_, folder_);
    setup.done = done_;
    return setup;
  }

  void write(const PlannedCase& c, const fs::path& folder, const BlindLogs& logs,
             const hal::TopologyCounts& counts) const {
    fs::create_directories(folder);
    CaseDescription description;
    description.engine = c.energyplus ? "energyplus" : "rc";
    description.model = plan_.twin;
    description.weather = fmt::format("../weather/{}.epw", c.window.number + 1);
    description.reference_log = "reference.csv";
    description.measured_log = "measured.csv";
    description.window = fmt::format("{}{}", c.window.number + 1, c.window.feedback ? "f" : "s");
    // Fan coils that a schedule drives say nothing of thermostats.
    description.duties = !c.energyplus || c.window.feedback;
    const auto log = [&](const std::string& file, const std::vector<hal::LogRow>& rows) {
      hal::LogWriter writer((folder / file).string(), counts, false);
      for (const hal::LogRow& row : rows) writer.append(row);
      writer.close();
    };
    log(description.reference_log, logs.reference);
    log(description.measured_log, logs.measured);
    write_case(folder, description);
  }

  const BlindPlan& plan_;
  const std::vector<sim::Effect>& effects_;
  fs::path folder_;
  std::function<void()> done_;
  std::unique_ptr<BlindSite> rc_, energyplus_;
};

nlohmann::json finite_or_null(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(); }

nlohmann::json key_of(const std::vector<Sized>& list, const std::vector<sim::Effect>& effects) {
  nlohmann::json j = nlohmann::json::array();
  for (const Sized& one : list) {
    j.push_back({{"id", id_of(one.hidden, effects)},
                 {"magnitude", one.hidden.magnitude},
                 {"achieved_ratio", finite_or_null(one.shown.ratio)},
                 {"shows_in", one.shown.channel}});
  }
  return j;
}

nlohmann::json key_entry(const PlannedCase& c, const MadeCase& made, const std::vector<sim::Effect>& effects) {
  const char* engine = c.energyplus ? "energyplus" : "rc";
  nlohmann::json entry = {{"set", c.set},
                          {"engine", engine},
                          {"workflow", engine},
                          {"feedback", c.window.feedback},
                          {"window", c.window.number},
                          {"ratio", c.ratio},
                          {"hidden", key_of(made.drawn.hidden, effects)}};
  for (const auto& [kind, shown] : made.live)
    entry["live"][kind] = {{"ratio", shown.ratio}, {"channel", shown.channel}};
  if (!made.drawn.not_reached.empty()) entry["not_reached"] = key_of(made.drawn.not_reached, effects);
  return entry;
}

}  // namespace

void forget_time(const fs::path& path) {
  const fs::file_time_type then{fs::file_time_type::clock::from_sys(
      std::chrono::sys_seconds{std::chrono::sys_days{std::chrono::year{2021} / std::chrono::December / 1}})};
  fs::last_write_time(path, then);
}

void make_blind_cases(const BlindPlan& plan, const std::vector<sim::Effect>& effects, const fs::path& folder,
                      const fs::path& key, const std::function<void()>& done) {
  std::error_code failed;
  if (fs::exists(folder) && !fs::is_empty(folder, failed)) {
    throw hal::InputError(folder.string(), "a folder that is not empty", "a new folder for the cases",
                          "name another with -o");
  }
  const fs::path inside = fs::weakly_canonical(key).lexically_relative(fs::weakly_canonical(folder));
  if (!inside.empty() && *inside.begin() != "..") {
    throw hal::InputError("--key " + key.string(), "a file in the folder of the cases", "a file outside it",
                          "whoever sees the cases must not see the key");
  }
  const Generator generator(plan, effects, folder, done);
  nlohmann::json answers = {{"format", 1}, {"seed", plan.seed}, {"cases", nlohmann::json::object()}};
  const std::vector<int> order = in_order_of_name(plan.seed, plan.total());
  std::mutex mutex;
  in_parallel(order.size(), plan.jobs, [&](std::size_t n) {
    const int i = order[n];
    const PlannedCase c = planned_case(plan, i);
    const std::string name = fmt::format("case-{:04}", n + 1);
    const MadeCase made = generator.make(i, c, name);
    const std::lock_guard lock(mutex);
    answers["cases"][name] = key_entry(c, made, effects);
    if (done) done();
  });
  std::vector<fs::path> all{folder};
  for (const auto& entry : fs::recursive_directory_iterator(folder)) all.push_back(entry.path());
  for (const fs::path& path : all) forget_time(path);
  std::ofstream out(key);
  out << answers.dump(1) << '\n';
  if (!out)
    throw hal::InputError("--key " + key.string(), "a file that cannot be written", "a writable path",
                          "choose another");
}

}  // namespace airside::tools::gap
