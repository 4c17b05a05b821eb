#include "tools/gap/retrain/retrain.hpp"

#include <fmt/format.h>

#include <charconv>

#include "hal/text/input_error.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/training/pretraining.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

constexpr const char *pretrain_start = "2021-07-01", *control_start = "2021-08-01";

Site seeded_site(const RetrainPlan& plan, std::uint64_t seed) {
  Site site = plan.site;
  site.file.seed = seed;
  return site;
}

/// The twins share a made-up year; the measured room has another one, and it does not depend on how its file is named.
PlantChoice choice_of(const RetrainPlan& plan, const RetrainRoom& room, std::uint64_t seed, bool measured) {
  PlantChoice choice;
  choice.kind = plan.plant;
  if (room.room.ends_with(".epJSON")) {
    choice.room = "twin";
    choice.model = room.room;
  } else {
    choice.room = room.room;
  }
  choice.patches = room.patches;
  choice.changes = room.changes;
  choice.changes_in_model = room.changes_in_model;
  choice.weather = plan.weather;
  choice.weather_of = plan.twin.room + (measured ? " as measured" : "");
  choice.seed = seed;
  choice.start = measured ? control_start : pretrain_start;
  return choice;
}

BlobBytes pretrain_on(const RetrainPlan& plan, const RetrainRoom& room, std::uint64_t seed) {
  const Site site = seeded_site(plan, seed);
  const auto twin = make_plant(choice_of(plan, room, seed, false), site, plan.pretrain_days);
  PretrainOptions options;
  options.seed = seed;
  const CivilTime until{twin->time().seconds + plan.pretrain_days * seconds_per_day};
  return pretrain(site, *twin, until, options).blob;
}

/// Days as text: child processes hand over text.
std::string control(const RetrainPlan& plan, const RetrainRoom& twin, std::uint64_t seed) {
  const BlobBytes blob = pretrain_on(plan, twin, seed);
  const Trial trial{seeded_site(plan, seed), choice_of(plan, plan.measured, seed, true), plan.expert_days, plan.days};
  Prepared prepared = prepare(trial);
  const Metrics m = metrics_of(trial.site, run_ours(trial, prepared, {blob, false, 0}));
  json days = json::array();
  for (const DayMetrics& d : m.days) days.push_back(d.dae_degc);
  return json{{"dae", m.dae_degc}, {"me", m.me_degc}, {"darv", m.darv_degc}, {"day1", m.day1_dae_degc}, {"days", days}}
      .dump();
}

Metrics metrics_from(const std::string& text) {
  const auto j = json::parse(text);
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

template <class Value>
RetrainSpread spread_by(const Retraining& retraining, const Value& value) {
  std::vector<double> before, after, change;
  for (const RetrainRun& run : retraining.runs) {
    before.push_back(value(run.before));
    after.push_back(value(run.after));
    change.push_back(after.back() - before.back());
  }
  return {tools::spread_of(before), tools::spread_of(after), tools::spread_of(change)};
}

json spread_json(const Spread& spread) { return {{"mean", spread.mean}, {"sd", spread.sd}}; }

json room_json(const RetrainRoom& room) {
  json changes = json::array();
  for (const sim::EffectChange& c : room.changes) {
    changes.push_back({{"id", c.at.id()}, {"magnitude", c.magnitude}, {"unit", c.at.effect->unit}});
  }
  return {{"room", text_of(room)}, {"changes", changes}};
}

json facts_json(const Metrics& m) {
  json daily = json::array();
  for (const DayMetrics& d : m.days) daily.push_back(d.dae_degc);
  json j = {{"daily_dae_degc", daily}};
  for (const RetrainFigure& f : retrain_figures()) j[f.key] = m.*f.figure;
  return j;
}

std::string days_text(int days) { return days == 1 ? "the first day" : fmt::format("the first {} days", days); }

}  // namespace

