#include "hal/site/site_stand_ins.hpp"

#include <vector>

#include "airside/topology.hpp"
#include "hal/text/input_error.hpp"

namespace airside::hal {
namespace {

/// What cannot be made up: without it there is nothing to control, or to control with.
void refuse_needed(const TomlSection& table, const std::string& key) {
  const bool room = key == "room_temp" || key.starts_with("room_temp_");
  if (!room && key != "setpoint") return;
  throw InputError(table.place(key), "a stand-in for `" + key + "`",
                   room ? "a sensor in each room: its temperature is what is controlled"
                        : "a register: the supply-air setpoint is what is written",
                   "remove the line, and add the row to the point map");
}

}  // namespace

StandIns read_stand_ins(TomlSection table, const std::string& topology) {
  StandIns stand_ins;
  const Shape shape = parse_shape(topology.c_str());
  const SignalCounts counts{shape.vavs, shape.fcus, shape.powers};
  for (const std::string& key : table.take_all_keys()) {
    refuse_needed(table, key);
    const auto kind = StandIns::kind_of(key, counts);
    if (!kind) {
      const std::vector<std::string> known = StandIns::names(counts);
      const std::string near = nearest_name(key, known);
      throw InputError(table.place(key), "an unknown signal `" + key + "`",
                       "a signal of " + topology +
                           " by its name in the point map, or a kind: vav_on, fcu_temp, "
                           "fcu_on, power, mau_temp, outdoor_temp, rain",
                       near.empty() ? "remove it" : "did you mean `" + near + "`?");
    }
    const StandIns::Plausible limits = StandIns::plausible(*kind);
    stand_ins.set(key, table.number(key, limits.usual, limits.min, limits.max, text_of(*kind).unit));
  }
  return stand_ins;
}

}  // namespace airside::hal
