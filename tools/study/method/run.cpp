#include "tools/study/method/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "hal/text/civil_text.hpp"
#include "hal/text/staged_file.hpp"
#include "tools/run/training/pretraining.hpp"
#include "tools/run/training/transfer.hpp"
#include "tools/study/method/forecast_check.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

constexpr const char* first_controlled_day = "2021-08-21";
constexpr const char* first_twin_day = "2021-07-01";
constexpr const char* first_operated_day = "2021-06-01";
constexpr const char* first_winter_day = "2021-01-05";
constexpr int first_days = 3;

std::string day_text(const std::string& day, int later) {
  PlantChoice at;
  at.start = day;
  return hal::civil_text({start_of(at).seconds + later * seconds_per_day}).substr(0, 10);
}

Site site_of(const MethodRow& row, std::uint64_t seed) {
  Site site =
      built_in_site("5vav-5fcu-2power", row.is_product ? hal::ControllerPreset::product : hal::ControllerPreset::paper);
  site.settings = method_settings(site.settings, row);
  site.file.seed = seed;
  return site;
}

PlantChoice choice_of(const MethodStudy& study, const std::string& room, std::uint64_t seed, const std::string& start) {
  PlantChoice c;
  c.kind = study.kind;
  c.room = room;
  c.seed = seed;
  c.start = start;
  if (!study.environment.empty()) {
    c.environment = study.environment;
    c.start = study.environment_from;
  }
  return c;
}

double mean_of(std::span<const double> values) { return spread_of(values).mean; }

/// What a cycle's length changes beside the figures of all rows: the errors of its forecasts, DAE over all rows of 6
/// min, and how far the mean room temperature swings.
void add_cycle_figures(nlohmann::json& j, const Site& site, const ControlRun& run) {
  const MetricsSettings scored = metrics_settings(site);
  std::vector<double> forecast_k, error_k, mean_degc;
  for (const CycleSample& c : run.cycles) {
    const double wrong_k = std::isfinite(c.head_error_k) ? c.head_error_k : c.network_error_k;
    if (is_scored(c.time, scored) && std::isfinite(wrong_k)) forecast_k.push_back(std::abs(wrong_k));
  }
  for (const hal::LogRow& row : run.rows) {
    if (!is_scored(row.time, scored)) continue;
    mean_degc.push_back(mean_of({row.value.data(), static_cast<std::size_t>(site.counts.vavs)}));
    error_k.push_back(std::abs(mean_degc.back() - scored.target_degc));
  }
  if (!forecast_k.empty()) j["forecast_mae_k"] = mean_of(forecast_k);
  j["row_dae_degc"] = mean_of(error_k);
  j["room_sd_k"] = spread_of(mean_degc).sd;
}

/// Scored days only. A figure of the first or seventh day is left out where there are fewer.
nlohmann::json figures_of(const Metrics& m, const ControlRun& run) {
  std::vector<double> dae;
  int positive = 0;
  for (const DayMetrics& d : m.days) {
    dae.push_back(d.dae_degc);
    positive += d.saved_area_degch > 0 ? 1 : 0;
  }
  const auto first = std::min<std::size_t>(dae.size(), first_days);
  const auto by_schedule =
      std::ranges::count_if(run.rows, [](const hal::LogRow& r) { return r.controller.mode == "expert"; });
  nlohmann::json j{{"dae_degc", m.dae_degc},
                   {"me_degc", m.me_degc},
                   {"day1_dae_degc", m.day1_dae_degc},
                   {"first3_dae_degc", mean_of({dae.data(), first})},
                   {"last_dae_degc", dae.back()},
                   {"daily_sd_degc", spread_of(dae).sd},
                   {"darv_degc", m.darv_degc},
                   {"cdh_degch", m.cdh_degch},
                   {"hdh_degch", m.hdh_degch},
                   {"saved_area_degch", m.saved_area_degch},
                   {"saving_days_share", static_cast<double>(positive) / static_cast<double>(dae.size())},
                   {"hvac_kwh_per_day", m.hvac_kwh_per_day},
                   {"schedule_share", static_cast<double>(by_schedule) / static_cast<double>(run.rows.size())}};
  if (dae.size() >= 7) j["day7_dae_degc"] = dae[6];
  return j;
}

std::vector<double> daily_dae(const Metrics& m) {
  std::vector<double> dae;
  for (const DayMetrics& d : m.days) dae.push_back(d.dae_degc);
  return dae;
}

BlobBytes source_of(const MethodStudy& study, const MethodJob& job, const Site& site) {
  const std::string name = job.source_name();
  return name.empty() ? BlobBytes{} : read_blob((fs::path(study.folder) / (name + ".blob")).string(), site);
}

