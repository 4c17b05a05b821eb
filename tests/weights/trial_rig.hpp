#pragma once

// A controller in its loop, an inbox, keys and a state folder: pushed weights as the daemon's rows take them.

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>

#include "firmware/edge/weights/weights_trial.hpp"
#include "support/blob_maker.hpp"
#include "support/controller_rig.hpp"
#include "support/test_folder.hpp"

namespace airside::weights {

using T = FiveZone;
using edge::TrialState;

class Trial : public ::testing::Test {
 protected:
  Trial() {
    std::filesystem::create_directories(folder.file("keys"));
    std::filesystem::create_directories(folder.file("inbox"));
    std::filesystem::create_directories(folder.file("state"));
    std::ofstream(folder.file("keys") / "ann.pub") << hal::public_key_text(key.open);
    open();
    rig.cycles(6);
  }
  /// A process's trial of weights; `is_known`: as WeightsTrial::join_counters().
  void open(bool is_known = true) {
    trial = std::make_unique<edge::WeightsTrial<T>>(folder.file("keys").string(), folder.file("inbox").string(),
                                                    folder.file("state").string(), 5, hal::Sync::none, "Room 301",
                                                    folder.file("log").string());
    trial->open_inbox();
    trial->join_counters(record, is_known);
  }

  void push(const Bytes& bytes) {
    const auto path = folder.file("inbox") / "weights.blob";
    std::ofstream out(path, std::ios::binary);
    for (const std::byte b : bytes) out.put(static_cast<char>(b));
    out.close();
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
  }
  void wish(const std::string& name) { std::ofstream(folder.file("inbox") / name); }
  /// The rig's weights with every one scaled, so that they differ and stay sane.
  Bytes other(std::uint64_t counter, float factor = 0.9F) {
    return signed_by(blob_of<T>(*rig.controller,
                                [&](auto& p) {
                                  for (float& w : p.weights) w *= factor;
                                }),
                     key, counter);
  }
  /// One row as the daemon has it. Returns whether the learning state was exchanged.
  bool row() {
    rig.row();
    const bool exchanged = trial->row({rig.now.seconds - row_s}, *rig.controller, record);
    trial->committed();
    return exchanged;
  }
  void rows(int n) {
    for (int i = 0; i < n; ++i) row();
  }
  float first_weight() const { return rig.controller->learning().weights.values[0]; }

  hal::TestFolder folder{"trial"};
  hal::SecretKey key = hal::make_key("Ann");
  ControllerRig rig;
  edge::TrialRecord record;
  std::unique_ptr<edge::WeightsTrial<T>> trial;
};

}  // namespace airside::weights
