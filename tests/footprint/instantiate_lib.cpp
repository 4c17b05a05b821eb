// Every template of lib, instantiated under the flags that lib is held to, so that tests can look at its object code.

#include "airside/controller/blob.hpp"
#include "airside/controller/instances.hpp"
#include "airside/controller/weight_trial.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/learning/row_window.hpp"
#include "airside/network/scaler.hpp"
#include "airside/reading.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

template class BlobCodec<FiveZone, 28773>;
template class RoomHead<FiveZone>;
template class RoomHead<ThreeVav>;
template class RoomHead<EightVavFourFcu>;
template class RowWindow<FiveZone>;
template struct Scaler<FiveZone>;
template class ScalerFit<FiveZone>;
template class Validator<FiveZone>;
template class WeightTrial<FiveZone>;  // the policy of trial and rollback needs nothing but lib
template class Validator<ThreeVav>;
template class Validator<EightVavFourFcu>;

}  // namespace airside
