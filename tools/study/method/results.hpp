#pragma once
// The runs that a folder holds, asked by row, room and figure.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/run/metrics.hpp"
#include "tools/study/method/run.hpp"

namespace airside::tools {

/// The files of runs that the study's folder has, in order of name.
std::vector<std::filesystem::path> run_files(const MethodStudy& study);

/// Refuses what is no run of the study; `place` names it.
/// Errors: hal::InputError naming the field.
void check_run(const std::string& place, const nlohmann::json& run, const MethodStudy& study);

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
  /// DAE of each controlled day over the runs of a row; days that not every run has are left out.
  std::vector<Spread> daily_dae(const std::string& row, const std::string& room = "") const;
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
    std::vector<double> daily_dae_degc;
  };
  std::vector<Run> runs_;
};

}  // namespace airside::tools
