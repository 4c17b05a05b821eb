#pragma once
// What a weight blob holds, read as far as it can be: whole blobs and damaged ones alike, of any topology of this
// build. For people to look at; what controls goes through BlobCodec::decode.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "airside/controller/blob.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools {

/// Over the finite ones of `count` values; all zero if there is none.
struct ValueStatistics {
  std::size_t count = 0, not_finite = 0;
  double min = 0, mean = 0, max = 0, rms = 0;
};
ValueStatistics statistics_of(std::span<const float> values);

struct BlobSignal {
  std::string name, unit;  ///< as in log headers; unit "" for 0/1 status
  double mean = 0, scale = 0;
};

/// A layer of the network and where its W and b stand in BlobFacts::weights.
struct BlobLayer {
  std::string name;
  int outputs = 0, inputs = 0, begin = 0, bias = 0, end = 0;
};

struct BlobFacts {
  std::string path;
  std::size_t bytes = 0;
  std::string digest;  ///< of the whole file, as reports name it
  BlobHeader header;
  bool digest_ok = false;
  std::optional<hal::InputError> refusal;  ///< why a controller would not take it
  std::string topology;                    ///< "": none of this build; then there is nothing below
  std::size_t missing_bytes = 0;           ///< of the payload; what is missing shows as NaN
  std::vector<BlobSignal> signals;
  std::vector<float> weights;
  std::vector<BlobLayer> layers;
  std::uint32_t head_states = 0, head_updates = 0;
  double head_gain = 0, head_gain_sd = 0;  ///< K room a K setpoint, in one cycle
  std::string provenance;
};

/// Reads a blob for looking at.
/// Errors: hal::InputError for a file that cannot be read or is no blob at all; any other fault goes to `refusal`.
BlobFacts read_blob_facts(const std::string& path);
/// The same for bytes that came from `place`.
BlobFacts facts_of_blob(std::span<const std::byte> file, const std::string& place);

/// Those of one layer.
std::span<const float> weights_of(const BlobFacts& facts, const BlobLayer& layer);

/// Header fields as name and text, in the file's order.
std::vector<std::pair<const char*, std::string>> header_fields(const BlobFacts& facts);
/// The field's name as docs/formats.md writes it.
std::string key_of(std::string name);
/// What `airside blob inspect --json` prints.
nlohmann::json json_of(const BlobFacts& facts);

/// The header's text fields.
std::string scope_text(const BlobHeader& header);  ///< "any site" where there is none
std::string key_text(const BlobHeader& header);    ///< hex, or "unsigned"

}  // namespace airside::tools
