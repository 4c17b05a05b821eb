#include "tools/gap/retrain.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/child_jobs.hpp"

namespace airside::tools::gap {

namespace {

Site retrain_site(const RetrainPlan& plan, std::uint64_t seed) {
  Site site = built_in_site("5vav-5fcu-2power",
                            plan.preset == "paper" ? hal::ControllerPreset::paper : hal::ControllerPreset::product);
  site.file.seed = seed;
  return site;
}

PlantChoice choice_of(const RetrainPlan& plan, const std::string& room, std::uint64_t seed, const char* start) {
  const RoomText text = parse_room_text(room);
  PlantChoice choice;
  choice.kind = plan.plant;
  choice.room = text.room;
  choice.patches = text.patches;
  choice.seed = seed;
  choice.start = start;
  return choice;
}

BlobBytes pretrain_on(const RetrainPlan& plan, const std::string& room, std::uint64_t seed) {
  const Site site = retrain_site(plan, seed);
  const auto twin = make_plant(choice_of(plan, room, seed, "2021-07-01"), site, plan.pretrain_days);
  PretrainOptions options;
  options.seed = seed;
  const CivilTime until{twin->time().seconds + plan.pretrain_days * std::int64_t{86400}};
  return pretrain(site, *twin, until, options).blob;
}

/// Days as text: child processes hand over text.
std::string control(const RetrainPlan& plan, const std::string& twin, std::uint64_t seed) {
  const BlobBytes blob = pretrain_on(plan, twin, seed);
  const Trial trial{retrain_site(plan, seed), choice_of(plan, plan.measured, seed, "2021-08-01"), plan.expert_days,
                    plan.days};
  Prepared prepared = prepare(trial);
  const Metrics m = metrics_of(trial.site, run_ours(trial, prepared, {blob, false, 0}));
  nlohmann::json days = nlohmann::json::array();
  for (const DayMetrics& d : m.days) days.push_back(d.dae_degc);
  return nlohmann::json{
      {"dae", m.dae_degc}, {"me", m.me_degc}, {"darv", m.darv_degc}, {"day1", m.day1_dae_degc}, {"days", days}}
      .dump();
}

Metrics metrics_from(const std::string& text) {
  const auto j = nlohmann::json::parse(text);
  Metrics m;
  m.dae_degc = j.at("dae");
  m.me_degc = j.at("me");
  m.darv_degc = j.at("darv");
  m.day1_dae_degc = j.at("day1");
  for (const double dae : j.at("days")) {
    m.days.emplace_back();
    m.days.back().dae_degc = dae;
  }
  return m;
}

}  // namespace

RoomText parse_room_text(const std::string& text) {
  RoomText out;
  std::size_t from = 0;
  while (from <= text.size()) {
    const std::size_t to = std::min(text.find('+', from), text.size());
    const std::string part = text.substr(from, to - from);
    if (from == 0) {
      out.room = part;
    } else {
      out.patches.push_back(part);
    }
    from = to + 1;
  }
  return out;
}

std::size_t retrain_steps(const RetrainPlan& plan) { return 2 * static_cast<std::size_t>(plan.seeds); }

std::vector<RetrainRun> retrain(const RetrainPlan& plan, const std::function<void()>& done) {
  for (const std::string& room : {plan.twin, plan.patched, plan.measured}) {
    (void)make_plant(choice_of(plan, room, 1, "2021-07-01"), retrain_site(plan, 1), 1);
  }
  const auto seed_of = [&plan](std::size_t i) { return static_cast<std::uint64_t>(plan.first_seed) + i / 2; };
  const auto texts = run_children(
      retrain_steps(plan), plan.jobs,
      [&](std::size_t i) { return control(plan, i % 2 == 0 ? plan.twin : plan.patched, seed_of(i)); },
      [&](std::size_t i) { return fmt::format("twin {}, seed {}", i % 2 == 0 ? plan.twin : plan.patched, seed_of(i)); },
      done);
  std::vector<RetrainRun> runs;
  for (std::size_t i = 0; i < texts.size(); i += 2) {
    runs.push_back({seed_of(i), metrics_from(texts[i]), metrics_from(texts[i + 1])});
  }
  return runs;
}

}  // namespace airside::tools::gap
