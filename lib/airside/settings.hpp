#pragma once
// Every number that a person may choose about control and learning, with meaning, default and range. The defaults are
// those of the printed method; presets.hpp has whole sets.

#include <array>

#include "airside/civil_time.hpp"
#include "airside/demand_settings.hpp"
#include "airside/held_rooms.hpp"
#include "airside/memory_size.hpp"
#include "airside/topology.hpp"

namespace airside {

constexpr int max_candidates = 192;  ///< setpoints scored in one decision

struct ControllerSettings {
  Shape shape;  ///< counts of the site; of the site file. Only capacity classes read them (topology.hpp)
  // Goal and schedule
  Objective objective = Objective::mean;  ///< docs/method.md 17 for `band`
  DemandSettings demand{};                ///< of the objective `band`
  double target_degc = 25.25;             ///< room temperature to hold (docs/method.md 1)
  HeldRooms held{};                       ///< which value of the rooms that is; of the site file (docs/method.md 16.7)
  double work_start_h = 7.0;              ///< hours; scoring and the expert's day start here (docs/method.md 2)
  double work_end_h = 19.0;               ///< hours
  int weekday_only = 0;                   ///< 1: Saturday and Sunday are days off, for schedule, scoring and room head
  int daylight_saving = 0;                ///< 0 none, 1 European Union, 2 United States (civil_time.hpp)
  double utc_offset_h = 0;                ///< of local standard time, hours east; the European rule needs it
  double expert_work_degc = 20.5;         ///< schedule in working hours (docs/method.md 6.3)
  double expert_off_degc = 25.0;          ///< schedule outside
  // When the AHU's fan runs, where no point shows it. While it rests, supply air cannot follow its setpoint.
  double fan_start_h = 0.0, fan_end_h = 24.0;  ///< hours; 0 to 24: always on
  int fan_weekday_only = 0;                    ///< 1: it rests on Saturday and Sunday
  int cycle_min = 18;  ///< control cycle: 6, 12, 18 or 24 min; `band` knows 18 alone (docs/method.md 2)
  // Action set (docs/method.md, open point 15)
  double action_min_degc = 20.0, action_max_degc = 26.0;
  double action_step_k = 0.1;
  double refine_step_k = 0.0;  ///< 0 off; else a second, finer grid around the best candidate

  // Score (6.1)
  double score_alpha = 1.0;   ///< a_s, weight of |S_long - target|
  double score_beta = 0.9;    ///< b_s, weight of |S_long - S|
  double tie_degc = 1e-6;     ///< scores closer than this tie (docs/method.md, open point 16)
  double move_penalty = 0.0;  ///< per K^2, calms the network's choice
  double gamma = 0.5;         ///< g, discount of the long-term prediction
  int long_term = 1;          ///< 0: the short-term prediction is scored in place of the long-term one

  // Confidence (6.2)
  double confidence_smoothing = 0.2;  ///< b_c
  double confidence_scale = 1.0;      ///< sigma_c
  double confidence_initial = 0.5;    ///< c_0
  double confidence_full = 1.0;       ///< c at and above which the schedule has no weight
  int confidence_strb_only = 0;       ///< 1: loss is L_STRB alone
  double confidence_error_k = 0.0;    ///< 0: loss is the network's; else (forecast error / this)^2

  // Losses (4)
  double weight_strb = 1, weight_tdb = 1, weight_gc = 1, weight_rc = 1, weight_rec = 1;
  double label_vav = 1.0;  ///< relation label of "VAV on" (docs/method.md, open point 4)

  // Learning (5)
  double learning_rate = 1e-3;
  double adam_beta1 = 0.9, adam_beta2 = 0.999, adam_epsilon = 1e-8;
  int target_sync_steps = 100;
  int batch = 1000;
  int updates_per_cycle = 10;
  int recent_in_batch = 0;        ///< number of newest transitions in every batch
  int gate = 0;                   ///< 1: new weights must pass the acceptance gate
  double gate_loss_ratio = 1.25;  ///< held-back loss may grow by this factor at most

  // Room head (docs/method.md 16.2)
  int head = 0;                                     ///< 1: the room head corrects the network's forecast
  double head_correction = 0.95;                    ///< share of the present error removed in one cycle
  double head_noise_k = 0.04;                       ///< sd of one innovation
  double head_clip_k = 0.15;                        ///< innovations are clipped here
  double head_moving_average = -0.1;                ///< weight of the last innovation
  double head_profile_sd_k = 0.04;                  ///< prior sd of a profile slot
  double head_profile_length = 4;                   ///< slots over which the profile is smooth
  double head_growth_per_day = 0.03;                ///< share of the profile's prior variance that returns each day
  double head_walk_per_day = 0.003;                 ///< sd by which each other coefficient drifts in a day
  double head_gain_min = 0.2, head_gain_max = 1.2;  ///< K/K, bounds of the setpoint gain
  double head_gain_prior = 0.6, head_gain_prior_sd = 0.3;
  double head_weight = 1.0;      ///< weight of the head when both forecasts err alike, 0..1
  int head_day_types = 0;        ///< 1: one profile; 2: another one for days off; 0: 2 where memory has it
  double head_days_alike = 0.8;  ///< share of the profile's prior that days off have in common with working days

