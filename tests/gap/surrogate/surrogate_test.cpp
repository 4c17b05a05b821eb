// An RC room in the stead of a model whose runs are dear: what it says where the model was run, what it keeps of that
// elsewhere, and what is hidden comes first for a small part of the model's runs, named or not.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <set>

#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/blind/blind.hpp"
#include "tools/gap/model/log_window.hpp"
#include "tools/gap/surrogate/asked_model.hpp"

namespace airside::tools::gap {
namespace {

const std::vector<sim::Effect>& some_effects() {
  static const std::vector<sim::Effect> effects = [] {
    const std::set<std::string> some{"solar_gain",       "vav_flow",        "gain_zone",   "fcu_degraded",
                                     "mau_setpoint",     "chiller_cop",     "fan_power",   "gain_occupied",
                                     "room_sensor_bias", "swapped_sensors", "infiltration"};
    auto all = sim::load_effects(sim::find_effects());
    std::erase_if(all, [&some](const sim::Effect& e) { return !some.contains(e.name); });
    return all;
  }();
  return effects;
}

sim::EffectChange change(const std::string& name, double magnitude, int place = 0) {
  for (const sim::Effect& e : some_effects()) {
    if (e.name == name) return {{&e, place}, magnitude};
  }
  throw std::invalid_argument(name);
}

/// A model that counts its runs: room 301 as others built it, in whose stead room 301 may answer.
class DearModel final : public Engine {
 public:
  explicit DearModel(sim::RcRoom room) : room_(std::move(room)) {}
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override {
    ++runs;
    return room_.simulate(changes, recording);
  }
  sim::Channels channels() const override { return room_.channels(); }
  std::array<bool, sim::facades> has_facade() const override { return room_.has_facade(); }
  bool can(const sim::Effect& effect) const override { return room_.can(effect); }
  bool only_shows(const sim::Effect& effect) const override { return room_.only_shows(effect); }
  bool spares_runs() const override { return true; }
  std::optional<sim::RcRoom> stand_in() const override { return sim::load_room("301"); }
  std::string description() const override { return "dear " + room_.description(); }
  mutable std::atomic<int> runs = 0;

 private:
  RcEngine room_;
};

sim::RcRoom other_room() { return with_other_structure(measured_room(sim::load_room("301"), 9, false), 9); }

/// Both windows of a room that is the model's, with something hidden in the second.
struct Days {
  std::shared_ptr<const sim::Weather> weather = sim::synthetic_weather(3);

