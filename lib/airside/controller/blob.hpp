#pragma once
// The weight blob: scaler, network weights, room head, residual network and provenance in one checked piece of bytes.
// docs/formats.md has the byte table.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <tl/expected.hpp>

#include "airside/civil_time.hpp"
#include "airside/controller/blob_layout.hpp"  // IWYU pragma: export
#include "airside/fault.hpp"
#include "airside/forecast/residual_forecaster.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scaler.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Why a blob was refused, and the field of docs/formats.md that says so.
struct BlobError {
  Fault fault;
  const char* field;
};

/// Encodes and decodes blobs of one topology.
template <Topology T, int Parameters>
class BlobCodec {
 public:
  using Payload = BlobPayload<T, Parameters>;
  static constexpr std::size_t max_bytes =
      sizeof(BlobHeader) + Payload::bytes(RoomHead<T>::states, ResidualNetwork::parameters) + blob_signature_bytes;

  /// Size of a blob with a head of this number of states and this number of residual parameters, bytes.
  static constexpr std::size_t size(std::uint32_t head_states, std::uint32_t residual_parameters,
                                    const Shape& site = capacity_of<T>()) {
    return sizeof(BlobHeader) + Payload::bytes(head_states, residual_parameters, site) + blob_signature_bytes;
  }
  static std::size_t size(const Payload& payload) {
    return size(payload.head_states, payload.residual_parameters(), payload.site);
  }

