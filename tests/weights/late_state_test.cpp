// State that comes after the start, with its parts exchanged under the box's memory: which weights stand in memory and
// on the medium, and what a person has yet to see.

#include <gtest/gtest.h>

#include "airside/presets.hpp"
#include "firmware/edge/daemon_state.hpp"
#include "support/blob_maker.hpp"
#include "support/controller_rig.hpp"
#include "support/default_cycle.hpp"
#include "support/test_folder.hpp"

namespace airside::weights {
namespace {

namespace fs = std::filesystem;
using Memory = edge::DaemonState<FiveZone>;

/// One process's memory and its room.
class Box {
 public:
  Box(const hal::SiteFile& site, CivilTime start) : rig_(product_settings(), start), site_(site) {
    rig_.controller->configure(product_settings(), rig_.controller->limits(), hal::box_kernels(), 1);
    memory_ = std::make_unique<Memory>(site_, hal::counts_of<FiveZone>(), hal::Sync::none, *rig_.controller);
    memory_->open();
    memory_->resume();
    if (memory_->state_lost()) rig_.controller->hold(Reason::state_lost, start, 0);
  }
  void row() {
    const CivilTime t = rig_.now;
    rig_.row();
    memory_->row(t, rig_.reading(), true);
  }
  void rows(int n) {
    for (int i = 0; i < n; ++i) row();
  }
  /// Until the next row but one begins a cycle.
  void rows_to_the_middle() {
    while (rig_.now.seconds % cycle_s != row_s) row();
  }
  CivilTime now() const { return rig_.now; }
  float first_weight() const { return rig_.controller->learning().weights.values[0]; }
  bool has_weights() const { return rig_.controller->cycle().has_weights != 0; }
  Reason reason() const { return rig_.controller->control_mode(rig_.now).reason; }
  void hand_back() { rig_.controller->hand_back(); }

 private:
  ControllerRig rig_;
  hal::SiteFile site_;
  std::unique_ptr<Memory> memory_;
};

class LateMemory : public ::testing::Test {
 protected:
  LateMemory() {
    for (const char* part : {"keys", "inbox"}) fs::create_directories(folder.file(part));
  }
  /// A site whose blob holds the rig's weights, every one scaled.
  hal::SiteFile site(float factor) const {
    const fs::path blob = folder.file("weights_" + std::to_string(factor) + ".blob");
    if (!fs::exists(blob)) {
      const ControllerRig rig;
      hal::write_blob_file(blob.string(), blob_of<FiveZone>(*rig.controller, [&](auto& payload) {
                             for (float& w : payload.weights) w *= factor;
                           }));
    }
    hal::SiteFile s;
    s.name = s.scope = "Room";
    s.state_dir = state.string();
    s.keys_dir = folder.file("keys").string();
    s.inbox_dir = folder.file("inbox").string();
    s.weights_blob = blob.string();
    return s;
  }
  /// State of a process of another version, one file of which cannot be set aside.
  void lay_state_of_another_version() const {
    hal::StoreLayout other = Memory::layout(capacity_of<FiveZone>());
    other.meaning ^= 1;
    auto store = hal::DurableStore::open(state.c_str(), other, hal::Sync::none);
    ASSERT_TRUE(store);
    const std::vector<std::byte> learning(other.learning_bytes, std::byte{1}), row(other.row_bytes, std::byte{2}),
        replay(other.transition_bytes * other.ring_capacity, std::byte{3});
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(store->commit({.learning = learning,
                                 .row = row,
                                 .replay = replay,
                                 .replay_count = 5,
                                 .log = {},
                                 .learning_changed = true}));
    }
    for (const char* name : {"other-replay.a", "other-replay.b"}) fs::create_directories(state / name);
  }

  static constexpr CivilTime start{1'627'862'400};
  hal::TestFolder folder{"late_memory"};
  const fs::path state = folder.file("state"), kept = folder.file("kept"), away = folder.file("away");
};

TEST_F(LateMemory, OfOtherWeightsLeavesNoneOfThemOnTheMedium) {
  { Box(site(1.0F), start).rows(4); }
  fs::rename(state, kept);
  float in_memory = 0, begun = 0;
  CivilTime last;
  {
    Box box(site(0.5F), {start.seconds + 34 * cycle_s});
    begun = box.first_weight();
    box.rows_to_the_middle();
    fs::rename(state, away);
    fs::rename(kept, state);
    box.rows(2);  // the second one begins no cycle either
    in_memory = box.first_weight();
    EXPECT_TRUE(box.has_weights());
    EXPECT_EQ(in_memory, begun);
    last = box.now();
  }
  Box next(site(0.5F), last);
  EXPECT_TRUE(next.has_weights());
  EXPECT_EQ(next.first_weight(), in_memory) << "as a kill would leave it";
}

TEST_F(LateMemory, ThatIsStillNoneWaitsForAPersonAsBefore) {
  lay_state_of_another_version();
  Box box(site(1.0F), start);
  for (int i = 0; i < 4 * rows_per_cycle; ++i) {
    box.row();
    ASSERT_EQ(box.reason(), Reason::state_lost) << i;
  }
  EXPECT_TRUE(box.has_weights());
  box.hand_back();
  box.rows(2 * rows_per_cycle);
  EXPECT_EQ(box.reason(), Reason::none);
}

}  // namespace
}  // namespace airside::weights