  Window window(const sim::RcRoom& room, const std::vector<Hidden>& hidden, int first_day, int days,
                std::uint64_t seed) const {
    const CivilTime start{sim::civil_midnight(2021, 7, 1).seconds + first_day * 86400};
    const MeasuredRun run{start, days, seed, true, 0};
    return window_of(measure(hide(room, hidden, some_effects()), weather, run, hidden), RcEngine(room).channels(),
                     weather, "case");
  }
};

double largest(const sim::ChannelTable& a, const sim::ChannelTable& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// Of all but duties.
double largest_but_duties(const sim::ChannelTable& a, const sim::ChannelTable& b) {
  return largest(a.leftCols(a.cols() - 5), b.leftCols(b.cols() - 5));
}

/// Of the rooms' temperatures, K: when a thermostat switches is chance.
double in_rooms(const sim::ChannelTable& a, const sim::ChannelTable& b) { return (a - b).leftCols(5).norm(); }

TEST(Surrogate, SaysWhatTheModelSaysWhereItWasRun) {
  const DearModel model(other_room());
  const sim::Recording days = Days().window(other_room(), {}, 0, 2, 1).recording;
  SurrogateEngine room(model, *model.stand_in());
  EXPECT_LT(largest(room.simulate({}, days), model.simulate({}, days)), 1e-9);
  const Changes fitted{change("gain_occupied", 1.1), change("room_sensor_bias", 0.2, 2)};
  const double before = largest(room.simulate(fitted, days), model.simulate(fitted, days));
  EXPECT_GT(before, 0.005) << "rooms of one kind, not one room";
  room.anchor(fitted, days);
  EXPECT_LT(largest(room.simulate(fitted, days), model.simulate(fitted, days)), 1e-9);
  Changes found = fitted;
  found.push_back(change("vav_flow", 0.7, 1));
  EXPECT_GT(largest(room.simulate(found, days), model.simulate(found, days)), 0.005);
  Changes half = found;
  half.back().magnitude = 0.85;
  const double unlearned = in_rooms(room.simulate(half, days), model.simulate(half, days));
  EXPECT_EQ(room.learned(found.back(), days), 0);
  room.learn({found.back()}, days, 1);
  EXPECT_EQ(room.learned(found.back(), days), 1);
  EXPECT_LT(largest_but_duties(room.simulate(found, days), model.simulate(found, days)), 1e-9);
  EXPECT_LT(in_rooms(room.simulate(half, days), model.simulate(half, days)), 0.7 * unlearned) << "half as far";
  found.back().magnitude = 1.3;
  EXPECT_EQ(room.learned(found.back(), days), 0) << "the other way nothing is known";
}

TEST(Surrogate, SaysWhatTheModelSaysAtEachSizeAndBetweenThemGoesAlongTheLine) {
  const DearModel model(other_room());
  const sim::Recording days = Days().window(other_room(), {}, 0, 2, 1).recording;
  SurrogateEngine room(model, *model.stand_in());
  const auto at = [](double flow) { return change("vav_flow", flow, 1); };
  room.learn({at(0.4), at(0.8)}, days, 1);
  for (const double flow : {0.8, 0.4})
    EXPECT_LT(largest_but_duties(room.simulate({at(flow)}, days), model.simulate({at(flow)}, days)), 1e-9) << flow;
  const sim::ChannelTable first = room.added_response(at(0.8), days), last = room.added_response(at(0.4), days);
  EXPECT_LT(largest(room.added_response(at(0.6), days), (first + last) / 2), 1e-9);
  EXPECT_LT(largest(room.added_response(at(0.9), days), first / 2), 1e-9);
  EXPECT_LT(largest(room.added_response(at(0.2), days), last * 0.8 / 0.6), 1e-9);
  EXPECT_DOUBLE_EQ(room.learned(at(0.5), days), 0.6 / 0.5) << "the nearer one";
  EXPECT_DOUBLE_EQ(room.learned(at(0.85), days), 0.2 / 0.15);
  room.learn({at(0.42)}, days, 1);
  EXPECT_DOUBLE_EQ(room.learned(at(0.4), days), 0.58 / 0.6) << "of nearly the same size the later run counts";
}

TEST(Surrogate, KeepsOfDutiesWhatTheHoursOfADayHaveAlike) {
  const DearModel model(other_room());
  const sim::Recording days = Days().window(other_room(), {}, 0, 3, 1).recording;
  SurrogateEngine room(model, *model.stand_in());
  const sim::EffectChange weak = change("fcu_degraded", 0.6, 1);
  room.learn({weak}, days, 1);
  const sim::ChannelTable added = room.added_response(weak, days).rightCols(5);
  EXPECT_GT(added.cwiseAbs().maxCoeff(), 0.001);
  for (const Eigen::Index hour : {8, 13, 17}) {
    const Eigen::Index row = hour * 10 + 5;
    EXPECT_EQ(added.row(row), added.row(row + 1));
    EXPECT_EQ(added.row(row), added.row(row + rows_per_day));
  }
  // Their mean over the days is what the model would have added.
  const sim::ChannelTable lack = model.simulate({weak}, days) - model.simulate({}, days);
  const RcEngine stand_in(*model.stand_in());
  const sim::ChannelTable own = stand_in.simulate({weak}, days) - stand_in.simulate({}, days);
  const Eigen::RowVectorXd off = (lack - own).rightCols(5).colwise().mean() - added.colwise().mean();
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Surrogate, SensorsShowTheModelsRoomsAndNotItsOwn) {
  const DearModel model(other_room());
  const sim::Recording days = Days().window(other_room(), {}, 0, 2, 1).recording;
  const SurrogateEngine room(model, *model.stand_in());
  const Changes swapped{change("swapped_sensors", 1, 0)};
  EXPECT_LT(largest(room.simulate(swapped, days), model.simulate(swapped, days)), 1e-9);
}

TEST(Surrogate, HeatInAZoneCostsNoRunAndOtherCommandsOne) {
  const DearModel model(other_room());
  sim::Recording days = Days().window(other_room(), {}, 0, 2, 1).recording;
  const SurrogateEngine room(model, *model.stand_in());
  room.simulate({}, days);
  const int runs = model.runs;
  sim::Recording heated = days;
  for (sim::RecordedRow& row : heated.rows) row.zone_heat_kw.assign(10, 0.5);
  EXPECT_GT(largest(room.simulate({}, heated), room.simulate({}, days)), 0.1);
  EXPECT_EQ(model.runs, runs);
  days.rows[50].setpoint_degc += 1;
  room.simulate({}, days);
  EXPECT_EQ(model.runs, runs + 1);
}

TEST(Surrogate, StandsInWhereTheModelSaysSoAlone) {
  const RcEngine cheap(sim::load_room("301"));
  EXPECT_FALSE(AskedModel(cheap).by_surrogate());
  const DearModel model(other_room());
  int replays = 0, runs = 0;
  const AskedModel asked(
      model, [&replays] { ++replays; }, [&runs] { ++runs; });
  ASSERT_TRUE(asked.by_surrogate());
  EXPECT_GT(asked.engine().usual_buildings(), 0);
  EXPECT_FALSE(asked.engine().spares_runs());
  asked.engine().simulate({}, Days().window(other_room(), {}, 0, 2, 1).recording);
  EXPECT_EQ(replays, 1);
  EXPECT_EQ(runs, 1);
}

TEST(Surrogate, FindsWhatIsHiddenForASmallPartOfTheRuns) {
  const sim::RcRoom built = other_room();
  const Days days;
  for (const auto& [effect, magnitude] : {std::pair("chiller_cop", 0.7), std::pair("vav_flow", 0.55)}) {
    const std::vector<Hidden> hidden{{effect, 0, magnitude}};
    const CaseData data{days.window(built, {}, 0, 8, 1), days.window(built, hidden, 8, 8, 2)};
    const DearModel model(built);
    AskedModel asked(model);
    const Library library = library_of(asked.engine(), some_effects());
    WindowResponses responses = asked.responses(library, data, 2);
    Rules rules;
    rules.buildings = 8;
    const Verdict v = asked.analyse(data, responses, rules, 2);
    const auto all = simulated_runs(model, library);
    std::printf("  %s: %s, %d of %zu runs\n", effect, v.reason.c_str(), model.runs.load(), 2 * all);
    ASSERT_FALSE(v.findings.empty()) << effect;
    EXPECT_EQ(v.findings.front().at.effect->name, effect);
    EXPECT_EQ(v.findings.front().at.id(), v.posteriors.front().effects.front().at.id());
    EXPECT_NEAR(v.findings.front().magnitude, magnitude, 0.1);
    EXPECT_LT(model.runs, static_cast<int>(all) / 2);
  }
}

}  // namespace
}  // namespace airside::tools::gap
