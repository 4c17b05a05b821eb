#pragma once
// What each reason asks for, why it is there and how it ends: one row a reason, checked by the compiler.

#include <array>
#include <cstddef>
#include <initializer_list>

#include "airside/supervision/control_mode.hpp"

namespace airside {

/// What a reason asks for. Texts are whole phrases for log, status and page.
struct ModeRequest {
  Reason reason;
  const char* name;
  ControlMode mode;
  bool beats = true;        ///< the heartbeat goes on, also while nothing is written
  bool for_person = false;  ///< ends only when a person hands the AHU back
  const char* why;
  const char* way_out;
};

/// One row a reason, in the order of their numbers.
constexpr auto mode_table = std::to_array<ModeRequest>({
    {.reason = Reason::none,
     .name = "none",
     .mode = ControlMode::learn,
     .why = "all is well",
     .way_out = "none needed"},
    {.reason = Reason::setpoint_altered,
     .name = "setpoint altered",
     .mode = ControlMode::learn,
     .why = "the AHU took another setpoint than the one written, shows one that cannot be, or answers no write",
     .way_out = "ends with the first setpoint that is taken as written; look for limits and local control in the AHU, "
                "for what stops writes on the way, and for the setpoint's scale and limits in the point map (airside "
                "probe)"},
    {.reason = Reason::storage_failed,
     .name = "storage failed",
     .mode = ControlMode::learn,
     .why = "state or log cannot be written",
     .way_out = "ends with the first write that succeeds; look at the disk"},
    {.reason = Reason::signal_held,
     .name = "signal held",
     .mode = ControlMode::run,
     .why = "a signal stands in with its last good value",
     .way_out = "ends when the signal is back"},
    {.reason = Reason::room_disagrees,
     .name = "room disagrees",
     .mode = ControlMode::run,
     .why = "one room sensor is far from all others, whose median stands in",
     .way_out = "ends when it is back among them; look at that sensor"},
    {.reason = Reason::sensor_drifts,
     .name = "sensor drifts",
     .mode = ControlMode::run,
     .why = "one room sensor has moved away from the others for days",
     .way_out = "ends when it stays where it is for two weeks; compare that sensor with a thermometer"},
    {.reason = Reason::supply_ignores_setpoint,
     .name = "supply ignores setpoint",
     .mode = ControlMode::run,
     .why = "supply air stays away from its setpoint",
     .way_out = "ends when it follows again; look at valve, coil and fan"},
    {.reason = Reason::no_excitation,
     .name = "no excitation",
     .mode = ControlMode::run,
     .why = "the setpoint has hardly moved for a day, nothing can be learned from that",
     .way_out = "ends when it moves"},
    {.reason = Reason::learning_refused,
     .name = "learning refused",
     .mode = ControlMode::run,
     .why = "every update of the weights was refused for a day",
     .way_out = "ends after a day"},
    {.reason = Reason::worse_than_schedule,
     .name = "worse than schedule",
     .mode = ControlMode::run,
     .why = "rooms are further from target than the schedule would have them",
     .way_out = "ends when they are closer again"},
    {.reason = Reason::no_weights,
     .name = "no weights",
     .mode = ControlMode::expert,
     .why = "there are no weights yet",
     .way_out = "ends with the first weights; airside push"},
    {.reason = Reason::signal_lost,
     .name = "signal lost",
     .mode = ControlMode::expert,
     .why = "a signal is gone for longer than it may be held",
     .way_out = "ends when the signal is back"},
    {.reason = Reason::no_reading,
     .name = "no reading",
     .mode = ControlMode::expert,
     .why = "the AHU does not answer",
     .way_out = "ends with the first answer; look at the bus"},
    {.reason = Reason::forecast_invalid,
     .name = "forecast invalid",
     .mode = ControlMode::expert,
     .why = "network and head give no number",
     .way_out = "ends with the first forecast"},
    {.reason = Reason::gain_reversed,
     .name = "gain reversed",
     .mode = ControlMode::expert,
     .why = "rooms get warmer when supply air gets colder",
     .way_out = "ends when the schedule's days show a sane answer; look for a heating AHU or exchanged sensors"},
    {.reason = Reason::write_refused,
     .name = "write refused",
     .mode = ControlMode::expert,
     .why = "the AHU refused a setpoint",
     .way_out = "ends with the first setpoint that is taken; look at limits and rights of the register"},
    {.reason = Reason::clock_not_set,
     .name = "clock not set",
     .mode = ControlMode::expert,
     .why = "the clock cannot be right",
     .way_out = "ends when it is set"},
    {.reason = Reason::crash_loop,
     .name = "crash loop",
     .mode = ControlMode::expert,
     .why = "the daemon was started too often in ten minutes",
     .way_out = "ends after an hour without a restart"},
    {.reason = Reason::state_lost,
     .name = "state lost",
     .mode = ControlMode::expert,
     .for_person = true,
     .why = "no saved state is whole and of this version, though there was one",
     .way_out = "ends when weights are pushed or the AHU is handed back; look at the disk"},
    {.reason = Reason::worse_for_long,
     .name = "worse for long",
     .mode = ControlMode::expert,
     .why = "rooms were further from target than the schedule would have had them, for a working day",
     .way_out = "ends after a day under the schedule"},
    {.reason = Reason::overridden,
     .name = "overridden",
     .mode = ControlMode::release,
     .why = "somebody else has set the setpoint",
     .way_out = "ends after the override's time, or when the AHU is handed back"},
    {.reason = Reason::two_masters,
     .name = "two masters",
     .mode = ControlMode::release,
     .beats = false,
     .for_person = true,
     .why = "somebody else sets the setpoint again and again, or another airsided has taken this one's state folder",
     .way_out = "ends when the AHU is handed back; find the other master"},
    {.reason = Reason::writes_refused,
     .name = "writes refused",
     .mode = ControlMode::release,
     .beats = false,
     .why = "the AHU refused the schedule's setpoint too",
     .way_out = "tried again every hour, and when the AHU is handed back"},
    {.reason = Reason::map_differs,
     .name = "map differs",
     .mode = ControlMode::release,
     .beats = false,
     .why = "the device is not the one that the point map describes",
     .way_out = "ends when it is; correct points.csv or the address"},
    {.reason = Reason::released_by_hand,
     .name = "released by hand",
     .mode = ControlMode::release,
     .beats = false,
     .for_person = true,
     .why = "an operator has released the AHU",
     .way_out = "ends when it is handed back"},
    {.reason = Reason::map_refused,
     .name = "map refused",
     .mode = ControlMode::learn,
     .why = "the device refuses a request that the point map makes",
     .way_out = "ends when it answers; correct function, address or type in points.csv, airside probe shows which"},
    {.reason = Reason::gateway_failed,
     .name = "gateway failed",
     .mode = ControlMode::learn,
     .why = "a gateway does not reach the device behind it",
     .way_out = "ends when it does; look at the gateway and at unit_id"},
    {.reason = Reason::order_doubted,
     .name = "order doubted",
     .mode = ControlMode::learn,
     .why = "a value makes sense only in another order of its words",
     .way_out = "ends when it makes sense as the map has it; airside probe shows which order fits"},
    {.reason = Reason::forecasts_doubted,
     .name = "forecasts doubted",
     .mode = ControlMode::learn,
     .why = "the room's forecasts have been so wrong for a day that the schedule has the say",
     .way_out = "ends when they come true again; look for what has changed in the room, or push other weights"},
    {.reason = Reason::authority_lost,
     .name = "authority lost",
     .mode = ControlMode::learn,
     .why = "the setpoint has been at its limit for hours and the rooms do not follow",
     .way_out =
         "ends when they come nearer to their target; look at coil, fan, dampers, and at the range in [setpoint]"},
});
constexpr int reason_count = static_cast<int>(mode_table.size());

/// Whether row i is that of reason i, and says in words what it is, why and how it ends.
constexpr bool is_complete(const decltype(mode_table)& table) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    const ModeRequest& row = table[i];
    if (static_cast<std::size_t>(row.reason) != i) return false;
    for (const char* text : {row.name, row.why, row.way_out}) {
      if (text == nullptr || *text == '\0') return false;
    }
    // Whoever waits for a person must have taken the control away from the weights.
    if (row.for_person && row.mode < ControlMode::expert) return false;
    // The heartbeat stops only where nothing is written.
    if (!row.beats && row.mode != ControlMode::release) return false;
  }
  return true;
}
static_assert(is_complete(mode_table));

/// The row of a reason. A number that is none, as from a damaged state, asks for release until a person comes.
constexpr ModeRequest request_of(Reason reason) {
  const auto i = static_cast<std::size_t>(reason);
  if (i < mode_table.size()) return mode_table[i];
  return {.reason = reason,
          .name = "unknown",
          .mode = ControlMode::release,
          .beats = false,
          .for_person = true,
          .why = "unknown",
          .way_out = "unknown"};
}

/// The control mode of a controller, and why.
struct ActiveMode {
  ControlMode mode = ControlMode::learn;
  Reason reason = Reason::none;
  bool operator==(const ActiveMode&) const = default;
};

constexpr const char* text_of(Reason reason) { return request_of(reason).name; }
/// What people read of it. The schedule without a reason is where every controller begins.
constexpr const char* why_of(ActiveMode on) {
  return on == ActiveMode{ControlMode::expert, Reason::none} ? "it has decided nothing yet" : request_of(on.reason).why;
}
constexpr const char* way_out_of(ActiveMode on) {
  return on == ActiveMode{ControlMode::expert, Reason::none} ? "ends with its first cycle"
                                                             : request_of(on.reason).way_out;
}

}  // namespace airside