RetrainRoom parse_retrain_room(const std::string& text) {
  RetrainRoom out;
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

std::string text_of(const RetrainRoom& room) {
  std::string text = room.room;
  for (const std::string& patch : room.patches) text += "+" + patch;
  return text;
}

int Retraining::seeds_lower(double Metrics::*figure) const {
  int lower = 0;
  for (const RetrainRun& run : runs) lower += run.after.*figure < run.before.*figure ? 1 : 0;
  return lower;
}

const std::vector<RetrainFigure>& retrain_figures() {
  static const std::vector<RetrainFigure> figures{{"dae_degc", "DAE", &Metrics::dae_degc},
                                                  {"me_degc", "ME", &Metrics::me_degc},
                                                  {"darv_degc", "DARV", &Metrics::darv_degc},
                                                  {"day1_dae_degc", "DAE, day 1", &Metrics::day1_dae_degc}};
  return figures;
}

RetrainSpread spread_of(const Retraining& retraining, double Metrics::*figure) {
  return spread_by(retraining, [figure](const Metrics& m) { return m.*figure; });
}

RetrainSpread daily_dae(const Retraining& retraining, std::size_t day) {
  return spread_by(retraining, [day](const Metrics& m) { return m.days.at(day).dae_degc; });
}

sim::EffectChange parse_change(const std::string& text, const std::vector<sim::Effect>& effects,
                               const sim::Channels& channels, const std::string& plant) {
  const std::string place = "--effect " + text;
  const std::size_t mark = text.find('=');
  double magnitude = 0;
  const char* end = text.data() + text.size();
  const char* number = mark == std::string::npos ? end : text.data() + mark + 1;
  if (const auto read = std::from_chars(number, end, magnitude); read.ec != std::errc{} || read.ptr != end) {
    throw hal::InputError(place, "no number after =", "ID=MAGNITUDE such as vav_flow@2=0.5",
                          "airside gap effects lists names, units and bounds");
  }
  const std::string id = text.substr(0, mark);
  for (const sim::Effect& effect : effects) {
    for (const sim::EffectAt& at : sim::places_of(effect, channels, {true, true, true, true})) {
      if (at.id() != id) continue;
      if (magnitude < effect.low || magnitude > effect.high) {
        throw hal::InputError(place, fmt::format("{}", magnitude),
                              fmt::format("{} to {} {}", effect.low, effect.high, effect.unit), "stay within bounds");
      }
      if ((plant == "rc" ? effect.rc : effect.energyplus).empty()) {
        throw hal::InputError(place, "an effect that is not in the model: it acts on sensors, clock or commands",
                              "one that a twin of kind " + plant + " can have", "choose another effect");
      }
      return {at, magnitude};
    }
  }
  throw hal::InputError(place, "no such effect or place", "an effect's name, with @ and place where it has places",
                        "airside gap effects lists them");
}

void check_retrain_room(const RetrainPlan& plan, const RetrainRoom& room) {
  (void)make_plant(choice_of(plan, room, 1, false), plan.site, 1);
}

void check_retrain_rooms(const RetrainPlan& plan) {
  for (const RetrainRoom* room : {&plan.twin, &plan.patched, &plan.measured}) check_retrain_room(plan, *room);
}

std::size_t retrain_steps(const RetrainPlan& plan) { return 2 * static_cast<std::size_t>(plan.seeds); }

Retraining retrain(const RetrainPlan& plan, const std::function<void()>& done) {
  const auto seed_of = [&plan](std::size_t i) { return static_cast<std::uint64_t>(plan.first_seed) + i / 2; };
  const auto texts = run_children(
      retrain_steps(plan), plan.jobs,
      [&](std::size_t i) { return control(plan, i % 2 == 0 ? plan.twin : plan.patched, seed_of(i)); },
      [&](std::size_t i) {
        return fmt::format("{} {}, seed {}", i % 2 == 0 ? "twin" : "patched twin",
                           text_of(i % 2 == 0 ? plan.twin : plan.patched), seed_of(i));
      },
      done);
  Retraining out;
  out.plan = plan;
  for (std::size_t i = 0; i < texts.size(); i += 2) {
    out.runs.push_back({seed_of(i), metrics_from(texts[i]), metrics_from(texts[i + 1])});
  }
  return out;
}

json json_of(const Retraining& retraining) {
  const RetrainPlan& plan = retraining.plan;
  json j = {{"plant", plan.plant},
            {"twin", room_json(plan.twin)},
            {"patched", room_json(plan.patched)},
            {"measured", room_json(plan.measured)},
            {"patched_twin_stands_for_measured", retraining.stand_in},
            {"preset", hal::name_of(plan.site.file.preset)},
            {"weather", plan.weather},
            {"pretrain_days", plan.pretrain_days},
            {"expert_days", plan.expert_days},
            {"days", plan.days},
            {"remarks", retraining.remarks},
            {"seeds", json::array()},
            {"runs", json::array()},
            {"daily_dae_degc", json::array()}};
  for (const RetrainRun& run : retraining.runs) {
    j["seeds"].push_back(run.seed);
    j["runs"].push_back({{"seed", run.seed}, {"before", facts_json(run.before)}, {"after", facts_json(run.after)}});
  }
  for (const RetrainFigure& f : retrain_figures()) {
    const RetrainSpread s = spread_of(retraining, f.figure);
    j["before"][f.key] = spread_json(s.before);
    j["after"][f.key] = spread_json(s.after);
    j["change"][f.key] = spread_json(s.change);
    j["seeds_lower"][f.key] = retraining.seeds_lower(f.figure);
  }
  for (std::size_t day = 0; day < static_cast<std::size_t>(plan.days); ++day) {
    const RetrainSpread s = daily_dae(retraining, day);
    j["daily_dae_degc"].push_back({{"before", spread_json(s.before)}, {"after", spread_json(s.after)}});
  }
  return j;
}

std::string text_of(const Retraining& retraining) {
  std::string text = fmt::format("{:<13} {:>20} {:>20} {:>20} {:>8}\n", "first days, K", "weights of the twin",
                                 "of the patched twin", "change, seed by seed", "lower");
  for (const RetrainFigure& f : retrain_figures()) {
    const RetrainSpread s = spread_of(retraining, f.figure);
    text += fmt::format("{:<13} {:>11.3f} +- {:.3f} {:>11.3f} +- {:.3f} {:>+11.3f} +- {:.3f} {:>3} of {}\n", f.title,
                        s.before.mean, s.before.sd, s.after.mean, s.after.sd, s.change.mean, s.change.sd,
                        retraining.seeds_lower(f.figure), retraining.runs.size());
  }
  for (const std::string& remark : retraining.remarks) text += remark + "\n";
  return text;
}

std::string sentence_of(const Retraining& retraining) {
  const RetrainSpread s = spread_of(retraining, &Metrics::dae_degc);
  return fmt::format("DAE of {} {:.3f} -> {:.3f} K, lower with {} of {} seeds", days_text(retraining.plan.days),
                     s.before.mean, s.after.mean, retraining.seeds_lower(&Metrics::dae_degc), retraining.runs.size());
}

}  // namespace airside::tools::gap
