#pragma once
// Blobs for tests: weights of a rig's controller, or any others, signed with any key.

#include <vector>

#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "hal/weights/signature.hpp"

namespace airside::weights {

using Bytes = std::vector<std::byte>;

/// What the controller has learned, as a blob; `change` may spoil the payload before it is encoded.
template <Topology T, class Change>
Bytes blob_of(const Controller<T>& controller, const Change& change, BlobHeader header = {}) {
  auto payload = std::make_unique<typename WeightBlob<T>::Payload>();
  give_payload<T>(controller, *payload);
  change(*payload);
  Bytes bytes(WeightBlob<T>::size(*payload));
  WeightBlob<T>::encode(header, *payload, bytes);
  return bytes;
}
template <Topology T>
Bytes blob_of(const Controller<T>& controller) {
  return blob_of<T>(controller, [](auto&) {});
}

inline Bytes signed_by(Bytes bytes, const hal::SecretKey& key, std::uint64_t counter) {
  hal::sign_blob(bytes, key, counter);
  return bytes;
}

}  // namespace airside::weights
