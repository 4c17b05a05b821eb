// Every template of lib, instantiated under the flags that lib is held to, so that tests can look at its object code.

#include "airside/blob.hpp"
#include "airside/reading.hpp"
#include "airside/room_head.hpp"
#include "airside/row_window.hpp"
#include "airside/scaler.hpp"
#include "airside/topology.hpp"
#include "airside/validation.hpp"

namespace airside {

template class BlobCodec<FiveZone, 28773>;
template class RoomHead<FiveZone>;
template class RoomHead<ThreeVav>;
template class RoomHead<EightVavFourFcu>;
template class RowWindow<FiveZone>;
template struct Scaler<FiveZone>;
template class ScalerFit<FiveZone>;
template class Validator<FiveZone>;
template class Validator<ThreeVav>;
template class Validator<EightVavFourFcu>;

}  // namespace airside
