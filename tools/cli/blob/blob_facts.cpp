#include "tools/cli/blob/blob_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "airside/controller/instances.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/weights/blob_file.hpp"

namespace airside::tools {

namespace {

constexpr const char* layer_names[layer_count] = {"enc_s.0", "enc_s.1", "enc_a.0", "enc_a.1", "share.0", "share.1",
                                                  "share.2", "strb.0",  "strb.1",  "tdb.0",   "tdb.1",   "dec"};

/// Zero-padded text with what a terminal must not see replaced.
std::string plain_text(std::span<const char> bytes) {
  std::string text(bytes.begin(), std::find(bytes.begin(), bytes.end(), '\0'));
  for (char& c : text) {
    const auto u = static_cast<unsigned char>(c);
    if (u < 0x20 || u == 0x7F) c = '?';
  }
  return text;
}

/// The shape that a header's hash belongs to. A damaged hash does not hide one of the build's own: the number of
/// weights shows it too. Not valid() where there is none.
Shape shape_of(const BlobHeader& header) {
  for (Shape s{1, 0, 0}; s.vavs <= Shape::max_vavs; ++s.vavs) {
    for (s.fcus = 0; s.fcus <= Shape::max_fcus; ++s.fcus) {
      for (s.powers = 0; s.powers <= Shape::max_powers; ++s.powers) {
        if (header.topology_hash == topology_hash(s, parameters_of<UpTo32>(s))) return s;
      }
    }
  }
  Shape shape;
  for_each_topology([&]<class T>(T) {
    const bool fits = T::exact && header.parameters == static_cast<std::uint32_t>(NetworkWeights<T, float>::count);
    if (fits && !shape.valid()) shape = capacity_of<T>();
  });
  return shape;
}

/// Layers of the site's own network, one behind the other.
template <Topology T>
std::vector<BlobLayer> layers_of(const Shape& site) {
  std::vector<BlobLayer> layers;
  int at = 0;
  for (int i = 0; i < layer_count; ++i) {
    const auto layer = static_cast<Layer>(i);
    const int outputs = layer == Layer::dec ? site.vavs : layer_shape<T>(layer).outputs;
    const int inputs = inputs_of<T>(site, layer);
    const int bias = at + outputs * inputs, end = bias + outputs;
    layers.push_back({layer_names[i], outputs, inputs, at, bias, end});
    at = end;
  }
  return layers;
}

template <Topology T>
void read_payload(std::span<const std::byte> file, const Shape& site, BlobFacts& out) {
  using Payload = typename WeightBlob<T>::Payload;
  BlobHeader header = out.header;
  constexpr auto one = static_cast<std::uint32_t>(RoomHead<T>::regressors + RoomHead<T>::slots);
  if (header.head_states != one && header.head_states != RoomHead<T>::states) header.head_states = 0;
  if (header.residual_parameters != ResidualNetwork::parameters) header.residual_parameters = 0;
  const std::size_t wanted = Payload::bytes(header.head_states, header.residual_parameters, site);
  // All bits set is NaN for floats and doubles: what the file lacks shows as not finite.
  std::vector<std::byte> bytes(wanted, std::byte{0xFF});
  const std::size_t there = std::min(wanted, file.size() - sizeof header);
  std::copy_n(file.begin() + sizeof header, there, bytes.begin());
  auto payload = std::make_unique<Payload>();
  payload->site = site;
  WeightBlob<T>::read_payload(header, bytes, *payload);

  out.topology = name_of(site).c_str();
  out.missing_bytes = wanted - there;
  for (int i = 0; i < site.inputs(); ++i) {
    const int slot = slot_of<T>(site, i);
    const SignalId id = signal_id<T>(slot);
    const SignalText text = text_of(id.kind);
    const std::string place = id.place == 0 ? "" : '_' + std::to_string(id.place);
    out.signals.push_back({text.name + place, text.unit, payload->scaler.mean(slot), payload->scaler.scale(slot)});
  }
  for_each_parameter<T>(site,
                        [&](Layer, int i) { out.weights.push_back(payload->weights[static_cast<std::size_t>(i)]); });
  out.layers = layers_of<T>(site);
  out.head_states = header.head_states;
  if (header.head_states != 0) {
    constexpr int g = HeadFeatures::setpoint_change;
    out.head_updates = payload->head_updates;
    out.head_gain = payload->head_theta(g);
    out.head_gain_sd = std::sqrt(payload->head_covariance[static_cast<std::size_t>(g * RoomHead<T>::states + g)]);
  }
  if (out.missing_bytes == 0) out.provenance = plain_text(payload->provenance);
}

template <Topology T>
std::optional<BlobError> refusal_of(std::span<const std::byte> file, const Shape& site, const BlobHeader& header) {
  auto payload = std::make_unique<typename WeightBlob<T>::Payload>();
  payload->site = site;
  if (const auto minutes = static_cast<int>(std::min(cycle_min_of(header), 1440U)); is_cycle_min(minutes))
    payload->cycle = cycle_of_minutes(minutes);
  const auto decoded = WeightBlob<T>::decode(file, header.site_scope, *payload);
  if (decoded) return {};
  return decoded.error();
}

}  // namespace

ValueStatistics statistics_of(std::span<const float> values) {
  ValueStatistics s;
  s.count = values.size();
  double sum = 0, square = 0;
  std::size_t finite = 0;
  for (const float value : values) {
    const double v = static_cast<double>(value);
    if (!std::isfinite(v)) {
      ++s.not_finite;
      continue;
    }
    s.min = finite == 0 ? v : std::min(s.min, v);
    s.max = finite == 0 ? v : std::max(s.max, v);
    ++finite;
    sum += v;
    square += v * v;
  }
  if (finite > 0) {
    s.mean = sum / static_cast<double>(finite);
    s.rms = std::sqrt(square / static_cast<double>(finite));
  }
  return s;
}

BlobFacts read_blob_facts(const std::string& path) { return facts_of_blob(hal::read_blob_file(path), path); }

BlobFacts facts_of_blob(std::span<const std::byte> file, const std::string& path) {
  BlobFacts out;
  out.path = path;
  out.bytes = file.size();
  out.digest = fmt::format("{:08x}", crc32c(file));
  if (file.size() < sizeof out.header) hal::throw_blob_error({Fault::blob_truncated, "header"}, path);
  std::memcpy(&out.header, file.data(), sizeof out.header);
  const BlobHeader& header = out.header;
  if (header.magic != BlobHeader{}.magic) hal::throw_blob_error({Fault::blob_magic, "magic"}, path);

  std::optional<BlobError> error;
  const Shape site = shape_of(header);
  const bool known = with_topology(name_of(site).c_str(), [&]<class T>(T) {
    error = refusal_of<T>(file, site, header);
    read_payload<T>(file, site, out);
  });
  if (!known) error = refusal_of<FiveZone>(file, capacity_of<FiveZone>(), header);
  const std::size_t payload = std::min<std::size_t>(header.payload_bytes, file.size() - sizeof header);
  std::uint32_t crc = 0;
  std::memcpy(&crc, header.digest.data(), sizeof crc);
  const auto body = file.subspan(sizeof header, payload);
  out.digest_ok = payload == header.payload_bytes && crc == blob_digest(header, body);
  if (error) {
    try {
      hal::throw_blob_error(*error, path);
    } catch (const hal::InputError& complaint) {
      out.refusal = complaint;
    }
  }
  return out;
}

std::string scope_text(const BlobHeader& header) {
  const std::string scope = plain_text(header.site_scope);
  return scope.empty() ? "any site" : scope;
}

std::string key_text(const BlobHeader& header) {
  std::string hex;
  for (const std::uint8_t byte : header.key_id) hex += fmt::format("{:02x}", byte);
  return hex.find_first_not_of('0') == std::string::npos ? "unsigned" : hex;
}

}  // namespace airside::tools