nlohmann::json run_control(const MethodStudy& study, const MethodJob& job) {
  const MethodRow& row = *job.row;
  const Site site = site_of(row, job.seed);
  const std::string start = day_text(first_controlled_day, -row.data_days);
  Trial trial{site, choice_of(study, job.room, job.seed, start), row.data_days, study.days};
  Prepared prepared = prepare(trial);
  const ControlRun run = row.baseline != nullptr
                             ? run_method(trial, prepared, row.baseline)
                             : run_ours(trial, prepared, {source_of(study, job, site), true, study.steps});
  const Metrics m = metrics_of(site, run);
  nlohmann::json figures = figures_of(m, run);
  add_cycle_figures(figures, site, run);
  return {{"figures", figures}, {"daily_dae_degc", daily_dae(m)}};
}

/// Mean |A_t - A_{t-1}| of cycles that begin in these hours, K.
double mean_move_k(const std::vector<CycleSample>& cycles, int from_h, int to_h) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 1; i < cycles.size(); ++i) {
    const int second = cycles[i].time.second_of_day();
    if (second < from_h * 3600 || second >= to_h * 3600) continue;
    sum += std::abs(cycles[i].setpoint_degc - cycles[i - 1].setpoint_degc);
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

/// Of the setpoints, in bins of half a kelvin, bit.
double setpoint_entropy_bit(const std::vector<CycleSample>& cycles) {
  std::array<int, 128> bins{};
  for (const CycleSample& c : cycles) {
    ++bins.at(static_cast<std::size_t>(std::clamp(std::floor(2 * c.setpoint_degc), 0.0, 127.0)));
  }
  double entropy = 0;
  for (const int n : bins) {
    const double share = static_cast<double>(n) / static_cast<double>(cycles.size());
    if (n > 0) entropy -= share * std::log2(share);
  }
  return entropy;
}

double share_near_target(const std::vector<CycleSample>& cycles, double target_degc) {
  const auto near = std::ranges::count_if(
      cycles, [target_degc](const CycleSample& c) { return std::abs(c.room_mean_degc - target_degc) <= 0.5; });
  return static_cast<double>(near) / static_cast<double>(cycles.size());
}

nlohmann::json run_pretraining(const MethodStudy& study, const MethodJob& job) {
  const Site site = site_of(*job.row, job.seed);
  const bool operated = job.row->start == MethodStart::operated_room;
  const int days = operated ? study.operated_days : study.pretrain_days;
  const PlantChoice twin = choice_of(study, job.room, job.seed, operated ? first_operated_day : first_twin_day);
  const auto plant = make_plant(twin, site, days);
  PretrainOptions options;
  options.seed = job.seed;
  options.pretrainer = job.row->start == MethodStart::static_twin ? Pretrainer::drawn_schedules : Pretrainer::agent;
  options.with_residual = false;  // it is of cycles of 18 min: rows of other lengths would have none
  options.provenance = fmt::format("airside study method: {}", job.name());
  const Pretraining made = pretrain(site, *plant, {plant->time().seconds + days * seconds_per_day}, options);
  hal::StagedFile blob((fs::path(study.folder) / (job.name() + ".blob")).string());
  blob.write({reinterpret_cast<const char*>(made.blob.data()), made.blob.size()});
  blob.commit();
  const Metrics m = metrics_of(site, made.run);
  nlohmann::json figures{{"transitions", made.transitions},
                         {"optimiser_steps", made.run.optimiser_steps},
                         {"evening_move_k", mean_move_k(made.run.cycles, 17, 21)},
                         {"midday_move_k", mean_move_k(made.run.cycles, 10, 14)},
                         {"entropy_bit", setpoint_entropy_bit(made.run.cycles)},
                         {"near_target_share", share_near_target(made.run.cycles, site.settings.target_degc)}};
  for (const std::size_t day : {1U, 2U, 3U, 6U, 7U, 14U}) {
    if (day < m.days.size()) figures[fmt::format("day{}_dae_degc", day)] = m.days[day].dae_degc;
  }
  return {{"figures", figures}, {"daily_dae_degc", daily_dae(m)}};
}

/// The room's log under good control: what forecasts are asked about. The product learns on it from its schedule days.
std::vector<hal::LogRow> varied_log(const MethodStudy& study, const MethodJob& job, const std::string& start,
                                    int days) {
  Site site = built_in_site();
  site.file.seed = job.seed;
  Trial trial{site, choice_of(study, job.room, job.seed, start), 5, days};
  Prepared prepared = prepare(trial);
  return run_ours(trial, prepared, {{}, true, 300}).rows;
}

std::vector<hal::LogRow> schedule_log(const MethodStudy& study, const MethodJob& job, const Site& site, int days) {
  return prepare({site, choice_of(study, job.room, job.seed, day_text(first_controlled_day, -days)), days, 1}).history;
}

BlobBytes tuned(const MethodStudy& study, const Site& site, const BlobBytes& source,
                const std::vector<hal::LogRow>& log, std::uint64_t seed) {
  FineTuneOptions options;
  options.steps = study.steps;
  options.seed = seed;
  return fine_tune(site, source, log, options);
}

nlohmann::json run_physics(const MethodStudy& study, const MethodJob& job) {
  const auto asked = varied_log(study, job, first_controlled_day, study.days);
  nlohmann::json figures;
  for (const char* name : {"paper", "without-physics"}) {
    const MethodRow& row = method_row(name);
    const Site site = site_of(row, job.seed);
    const BlobBytes blob = tuned(study, site, {}, schedule_log(study, job, site, row.data_days), job.seed);
    const ForecastCheck check = check_forecasts(site, blob, asked);
    const std::string with = row.table == MethodTable::control ? "with" : "without";
    figures[with + "_mae_k"] = check.mae_k;
    figures[with + "_violation_share"] = check.violation_share;
    figures[with + "_gain_sign_share"] = check.gain_sign_share;
  }
  return {{"figures", figures}};
}

nlohmann::json run_offline(const MethodStudy& study, const MethodJob& job) {
  const auto summer = varied_log(study, job, first_twin_day, study.summer_days);
  const auto winter = varied_log(study, job, first_winter_day, study.winter_days);
  const Site site = site_of(*job.row, job.seed);
  const auto taught = schedule_log(study, job, site, job.row->data_days);
  nlohmann::json figures;
  for (const char* name : {"dynamic-5", "static-5", "scratch-5"}) {
    const MethodJob as{&method_row(name), job.room, job.seed};
    const BlobBytes blob = tuned(study, site, source_of(study, as, site), taught, job.seed);
    const std::string start = std::string(name).substr(0, std::string(name).find('-'));
    const double warm = check_forecasts(site, blob, summer).mae_k, cold = check_forecasts(site, blob, winter).mae_k;
    figures[start + "_summer_k"] = warm;
    figures[start + "_winter_k"] = cold;
    figures[start + "_mean_k"] = 0.5 * (warm + cold);
  }
  return {{"figures", figures}};
}

/// Whether one of the tables needs the row, for itself or to start from.
bool is_needed(const MethodRow& row, const std::vector<MethodTable>& tables) {
  const auto asked = [&tables](MethodTable t) { return std::ranges::find(tables, t) != tables.end(); };
  if (asked(row.table)) return true;
  // The published setting is in four tables, five schedule days in two.
  if (row.table == MethodTable::control && row.baseline == nullptr)
    return asked(MethodTable::score) || asked(MethodTable::ablation) || asked(MethodTable::cycle);
  if (row.table == MethodTable::deployment) return asked(MethodTable::data) && row.start != MethodStart::static_twin;
  if (row.table != MethodTable::pretraining) return false;
  if (row.start == MethodStart::operated_room) return asked(MethodTable::neighbours);
  return asked(MethodTable::deployment) || asked(MethodTable::offline) ||
         (asked(MethodTable::data) && row.start == MethodStart::dynamic_twin);
}

}  // namespace

