#include "band_faults/band_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "airside/controller/cycle.hpp"
#include "airside/network/kernels/kernels.hpp"
#include "airside/presets.hpp"
#include "hal/points/signal_limits.hpp"
#include "sim/rc/modulating_room.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/default_cycle.hpp"

namespace airside::band_faults {
namespace {

constexpr Shape five_zones{5, 0, 2};
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

ControllerSettings band_settings() {
  ControllerSettings s = product_settings();
  s.objective = Objective::band;
  s.shape = five_zones;
  s.action_min_degc = s.limit_min_degc = 12;
  s.action_max_degc = s.limit_max_degc = 18;
  s.expert_work_degc = s.expert_off_degc = 14;
  return s;
}

struct Quiet {
  bool row(CivilTime, const Expected<Reading<BandSite>>&, const Controller<BandSite>&) const { return true; }
};

}  // namespace

void BandWatch::add(const BandWatch& other) {
  for (auto member :
       {&BandWatch::cycles, &BandWatch::writes, &BandWatch::not_finite, &BandWatch::outside, &BandWatch::beyond_a_step,
        &BandWatch::while_released, &BandWatch::blind, &BandWatch::blind_chosen, &BandWatch::model_broken}) {
    this->*member += other.*member;
  }
  if (first.empty()) first = other.first;
}

BandBefore::BandBefore()
    : settings(band_settings()),
      counts(hal::counts_of(five_zones)),
      points(hal::PointMap::parse(hal::default_point_map(5, 0, 2, {}, true), "points.csv")),
      controller(std::make_unique<Controller<BandSite>>()) {
  const sim::ModulatingRoom room = sim::modulating_room("mild", 1, five_zones.vavs, five_zones.powers);
  const CivilTime start = sim::civil_midnight(2021, 4, 8);
  plant = std::make_unique<sim::ModulatingPlant>(room, sim::synthetic_weather(78, room.climate), start, 1);
  controller->configure(settings, hal::signal_limits<BandSite>(points, five_zones), strict_kernels<float>(), 1);
  sim::SimulatedPlant<BandSite> registers(*plant, points, five_zones);
  sim::SimulatedClock clock(*plant);
  Quiet quiet;
  const CivilTime until{start.seconds + 8 * seconds_per_day};
  run_cycles<BandSite>(registers, clock, *controller, quiet, start, until);
  (void)clock.sleep_until(until);
}

const BandBefore& band_before() {
  static const BandBefore before;
  return before;
}

struct BandLoop::Bus {
  BandLoop& loop;
  Expected<Reading<BandSite>> sense() { return loop.sense(); }
  Expected<Applied> actuate(const Command& command) { return loop.actuate(command); }
};

struct BandLoop::Sink {
  BandLoop& loop;
  bool row(CivilTime t, const Expected<Reading<BandSite>>& sensed, const Controller<BandSite>&) {
    loop.end_what_is_over();
    if (!starts_cycle(t)) return true;
    loop.look(sensed);
    return --loop.cycles_left_ > 0;
  }
};

BandLoop::BandLoop()
    : plant_(*band_before().plant),
      model_(plant_, sim::FaultScript{}),
      registers_(model_, band_before().points, five_zones),
      controller_(std::make_unique<Controller<BandSite>>(*band_before().controller)),
      seen_standing_degc_(model_.standing_degc()) {}

void BandLoop::cycles(int count) {
  cycles_left_ = count;
  Bus bus{*this};
  sim::SimulatedClock clock(model_);
  Sink sink{*this};
  const CivilTime end{plant_.time().seconds + (count + 2) * cycle_s};
  (void)clock.sleep_until({run_cycles<BandSite>(bus, clock, *controller_, sink, next_row(plant_.time()), end).seconds});
}

void BandLoop::begin(sim::FaultKind kind, double for_h, const std::string& signal, double magnitude) {
  const std::vector<std::string> names = sim::fault_signals(band_before().counts);
  const auto at = std::ranges::find(names, signal);
  if (!signal.empty() && at == names.end()) throw std::invalid_argument(signal);
  model_.begin(kind, for_h, signal.empty() ? -1 : static_cast<int>(at - names.begin()), magnitude);
}

void BandLoop::begin_all(sim::FaultKind kind, double for_h, const std::string& stem, double magnitude) {
  for (int place = 1; place <= five_zones.vavs; ++place) begin(kind, for_h, stem + std::to_string(place), magnitude);
}

void BandLoop::stop_fan(double for_h) {
  fan_until_h_ = hours() + for_h;
  plant_.stop_fan(true);
}

void BandLoop::hold_damper(std::size_t zone, double opening, double for_h) {
  held_.emplace_back(zone, hours() + for_h);
  plant_.hold_damper(zone, opening);
}

void BandLoop::kill() {
  const CycleState<BandSite> saved = controller_->cycle();
  const Decision decision = controller_->decision();
  auto next = std::make_unique<Controller<BandSite>>();
  next->configure(controller_->settings(), controller_->limits(), strict_kernels<float>(), 1);
  (void)next->restore(saved, 0, decision);
  controller_ = std::move(next);
}

void BandLoop::clear() {
  silent_until_h_ = fan_until_h_ = 0;
  for (auto& [zone, until_h] : held_) until_h = 0;
  end_what_is_over();
  model_.clear();
}

void BandLoop::end_what_is_over() {
  if (hours() >= fan_until_h_) plant_.stop_fan(false);
  for (const auto& [zone, until_h] : held_) {
    if (hours() >= until_h) plant_.hold_damper(zone, nan);
  }
  std::erase_if(held_, [this](const auto& held) { return hours() >= held.second; });
}

Expected<Reading<BandSite>> BandLoop::sense() {
  if (hours() < silent_until_h_) return tl::unexpected(Fault::no_reading);
  Expected<Reading<BandSite>> reading = registers_.sense();
  const bool shows = std::abs(reading->setpoint_degc - model_.standing_degc()) < 0.02;
  if (std::isfinite(reading->setpoint_degc)) seen_standing_degc_ = shows ? model_.standing_degc() : nan;
  found_degc_ = seen_standing_degc_;
  return reading;
}

Expected<Applied> BandLoop::actuate(const Command& command) {
  if (hours() < silent_until_h_) return tl::unexpected(Fault::not_applied);
  const double a = command.setpoint_degc(), standing = model_.standing_degc();
  const ControllerSettings& s = controller_->settings();
  ++watch_.writes;
  const bool way_in =
      (seen_standing_degc_ < a && a < s.limit_min_degc) || (seen_standing_degc_ > a && a > s.limit_max_degc);
  if (!std::isfinite(a)) complain(watch_.not_finite, "a setpoint that is no number");
  if (!way_in && !(a >= s.limit_min_degc && a <= s.limit_max_degc)) complain(watch_.outside, fmt::format("{} degC", a));
  if (mode() == ControlMode::release) complain(watch_.while_released, "a write in RELEASE");
  if (standing == seen_standing_degc_ && std::abs(a - standing) > s.limit_change_k + 0.011)
    complain(watch_.beyond_a_step, fmt::format("{} degC on {}", a, standing));
  const Expected<Applied> applied = registers_.actuate(command);
  seen_standing_degc_ = model_.standing_degc();
  return applied ? Expected<Applied>(Applied{model_.standing_degc()}) : applied;
}

void BandLoop::look(const Expected<Reading<BandSite>>& sensed) {
  ++watch_.cycles;
  moved_ +=
      std::abs(controller_->decision().command.setpoint_degc() - controller_->decision().expert_degc) > 0.05 ? 1 : 0;
  if (!controller_->cycle().band.power().finite()) complain(watch_.model_broken, "a power model that is not finite");
  int seen = 0;
  for (Eigen::Index i = 0; sensed && i < five_zones.vavs; ++i) {
    seen += sensed->damper(i) >= 0 && sensed->damper(i) <= 1 && std::isfinite(sensed->zone_setpoint_degc(i)) ? 1 : 0;
  }
  // While the fan rests nothing is held: what stands then is for its next start.
  if (2 * seen >= five_zones.vavs || (sensed && sensed->flows < 0.5)) return;
  ++watch_.blind;
  const Decision& d = controller_->decision();
  const double a = d.command.setpoint_degc();
  if (!sensed && d.mode < ControlMode::expert) complain(watch_.blind_chosen, "no reading, and not the schedule");
  if (!sensed || std::isnan(found_degc_) || std::abs(a - d.expert_degc) < 0.011) return;
  // From wherever the register was found, one whole step towards the schedule's.
  const double wanted = d.expert_degc - found_degc_, moved = a - found_degc_;
  const bool on_its_way =
      moved * wanted > 0 && std::abs(std::abs(moved) - controller_->settings().limit_change_k) < 0.02;
  if (!on_its_way) complain(watch_.blind_chosen, fmt::format("{} degC beside the schedule's {}", a, d.expert_degc));
}

void BandLoop::complain(std::uint64_t& count, const std::string& what) {
  ++count;
  if (watch_.first.empty()) watch_.first = fmt::format("cycle {}: {}", watch_.cycles, what);
}

// ---- The faults
namespace {

using sim::FaultKind;

double hours_of(SplitMix64& draw) { return 0.2 + 10 * draw.uniform(); }
std::string any_of(SplitMix64& draw, const char* stem) { return stem + std::to_string(1 + draw.below(5)); }
double sign(SplitMix64& draw) { return draw.below(2) == 0 ? -1.0 : 1.0; }

/// One of five, or all.
double on_zones(BandLoop& loop, SplitMix64& draw, FaultKind kind, const char* stem, double magnitude = 0) {
  const double h = hours_of(draw);
  if (draw.below(2) == 0)
    loop.begin_all(kind, h, stem, magnitude);
  else
    loop.begin(kind, h, any_of(draw, stem), magnitude);
  return h;
}

double on_one(BandLoop& loop, SplitMix64& draw, FaultKind kind, const std::string& signal, double magnitude = 0) {
  const double h = hours_of(draw);
  loop.begin(kind, h, signal, magnitude);
  return h;
}

double wrong(BandLoop& loop, SplitMix64& draw, const std::string& signal, double scale) {
  const FaultKind kinds[] = {FaultKind::set_to, FaultKind::offset, FaultKind::stuck, FaultKind::drift};
  const FaultKind kind = kinds[draw.below(4)];
  return on_one(loop, draw, kind, signal, kind == FaultKind::stuck ? 0 : sign(draw) * scale * draw.uniform());
}

}  // namespace

const std::vector<BandFault>& band_faults() {
  using L = BandLoop;
  using D = SplitMix64;
  static const std::vector<BandFault> faults = {
      {"dampers lost", [](L& l, D& d) { return on_zones(l, d, FaultKind::not_a_number, "damper_"); }},
      {"dampers out of range", [](L& l, D& d) { return on_zones(l, d, FaultKind::set_to, "damper_", 3 * sign(d)); }},
      {"dampers frozen", [](L& l, D& d) { return on_zones(l, d, FaultKind::stuck, "damper_"); }},
      {"dampers wrong", [](L& l, D& d) { return on_zones(l, d, FaultKind::set_to, "damper_", d.uniform()); }},
      {"dampers reversed", [](L& l, D& d) { return on_zones(l, d, FaultKind::reversed, "damper_"); }},
      {"a box stuck",
       [](L& l, D& d) {
         const double h = hours_of(d);
         l.hold_damper(d.below(5), d.uniform(), h);
         return h;
       }},
      {"zone setpoints lost", [](L& l, D& d) { return on_zones(l, d, FaultKind::not_a_number, "zone_setpoint_"); }},
      {"zone setpoints wrong",
       [](L& l, D& d) { return on_zones(l, d, FaultKind::set_to, "zone_setpoint_", 5 + 40 * d.uniform()); }},
      {"zone setpoints off",
       [](L& l, D& d) { return on_zones(l, d, FaultKind::offset, "zone_setpoint_", 12 * sign(d) * d.uniform()); }},
      {"heating setpoints lost",
       [](L& l, D& d) { return on_zones(l, d, FaultKind::not_a_number, "zone_heating_setpoint_"); }},
      {"heating setpoints wrong",
       [](L& l, D& d) { return on_zones(l, d, FaultKind::set_to, "zone_heating_setpoint_", 5 + 40 * d.uniform()); }},
      {"heating setpoints off",
       [](L& l, D& d) {
         return on_zones(l, d, FaultKind::offset, "zone_heating_setpoint_", 12 * sign(d) * d.uniform());
       }},
      {"a meter lost",
       [](L& l, D& d) { return on_one(l, d, FaultKind::not_a_number, d.below(2) ? "power_1" : "power_2"); }},
      {"a meter wrong", [](L& l, D& d) { return wrong(l, d, d.below(2) ? "power_1" : "power_2", 600); }},
      {"fan off",
       [](L& l, D& d) {
         const double h = hours_of(d);
         l.stop_fan(h);
         return h;
       }},
      {"the fan's status wrong", [](L& l, D& d) { return on_one(l, d, FaultKind::reversed, "ahu_on"); }},
      {"the fan's status lost", [](L& l, D& d) { return on_one(l, d, FaultKind::not_a_number, "ahu_on"); }},
      {"supply temperature lost", [](L& l, D& d) { return on_one(l, d, FaultKind::not_a_number, "supply_temp"); }},
      {"supply temperature wrong", [](L& l, D& d) { return wrong(l, d, "supply_temp", 40); }},
      {"supply flow lost", [](L& l, D& d) { return on_one(l, d, FaultKind::not_a_number, "supply_flow"); }},
      {"supply flow wrong", [](L& l, D& d) { return wrong(l, d, "supply_flow", 1e6); }},
      {"outdoor temperature lost", [](L& l, D& d) { return on_one(l, d, FaultKind::not_a_number, "outdoor_temp"); }},
      {"outdoor temperature wrong", [](L& l, D& d) { return wrong(l, d, "outdoor_temp", 60); }},
      {"rooms lost", [](L& l, D& d) { return on_zones(l, d, FaultKind::not_a_number, "room_temp_"); }},
      {"a room wrong", [](L& l, D& d) { return wrong(l, d, any_of(d, "room_temp_"), 30); }},
      {"all rooms off", [](L& l, D& d) { return on_one(l, d, FaultKind::all_offset, "", 10 * sign(d) * d.uniform()); }},
      {"the device repeats itself", [](L& l, D& d) { return on_one(l, d, FaultKind::all_stuck, ""); }},
      {"an override", [](L& l, D& d) { return on_one(l, d, FaultKind::setpoint_by_hand, "", 8 + 24 * d.uniform()); }},
      {"a competing writer",
       [](L& l, D& d) { return on_one(l, d, FaultKind::setpoint_fought, "", 8 + 24 * d.uniform()); }},
      {"the setpoint ignored", [](L& l, D& d) { return on_one(l, d, FaultKind::setpoint_ignored, ""); }},
      {"the AHU restarts", [](L& l, D& d) { return on_one(l, d, FaultKind::restarted, "", 18); }},
      {"no answer",
       [](L& l, D& d) {
         const double h = hours_of(d);
         l.no_answer(h);
         return h;
       }},
      {"the box is killed",
       [](L& l, D&) {
         l.kill();
         return 0.3;
       }},
  };
  return faults;
}

}  // namespace airside::band_faults
