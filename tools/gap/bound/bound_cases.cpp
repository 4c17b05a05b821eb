#include "tools/gap/bound/bound_cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/epw.hpp"
#include "tools/gap/case/case_loader.hpp"
#include "tools/gap/model/log_window.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Periods of a case, in the order of a file.
struct BoundTables {
  Json about;
  std::vector<Eigen::MatrixXd> periods;
};

fs::path file_of(const fs::path& folder, const std::string& name, const char* ending) {
  return folder / (name + ending);
}

void write_tables(const fs::path& folder, const std::string& name, Json head, const std::vector<BoundTables>& cases,
                  const BoundColumns& columns) {
  const fs::path whole = file_of(folder, name, ".bin"), part = file_of(folder, name, ".bin.part");
  std::ofstream out(part, std::ios::binary);
  head["format"] = 1;
  head["columns"] = columns.names;
  head["units_per_step"] = columns.units_per_step;
  head["bins"] = cases.empty() ? 0 : cases.front().periods.front().rows();
  for (const BoundTables& c : cases) {
    head["cases"].push_back(c.about);
    for (const Eigen::MatrixXd& period : c.periods) {
      for (const std::int16_t step : steps_of(period, columns)) {
        const auto bits = static_cast<std::uint16_t>(step);
        const char bytes[] = {static_cast<char>(bits & 0xFFU), static_cast<char>(bits >> 8U)};
        out.write(bytes, sizeof bytes);
      }
    }
  }
  out.close();
  std::ofstream text(file_of(folder, name, ".json.part"));
  text << head.dump(1) << '\n';
  text.close();
  if (!out || !text)
    throw hal::InputError(whole.string(), "a file that cannot be written", "room on the disk", "name another folder");
  fs::rename(part, whole);
  fs::rename(file_of(folder, name, ".json.part"), file_of(folder, name, ".json"));  // last: it says that all is there
}

/// Of what recording rows show.
template <class Value>
double mean_of_bin(const sim::Recording& recording, Eigen::Index bin, Value&& value) {
  double sum = 0;
  for (Eigen::Index r = bin * rows_per_bin; r < (bin + 1) * rows_per_bin; ++r)
    sum += value(recording.rows[static_cast<std::size_t>(r)]);
  return sum / rows_per_bin;
}

/// One seed of the generator.
class Drawing {
 public:
  Drawing(const BoundPlan& bound, std::uint64_t seed, const std::map<bool, Eigen::VectorXd>& noise,
          const std::vector<sim::Effect>& effects, const fs::path& weather_folder)
      : effects_(effects), folder_(weather_folder), engine_(sim::load_room(bound.twin)) {
    plan_.single = bound.cases;
    plan_.seed = seed;
    plan_.twin = bound.twin;
    plan_.days = bound.days;
    plan_.jobs = 1;
    plan_.rough = bound.rough;
    write_window_weather(folder_, seed);
    BlindSetup setup = setup_of(plan_, effects_, folder_);
    setup.noise = noise;
    site_ = make_rc_site(setup);
    std::vector<BlindWindow> windows;
    for (int i = 0; i < plan_.total(); ++i) windows.push_back(planned_case(plan_, i).window);
    std::sort(windows.begin(), windows.end());
    windows.erase(std::unique(windows.begin(), windows.end()), windows.end());
    site_->prepare(windows);
    for (int w = 0; w < blind_windows; ++w) weather_.push_back(sim::read_epw(weather_of_window(folder_, w).string()));
  }

  BoundTables case_of(int i) const {
    const PlannedCase c = planned_case(plan_, i);
    const Sized one = drawn_case(plan_, *site_, i, c).hidden.front();
    const std::uint64_t seed = seed_of_case(plan_.seed, i);
    const BlindLogs logs = site_->live({one.hidden}, c.window, seed);
    const auto without = site_->lived_on({}, c.window, seed, plan_.days, nullptr);
    BoundTables tables;
    tables.about = {{"id", id_of(one.hidden, effects_)},
                    {"effect", one.hidden.effect},
                    {"place", one.hidden.place},
                    {"magnitude", one.hidden.magnitude},
                    {"ratio", c.ratio},
                    {"achieved_ratio", one.shown.ratio},
                    {"shows_in", one.shown.channel},
                    {"feedback", c.window.feedback},
                    {"window", c.window.number}};
    for (const auto* rows : {&logs.reference, &logs.measured, &without}) {
      tables.periods.push_back(bound_table(
          engine_, window_of(*rows, engine_.channels(), weather_[static_cast<std::size_t>(c.window.number)], "drawn")));
    }
    return tables;
  }

