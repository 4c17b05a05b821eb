#include "tools/gap/blind/blind_site.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/rc/rc_replay.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/epw.hpp"
#include "tools/gap/model/log_window.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

constexpr double share_missing = 0.002;

MeasuredRun reference_run(const BlindSetup& setup, const BlindWindow& w, std::uint64_t seed) {
  return {setup.starts[static_cast<std::size_t>(w.number)], setup.days, seed, w.feedback, share_missing};
}

MeasuredRun run_after(MeasuredRun run) {
  run.start.seconds += run.days * seconds_per_day;
  run.seed += 1;
  if (run.command_seed) *run.command_seed += 1;
  return run;
}

MeasuredRun with_tests(MeasuredRun run, int days, std::shared_ptr<const TestCommands> tests) {
  run.passive_days = run.days;
  run.days = days;
  run.tests = std::move(tests);
  return run;
}

BlindSite::Kinds kinds_of(const Engine& engine, const std::vector<sim::Effect>& effects,
                          const std::function<bool(const sim::Effect&)>& can) {
  BlindSite::Kinds kinds;
  for (const sim::EffectAt& at : library_of(engine, effects).candidates) {
    if (can(*at.effect)) kinds[at.effect->name].push_back(at);
  }
  return kinds;
}

/// What fits to reference periods of such rooms left, as a table: for quick sets.
Eigen::VectorXd rough_noise(const sim::Channels& c) {
  Eigen::VectorXd noise(c.count());
  noise.head(c.fcu_temp()).setConstant(0.16);
  noise.segment(c.fcu_temp(), c.fcus).setConstant(0.24);
  noise(c.mau_temp()) = 0.25;
  noise(c.supply_temp()) = 0.02;
  noise.segment(c.power(), c.powers).setConstant(0.15);
  noise(c.power()) = c.powers > 1 ? 0.03 : 0.15;
  noise.tail(c.fcus).setConstant(0.25);
  return noise;
}

/// Duties only where asked: a thermostat that switches a little earlier shows as much in them as a real change.
Shown shown_most(const Eigen::MatrixXd& response, const Eigen::VectorXd& noise, const sim::Channels& channels,
                 bool duties) {
  Shown most;
  for (Eigen::Index k = 0; k < (duties ? channels.count() : channels.fcu_duty()); ++k) {
    double square = 0;
    int count = 0;
    for (Eigen::Index b = bins_per_day; b < response.rows(); ++b) {
      if (!std::isfinite(response(b, k))) continue;
      square += response(b, k) * response(b, k);
      ++count;
    }
    if (count == 0 || !(noise(k) > 0)) continue;
    const double ratio = std::sqrt(square / count) / noise(k);
    if (ratio > most.ratio) most = {ratio, channels.name(static_cast<int>(k))};
  }
  return most;
}

/// "room_temp", "fcu_temp", "mau_temp", "power", "fcu_duty". Duties as means of 3 h: when a thermostat switches is
/// chance.
ShownLive shown_by_kind(const Eigen::MatrixXd& difference, const Eigen::VectorXd& noise, const sim::Channels& c) {
  ShownLive kinds;
  const auto add = [&](const char* kind, int from, int count) {
    Shown& most = kinds[kind] = {};
    for (int k = from; k < from + count; ++k) {
      const Eigen::Index step = k >= c.fcu_duty() ? 6 : 1;
      double square = 0;
      int means = 0;
      for (Eigen::Index b = bins_per_day; b + step <= difference.rows(); b += step) {
        const double mean = difference.col(k).segment(b, step).mean();
        if (!std::isfinite(mean)) continue;
        square += mean * mean;
        ++means;
      }
      const double sd = noise(k) > 0 ? noise(k) : rough_noise(c)(k);
      const double ratio = means > 0 ? std::sqrt(square / means) / sd : 0;
      if (ratio > most.ratio) most = {ratio, c.name(k)};
    }
  };
  add("room_temp", 0, c.rooms);
  add("fcu_temp", c.fcu_temp(), c.fcus);
  add("mau_temp", c.mau_temp(), 1);
  add("power", c.power(), c.powers);
  add("fcu_duty", c.fcu_duty(), c.fcus);
  return kinds;
}

