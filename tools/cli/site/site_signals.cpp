#include "tools/cli/site/site_signals.hpp"

#include <fmt/format.h>

#include <vector>

#include "hal/points/point_map.hpp"
#include "tools/study/missing_signals.hpp"

namespace airside::tools {

namespace {

/// `power 4`, once where all of a kind have the same stand-in.
struct Missing {
  SignalKind kind;
  double stand_in;
  std::string names;
  int count = 0;
};

std::vector<Missing> missing_of(const hal::TopologyCounts& site) {
  std::vector<Missing> found;
  for (int i = 0; i < site.signals(); ++i) {
    const auto value = site.stand_in(i);
    if (!value) continue;
    const SignalId id = site.signal(i);
    const bool more = !found.empty() && found.back().kind == id.kind && found.back().stand_in == *value;
    if (!more) found.push_back({id.kind, *value, hal::point_name(id)});
    Missing& last = found.back();
    if (++last.count > 1) last.names = last.names.substr(0, last.names.find(" to ")) + " to " + hal::point_name(id);
  }
  return found;
}

}  // namespace

std::string signal_facts(const hal::TopologyCounts& site) {
  std::string text, sides;
  for (const Missing& m : missing_of(site)) {
    text += fmt::format("{}{} ({:g} stands in, costs {})", text.empty() ? "lacks " : ", ", m.names, m.stand_in,
                        cost_text(measured_cost_degc(m.kind)));
  }
  if (text.empty()) {
    text = "each signal is sensed";
  } else {
    text += fmt::format(
        "; as measured on {}, each kind alone: {:.3f} ± {:.3f} °C with all signals, {:.3f} ± {:.3f} °C with room "
        "temperatures, setpoint and outdoor_temp alone (`airside study signals`)",
        measured_on, measured_dae_degc.whole.mean, measured_dae_degc.whole.sd, measured_dae_degc.bare.mean,
        measured_dae_degc.bare.sd);
  }
  for (const hal::SideColumn& side : site.sides) sides += (sides.empty() ? "" : ", ") + hal::column_of(side);
  return sides.empty() ? text : text + "; also shown: " + sides;
}

}  // namespace airside::tools
