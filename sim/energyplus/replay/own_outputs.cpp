#include "sim/energyplus/replay/own_outputs.hpp"

namespace airside::sim {

std::vector<ChannelOutput> own_outputs(const EnergyPlusTwin& twin) {
  using Kind = ChannelOutput::Kind;
  const OwnNames& own = twin.own.value();
  const Channels at = channels_of(twin);
  std::vector<ChannelOutput> outputs;
  const auto add = [&outputs](int column, const std::string& key, const char* variable, Kind kind = Kind::variable,
                              double factor = 1, double offset = 0) {
    if (!key.empty()) outputs.push_back({column, key, variable, kind, factor, offset});
  };
  const auto each = [&add](int first, const std::vector<std::string>& keys, const char* variable, Kind kind,
                           double factor) {
    for (std::size_t i = 0; i < keys.size(); ++i) add(first + static_cast<int>(i), keys[i], variable, kind, factor);
  };
  for (std::size_t i = 0; i < own.zones.size(); ++i) {
    const bool other = i < own.room_outputs.size() && !own.room_outputs[i].variable.empty();
    if (other)
      add(static_cast<int>(i), own.room_outputs[i].key, own.room_outputs[i].variable.c_str());
    else
      add(static_cast<int>(i), own.zones[i], "Zone Mean Air Temperature");
  }
  each(at.fcu_temp(), own.fcu_zones, "Zone Mean Air Temperature", Kind::variable, 1);
  add(at.mau_temp(), own.mau_outlet_node, "System Node Temperature");
  // The AHU's own sensor, which the plant too reports.
  add(at.supply_temp(), own.supply_air_node, "System Node Temperature", Kind::variable, 1, -twin.loops.supply_bias_k);
  const double kw_of_joule = 1 / (1000.0 * twin.step_s);
  each(at.power(), own.powers, "", Kind::meter, kw_of_joule);
  for (std::size_t i = 0; i < own.power_outputs.size(); ++i) {
    const OwnOutput& other = own.power_outputs[i];
    if (other.variable.empty()) continue;
    add(at.power() + static_cast<int>(i), other.key, other.variable.c_str(), Kind::variable,
        other.variable.ends_with("Energy") ? kw_of_joule : 1e-3);
  }
  each(at.fcu_duty(), own_parts(twin.model, own).fcu_fans, "Fan Electricity Rate", Kind::runs, 1);
  if (at.dampers > 0) each(at.damper(), own.terminals, "Zone Air Terminal VAV Damper Position", Kind::variable, 1);
  return outputs;
}

}  // namespace airside::sim
