// airside blob: what a weight blob holds, and how two of them differ.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/cli/blob/blob_facts.hpp"
#include "tools/cli/blob/rank.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

void print_object(const json& j) { fmt::print("{}\n", j.dump(-1, ' ', false, json::error_handler_t::replace)); }

/// A refused blob is shown, then the program fails as it does for every other bad input.
void complain(const BlobFacts& f) {
  if (f.refusal) throw *f.refusal;
}

std::string head_text(const BlobFacts& f) {
  if (f.head_states == 0) return "none";
  if (!std::isfinite(f.head_gain)) return "not readable";
  return fmt::format("gain {:.3f} ± {:.3f} K/K, {} updates of its profile", f.head_gain, f.head_gain_sd,
                     f.head_updates);
}

void print(const BlobFacts& f) {
  fmt::print("{}: {} bytes, digest {} ({})\n", f.path, f.bytes, f.digest,
             f.digest_ok ? "its checksum holds" : "ITS CHECKSUM DOES NOT HOLD");
  for (const auto& [name, text] : header_fields(f)) fmt::print("  {:<17} {}\n", name, text);
  if (f.topology.empty()) return;
  if (f.missing_bytes != 0) {
    fmt::print("  {} bytes of the payload are missing; they show as nan below\n", f.missing_bytes);
  } else {
    fmt::print("  {:<17} {}\n", "provenance", f.provenance.empty() ? "none" : f.provenance);
  }
  fmt::print("  {:<17} {}\n\n", "room head", head_text(f));
  fmt::print("  {:<4} {:<16} {:<6} {:>12} {:>12}\n", "", "signal", "unit", "mean", "scale");
  for (std::size_t i = 0; i < f.signals.size(); ++i) {
    const BlobSignal& s = f.signals[i];
    fmt::print("  {:<4} {:<16} {:<6} {:>12.4f} {:>12.4f}\n", i, s.name, s.unit.empty() ? "0/1" : s.unit, s.mean,
               s.scale);
  }
  fmt::print("\n  {:<8} {:>9} {:>7} {:>10} {:>10} {:>10} {:>10}\n", "layer", "shape", "values", "min", "mean", "max",
             "rms");
  for (const BlobLayer& l : f.layers) {
    const ValueStatistics s = statistics_of(weights_of(f, l));
    fmt::print("  {:<8} {:>9} {:>7} {:>10.5f} {:>10.5f} {:>10.5f} {:>10.5f}", l.name,
               fmt::format("{}x{}", l.outputs, l.inputs), s.count, s.min, s.mean, s.max, s.rms);
    if (s.not_finite != 0) fmt::print("  {} not finite", s.not_finite);
    fmt::print("\n");
  }
}

struct InspectCommand {
  std::string path;
  bool as_json = false;

  void run() const {
    const BlobFacts f = read_blob_facts(path);
    if (as_json) {
      print_object(json_of(f));
    } else {
      print(f);
    }
    std::fflush(stdout);
    complain(f);
  }
};

/// How the weights of one layer moved.
struct LayerDifference {
  std::string name;
  double rms = 0, largest = 0, relative = 0;  ///< relative: rms over the rms of A's layer
};

std::vector<LayerDifference> layer_differences(const BlobFacts& a, const BlobFacts& b) {
  std::vector<LayerDifference> out;
  for (const BlobLayer& l : a.layers) {
    LayerDifference d{l.name, 0, 0, 0};
    double square = 0;
    const auto x = weights_of(a, l), y = weights_of(b, l);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double difference = static_cast<double>(y[i]) - static_cast<double>(x[i]);
      square += difference * difference;
      d.largest = std::max(d.largest, std::abs(difference));
    }
    d.rms = std::sqrt(square / static_cast<double>(x.size()));
    const double scale = statistics_of(x).rms;
    d.relative = scale > 0 ? d.rms / scale : 0;
    out.push_back(d);
  }
  return out;
}

struct DiffCommand {
  std::string first, second;
  bool as_json = false;