constexpr int noise_rooms = 5;

/// Of each row.
Eigen::VectorXd median_of(Eigen::MatrixXd table) {
  const Eigen::Index middle = table.cols() / 2;
  for (auto row : table.rowwise()) std::nth_element(row.begin(), row.begin() + middle, row.end());
  return table.col(middle);
}

class RcSite final : public BlindSite {
 public:
  explicit RcSite(const BlindSetup& setup) : setup_(setup), twin_(sim::load_room(setup.twin)), engine_(twin_) {
    for (const auto& file : setup.weather) weather_.push_back(sim::read_epw(file.string()));
    kinds_ = kinds_of(engine_, *setup.effects, rc_can_hide);
  }

  hal::TopologyCounts counts() const override { return {"", twin_.vavs, twin_.fcus, twin_.powers}; }

  void prepare(const std::vector<BlindWindow>& windows) override {
    for (const BlindWindow& w : windows) {
      Prepared& p = prepared_[w];
      // Rooms that no case has: noise and commands are like theirs.
      p.room = built(setup_.seed + 77, w.feedback);
      p.reference = reference_of(p.room, w, setup_.seed + 77);
      p.base = binned(engine_.simulate({}, p.reference.recording), engine_.channels());
      p.own = sim::replay_rc(p.room, p.reference.recording);
      p.noise = setup_.noise.contains(w.feedback) ? setup_.noise.at(w.feedback)
                : setup_.rough                    ? rough_noise(engine_.channels())
                                                  : usual_noise(w);
      if (setup_.done) setup_.done();
    }
  }

  Shown shown(const Hidden& h, const BlindWindow& w) const override {
    const Prepared& p = prepared_.at(w);
    if (const sim::Effect* effect = find_effect(*setup_.effects, h.effect)) {
      const Changes change{{{effect, h.place}, h.magnitude}};
      // Duties, which cost a second run, are not looked at.
      const sim::ChannelTable with =
          sim::changed_sensors(sim::replay_rc(sim::changed_room(twin_, change),
                                              sim::changed_recording(p.reference.recording, change), false, false),
                               engine_.channels(), change);
      return shown_most(binned(with, engine_.channels()) - p.base, p.noise, engine_.channels(), false);
    }
    const sim::ChannelTable with = sim::replay_rc(hide(p.room, {h}, *setup_.effects), p.reference.recording);
    return shown_most(binned(with - p.own, engine_.channels()), p.noise, engine_.channels(), true);
  }

  int outside_places(const std::string& kind) const override {
    return kind == "fcu_dial" ? twin_.fcus : kind == "odd_heater" || kind == "escape_door" ? twin_.zones() : 0;
  }

  /// Of the i-th room that no case has.
  Eigen::VectorXd noise_of_room(int i, const BlindWindow& w) const {
    const std::uint64_t seed = setup_.seed + 77 + static_cast<std::uint64_t>(i);
    const Window window = reference_of(built(seed, w.feedback), w, seed);
    const Responses responses =
        simulate_responses(engine_, library_of(engine_, *setup_.effects), window.recording, true, setup_.jobs);
    return fit_reference(engine_, responses, window, setup_.jobs).noise.spread();
  }

  BlindLogs live(const std::vector<Hidden>& hidden, const BlindWindow& w, std::uint64_t seed) const override {
    const sim::RcRoom room = built(seed, w.feedback);
    const MeasuredRun reference = reference_run(setup_, w, seed);
    return {measure(room, weather(w), reference),
            measure(hide(room, hidden, *setup_.effects), weather(w), run_after(reference), hidden)};
  }

  std::vector<hal::LogRow> lived_on(const std::vector<Hidden>& hidden, const BlindWindow& w, std::uint64_t seed,
                                    int days, std::shared_ptr<const TestCommands> tests) const override {
    const MeasuredRun run = with_tests(run_after(reference_run(setup_, w, seed)), days, std::move(tests));
    return measure(hide(built(seed, w.feedback), hidden, *setup_.effects), weather(w), run, hidden);
  }