 private:
  const std::vector<sim::Effect>& effects_;
  fs::path folder_;
  RcEngine engine_;
  BlindPlan plan_;
  std::unique_ptr<BlindSite> site_;
  std::vector<std::shared_ptr<const sim::Weather>> weather_;
};

void make_folder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw hal::InputError(folder.string(), failed.message(), "a folder to write to", "name another with -o");
}

}  // namespace

BoundColumns bound_columns(const sim::Channels& channels) {
  BoundColumns columns;
  const auto add = [&columns](std::string name, double step) {
    columns.names.push_back(std::move(name));
    columns.units_per_step.push_back(step);
  };
  for (int k = 0; k < channels.count(); ++k) add(channels.name(k), 0.001);
  add("setpoint_degc", 0.01);
  add("outdoor_temp_degc", 0.01);
  add("sun_w_m2", 0.1);
  add("rain", 0.001);
  add("humidity_ratio_g_kg", 0.01);
  add("supply_less_setpoint_k", 0.001);
  for (int v = 0; v < channels.rooms; ++v) add(fmt::format("vav_on_{}", v + 1), 0.001);
  for (int f = 0; f < channels.fcus; ++f) add(fmt::format("fcu_on_{}", f + 1), 0.001);
  return columns;
}

Eigen::MatrixXd bound_table(const Engine& engine, const Window& window) {
  const sim::Channels channels = engine.channels();
  const sim::Recording& recording = window.recording;
  Eigen::MatrixXd table(window.measured.rows(), std::ssize(bound_columns(channels).names));
  table.leftCols(channels.count()) = window.measured - binned(engine.simulate({}, recording), channels);
  for (Eigen::Index b = 0; b < table.rows(); ++b) {
    const auto mean = [&](auto&& value) { return mean_of_bin(recording, b, value); };
    const CivilTime middle{recording.time(static_cast<std::size_t>(b * rows_per_bin)).seconds +
                           row_s * rows_per_bin / 2};
    const sim::WeatherRecord station = recording.station->at(middle);
    Eigen::Index k = channels.count();
    table(b, k++) = mean([](const sim::RecordedRow& row) { return row.setpoint_degc; });
    table(b, k++) = mean([](const sim::RecordedRow& row) { return row.outdoor_temp_degc; });
    table(b, k++) = station.global_horizontal_w_m2;
    table(b, k++) = mean([](const sim::RecordedRow& row) { return row.rain; });
    table(b, k++) =
        1000 * sim::humidity_ratio(station.outdoor_temp_degc, station.relative_humidity_pct, station.pressure_pa);
    table(b, k++) = window.measured(b, channels.supply_temp()) - table(b, channels.count());
    for (std::size_t v = 0; v < static_cast<std::size_t>(channels.rooms); ++v)
      table(b, k++) = mean([v](const sim::RecordedRow& row) { return row.vav_on[v]; });
    for (std::size_t f = 0; f < static_cast<std::size_t>(channels.fcus); ++f)
      table(b, k++) = mean([f](const sim::RecordedRow& row) { return row.fcu_on[f]; });
  }
  return table;
}

std::vector<std::int16_t> steps_of(const Eigen::MatrixXd& table, const BoundColumns& columns) {
  std::vector<std::int16_t> steps;
  steps.reserve(static_cast<std::size_t>(table.size()));
  for (Eigen::Index k = 0; k < table.cols(); ++k) {
    for (Eigen::Index b = 0; b < table.rows(); ++b) {
      const double x = table(b, k) / columns.units_per_step[static_cast<std::size_t>(k)];
      steps.push_back(std::isfinite(x) ? static_cast<std::int16_t>(std::lround(std::clamp(x, -32767.0, 32767.0)))
                                       : std::numeric_limits<std::int16_t>::min());
    }
  }
  return steps;
}