  void run() const {
    const BlobFacts a = read_blob_facts(first), b = read_blob_facts(second);
    complain(a);
    complain(b);
    const bool same_shape = a.topology == b.topology;
    json header = json::array(), scaler = json::array(), layers = json::array();
    auto fields = header_fields(a);
    fields.emplace_back("provenance", a.provenance);
    auto others = header_fields(b);
    others.emplace_back("provenance", b.provenance);
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (fields[i].second == others[i].second) continue;
      header.push_back({{"field", key_of(fields[i].first)}, {"a", fields[i].second}, {"b", others[i].second}});
    }
    for (std::size_t i = 0; same_shape && i < a.signals.size(); ++i) {
      const BlobSignal &x = a.signals[i], &y = b.signals[i];
      if (x.mean == y.mean && x.scale == y.scale) continue;
      scaler.push_back({{"signal", x.name},
                        {"unit", x.unit},
                        {"mean_a", x.mean},
                        {"mean_b", y.mean},
                        {"scale_a", x.scale},
                        {"scale_b", y.scale}});
    }
    if (same_shape) {
      for (const LayerDifference& d : layer_differences(a, b)) {
        layers.push_back({{"layer", d.name}, {"rms", d.rms}, {"max", d.largest}, {"rms_relative", d.relative}});
      }
    }
    json out = {{"a", first},
                {"b", second},
                {"same_topology", same_shape},
                {"header", header},
                {"scaler", scaler},
                {"layers", layers},
                {"identical", a.digest == b.digest && a.bytes == b.bytes}};
    if (a.head_states != 0 && b.head_states != 0) {
      out["head"] = {{"gain_a_k_per_k", a.head_gain},
                     {"gain_b_k_per_k", b.head_gain},
                     {"gain_difference_k_per_k", b.head_gain - a.head_gain}};
    }
    if (as_json) {
      print_object(out);
    } else {
      show(out, a, b);
    }
  }

  static void show(const json& d, const BlobFacts& a, const BlobFacts& b) {
    if (d["identical"]) {
      fmt::print("{} and {} are identical (digest {})\n", a.path, b.path, a.digest);
      return;
    }
    fmt::print("a: {} (digest {})\nb: {} (digest {})\n", a.path, a.digest, b.path, b.digest);
    for (const json& h : d["header"]) {
      fmt::print("  {:<17} a: {}\n  {:<17} b: {}\n", h["field"].get<std::string>(), h["a"].get<std::string>(), "",
                 h["b"].get<std::string>());
    }
    if (!d["same_topology"]) {
      fmt::print("  other room shapes: nothing further can be compared\n");
      return;
    }
    fmt::print("  scaler: {}\n",
               d["scaler"].empty() ? "the same" : fmt::format("{} signals differ", d["scaler"].size()));
    for (const json& s : d["scaler"]) {
      fmt::print("    {:<16} mean {:>9.4f} -> {:>9.4f}   scale {:>9.4f} -> {:>9.4f} {}\n",
                 s["signal"].get<std::string>(), s["mean_a"].get<double>(), s["mean_b"].get<double>(),
                 s["scale_a"].get<double>(), s["scale_b"].get<double>(), s["unit"].get<std::string>());
    }
    fmt::print("  room head: a {}; b {}\n", head_text(a), head_text(b));
    fmt::print("  {:<8} {:>11} {:>11} {:>10}\n", "layer", "rms moved", "max moved", "of its rms");
    for (const json& l : d["layers"]) {
      fmt::print("  {:<8} {:>11.3g} {:>11.3g} {:>8.2f} %\n", l["layer"].get<std::string>(), l["rms"].get<double>(),
                 l["max"].get<double>(), 100 * l["rms_relative"].get<double>());
    }
  }
};

}  // namespace

void add_blob(CLI::App& app) {
  CLI::App* blob = app.add_subcommand("blob", "look into weight blobs");
  blob->require_subcommand(1);

  auto inspect = std::make_shared<InspectCommand>();
  CLI::App* c = blob->add_subcommand("inspect",
                                     "header, provenance, scaler, weights by layer, room head; also of a damaged blob");
  c->add_option("file", inspect->path, "the blob")->required();
  c->add_flag("--json", inspect->as_json, "print one JSON object and nothing else on standard output");
  c->callback([inspect] { inspect->run(); });

  auto diff = std::make_shared<DiffCommand>();
  c = blob->add_subcommand("diff", "how two blobs differ");
  c->add_option("a", diff->first, "a blob")->required();
  c->add_option("b", diff->second, "another")->required();
  c->add_flag("--json", diff->as_json, "print one JSON object and nothing else on standard output");
  c->callback([diff] { diff->run(); });
  add_rank(*blob);
}

}  // namespace airside::tools
