#pragma once
// What tools/gym/method_peers found of the methods that are not the program's own.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace airside::tools {

/// A row of its tables: a method, and in the comparison of transfer a room. Figures by their keys in the file.
struct PeerRow {
  std::string method, room;
  int runs = 0;
  nlohmann::json figures;

  std::optional<double> number(const std::string& key) const;
  std::vector<double> daily_dae_degc() const;
};

/// A condition of a claim; nothing where a row that it needs is missing.
struct PeerCondition {
  int claim = 0;
  std::string condition;
  std::optional<bool> holds;
};

struct PeerRows {
  std::vector<PeerRow> control, transfer;
  std::vector<PeerCondition> conditions;

  bool empty() const { return control.empty() && transfer.empty(); }
  const PeerRow* of_control(const std::string& method) const;
};

/// Adds what a file holds: the standard output of `tools/gym/method_peers control --json`, or of `transfer`.
/// Errors: hal::InputError naming file and field.
void add_peer_rows(PeerRows& rows, const std::string& file);

}  // namespace airside::tools