std::map<bool, Eigen::VectorXd> bound_noise(const BoundPlan& plan, const std::vector<sim::Effect>& effects,
                                            const fs::path& folder, const std::function<void()>& done) {
  make_folder(folder);
  const fs::path file = folder / "noise";
  const char* names[] = {"without_feedback", "with_feedback"};
  std::map<bool, Eigen::VectorXd> noise;
  if (fs::exists(file)) {
    const Json j = sim::read_json(file.string());
    for (const bool feedback : {false, true}) {
      const auto list = j.at(names[feedback ? 1 : 0]).get<std::vector<double>>();
      noise[feedback] = Eigen::Map<const Eigen::VectorXd>(list.data(), std::ssize(list));
    }
    return noise;
  }
  BlindPlan blind;
  blind.seed = plan.first_seed;
  blind.twin = plan.twin;
  blind.days = plan.days;
  blind.jobs = plan.jobs;
  const fs::path weather = folder / "weather-of-noise";
  write_window_weather(weather, plan.first_seed);
  BlindSetup setup = setup_of(blind, effects, weather);
  setup.done = done;
  noise = usual_rc_noise(setup);
  Json j = {{"seed", plan.first_seed}};
  for (const auto& [feedback, sd] : noise) j[names[feedback ? 1 : 0]] = std::vector<double>(sd.begin(), sd.end());
  std::ofstream(file) << j.dump(1) << '\n';
  fs::remove_all(weather);
  return noise;
}

int make_bound_tables(const BoundPlan& plan, const std::map<bool, Eigen::VectorXd>& noise,
                      const std::vector<sim::Effect>& effects, const fs::path& folder,
                      const std::function<void()>& done) {
  make_folder(folder);
  std::vector<std::uint64_t> seeds;
  for (int d = 0; d < plan.drawings; ++d) {
    const std::uint64_t seed = plan.first_seed + static_cast<std::uint64_t>(d);
    if (!fs::exists(file_of(folder, std::to_string(seed), ".json"))) {
      seeds.push_back(seed);
      continue;
    }
    for (int i = 0; i < plan.cases && done; ++i) done();
  }
  const RcEngine engine(sim::load_room(plan.twin));
  const BoundColumns columns = bound_columns(engine.channels());
  in_parallel(seeds.size(), plan.jobs, [&](std::size_t s) {
    const std::string name = std::to_string(seeds[s]);
    const fs::path weather = folder / ("weather-of-" + name);
    std::vector<BoundTables> cases;
    {
      const Drawing drawing(plan, seeds[s], noise, effects, weather);
      for (int i = 0; i < plan.cases; ++i) {
        cases.push_back(drawing.case_of(i));
        if (done) done();
      }
    }
    const Json head = {{"seed", seeds[s]},
                       {"days", plan.days},
                       {"twin", plan.twin},
                       {"periods", {"reference", "measured", "without"}}};
    write_tables(folder, name, head, cases, columns);
    fs::remove_all(weather);
  });
  return static_cast<int>(seeds.size());
}

void make_bound_tables_of(const fs::path& cases, const fs::path& key, const fs::path& folder, const std::string& name,
                          int jobs, const std::function<void()>& done) {
  make_folder(folder);
  const Json answers = sim::read_json(key.string());
  const std::vector<fs::path> folders = case_folders(cases);
  std::vector<BoundTables> tables(folders.size());
  BoundColumns columns;
  in_parallel(folders.size(), jobs, [&](std::size_t n) {
    const std::string of = folders[n].filename().string();
    if (!answers.contains("cases") || !answers["cases"].contains(of))
      throw hal::InputError(key.string(), "no answer for " + of, "the key that was drawn with these cases",
                            "name it with --key");
    const LoadedCase c = load_case(read_case(folders[n]), of, {});
    const Json& answer = answers["cases"][of];
    const Json hidden = answer["hidden"].empty() ? Json{{"id", "nothing"}, {"magnitude", 0}} : answer["hidden"][0];
    tables[n].about = hidden;
    tables[n].about["case"] = of;
    for (const char* word : {"set", "ratio", "feedback", "window"}) tables[n].about[word] = answer[word];
    tables[n].periods = {bound_table(*c.engine, c.data.reference), bound_table(*c.engine, c.data.test)};
    if (n == 0) columns = bound_columns(c.engine->channels());
    if (done) done();
  });
  write_tables(folder, name, {{"seed", answers.value("seed", 0)}, {"periods", {"reference", "measured"}}}, tables,
               columns);
}

}  // namespace airside::tools::gap