 private:
  struct Prepared {
    sim::RcRoom room;
    Window reference;
    Eigen::MatrixXd base;   // of the twin
    sim::ChannelTable own;  // of the room itself
    Eigen::VectorXd noise;
  };

  sim::RcRoom built(std::uint64_t seed, bool feedback) const {
    return with_other_structure(measured_room(twin_, seed, feedback), seed);
  }
  std::shared_ptr<const sim::Weather> weather(const BlindWindow& w) const {
    return weather_[static_cast<std::size_t>(w.number)];
  }
  Window window_at(const std::vector<hal::LogRow>& rows, const BlindWindow& w) const {
    return window_of(rows, engine_.channels(), weather(w), "blind");
  }
  Window reference_of(const sim::RcRoom& room, const BlindWindow& w, std::uint64_t seed) const {
    MeasuredRun run = reference_run(setup_, w, seed);
    run.missing_share = 0;
    return window_at(measure(room, weather(w), run), w);
  }
  /// Rooms differ by a factor of two, and an effect is sized by the channel that shows it most: of one room that would
  /// be the channel in which it happens to be calm.
  Eigen::VectorXd usual_noise(const BlindWindow& w) const {
    Eigen::MatrixXd noise(engine_.channels().count(), noise_rooms);
    for (int i = 0; i < noise_rooms; ++i) noise.col(i) = noise_of_room(i, w);
    return median_of(std::move(noise));
  }

  BlindSetup setup_;
  sim::RcRoom twin_;
  RcEngine engine_;
  std::vector<std::shared_ptr<const sim::Weather>> weather_;
  std::map<BlindWindow, Prepared> prepared_;
};

class EnergyPlusSite final : public BlindSite {
 public:
  explicit EnergyPlusSite(const BlindSetup& setup)
      : setup_(setup), engine_(sim::twin_of(sim::energyplus_room(setup.twin)), setup.twin, setup.cache, false) {
    for (const auto& file : setup.weather) weather_.push_back(sim::read_epw(file.string()));
    kinds_ = kinds_of(engine_, *setup.effects, energyplus_can_hide);
  }

  hal::TopologyCounts counts() const override {
    const sim::Channels c = engine_.channels();
    return {"", c.rooms, c.fcus, c.powers};
  }

  void prepare(const std::vector<BlindWindow>& windows) override {
    for (const BlindWindow& w : windows) prepared_[w];
    in_parallel(windows.size(), setup_.jobs, [&](std::size_t i) {
      const BlindWindow& w = windows[i];
      Prepared& p = prepared_.at(w);
      p.room = energyplus_measured_room(setup_.twin, room_seed(w), w.feedback);
      p.rows = measure(p.room, weather_file(w), commanded(w, room_seed(w)));
      p.reference = window_of(p.rows, engine_.channels(), weather_[static_cast<std::size_t>(w.number)], "blind");
      p.base = binned(engine_.simulate({}, p.reference.recording), engine_.channels());
    });
    // A fit costs as much as a window's cases together, and noise depends on control more than on the window.
    std::map<bool, Eigen::VectorXd> noise;
    for (const BlindWindow& w : windows) {
      if (!noise.contains(w.feedback)) {
        noise[w.feedback] = setup_.rough ? rough_noise(engine_.channels()) : fitted_noise(prepared_.at(w).reference);
      }
      prepared_.at(w).noise = noise.at(w.feedback);
      if (setup_.done) setup_.done();
    }
  }

  /// By the twin, whose response is what the workflow will look for.
  Shown shown(const Hidden& h, const BlindWindow& w) const override {
    const Prepared& p = prepared_.at(w);
    const sim::Effect* effect = find_effect(*setup_.effects, h.effect);
    if (effect == nullptr) return {std::numeric_limits<double>::quiet_NaN(), ""};
    const Changes change{{{effect, h.place}, h.magnitude}};
    return shown_most(binned(engine_.simulate(change, p.reference.recording), engine_.channels()) - p.base, p.noise,
                      engine_.channels(), false);
  }

  int outside_places(const std::string& kind) const override {
    const sim::Channels c = engine_.channels();
    return kind == "odd_heater" || kind == "escape_door" ? c.rooms + c.fcus : 0;
  }

