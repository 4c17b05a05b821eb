#pragma once
// Effects that a model may lack, and parameters that it may have wrong: each is one file of sim/effects/library, with
// what it changes in the RC room, in the EnergyPlus model, in the recorded commands, the clock and the sensors. The gap
// workflow never edits a model by any other way.

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "sim/energyplus/options.hpp"
#include "sim/rc/rc_room.hpp"
#include "sim/weather/recording.hpp"

namespace airside::sim {

/// What an effect is at: one instance a place.
enum class PlaceKind { floor, facade, zone, vav, fcu, vav_pair };

/// How a magnitude m changes a value x, with m' = offset + factor m.
enum class By {
  multiply,  ///< x m'
  add,       ///< x + m'
  set,       ///< m'
  raise,     ///< max(x, m')
  lower,     ///< min(x, m')
  drift,     ///< x + m' days since the start
  lag,       ///< first-order lag of m' s
  exchange,  ///< m' of the other sensor of the pair, 1 - m' of its own
  jet,       ///< m' of the supply temperature, 1 - m' of its own
  divide,    ///< x / m'
  shift,     ///< of a schedule: m' h later
};

/// How an object of a model that somebody else wrote stands to an effect's place.
enum class Select {
  model,      ///< any of its type
  zones,      ///< in the place's zone, or in the zones of the loop
  terminals,  ///< the air terminal of those zones
  air_loop,   ///< fan, coil or outdoor-air controller of the loop
  windows,  ///< outermost layer of its type in the windows of those zones; at a façade in copies for its windows alone
  walls,    ///< the layer that insulates most in each outer construction of those zones
};

/// One change. In names and texts {n} is the 1-based place, {zone} the model's zone there, {facade} "south",
/// {Facade} "South", {m} the number m'.
struct EffectOp {
  enum class On { room, model, loop, command, clock, weather, sensor, selected };
  On on = On::room;
  std::string type;                   ///< model: object type
  std::string name;                   ///< model: object name, `*` matches anything
  std::string field;                  ///< room, model, loop: field; command, weather, sensor: which
  Select select = Select::model;      ///< selected: how the object stands to the effect's place
  std::vector<std::string> fields;    ///< selected: each that the object has
  nlohmann::json object;              ///< model: a new object instead of a field; a text that is "{m}" becomes m'.
                                      ///< selected: a new one where no field was found
  bool per_area = false;              ///< selected: m' is times the zone's floor area, m2
  PlaceKind each = PlaceKind::floor;  ///< zone, vav or fcu: at every one; floor: at the effect's own place
  By by = By::add;
  double factor = 1, offset = 0;
  double lowest = -std::numeric_limits<double>::infinity();  ///< model, loop: the changed value is kept within
  double highest = std::numeric_limits<double>::infinity();
};

/// One file of sim/effects/library.
struct Effect {
  std::string name, title, unit;
  PlaceKind place = PlaceKind::floor;
  double null_value = 0;                         ///< magnitude at which nothing at all is changed
  double low = 0, high = 0;                      ///< physical bounds
  double least = 0;                              ///< nearer to null it is not this effect; null: there is no such bound
  std::array<double, 2> probe{};                 ///< magnitudes at which its response is simulated
  double prior_sd = 0;                           ///< > 0: also a parameter that no twin knows exactly,
  bool prior_on_energyplus = true;               ///< false: on the RC room alone
  bool candidate = true;                         ///< false: a parameter only, never named
  std::string looks_like, confirm;               ///< in words, for people
  std::vector<EffectOp> rc, energyplus, common;  ///< common: commands, clock, weather, sensors
  std::vector<EffectOp> any_model;               ///< of an EnergyPlus model that somebody else wrote
  bool on_rc = true, on_energyplus = true, on_any_model = true;
  std::string file;

  /// Sensors are exchanged or not, never by a tenth.
  bool plausible(double magnitude) const { return std::abs(magnitude - null_value) >= std::abs(least - null_value); }
};

/// An effect at a place.
struct EffectAt {
  const Effect* effect = nullptr;
  int place = 0;  ///< 0-based; façade: order of Facade
  /// "solar_gain@south", "vav_flow@3", "infiltration".
  std::string id() const;
  /// "solar gain through the south façade".
  std::string text() const;
};

/// An effect at a place and a magnitude.
struct EffectChange {
  EffectAt at;
  double magnitude = 0;
};

/// All files of a folder, in order of name.
/// Errors: hal::InputError with file and key: unknown key, wrong type, a field that the room does not have, a change
/// that its target cannot take, a placeholder that the place does not fill, bounds that do not hold null and probes.
std::vector<Effect> load_effects(const std::filesystem::path& folder);

/// `effects` without "sun_differs": the weather file's sun was measured on the site itself.
std::vector<Effect> with_sun_on_site(std::vector<Effect> effects);

/// sim/effects/library beside the models.
std::filesystem::path find_effects();

/// The two VAVs of pair number `place`: 1-2, 1-3, .. 2-3, ...; 0-based.
std::pair<int, int> vav_pair(int place, int vavs);

/// Every place of an effect on a room of these counts; façades: those with windows.
std::vector<EffectAt> places_of(const Effect& effect, const Channels& channels,
                                const std::array<bool, facades>& has_facade);

/// Changes in order; every field stays within its range.
RcRoom changed_room(RcRoom room, std::span<const EffectChange> changes);
/// Commands, clock and weather as they truly were, if the changes are true. A share of the time that a box or fan coil
/// runs becomes rows in which it does and rows in which it does not: both engines know on and off only.
Recording changed_recording(Recording recording, std::span<const EffectChange> changes);
/// What the sensors show of a table of true values.
ChannelTable changed_sensors(ChannelTable table, const Channels& channels, std::span<const EffectChange> changes);

/// The changes to a model as one merge patch (RFC 7386); empty where they do not touch it.
/// Errors: hal::InputError when no object matches, or its field is no number.
nlohmann::json model_patch(const nlohmann::json& model, const ModelNames& names, std::span<const EffectChange> changes);
/// `ops`: the list that names the loops.
RoomLoopOptions changed_loops(RoomLoopOptions loops, std::span<const EffectChange> changes,
                              const std::vector<EffectOp> Effect::*ops = &Effect::energyplus);
/// What a change makes of a number, kept within the change's bounds; m' as of the magnitude.
double changed_number(const EffectOp& op, double x, double magnitude);

}  // namespace airside::sim
