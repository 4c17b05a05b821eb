// Rooms whose numbers are known, found again from what they logged.

#include "tools/gap/fit/fit_room.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_replay.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/blind/blind.hpp"
#include "tools/gap/model/log_window.hpp"

namespace airside::tools::gap {
namespace {

const CivilTime july = sim::civil_midnight(2021, 7, 5);

Window logged(const sim::RcRoom& room, int days, bool feedback, std::uint64_t seed) {
  const auto weather = sim::synthetic_weather(3);
  const auto rows = measure(room, weather, {july, days, seed, feedback, 0});
  return window_of(rows, {room.vavs, room.fcus, room.powers}, weather, "log");
}

/// A parameter's truth as the fit counts it: what the room multiplies throughout belongs to each field.
sim::RcRoom spread_out(sim::RcRoom room) {
  for (auto* list : {&room.air_capacity_factor, &room.mass_kj_k, &room.wall_kj_k}) {
    for (double& x : *list) x *= room.capacity_factor;
  }
  room.capacity_factor = 1;
  for (double* f :
       {&room.solar_factor_north, &room.solar_factor_east, &room.solar_factor_south, &room.solar_factor_west}) {
    *f *= room.site_solar_factor;
  }
  room.site_solar_factor = 1;
  return room;
}

const FittedParameter& parameter(const RoomFit& fit, const std::string& text) {
  for (const FittedParameter& p : fit.parameters) {
    if (p.prior.name == text) return p;
  }
  throw std::logic_error("no parameter " + text);
}

TEST(ParameterFit, FindsLineWithPriorAndSaysWhatWasTold) {
  // Two channels: a + b t / bins, and noise alone; c moves nothing.
  constexpr Eigen::Index bins = 20 * bins_per_day, rows = bins * rows_per_bin;
  const FitModel model = [](const Eigen::VectorXd& p) {
    sim::ChannelTable table = sim::ChannelTable::Zero(rows, 3);
    table.col(0) = p(0) + p(1) * Eigen::VectorXd::LinSpaced(rows, 0, 1).array();
    return table;
  };
  const std::vector<FitParameter> parameters{
      {"a", "K", 0, 5, false, -100, 100}, {"b", "K", 1, 1, true, 0.01, 100}, {"c", "K", 2, 1, false, -10, 10}};
  Eigen::MatrixXd measured = binned(model(Eigen::Vector3d(2, 3, 0)), {});
  std::srand(7);
  measured += 0.1 * Eigen::MatrixXd::Random(measured.rows(), measured.cols());
  const ParameterFit fit =
      fit_parameters(parameters, model, measured, std::vector<bool>(static_cast<std::size_t>(bins), true), {1, 0, 0});
  EXPECT_NEAR(parameters[0].value(fit.z(0)), 2, 0.03);
  EXPECT_NEAR(parameters[1].value(fit.z(1)), 3, 0.05);
  EXPECT_GT(fit.learned(0), 0.99);
  EXPECT_GT(fit.learned(1), 0.99);
  EXPECT_NEAR(fit.learned(2), 0, 1e-6);
  EXPECT_EQ(parameters[2].value(fit.z(2)), 2);
  // Uniform noise of 0.1 / sqrt(3) on 960 bins of a line: sd of a is 2 sd / sqrt(n).
  EXPECT_NEAR(fit.sd(parameters[0], 0), 2 * 0.1 / std::sqrt(3.0) / std::sqrt(960.0), 0.002);
}

TEST(FitRoom, ExactReplayDiffersFromARoundedOneByRoundingOnly) {
  const sim::RcRoom room = sim::load_room("suite-3vav");
  const Window window = logged(room, 2, false, 1);
  const auto rounded = sim::replay_rc(room, window.recording, false);
  const auto exact = sim::replay_rc(room, window.recording, false, false);
  const double most = (rounded - exact).cwiseAbs().maxCoeff();
  EXPECT_LE(most, 0.005 + 1e-9);
  EXPECT_GT(most, 0.003);
}

TEST(FitRoom, RoomFileReadsBackToTheSameRoom) {
  const sim::RcRoom room = sim::perturbed_room(sim::load_room("301"), 9);
  const sim::RcRoom again = sim::parse_room(room_file_text(room, "a test"), "text", room.name);
  for (const sim::RoomField& field : sim::room_fields()) {
    if (const auto* scalar = std::get_if<sim::ScalarField>(&field.member)) {
      EXPECT_EQ(room.*(*scalar), again.*(*scalar)) << field.name;
    } else {
      const auto member = std::get<sim::ListField>(field.member);
      EXPECT_EQ(room.*member, again.*member) << field.name;
    }
  }
}

TEST(FitRoom, KnobsTurnWhatTheyName) {
  const sim::RcRoom start = sim::load_room("301");
  const auto knobs = room_knobs(start);
  Eigen::VectorXd values(std::ssize(knobs));
  for (std::size_t i = 0; i < knobs.size(); ++i) {
    const FitParameter p = parameter_of(knobs[i], start);
    EXPECT_GE(p.start, p.low) << p.name;
    EXPECT_LE(p.start, p.high) << p.name;
    values(static_cast<Eigen::Index>(i)) = p.value(0.3);
  }
  const sim::RcRoom room = turned(start, knobs, values);
  for (std::size_t i = 0; i < knobs.size(); ++i) {
    EXPECT_NEAR(value_in(room, knobs[i], start), values(static_cast<Eigen::Index>(i)), 1e-9) << knobs[i].text;
  }
  EXPECT_NO_THROW(sim::check_room(room, "turned"));
}

TEST(FitRoom, RefusesALogThatIsTooShort) {
  const sim::RcRoom room = sim::load_room("suite-3vav");
  const Window window = logged(room, 8, false, 1);
  try {
    fit_room(room, window, "short.csv");
    FAIL() << "nothing was refused";
  } catch (const hal::InputError& e) {
    EXPECT_EQ(e.place(), "short.csv");
    EXPECT_NE(e.found().find("8 whole days"), std::string::npos) << e.what();
  }
}

TEST(FitRoom, FindsAChangedSuiteAndPredictsLockedDays) {
  const sim::RcRoom start = sim::load_room("suite-3vav");
  sim::RcRoom truth = start;
  truth.envelope_factor *= 1.3;
  truth.solar_factor_south *= 0.7;
  truth.vav_flow_calibration[1] *= 0.8;
  truth.gain_base_w_m2 *= 1.2;
  truth.chiller_cop *= 0.85;
  const Window window = logged(truth, 10, false, 5);
  RoomFitSettings settings;
  settings.jobs = 2;
  const RoomFit fit = fit_room(start, window, "log", settings);
  EXPECT_EQ(fit.fitted_days, 7);
  EXPECT_EQ(fit.locked_days, 3);
  EXPECT_LT(fit.room_temp_k, 0.6 * fit.room_temp_start_k);
  const FittedParameter& flow = parameter(fit, "flow of box 2");
  // Known to fall short: 0.96 +- 0.04 for a truth of 0.8. The sign is right, the interval too narrow.
  EXPECT_LT(flow.estimate, 0.99);
  EXPECT_LT(flow.sd, 0.15);
  EXPECT_GT(flow.learned, 0.6);
  const FittedParameter& sun = parameter(fit, "sun, south facade");
  EXPECT_LT(sun.estimate, 0.99);  // for a truth of 0.7: the same shortfall
  // Nothing in this log tells how thick the outside wall is.
  EXPECT_LT(parameter(fit, "outside wall").learned, 0.9);
}

/// Not a test of one figure but a table: rooms of another structure, five seeds. Minutes; asked for by
/// name.
TEST(FitRoom, DISABLED_TableOfPerturbedRooms) {
  const sim::RcRoom start = sim::load_room("301");
  double before = 0, after = 0;
  std::map<std::string, std::array<int, 3>> by_field;  // told: within one sd, within two, all
  int within = 0, all = 0, told_within = 0, told_all = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const bool feedback = seed % 2 == 0;
    const sim::RcRoom truth = measured_room(start, seed, feedback);
    const Window window = logged(truth, 21, feedback, seed + 100);
    RoomFitSettings settings;
    settings.locked_days = 7;
    settings.jobs = 2;
    const RoomFit fit = fit_room(start, window, "log", settings);
    const sim::RcRoom known = spread_out(truth);
    int hit = 0, hit_told = 0, n_told = 0;
    for (const FittedParameter& p : fit.parameters) {
      const double true_value = value_in(known, p.knob, start);
      const auto [low, high] = p.interval(2);
      const auto [low1, high1] = p.interval(1);
      const bool in = true_value >= low && true_value <= high;
      hit += in ? 1 : 0;
      if (p.learned > 0.5) {
        ++n_told;
        hit_told += in ? 1 : 0;
        auto& row = by_field[p.knob.field];
        row[0] += true_value >= low1 && true_value <= high1 ? 1 : 0;
        row[1] += in ? 1 : 0;
        ++row[2];
      }
      if (seed == 1) {
        fmt::print("  {:<36} {:9.4g} -> {:9.4g} +- {:8.2g} true {:9.4g} told {:3.0f} %{}\n", p.prior.name,
                   p.prior.start, p.estimate, p.sd, true_value, 100 * p.learned, in ? "" : "  *");
      }
    }
    const auto n = static_cast<int>(fit.parameters.size());
    fmt::print(
        "seed {} feedback {}: locked rooms {:.3f} -> {:.3f} K; in 2 sd {}/{}, told by half {}/{}; inflation {:.1f}, {} "
        "runs\n",
        seed, feedback, fit.room_temp_start_k, fit.room_temp_k, hit, n, hit_told, n_told, fit.inflation, fit.runs);
    for (const ChannelFit& c : fit.channels) {
      if (seed <= 2) {
        fmt::print("    {:<18} {:>7.3f} {:>7.3f} {:>7.3f} {:>7.3f} {:>7.3f} {}\n", c.name, c.start_sd, c.fitted_sd,
                   c.one_step_sd, c.locked_start, c.locked_rmse, c.unit);
      }
    }
    before += fit.room_temp_start_k / 5;
    after += fit.room_temp_k / 5;
    within += hit;
    all += n;
    told_within += hit_told;
    told_all += n_told;
    std::fflush(stdout);
  }
  fmt::print("mean locked {:.3f} -> {:.3f} K; coverage of 2 sd {}/{} = {:.0f} %, of told {}/{} = {:.0f} %\n", before,
             after, within, all, 100.0 * within / all, told_within, told_all,
             100.0 * told_within / std::max(1, told_all));
  for (const auto& [field, row] : by_field) fmt::print("  {:<28} {} {} of {}\n", field, row[0], row[1], row[2]);
}

}  // namespace
}  // namespace airside::tools::gap
