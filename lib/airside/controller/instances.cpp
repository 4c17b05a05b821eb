#include "airside/controller/instances.hpp"

#include "airside/controller/blob.hpp"
#include "airside/controller/controller.hpp"
#include "airside/controller/controller_memory.hpp"
#include "airside/controller/footprint.hpp"
#include "airside/controller/weight_trial.hpp"
#include "airside/network/network.hpp"
#include "airside/topologies.hpp"

namespace airside {

#define AIRSIDE_INSTANTIATE(Tag)                                                      \
  static_assert(within_budget<Tag>(), "a part of the controller is over its budget"); \
  template class ControllerMemory<Tag, float>;                                        \
  template class Controller<Tag, float>;                                              \
  template class WeightTrial<Tag>;                                                    \
  template class BlobCodec<Tag, NetworkWeights<Tag, float>::count>;
AIRSIDE_FOR_EACH_TOPOLOGY(AIRSIDE_INSTANTIATE)
#undef AIRSIDE_INSTANTIATE

}  // namespace airside
