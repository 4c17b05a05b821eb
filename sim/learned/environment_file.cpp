#include "sim/learned/environment_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"

namespace airside::sim {

namespace {

using Field = nlohmann::json;
constexpr const char* environment_format = "airside learned environment 1";
constexpr std::size_t most_width = 4096;

[[noreturn]] void refuse_field(const std::string& file, const std::string& field, const std::string& found,
                               const std::string& expected) {
  throw hal::InputError(file + ": " + field, found, expected, "write the file with tools/learn_environment");
}

const Field& field_of(const Field& json, const std::string& file, const std::string& place, const char* name) {
  const std::string field = place.empty() ? name : place + "." + name;
  if (!json.is_object() || !json.contains(name)) refuse_field(file, field, "nothing", "this field");
  return json.at(name);
}

/// Numbers, `size` of them; any number where that is 0.
Eigen::VectorXd numbers(const Field& json, const std::string& file, const std::string& field, std::size_t size) {
  if (!json.is_array()) refuse_field(file, field, json.type_name(), "an array of numbers");
  if (json.size() > most_width || json.empty() || (size > 0 && json.size() != size)) {
    refuse_field(file, field, std::to_string(json.size()) + " numbers",
                 size > 0 ? std::to_string(size) : "1 to " + std::to_string(most_width));
  }
  Eigen::VectorXd out(static_cast<Eigen::Index>(json.size()));
  for (std::size_t i = 0; i < json.size(); ++i) {
    if (!json[i].is_number() || !std::isfinite(json[i].get<double>()))
      refuse_field(file, field + "[" + std::to_string(i) + "]", json[i].dump(), "a number");
    out(static_cast<Eigen::Index>(i)) = json[i].get<double>();
  }
  return out;
}

LearnedNetwork::Layer layer_of(const Field& json, const std::string& file, const std::string& place,
                               std::size_t inputs) {
  LearnedNetwork::Layer layer;
  layer.bias = numbers(field_of(json, file, place, "bias"), file, place + ".bias", 0);
  const Field& weight = field_of(json, file, place, "weight");
  const auto outputs = static_cast<std::size_t>(layer.bias.size());
  if (!weight.is_array() || weight.size() != outputs) {
    refuse_field(file, place + ".weight",
                 weight.is_array() ? std::to_string(weight.size()) + " rows" : weight.type_name(),
                 std::to_string(outputs) + " rows, one an entry of bias");
  }
  layer.weight.resize(layer.bias.size(), static_cast<Eigen::Index>(inputs));
  for (std::size_t o = 0; o < outputs; ++o) {
    layer.weight.row(static_cast<Eigen::Index>(o)) =
        numbers(weight[o], file, place + ".weight[" + std::to_string(o) + "]", inputs).transpose();
  }
  return layer;
}

LearnedNetwork network_of(const Field& json, const std::string& file, const hal::TopologyCounts& counts) {
  const auto inputs = static_cast<std::size_t>(counts.signals()) + 1;
  LearnedNetwork network;
  network.mean = numbers(field_of(json, file, "", "mean"), file, "mean", inputs);
  network.scale = numbers(field_of(json, file, "", "scale"), file, "scale", inputs);
  if (network.scale.minCoeff() <= 0)
    refuse_field(file, "scale", "a number that is not above 0", "spreads of the inputs");
  network.out_scale_k =
      numbers(field_of(json, file, "", "out_scale"), file, "out_scale", static_cast<std::size_t>(counts.vavs));
  const Field& slope = field_of(json, file, "", "slope");
  if (!slope.is_number()) refuse_field(file, "slope", slope.dump(), "a number from 0 to 1");
  network.slope = slope;
  const Field& layers = field_of(json, file, "", "layers");
  if (!layers.is_array() || layers.empty()) refuse_field(file, "layers", layers.type_name(), "an array of layers");
  std::size_t width = inputs;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    network.layers.push_back(layer_of(layers[i], file, "layers[" + std::to_string(i) + "]", width));
    width = static_cast<std::size_t>(network.layers.back().bias.size());
  }
  if (width != static_cast<std::size_t>(counts.vavs)) {
    refuse_field(file, "layers", std::to_string(width) + " outputs of the last one",
                 std::to_string(counts.vavs) + ", one a room");
  }
  return network;
}

void check_columns(const Field& columns, const std::string& file, const hal::TopologyCounts& counts) {
  std::vector<std::string> expected;
  for (int i = 0; i < counts.signals(); ++i) expected.push_back(hal::column_of(counts, i));
  expected.emplace_back("setpoint_degc");
  if (!columns.is_array()) refuse_field(file, "columns", columns.type_name(), "an array of names");
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (i < columns.size() && columns[i] == expected[i]) continue;
    refuse_field(file, "columns[" + std::to_string(i) + "]", i < columns.size() ? columns[i].dump() : "nothing",
                 expected[i] + ", as a log of topology " + counts.name + " has it");
  }
}

constexpr const char* midnight = "T00:00:00";

std::string day_of(const Field& json, const std::string& file) {
  const Field& day = field_of(json, file, "", "test_from");
  if (!day.is_string() || !hal::parse_civil_text(day.get<std::string>() + midnight))
    refuse_field(file, "test_from", day.dump(), "a date such as 2021-07-25");
  return day;
}

std::vector<hal::LogRow> replayed(const std::string& log, CivilTime from, const hal::TopologyCounts& counts) {
  std::vector<hal::LogRow> rows = hal::read_log(log, counts).rows;
  const auto first = std::ranges::find_if(rows, [from](const hal::LogRow& r) { return !(r.time < from); });
  rows.erase(rows.begin(), first);
  if (rows.size() < rows_per_day || rows.front().time.seconds != from.seconds) {
    throw hal::InputError(log, std::to_string(rows.size()) + " rows from " + hal::civil_text(from) + " on",
                          "a day of them at least", "keep the log that the network was learned from");
  }
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].time.seconds - rows[i - 1].time.seconds == row_s) continue;
    throw hal::InputError(log, "a gap after " + hal::civil_text(rows[i - 1].time), "rows that are 6 min apart",
                          "learn from a log without gaps in its last third");
  }
  return rows;
}

}  // namespace

Eigen::VectorXd LearnedNetwork::change_k(const Eigen::VectorXd& inputs) const {
  Eigen::VectorXd x = (inputs - mean).cwiseQuotient(scale);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    x = layers[i].weight * x + layers[i].bias;
    if (i + 1 < layers.size()) x = (x.array() > 0).select(x, slope * x);
  }
  return x.cwiseProduct(out_scale_k);
}

std::string environment_start(const std::string& file) { return day_of(read_json(file), file); }

LearnedEnvironment read_environment(const std::string& file, const hal::TopologyCounts& counts) {
  const Field json = read_json(file);
  const Field& format = field_of(json, file, "", "format");
  if (format != environment_format) refuse_field(file, "format", format.dump(), environment_format);
  check_columns(field_of(json, file, "", "columns"), file, counts);
  LearnedEnvironment out;
  out.network = network_of(json, file, counts);
  const Field& log = field_of(json, file, "", "log");
  if (!log.is_string()) refuse_field(file, "log", log.dump(), "the path of a log, from the model file's folder");
  const CivilTime from = hal::parse_civil_text(day_of(json, file) + midnight).value();
  out.rows = replayed((std::filesystem::path(file).parent_path() / log.get<std::string>()).string(), from, counts);
  out.description = "learned environment " + std::filesystem::path(file).filename().string();
  return out;
}

}  // namespace airside::sim
