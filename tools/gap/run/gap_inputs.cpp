#include "tools/gap/run/gap_inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "hal/storage/digest64.hpp"
#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(in), {});
  if (!in) throw hal::InputError(file.string(), "a file that cannot be read", "a file", "check its rights");
  return text;
}

/// Of a file, or of all files of a folder with their names.
std::string digest_of(const fs::path& path) {
  std::string text;
  if (fs::is_directory(path)) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) text += file.filename().string() + '\n' + digest_of(file) + '\n';
  } else {
    text = bytes_of(path);
  }
  return fmt::format("digest64:{:016x}", hal::digest64(std::as_bytes(std::span(text))));
}

json input_json(const std::string& path) {
  if (path.empty()) return nullptr;
  const fs::path absolute = fs::absolute(path).lexically_normal();
  return {{"path", absolute.string()}, {"digest", digest_of(absolute)}};
}

bool is_file(const std::string& model) { return fs::exists(model) && fs::path(model).has_extension(); }

/// An input as it was; its path.
std::string unchanged(const std::string& report, const char* what, const json& input) {
  if (input.is_null()) return "";
  const std::string path = input.at("path"), then = input.at("digest");
  if (!fs::exists(path)) {
    throw hal::InputError(path, "nothing", fmt::format("the {} that {} was made from", what, report),
                          "put it back, or judge all days anew with airside gap");
  }
  if (const std::string now = digest_of(path); now != then) {
    throw hal::InputError(path, fmt::format("a content of {}", now),
                          fmt::format("the {} that {} was made from, {}", what, report, then),
                          "put it back as it was, or judge all days anew with airside gap");
  }
  return path;
}

/// Of a model that is a name or a file.
void read_model(const std::string& report, const json& model, CaseDescription& c) {
  c.engine = model.at("engine");
  c.model = model.at("name");
  for (const json& patch : model.at("patches")) c.patches.push_back(unchanged(report, "patch", patch));
  unchanged(report, "model", model.at("file"));
  if (const std::string now = model_digest(model_of(c)), then = model.at("digest"); now != then) {
    throw hal::InputError(c.model, "a model of " + now,
                          fmt::format("the model that {} was made from, {}", report, then),
                          "put it back as it was, or judge all days anew with airside gap");
  }
}

GapRequest request_of(const std::string& report, const json& inputs) {
  GapRequest r;
  CaseDescription& c = r.source;
  r.site = inputs.at("site");
  c.topology = inputs.at("topology");
  c.duties = inputs.at("duties");
  if (inputs.contains("site_file")) c.site = unchanged(report, "site file", inputs.at("site_file"));
  if (inputs.contains("map_file")) c.map = unchanged(report, "mapping file", inputs.at("map_file"));
  c.reference_days = inputs.at("reference_days");
  read_model(report, inputs.at("model"), c);
  c.weather = unchanged(report, "weather file", inputs.at("weather"));
  c.reference_log = unchanged(report, "reference log", inputs.at("reference"));
  c.measured_log = unchanged(report, "measured log", inputs.at("measured"));
  r.effects = unchanged(report, "folder of effects", inputs.at("effects"));
  r.sun_on_site = inputs.at("sun_on_site");
  r.findings_only = inputs.at("findings_only");
  r.buildings = inputs.value("buildings", 0);  // reports of earlier versions have none
  r.price = {inputs.at("price").at("per_kwh"), inputs.at("price").at("currency")};
  for (const json& more : inputs.at("more"))
    r.more.push_back({unchanged(report, "log of added days", more.at("log")), more.at("test")});
  return r;
}

}  // namespace

json inputs_json(const GapRequest& r) {
  const CaseDescription& c = r.source;
  json patches = json::array(), more = json::array();
  for (const std::string& patch : c.patches) patches.push_back(input_json(patch));
  for (const MoreDays& days : r.more) more.push_back({{"log", input_json(days.log)}, {"test", days.test}});
  const bool file = is_file(c.model);
  return {{"site", r.site},
          {"topology", c.topology},
          {"duties", c.duties},
          {"site_file", input_json(c.site)},
          {"map_file", input_json(c.map)},
          {"model",
           {{"engine", c.engine},
            {"name", file ? fs::absolute(c.model).lexically_normal().string() : c.model},
            {"file", file ? input_json(c.model) : json()},
            {"patches", patches},
            {"digest", model_digest(model_of(c))}}},
          {"weather", input_json(c.weather)},
          {"reference", input_json(c.reference_log)},
          {"reference_days", c.reference_days},
          {"measured", input_json(c.measured_log)},
          {"more", more},
          {"effects", input_json(r.effects.string())},
          {"sun_on_site", r.sun_on_site},
          {"findings_only", r.findings_only},
          {"buildings", r.buildings.value_or(0)},
          {"price", {{"per_kwh", r.price.per_kwh}, {"currency", r.price.currency}}}};
}

GapRequest earlier_request(const fs::path& folder) {
  const fs::path file = folder / "gap.json";
  if (!fs::exists(file)) {
    throw hal::InputError(folder.string(), "no gap.json", "the folder of an earlier report of airside gap",
                          "name the folder that --out made");
  }
  const json j = sim::read_json(file);
  if (!j.is_object() || !j.contains("inputs") || !j.contains("verdict")) {
    throw hal::InputError(file.string(), "no \"inputs\"", "a report that says what it was made from",
                          "an earlier version wrote it: run airside gap again on the same days");
  }
  try {
    GapRequest request = request_of(file.string(), j.at("inputs"));
    request.earlier = j;
    return request;
  } catch (const json::exception& e) {
    throw hal::InputError(file.string() + ": inputs", e.what(), "what airside gap wrote",
                          "run airside gap again on the same days");
  }
}

}  // namespace airside::tools::gap
