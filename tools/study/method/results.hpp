#pragma once
// The runs that a folder holds, asked by row, room and figure.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/run/metrics.hpp"
#include "tools/study/method/run.hpp"

namespace airside::tools {

class MethodResults {
 public:
  /// Every run of method_rows() in the folder, whatever its seed, in order of name.
  /// Errors: hal::InputError naming file and field for a file that is no run, or one of another study.
  static MethodResults read(const MethodStudy& study);

  /// A figure over the runs of a row; of one room where one is named.
  Spread spread(const std::string& row, const std::string& key, const std::string& room = "") const;
  double mean(const std::string& row, const std::string& key, const std::string& room = "") const {
    return spread(row, key, room).mean;
  }
  bool has(const std::string& row) const;
  /// How many seeds the folder has of any row, and how many runs.
  int seeds() const;
  std::size_t runs() const { return runs_.size(); }
  /// Of one seed alone.
  MethodResults of_seed(std::uint64_t seed) const;
  std::vector<std::uint64_t> seeds_of(const std::string& row) const;

 private:
  struct Run {
    std::string row, room;
    std::uint64_t seed = 0;
    nlohmann::json figures;
  };
  std::vector<Run> runs_;
};

}  // namespace airside::tools
