#pragma once
// The controllers of this build, compiled once in lib/airside/controller/instances.cpp. Include this instead of
// controller.hpp wherever the code is not itself generic in Scalar.

#include "airside/controller/blob.hpp"
#include "airside/controller/controller.hpp"
#include "airside/controller/controller_memory.hpp"
#include "airside/network/network.hpp"
#include "airside/topologies.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Blob codec of a topology's float network.
template <Topology T>
using WeightBlob = BlobCodec<T, NetworkWeights<T, float>::count>;

#define AIRSIDE_EXTERN(Tag)                           \
  extern template class ControllerMemory<Tag, float>; \
  extern template class Controller<Tag, float>;       \
  extern template class BlobCodec<Tag, NetworkWeights<Tag, float>::count>;
AIRSIDE_FOR_EACH_TOPOLOGY(AIRSIDE_EXTERN)
#undef AIRSIDE_EXTERN

}  // namespace airside
