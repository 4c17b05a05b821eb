// A blob's facts as JSON.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/civil_text.hpp"
#include "tools/cli/blob/blob_facts.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

/// A number, null where there is none.
json number(double value) { return std::isfinite(value) ? json(value) : json(); }

json json_of(const ValueStatistics& s) {
  return {{"count", s.count}, {"not_finite", s.not_finite}, {"min", s.min}, {"mean", s.mean}, {"max", s.max},
          {"rms", s.rms}};
}

}  // namespace

std::span<const float> weights_of(const BlobFacts& f, const BlobLayer& layer) {
  return std::span(f.weights).subspan(static_cast<std::size_t>(layer.begin),
                                      static_cast<std::size_t>(layer.end - layer.begin));
}

std::vector<std::pair<const char*, std::string>> header_fields(const BlobFacts& f) {
  const BlobHeader& h = f.header;
  return {
      {"format version", std::to_string(h.format_version)},
      {"topology", f.topology.empty() ? fmt::format("none of this build (hash {:016x})", h.topology_hash) : f.topology},
      {"units hash", fmt::format("{:016x}", h.units_hash)},
      {"site scope", scope_text(h)},
      {"cycle min", std::to_string(cycle_min_of(h))},
      {"created", hal::civil_text({h.created_s})},
      {"security counter", std::to_string(h.security_counter)},
      {"key", key_text(h)},
      {"parameters", std::to_string(h.parameters)},
      {"head states", std::to_string(h.head_states)},
      {"residual parameters", std::to_string(h.residual_parameters)},
      {"payload bytes", std::to_string(h.payload_bytes)}};
}

std::string key_of(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

json json_of(const BlobFacts& f) {
  json header, scaler = json::array(), layers = json::array();
  for (const auto& [name, text] : header_fields(f)) header[key_of(name)] = text;
  for (const BlobSignal& s : f.signals) {
    scaler.push_back({{"signal", s.name}, {"unit", s.unit}, {"mean", number(s.mean)}, {"scale", number(s.scale)}});
  }
  for (const BlobLayer& l : f.layers) {
    json entry = json_of(statistics_of(weights_of(f, l)));
    entry["layer"] = l.name;
    entry["outputs"] = l.outputs;
    entry["inputs"] = l.inputs;
    layers.push_back(entry);
  }
  json out = {{"file", f.path},
              {"bytes", f.bytes},
              {"digest", f.digest},
              {"ok", !f.refusal},
              {"header", header},
              {"digest_ok", f.digest_ok},
              {"topology", f.topology},
              {"scaler", scaler},
              {"layers", layers},
              {"missing_bytes", f.missing_bytes},
              {"provenance", f.provenance}};
  if (f.head_states != 0) {
    out["head"] = {{"gain_k_per_k", number(f.head_gain)},
                   {"gain_sd_k_per_k", number(f.head_gain_sd)},
                   {"updates", f.head_updates}};
  }
  if (f.refusal) {
    out["refusal"] = {{"place", f.refusal->place()},
                      {"found", f.refusal->found()},
                      {"expected", f.refusal->expected()},
                      {"remedy", f.refusal->remedy()}};
  }
  return out;
}

}  // namespace airside::tools
