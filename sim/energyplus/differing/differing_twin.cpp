#include "sim/energyplus/differing/differing_twin.hpp"

#include "sim/energyplus/differing/other_numbers.hpp"
#include "sim/energyplus/differing/other_objects.hpp"

namespace airside::sim {

EnergyPlusTwin differing_twin(EnergyPlusTwin twin, std::uint64_t seed, double share) {
  perturb_numbers(twin.model, seed, share);
  perturb_loops(twin.loops, seed, share);
  const nlohmann::json nominal = twin.model;
  const double modulation = seed % 2 == 1 ? modulation_of(seed) : 0;
  twin.model = other_objects(nominal, nominal, twin.names, twin.loops, {seed, modulation});
  return twin;
}

}  // namespace airside::sim
