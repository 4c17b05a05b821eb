#pragma once
// One run of a study of the published method, as the JSON object that its file holds.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/study/control_methods.hpp"
#include "tools/study/method/rows.hpp"

namespace airside::tools {

/// What all runs of a folder share.
struct MethodStudy {
  std::string folder;
  std::string kind = "rc";                 ///< plant, as PlantChoice::kind
  std::string environment;                 ///< a learned environment in the place of room 301
  std::string environment_from;            ///< its first day
  int days = 14;                           ///< controlled days
  int pretrain_days = 31;                  ///< in the twin, from 1 July
  int operated_days = 60;                  ///< of the room that others learn from, from 1 June
  int steps = 3000;                        ///< optimiser steps of fine-tuning
  int summer_days = 90, winter_days = 70;  ///< of the offline comparison

  /// What a file must say to be one of this study's.
  nlohmann::json facts() const;
};

struct MethodJob {
  const MethodRow* row;
  std::string room;
  std::uint64_t seed;
  /// Of its file, without the ending.
  std::string name() const;
  /// The file with the weights that it starts from, without the ending; "" for scratch.
  std::string source_name() const;
  /// All jobs whose weights it starts from, by name.
  std::vector<std::string> sources() const;
};

/// Every job of these tables and seeds, seed by seed, in the order of method_rows(); those that others start from are
/// among them where a table needs them. In a learned environment every row has that for its room.
std::vector<MethodJob> method_jobs(const MethodStudy& study, const std::vector<MethodTable>& tables, int first_seed,
                                   int seeds);
/// Those that a learned environment can run: no other room is like it.
bool runs_in_environment(MethodTable table);

/// Runs it; a pretraining also leaves its weights in the folder.  Cost: up to 4 min of one core.
/// Errors: hal::InputError for weights of the folder that are missing or do not fit.
nlohmann::json run_method_job(const MethodStudy& study, const MethodJob& job);

}  // namespace airside::tools
