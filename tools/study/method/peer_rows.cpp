#include "tools/study/method/peer_rows.hpp"

#include <algorithm>

#include "hal/text/input_error.hpp"
#include "sim/json/json_file.hpp"

namespace airside::tools {

namespace {

[[noreturn]] void refuse_peers(const std::string& file, const std::string& field, const std::string& found,
                               const std::string& expected) {
  throw hal::InputError(file + ": " + field, found, expected,
                        "make it by tools/gym/method_peers control --only-table --json > FILE (or transfer)");
}

const nlohmann::json& list_of(const std::string& file, const nlohmann::json& j, const char* field) {
  if (!j.contains(field) || !j[field].is_array())
    refuse_peers(file, field, "no list", "the rows of method_peers --json");
  return j[field];
}

PeerRow row_of(const std::string& file, const nlohmann::json& j) {
  if (!j.is_object() || !j.contains("method") || !j["method"].is_string()) {
    refuse_peers(file, "rows", j.dump().substr(0, 40), "an object with the name of a method");
  }
  PeerRow row{j["method"], j.value("room", ""), 0, j};
  if (!j.contains("runs") || !j["runs"].is_number_unsigned()) {
    refuse_peers(file, "rows." + row.method + ".runs", "no count", "how many runs the row is made of");
  }
  row.runs = j["runs"];
  return row;
}

PeerCondition condition_of(const std::string& file, const nlohmann::json& j) {
  const bool is_whole = j.is_object() && j.contains("claim") && j["claim"].is_number_unsigned() &&
                        j.contains("condition") && j["condition"].is_string() && j.contains("holds") &&
                        (j["holds"].is_boolean() || j["holds"].is_null());
  if (!is_whole) refuse_peers(file, "claims", j.dump().substr(0, 40), "claim, condition, holds");
  PeerCondition c{j["claim"], j["condition"], {}};
  if (j["holds"].is_boolean()) c.holds = j["holds"].get<bool>();
  return c;
}

}  // namespace

std::optional<double> PeerRow::number(const std::string& key) const {
  if (!figures.contains(key) || !figures[key].is_number()) return {};
  return figures[key].get<double>();
}

std::vector<double> PeerRow::daily_dae_degc() const {
  std::vector<double> days;
  for (const nlohmann::json& day : figures.value("daily_dae_degc", nlohmann::json::array())) {
    if (day.is_number()) days.push_back(day);
  }
  return days;
}

const PeerRow* PeerRows::of_control(const std::string& method) const {
  const auto row = std::ranges::find(control, method, &PeerRow::method);
  return row == control.end() ? nullptr : &*row;
}

void add_peer_rows(PeerRows& rows, const std::string& file) {
  const nlohmann::json j = sim::read_json(file);
  const std::string study = j.is_object() ? j.value("study", "") : "";
  if (study != "control" && study != "transfer") {
    refuse_peers(file, "study", study.empty() ? "nothing" : study, "control or transfer");
  }
  auto& list = study == "control" ? rows.control : rows.transfer;
  if (!list.empty()) refuse_peers(file, "study", study + " a second time", "one file of each comparison");
  for (const nlohmann::json& row : list_of(file, j, "rows")) list.push_back(row_of(file, row));
  for (const nlohmann::json& one : list_of(file, j, "claims")) rows.conditions.push_back(condition_of(file, one));
}

}  // namespace airside::tools
