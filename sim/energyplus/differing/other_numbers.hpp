#pragma once
// The numbers of an EnergyPlus room that differs from its twin, in the twin's objects.

#include <nlohmann/json.hpp>

#include "sim/energyplus/options.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::sim {

/// Draws of rooms that differ.
constexpr std::uint64_t draw_built = 730;

/// Numbers one after the other, for what is drawn in a fixed order.
class Lots {
 public:
  Lots(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}
  double uniform(double low, double high) { return low + (high - low) * draw_uniform(seed_, stream_, next_++, 0); }
  /// 1 + size, size drawn from half the figure up to the figure, either sign: 10 to 20 % for 0.2.
  double factor(double width) {
    const double x = uniform(-0.5, 0.5);
    return 1 + width * (x < 0 ? x - 0.5 : x + 0.5);
  }
  double shift(double width) { return factor(width) - 1; }

 private:
  std::uint64_t seed_, stream_, next_ = 0;
};

/// Multiplies a number of an object; nothing where it is absent or no number.
void scale_field(nlohmann::json& object, const char* field, double factor);

/// Calls f(name, object) for every object of a type.
template <class F>
void each_object(nlohmann::json& model, const char* type, F&& f) {
  if (!model.contains(type)) return;
  for (auto& [name, object] : model[type].items()) f(name, object);
}

/// Envelope, mass, gains, flows, leaks, coils: 10 to 20 % of each. Objects that are absent stay so.
void perturb_numbers(nlohmann::json& model, std::uint64_t seed);

/// The loops' numbers, and what the room's weather differs by from the station's.  An AHU is 1.1 to 1.8 times as
/// slow.
WeatherChange perturb_loops(RoomLoopOptions& loops, std::uint64_t seed);

/// How much the boxes of such a room open a kelvin, where they do: 0.02 to 0.06 /K.
double modulation_of(std::uint64_t seed);

}  // namespace airside::sim
