#pragma once
// Everything that can go wrong inside lib, as numbers that never change meaning, and the result type.

#include <cstdint>
#include <tl/expected.hpp>

namespace airside {

/// Frozen numbers: they stand in logs, snapshots and durable state.
enum class Fault : std::uint8_t {
  none = 0,
  not_finite = 1,          ///< NaN, Inf or a sentinel where a number was expected
  out_of_range = 2,        ///< outside the point's limits
  rate_exceeded = 3,       ///< changed faster than the point's maximum rate
  stuck = 4,               ///< has not moved although its neighbours have
  stale = 5,               ///< older than the point allows
  no_reading = 6,          ///< the plant gave no reading at all
  not_applied = 7,         ///< the plant refused the command
  forecast_invalid = 8,    ///< the network or head produced a number that is not finite
  learning_rejected = 9,   ///< the acceptance gate refused new weights
  blob_truncated = 10,     ///< fewer bytes than the header says
  blob_magic = 11,         ///< not a weight blob
  blob_version = 12,       ///< a format that this build does not read
  blob_architecture = 13,  ///< other endianness or float format
  blob_topology = 14,      ///< for another topology
  blob_units = 15,         ///< for other units or signal order
  blob_digest = 16,        ///< payload does not match its digest
  blob_value = 17,         ///< payload holds a number that is not finite or out of bounds
  blob_scope = 18,         ///< for another site
  blob_size = 19,          ///< length differs from what the topology needs
  state_invalid = 20,      ///< durable state fails its checksum or its size
  settings_invalid = 21,   ///< a setting is outside its documented range
  disagrees = 22,          ///< far from the median of all rooms
  frozen = 23,             ///< every signal unchanged for too long: the device repeats itself
  write_refused = 24,      ///< the device answered, and refused the setpoint
  released = 25,           ///< nothing was written, as the mode arbiter asks
  blob_signature = 26,     ///< not signed, or signed by a key that is unknown or revoked, or changed since
  blob_counter = 27,       ///< as old as or older than one that was installed
  other_device = 28,       ///< the device is not the one that the point map describes
  blob_taken_back = 29,    ///< whoever sent it asked for a rollback before it was tried
  no_way_back = 30,        ///< the weights before the pushed ones cannot be read
  counter_unknown = 31,    ///< what was taken before is lost, so that no blob is known to be newer
  blob_cycle = 32,         ///< for another length of the control cycle
};

constexpr const char* text_of(Fault fault) {
  switch (fault) {
    case Fault::none: return "none";
    case Fault::not_finite: return "not finite";
    case Fault::out_of_range: return "out of range";
    case Fault::rate_exceeded: return "rate exceeded";
    case Fault::stuck: return "stuck";
    case Fault::stale: return "stale";
    case Fault::no_reading: return "no reading";
    case Fault::not_applied: return "not applied";
    case Fault::forecast_invalid: return "forecast invalid";
    case Fault::learning_rejected: return "learning rejected";
    case Fault::blob_truncated: return "blob truncated";
    case Fault::blob_magic: return "not a weight blob";
    case Fault::blob_version: return "blob format version";
    case Fault::blob_architecture: return "blob architecture";
    case Fault::blob_topology: return "blob topology";
    case Fault::blob_units: return "blob units";
    case Fault::blob_digest: return "blob digest";
    case Fault::blob_value: return "blob value";
    case Fault::blob_scope: return "blob site scope";
    case Fault::blob_size: return "blob size";
    case Fault::state_invalid: return "state invalid";
    case Fault::settings_invalid: return "settings invalid";
    case Fault::disagrees: return "disagrees with the other rooms";
    case Fault::frozen: return "all signals frozen";
    case Fault::write_refused: return "write refused";
    case Fault::released: return "released";
    case Fault::blob_signature: return "blob signature";
    case Fault::blob_counter: return "blob counter";
    case Fault::other_device: return "other device";
    case Fault::blob_taken_back: return "blob taken back";
    case Fault::no_way_back: return "no way back";
    case Fault::counter_unknown: return "counter unknown";
    case Fault::blob_cycle: return "blob control cycle";
  }
  return "unknown";
}

template <class V>
using Expected = tl::expected<V, Fault>;

}  // namespace airside
