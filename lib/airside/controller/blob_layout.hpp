#pragma once
// What lies where in a weight blob: header, hashes, payload. docs/formats.md has the byte table; this header and the
// codec of blob.hpp are the only code that knows it.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "airside/civil_time.hpp"
#include "airside/crc32c.hpp"
#include "airside/forecast/residual_forecaster.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scaler.hpp"
#include "airside/signals.hpp"
#include "airside/topology.hpp"

namespace airside {

static_assert(std::endian::native == std::endian::little, "the blob codec copies little-endian memory");

/// Of blobs without and with a residual network, and of those of another cycle than 18 min: readers from before there
/// were any refuse what they do not know by its version.
constexpr std::uint16_t blob_version_plain = 1, blob_version_residual = 2, blob_version_cycle = 3;

/// Fixed header. Every field is little-endian; reserved bytes are zero.
struct BlobHeader {
  std::array<char, 8> magic{'A', 'I', 'R', 'S', 'I', 'D', 'E', 'B'};
  std::uint16_t format_version = blob_version_plain;
  std::uint16_t header_bytes = 192;
  std::uint32_t endian_mark = 0x01020304;
  double float_mark = 0.15625;
  std::uint64_t topology_hash = 0;
  std::uint64_t units_hash = 0;
  std::uint64_t security_counter = 0;
  std::array<std::uint8_t, 8> key_id{};
  std::array<char, 32> site_scope{};  ///< zero-padded; empty: any site
  std::uint32_t payload_bytes = 0;
  std::uint32_t parameters = 0;   ///< network weights
  std::uint32_t head_states = 0;  ///< 0: no head; else theta and covariance follow
  std::uint32_t digest_kind = 1;  ///< 1: CRC-32C in the digest's first four bytes
  std::array<std::uint8_t, 32> digest{};
  std::int64_t created_s = 0;             ///< civil time of training's end
  std::uint32_t residual_parameters = 0;  ///< 0: no residual network; else its numbers follow the head
  std::uint32_t cycle_min = 0;            ///< control cycle that the weights predict; 0: 18, as in versions 1 and 2
  std::array<std::uint8_t, 40> reserved{};
};
static_assert(sizeof(BlobHeader) == 192 && std::is_trivially_copyable_v<BlobHeader>);

/// min
constexpr std::uint32_t cycle_min_of(const BlobHeader& header) {
  return header.cycle_min != 0 ? header.cycle_min : static_cast<std::uint32_t>(default_cycle.minutes());
}

constexpr std::size_t blob_signature_bytes = 64;    ///< Ed25519; zero while unsigned
constexpr std::size_t blob_provenance_bytes = 512;  ///< UTF-8, zero-padded

namespace blob_detail {
constexpr std::uint64_t fnv1a(std::uint64_t hash, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) hash = (hash ^ ((value >> (8 * i)) & 0xFF)) * 0x100000001B3u;
  return hash;
}
constexpr std::uint64_t fnv1a(std::uint64_t hash, const char* text) {
  for (; *text != '\0'; ++text) hash = (hash ^ static_cast<std::uint8_t>(*text)) * 0x100000001B3u;
  return hash;
}
constexpr std::uint64_t fnv_seed = 0xCBF29CE484222325u;
}  // namespace blob_detail

/// Checksum over everything but the digest itself and the signature.
inline std::uint32_t blob_digest(BlobHeader header, std::span<const std::byte> payload) {
  header.digest = {};
  std::array<std::byte, sizeof(BlobHeader)> bytes{};
  std::memcpy(bytes.data(), &header, sizeof header);
  return crc32c(payload, crc32c(bytes));
}

/// Hash of the counts and of the number of parameters that a network of this shape has.
constexpr std::uint64_t topology_hash(const Shape& site, int parameters) {
  using blob_detail::fnv1a;
  std::uint64_t h = fnv1a(blob_detail::fnv_seed, name_of(site).c_str());
  for (const int n : {site.vavs, site.fcus, site.powers, parameters}) h = fnv1a(h, static_cast<std::uint64_t>(n));
  return h;
}

/// Hash of kind, place and unit of every input that the site has, in order.
template <Topology T>
constexpr std::uint64_t units_hash(const Shape& site) {
  using blob_detail::fnv1a;
  std::uint64_t h = blob_detail::fnv_seed;
  for (int i = 0; i < site.inputs(); ++i) {
    const SignalId id = signal_id<T>(slot_of<T>(site, i));
    h = fnv1a(fnv1a(h, static_cast<std::uint64_t>(id.kind)), static_cast<std::uint64_t>(id.place));
    h = fnv1a(h, text_of(id.kind).unit);
  }
  return h;
}

/// What a blob carries, beside its header. A file holds the parameters and scales of the site's own shape alone, so
/// that the same bytes fit every topology that holds it. Shape: weights as many as the topology's network has.
template <Topology T, int Parameters>
struct BlobPayload {
  Shape site = capacity_of<T>();  ///< set by who encodes, and by who expects it before decode() or read()
  ControlCycle cycle;             ///< the same
  Scaler<T> scaler;
  std::array<float, static_cast<std::size_t>(Parameters)> weights{};
  std::uint32_t head_states = 0;
  std::uint32_t head_updates = 0;
  typename RoomHead<T>::State head_theta = RoomHead<T>::State::Zero();
  typename RoomHead<T>::CovarianceStore head_covariance{};  ///< states x states, column-major
  ResidualNetwork residual;                                 ///< in the file where it is trained
  std::array<char, blob_provenance_bytes> provenance{};

  static constexpr std::size_t bytes(std::uint32_t head_states, std::uint32_t residual_parameters,
                                     const Shape& site = capacity_of<T>()) {
    const std::size_t n = head_states;
    return 2 * sizeof(double) * static_cast<std::size_t>(site.inputs()) +
           sizeof(float) * static_cast<std::size_t>(parameters(site)) + sizeof(std::uint32_t) +
           sizeof(double) * (n + n * (n + 1) / 2) + sizeof(float) * std::size_t{residual_parameters} +
           blob_provenance_bytes;
  }
  std::uint32_t residual_parameters() const {
    return residual.is_trained != 0 ? static_cast<std::uint32_t>(ResidualNetwork::parameters) : 0u;
  }
  /// Of a network of the site's shape; Parameters where that fills the topology.
  static constexpr int parameters(const Shape& site) {
    return site == capacity_of<T>() ? Parameters : parameters_of<T>(site);
  }
};

}  // namespace airside