  /// Fan coils that follow a schedule have no dial.
  bool has_outside(const std::string& kind, const BlindWindow& w) const override {
    return kind != "fcu_dial" || w.feedback;
  }

  ShownLive shown_live(const BlindLogs& logs, const BlindWindow& w, std::uint64_t seed) const override {
    const Prepared& p = prepared_.at(w);
    const auto without = measure(p.room, weather_file(w), run_after(commanded(w, seed)));
    const auto table = [&](const std::vector<hal::LogRow>& rows) {
      return window_of(rows, engine_.channels(), weather_[static_cast<std::size_t>(w.number)], "blind").measured;
    };
    return shown_by_kind(table(logs.measured) - table(without), p.noise, engine_.channels());
  }

  BlindLogs live(const std::vector<Hidden>& hidden, const BlindWindow& w, std::uint64_t seed) const override {
    const Prepared& p = prepared_.at(w);
    return {p.rows,
            measure(hide(p.room, hidden, *setup_.effects, seed), weather_file(w), run_after(commanded(w, seed)))};
  }

  std::vector<hal::LogRow> lived_on(const std::vector<Hidden>& hidden, const BlindWindow& w, std::uint64_t seed,
                                    int days, std::shared_ptr<const TestCommands> tests) const override {
    const EnergyPlusRoom room = energyplus_measured_room(setup_.twin, room_seed(w), w.feedback);
    const MeasuredRun run = with_tests(run_after(commanded(w, seed)), days, std::move(tests));
    return measure(hide(room, hidden, *setup_.effects, seed), weather_file(w), run);
  }

 private:
  struct Prepared {
    EnergyPlusRoom room;
    std::vector<hal::LogRow> rows;
    Window reference;
    Eigen::MatrixXd base;
    Eigen::VectorXd noise;
  };

  const std::filesystem::path& weather_file(const BlindWindow& w) const {
    return setup_.weather[static_cast<std::size_t>(w.number)];
  }

  /// People and noise are the case's, commands the window's.
  MeasuredRun commanded(const BlindWindow& w, std::uint64_t seed) const {
    MeasuredRun run = reference_run(setup_, w, seed);
    run.command_seed = room_seed(w);
    return run;
  }

  std::uint64_t room_seed(const BlindWindow& w) const {
    return setup_.seed * 1'000'003 + 500'000 + static_cast<std::uint64_t>(w.number) * 2;
  }

  Eigen::VectorXd fitted_noise(const Window& window) const {
    const Library library = library_of(engine_, *setup_.effects);
    // With the candidates, as the workflow does it, whose runs these are: a cache spares them there.
    const Responses responses = simulate_responses(engine_, library, window.recording, true, setup_.jobs);
    return fit_reference(engine_, responses, window).noise.spread();
  }

  BlindSetup setup_;
  EnergyPlusEngine engine_;  // without duties: their runs cost as much again, and no size is found by them
  std::vector<std::shared_ptr<const sim::Weather>> weather_;
  std::map<BlindWindow, Prepared> prepared_;
};

}  // namespace

std::unique_ptr<BlindSite> make_rc_site(const BlindSetup& setup) { return std::make_unique<RcSite>(setup); }

std::map<bool, Eigen::VectorXd> usual_rc_noise(const BlindSetup& setup) {
  const RcSite site(setup);
  std::map<bool, Eigen::VectorXd> noise;
  for (const bool feedback : {false, true}) {
    std::vector<Eigen::VectorXd> rooms;
    for (int i = 0; i < noise_rooms; ++i) {
      rooms.push_back(site.noise_of_room(i, {i % static_cast<int>(std::ssize(setup.starts)), feedback}));
      if (setup.done) setup.done();
    }
    Eigen::MatrixXd table(rooms.front().size(), noise_rooms);
    for (int i = 0; i < noise_rooms; ++i) table.col(i) = rooms[static_cast<std::size_t>(i)];
    noise[feedback] = median_of(std::move(table));
  }
  return noise;
}

std::unique_ptr<BlindSite> make_energyplus_site(const BlindSetup& setup) {
  return std::make_unique<EnergyPlusSite>(setup);
}

}  // namespace airside::tools::gap