  /// Writes header and payload to `out`, fills in sizes, hashes and digest; the signature stays zero.
  /// Errors: 0 if `out` is too small. Returns the blob's size.
  static std::size_t encode(BlobHeader header, const Payload& payload, std::span<std::byte> out) {
    const std::size_t total = size(payload);
    if (out.size() < total) return 0;
    const int parameters = Payload::parameters(payload.site);
    header.topology_hash = topology_hash(payload.site, parameters);
    header.units_hash = units_hash<T>(payload.site);
    header.payload_bytes = static_cast<std::uint32_t>(total - sizeof header - blob_signature_bytes);
    header.parameters = static_cast<std::uint32_t>(parameters);
    header.head_states = payload.head_states;
    header.residual_parameters = payload.residual_parameters();
    header.format_version = header.residual_parameters != 0 ? blob_version_residual : blob_version_plain;
    header.cycle_min = 0;
    if (payload.cycle != default_cycle) {
      header.format_version = blob_version_cycle;
      header.cycle_min = static_cast<std::uint32_t>(payload.cycle.minutes());
    }
    std::byte* at = out.data() + sizeof(BlobHeader);
    const auto put = [&at](const void* from, std::size_t n) {
      std::memcpy(at, from, n);
      at += n;
    };
    const auto put_one = [&put](const auto& number) { put(&number, sizeof number); };
    for_each_number(payload, put_one);
    put(&payload.head_updates, sizeof(std::uint32_t));
    const int n = static_cast<int>(payload.head_states);
    put(payload.head_theta.data(), sizeof(double) * payload.head_states);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) {
        const double c = payload.head_covariance[static_cast<std::size_t>(j * RoomHead<T>::states + i)];
        put(&c, sizeof c);
      }
    }
    put(payload.residual.values.data(), sizeof(float) * header.residual_parameters);
    put(payload.provenance.data(), blob_provenance_bytes);
    std::memset(at, 0, blob_signature_bytes);
    const std::uint32_t crc = blob_digest(header, out.subspan(sizeof(BlobHeader), header.payload_bytes));
    header.digest = {};
    std::memcpy(header.digest.data(), &crc, sizeof crc);
    std::memcpy(out.data(), &header, sizeof header);
    return total;
  }

  /// Reads a blob whole, or not at all: `payload` is complete on success and unspecified on error.
  /// Errors: BlobError naming the field; checked in the order of read(), then the values.
  static tl::expected<BlobHeader, BlobError> decode(std::span<const std::byte> in, std::span<const char> site_scope,
                                                    Payload& payload) {
    const auto header = read(in, site_scope, payload);
    if (!header) return header;
    const BlobError wrong = check_values(payload);
    return wrong.fault == Fault::none ? header : tl::unexpected(wrong);
  }

  /// As decode(), for a caller who has other questions before he looks at the values.
  /// Errors: BlobError naming the field; checked in the order length, magic, version, architecture, size, digest,
  /// topology, units, sizes, cycle, scope.
  static tl::expected<BlobHeader, BlobError> read(std::span<const std::byte> in, std::span<const char> site_scope,
                                                  Payload& payload) {
    const auto refuse = [](Fault fault, const char* field) { return tl::unexpected(BlobError{fault, field}); };
    if (in.size() < sizeof(BlobHeader)) return refuse(Fault::blob_truncated, "header");
    BlobHeader header;
    std::memcpy(&header, in.data(), sizeof header);
    if (header.magic != BlobHeader{}.magic) return refuse(Fault::blob_magic, "magic");
    if (header.format_version < blob_version_plain || header.format_version > blob_version_cycle) {
      return refuse(Fault::blob_version, "format_version");
    }
    if (header.header_bytes != sizeof header) return refuse(Fault::blob_version, "header_bytes");
    if (header.endian_mark != BlobHeader{}.endian_mark) return refuse(Fault::blob_architecture, "endian_mark");
    if (header.float_mark != BlobHeader{}.float_mark) return refuse(Fault::blob_architecture, "float_mark");
    // 64 bits also where size_t has 32: a length near 2^32 must not wrap round to a small one.
    const std::uint64_t total = sizeof header + std::uint64_t{header.payload_bytes} + blob_signature_bytes;
    if (in.size() < total) return refuse(Fault::blob_truncated, "payload_bytes");
    if (in.size() > total) return refuse(Fault::blob_size, "payload_bytes");
    if (header.digest_kind != 1) return refuse(Fault::blob_digest, "digest_kind");
    std::uint32_t crc = 0;
    std::memcpy(&crc, header.digest.data(), sizeof crc);
    for (std::size_t i = sizeof crc; i < header.digest.size(); ++i) {
      if (header.digest[i] != 0) return refuse(Fault::blob_digest, "digest");
    }
    if (crc != blob_digest(header, in.subspan(sizeof header, header.payload_bytes))) {
      return refuse(Fault::blob_digest, "digest");
    }
    const int parameters = Payload::parameters(payload.site);
    if (header.topology_hash != topology_hash(payload.site, parameters)) {
      return refuse(Fault::blob_topology, "topology_hash");
    }
    if (header.units_hash != units_hash<T>(payload.site)) return refuse(Fault::blob_units, "units_hash");
    if (header.parameters != static_cast<std::uint32_t>(parameters)) return refuse(Fault::blob_size, "parameters");
    constexpr auto one = static_cast<std::uint32_t>(RoomHead<T>::regressors + RoomHead<T>::slots);
    const bool known_head = header.head_states == 0 || header.head_states == one ||
                            header.head_states == static_cast<std::uint32_t>(RoomHead<T>::states);
    if (!known_head) return refuse(Fault::blob_size, "head_states");
    const bool has_residual = header.format_version == blob_version_cycle
                                  ? header.residual_parameters != 0
                                  : header.format_version == blob_version_residual;
    if (header.residual_parameters != (has_residual ? std::uint32_t{ResidualNetwork::parameters} : 0u)) {
      return refuse(Fault::blob_size, "residual_parameters");
    }
    if (header.payload_bytes != Payload::bytes(header.head_states, header.residual_parameters, payload.site)) {
      return refuse(Fault::blob_size, "payload_bytes");
    }
    if ((header.format_version == blob_version_cycle) != (header.cycle_min != 0) ||
        cycle_min_of(header) != static_cast<std::uint32_t>(payload.cycle.minutes())) {
      return refuse(Fault::blob_cycle, "cycle_min");
    }
    if (!scope_matches(header, site_scope)) return refuse(Fault::blob_scope, "site_scope");
    read_payload(header, in.subspan(sizeof header), payload);
    return header;
  }

  /// Whether all values can be: finite, weights within 1000, no negative variance. Fault::none, or what is wrong.
  static BlobError check_values(const Payload& payload) {
    if (!payload.scaler.finite()) return {Fault::blob_value, "scaler"};
    for (const float w : payload.weights) {
      if (!(w >= -1e3f && w <= 1e3f)) return {Fault::blob_value, "weights"};
    }
    if (!payload.head_theta.allFinite()) return {Fault::blob_value, "head_theta"};
    const typename RoomHead<T>::ConstCovariance covariance(payload.head_covariance.data());
    if (!covariance.allFinite()) return {Fault::blob_value, "head_covariance"};
    if (!(covariance.diagonal().array() >= 0).all()) return {Fault::blob_value, "head_covariance"};
    if (!payload.residual.is_sound()) return {Fault::blob_value, "residual"};
    return {Fault::none, ""};
  }

  /// Payload bytes as they are, for showing blobs that decode() refuses.
  /// Shape: in: Payload::bytes() of the header's counts, head_states at most RoomHead's, residual_parameters 0 or all.
  static void read_payload(const BlobHeader& header, std::span<const std::byte> in, Payload& payload) {
    const std::byte* at = in.data();
    const auto get = [&at](void* to, std::size_t n) {
      std::memcpy(to, at, n);
      at += n;
    };
    payload.scaler = Scaler<T>();
    payload.weights.fill(0.0f);
    const auto get_one = [&get](auto& number) { get(&number, sizeof number); };
    for_each_number(payload, get_one);
    get(&payload.head_updates, sizeof(std::uint32_t));
    payload.head_states = header.head_states;
    payload.head_theta.setZero();
    payload.head_covariance.fill(0);
    typename RoomHead<T>::Covariance covariance(payload.head_covariance.data());
    const int n = static_cast<int>(header.head_states);
    get(payload.head_theta.data(), sizeof(double) * header.head_states);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) {
        double c = 0;
        get(&c, sizeof c);
        covariance(i, j) = covariance(j, i) = c;
      }
    }
    payload.residual = ResidualNetwork();
    get(payload.residual.values.data(), sizeof(float) * header.residual_parameters);
    payload.residual.is_trained = header.residual_parameters != 0 ? 1 : 0;
    get(payload.provenance.data(), blob_provenance_bytes);
  }

 private:
  /// Scaler and weights in the file's order.
  template <class P, class F>
  static void for_each_number(P& payload, F&& number) {
    const int inputs = payload.site.inputs();
    for (int i = 0; i < inputs; ++i) number(payload.scaler.mean(slot_of<T>(payload.site, i)));
    for (int i = 0; i < inputs; ++i) number(payload.scaler.scale(slot_of<T>(payload.site, i)));
    if (payload.site == capacity_of<T>()) {
      for (auto& weight : payload.weights) number(weight);
    } else {
      for_each_parameter<T>(payload.site, [&](Layer, int i) { number(payload.weights[static_cast<std::size_t>(i)]); });
    }
  }

  static bool scope_matches(const BlobHeader& header, std::span<const char> site_scope) {
    if (header.site_scope[0] == '\0') return true;
    for (std::size_t i = 0; i < header.site_scope.size(); ++i) {
      if (header.site_scope[i] != (i < site_scope.size() ? site_scope[i] : '\0')) return false;
    }
    return true;
  }
};

}  // namespace airside