  // Safety envelope
  double limit_min_degc = 18.0;  ///< nothing below is written, but on the way from further outside (envelope.hpp)
  double limit_max_degc = 27.0;
  double limit_change_k = 6.0;  ///< largest change from one cycle to the next
  int outside_jump = 0;         ///< 1: a setpoint found outside the limits is brought inside at once, not in steps
  double round_k = 0.01;        ///< resolution of what is written (docs/method.md, open point 18)
  /// The AHU's register holds offset + n * step, and is read back in steps of its own; 0: any value. Of the point map.
  double register_step_k = 0, register_offset_degc = 0, readback_step_k = 0;
  double hold_s = 1080;       ///< a lost signal keeps its last good value so long
  double writes_per_day = 0;  ///< 0: no limit; else setpoints written on average, for registers in EEPROM

  // Mode arbiter (docs/box-and-safety.md, "Thresholds")
  double frozen_s = 3600;          ///< all signals unchanged for so long: the device repeats itself
  double disagree_k = 8.0;         ///< a room so far from the median of all is not believed
  double drift_k = 1.0;            ///< a room so far from where it was against the others drifts
  double supply_ignored_k = 1.5;   ///< supply air so far from its setpoint ignores it
  double supply_ignored_s = 5400;  ///< when it has lasted so long
  double authority_k = 0.5;        ///< rooms so far from target with the setpoint at its limit do not follow
  double authority_s = 7200;       ///< when it has lasted so long in working hours
  double excitation_k = 0.05;      ///< sd of a day's setpoints below which nothing is learned
  double worse_k = 0.15;           ///< further from target than the schedule's shadow by so much
  double worse_h = 12.0;           ///< working hours until the schedule takes over for a day
  double override_h = 4.0;         ///< somebody else's setpoint is left alone for so long
  double trust_ratio = 0.10;       ///< one cycle's learning may move the weights by this share of their norm
  int refused_updates = 80;        ///< number in a row that freezes the weights for a day
};

/// One overridable setting: its name in site files, where it lives, its bounds.
struct SettingEntry {
  const char* name;
  double ControllerSettings::*real;
  int ControllerSettings::*whole;
  double min, max;
};

#define AIRSIDE_REAL(field, lo, hi) \
  SettingEntry { #field, &ControllerSettings::field, nullptr, lo, hi }
#define AIRSIDE_WHOLE(field, lo, hi) \
  SettingEntry { #field, nullptr, &ControllerSettings::field, lo, hi }

/// Every setting by name. Shape: one entry a field of ControllerSettings.
constexpr auto setting_table = std::to_array<SettingEntry>({
    AIRSIDE_WHOLE(cycle_min, 6, 24),
    AIRSIDE_REAL(target_degc, 10, 40),
    AIRSIDE_REAL(work_start_h, 0, 24),
    AIRSIDE_REAL(work_end_h, 0, 24),
    AIRSIDE_WHOLE(weekday_only, 0, 1),
    AIRSIDE_WHOLE(daylight_saving, 0, 2),
    AIRSIDE_REAL(utc_offset_h, -12, 14),
    AIRSIDE_REAL(expert_work_degc, 5, 40),
    AIRSIDE_REAL(expert_off_degc, 5, 40),
    AIRSIDE_REAL(fan_start_h, 0, 24),
    AIRSIDE_REAL(fan_end_h, 0, 24),
    AIRSIDE_WHOLE(fan_weekday_only, 0, 1),
    AIRSIDE_REAL(action_min_degc, 5, 40),
    AIRSIDE_REAL(action_max_degc, 5, 40),
    AIRSIDE_REAL(action_step_k, 0.05, 2),
    AIRSIDE_REAL(refine_step_k, 0, 0.1),
    AIRSIDE_REAL(score_alpha, 0, 10),
    AIRSIDE_REAL(score_beta, 0, 10),
    AIRSIDE_REAL(tie_degc, 0, 0.1),
    AIRSIDE_REAL(move_penalty, 0, 10),
    AIRSIDE_REAL(gamma, 0, 0.99),
    AIRSIDE_WHOLE(long_term, 0, 1),
    AIRSIDE_REAL(confidence_smoothing, 0, 1),
    AIRSIDE_REAL(confidence_scale, 1e-3, 1e3),
    AIRSIDE_REAL(confidence_initial, 0, 1),
    AIRSIDE_REAL(confidence_full, 0.1, 1),
    AIRSIDE_WHOLE(confidence_strb_only, 0, 1),
    AIRSIDE_REAL(confidence_error_k, 0, 10),
    AIRSIDE_REAL(weight_strb, 0, 100),
    AIRSIDE_REAL(weight_tdb, 0, 100),
    AIRSIDE_REAL(weight_gc, 0, 100),
    AIRSIDE_REAL(weight_rc, 0, 100),
    AIRSIDE_REAL(weight_rec, 0, 100),
    AIRSIDE_REAL(label_vav, -1, 1),
    AIRSIDE_REAL(learning_rate, 0, 1),
    AIRSIDE_REAL(adam_beta1, 0, 0.9999),
    AIRSIDE_REAL(adam_beta2, 0, 0.999999),
    AIRSIDE_REAL(adam_epsilon, 1e-12, 1),
    AIRSIDE_WHOLE(target_sync_steps, 1, 100000),
    AIRSIDE_WHOLE(batch, 1, max_batch),
    AIRSIDE_WHOLE(updates_per_cycle, 0, 100),
    AIRSIDE_WHOLE(recent_in_batch, 0, max_batch),
    AIRSIDE_WHOLE(gate, 0, 1),
    AIRSIDE_REAL(gate_loss_ratio, 1, 100),
    AIRSIDE_WHOLE(head, 0, 1),
    AIRSIDE_REAL(head_correction, 0, 1.5),
    AIRSIDE_REAL(head_noise_k, 1e-3, 10),
    AIRSIDE_REAL(head_clip_k, 1e-3, 10),
    AIRSIDE_REAL(head_moving_average, -0.99, 0.99),
    AIRSIDE_REAL(head_profile_sd_k, 0, 10),
    AIRSIDE_REAL(head_profile_length, 0.1, 80),
    AIRSIDE_REAL(head_growth_per_day, 0, 1),
    AIRSIDE_REAL(head_walk_per_day, 0, 1),
    AIRSIDE_REAL(head_gain_min, 1e-3, 10),
    AIRSIDE_REAL(head_gain_max, 1e-3, 10),
    AIRSIDE_REAL(head_gain_prior, 0, 10),
    AIRSIDE_REAL(head_gain_prior_sd, 1e-3, 10),
    AIRSIDE_REAL(head_weight, 0, 1),
    AIRSIDE_WHOLE(head_day_types, 0, max_day_types),
    AIRSIDE_REAL(head_days_alike, 0, 1),
    AIRSIDE_REAL(limit_min_degc, 0, 50),
    AIRSIDE_REAL(limit_max_degc, 0, 50),
    AIRSIDE_REAL(limit_change_k, 0.01, 50),
    AIRSIDE_WHOLE(outside_jump, 0, 1),
    AIRSIDE_REAL(round_k, 0.001, 1),
    AIRSIDE_REAL(hold_s, 0, 86400),
    AIRSIDE_REAL(writes_per_day, 0, 240),
    AIRSIDE_REAL(frozen_s, 720, 86400),
    AIRSIDE_REAL(disagree_k, 1, 50),
    AIRSIDE_REAL(drift_k, 0.1, 50),
    AIRSIDE_REAL(supply_ignored_k, 0.1, 50),
    AIRSIDE_REAL(supply_ignored_s, 0, 86400),
    AIRSIDE_REAL(authority_k, 0.1, 50),
    AIRSIDE_REAL(authority_s, 0, 86400),
    AIRSIDE_REAL(excitation_k, 0, 5),
    AIRSIDE_REAL(worse_k, 0, 10),
    AIRSIDE_REAL(worse_h, 0.3, 1000),
    AIRSIDE_REAL(override_h, 0, 168),
    AIRSIDE_REAL(trust_ratio, 1e-3, 10),
    AIRSIDE_WHOLE(refused_updates, 1, 1000000),
});

#undef AIRSIDE_REAL
#undef AIRSIDE_WHOLE
/// Whether all settings lie in their range and agree with one another.
constexpr bool settings_valid(const ControllerSettings& s) {
  for (const SettingEntry& e : setting_table) {
    const double v = e.real != nullptr ? s.*e.real : static_cast<double>(s.*e.whole);
    if (!(v >= e.min && v <= e.max)) return false;
  }
  const double candidates = (s.action_max_degc - s.action_min_degc) / s.action_step_k;
  return fits_objective(s.objective, s.cycle_min) && demand_settings_valid(s.demand) &&
         held_rooms_valid(s.held, s.shape.vavs) && s.work_start_h < s.work_end_h && s.fan_start_h < s.fan_end_h &&
         s.action_min_degc < s.action_max_degc && candidates < max_candidates - 1 &&
         s.limit_min_degc < s.limit_max_degc && s.head_gain_min < s.head_gain_max;
}

constexpr ControlCycle control_cycle(const ControllerSettings& s) { return cycle_of_minutes(s.cycle_min); }
/// People's clock at standard time t.
constexpr CivilTime local_time(const ControllerSettings& s, CivilTime t) {
  return local_time(static_cast<DaylightSaving>(s.daylight_saving), s.utc_offset_h, t);
}

}  // namespace airside