nlohmann::json MethodStudy::facts() const {
  nlohmann::json j{{"plant_kind", environment.empty() ? kind : "learned"},
                   {"days", days},
                   {"pretrain_days", pretrain_days},
                   {"operated_days", operated_days},
                   {"steps", steps},
                   {"summer_days", summer_days},
                   {"winter_days", winter_days}};
  if (!environment.empty()) j["environment"] = weather_file_text(environment);
  return j;
}

std::string MethodJob::name() const { return fmt::format("{}_{}_{}", row->name, room, seed); }

std::string MethodJob::source_name() const {
  if (row->work != MethodWork::control || row->start == MethodStart::scratch) return "";
  return fmt::format("{}_{}_{}", source_row(row->start), source_room(row->start, room), seed);
}

std::vector<std::string> MethodJob::sources() const {
  if (row->work != MethodWork::offline) {
    const std::string one = source_name();
    return one.empty() ? std::vector<std::string>{} : std::vector<std::string>{one};
  }
  std::vector<std::string> list;
  for (const MethodStart start : {MethodStart::dynamic_twin, MethodStart::static_twin})
    list.push_back(fmt::format("{}_{}_{}", source_row(start), source_room(start, room), seed));
  return list;
}

bool runs_in_environment(MethodTable table) {
  return table == MethodTable::control || table == MethodTable::score || table == MethodTable::ablation;
}

std::vector<MethodJob> method_jobs(const MethodStudy& study, const std::vector<MethodTable>& tables, int first_seed,
                                   int seeds) {
  std::vector<MethodJob> jobs;
  for (int s = 0; s < seeds; ++s) {
    for (const MethodRow& row : method_rows()) {
      if (!is_needed(row, tables)) continue;
      for (const std::string& room :
           study.environment.empty() ? method_rooms(row) : std::vector<std::string>{"environment"})
        jobs.push_back({&row, room, static_cast<std::uint64_t>(first_seed + s)});
    }
  }
  return jobs;
}

nlohmann::json run_method_job(const MethodStudy& study, const MethodJob& job) {
  nlohmann::json j;
  switch (job.row->work) {
    case MethodWork::control: j = run_control(study, job); break;
    case MethodWork::pretrain: j = run_pretraining(study, job); break;
    case MethodWork::physics: j = run_physics(study, job); break;
    case MethodWork::offline: j = run_offline(study, job); break;
  }
  j["row"] = job.row->name;
  j["room"] = job.room;
  j["seed"] = job.seed;
  j["study"] = study.facts();
  return j;
}

}  // namespace airside::tools
