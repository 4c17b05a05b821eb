// Weight blobs.

#include "input/program_input_cases.hpp"

namespace airside::broken {

std::vector<Case> blobs() {
  return {
      {"BlobMissing", from_blob, whole, {"a.blob", "No such file", "weight blob", "airside pretrain"}},
      {"BlobEmpty", from_blob, file("a.blob", ""), {"a.blob", "0 bytes", "192 to", "copy the file again"}},
      {"BlobOtherFile",
       from_blob,
       [](const Desk& d) { d.write("a.blob", std::string(300, 'x')); },
       {"a.blob: magic", "another kind of file", "weight blob", "airside pretrain"}},
      {"BlobCutInHeader",
       try_blob,
       [](const Desk& d) { d.blob(), d.cut("a.blob", 100); },
       {"a.blob", "100 bytes", "192", "copy"}},
      {"BlobCutInPayload",
       try_blob,
       [](const Desk& d) { d.blob(), d.cut("a.blob", 60000); },
       {"a.blob: payload_bytes", "ends early", "header says", "copy"}},
      {"BlobTooLong",
       try_blob,
       [](const Desk& d) { d.blob(), d.write("a.blob", text_of_file(d.path("a.blob")) + "x"); },
       {"a.blob: payload_bytes", "length", "", ""}},
      {"BlobVersion",
       from_blob,
       blob(8, std::uint16_t{9}, true),
       {"a.blob: format_version", "version", "version 1", "airside"}},
      {"BlobByteOrder",
       from_blob,
       blob(12, std::uint32_t{0x04030201}, true),
       {"a.blob: endian_mark", "byte order", "little", "machine"}},
      {"BlobFlippedWeight",
       try_blob,
       blob(weights_at + 4000, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "undamaged", "copy"}},
      {"BlobFlippedHeader",
       try_blob,
       blob(136, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "undamaged", "copy"}},
      {"BlobOtherTopology",
       try_blob,
       [](const Desk& d) { d.small_blob(); },
       {"a.blob: topology_hash", "another topology", "site's", "pretrain"}},
  };
}

std::vector<Case> blobs_of_wrong_content() {
  return {
      {"BlobOtherUnits", from_blob, blob(32, std::uint64_t{7}, true), {"a.blob: units_hash", "units", "", "again"}},
      {"BlobScope",
       from_blob,
       blob(56, std::array<char, 9>{"Room 999"}, true),
       {"a.blob: site_scope", "another site", "scope", "transfer"}},
      {"BlobNanWeight",
       try_blob,
       blob(weights_at, std::numeric_limits<float>::quiet_NaN(), true),
       {"a.blob: weights", "not finite", "finite", "train again"}},
      {"BlobHugeWeight",
       from_blob,
       blob(weights_at + 400, 1e6f, true),
       {"a.blob: weights", "out of bounds", "1000", "train again"}},
      {"BlobNanScaler",
       from_blob,
       blob(scaler_at, nan_value, true),
       {"a.blob: scaler", "not finite", "", "train again"}},
      {"BlobZeroScale",
       from_blob,
       blob(scaler_at + 8 * Layout<FiveZone>::inputs, 0.0, true),
       {"a.blob: scaler", "", "", ""}},
      {"BlobOfCheck",
       "check --weights a.blob",
       blob(weights_at, std::numeric_limits<float>::infinity(), true),
       {"a.blob: weights", "finite", "", ""}},
      {"BlobOfInspect",
       "blob inspect a.blob",
       blob(weights_at + 4000, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "", "copy"}},
      {"BlobOfDiff",
       "blob diff a.blob a.blob",
       blob(weights_at + 4000, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "", "copy"}},
      {"BlobOfDaemon",
       "airsided --site site.toml --check",
       [](const Desk& d) {
         d.blob(), d.cut("a.blob", 60000), d.site(), d.edit("site.toml", "blob = \"\"", "blob = \"a.blob\"");
       },
       {"a.blob: payload_bytes", "ends early", "header says", "copy"}},
  };
}

}  // namespace airside::broken
