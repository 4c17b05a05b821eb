#include "hal/storage/durable_store.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <set>

#include "airside/splitmix64.hpp"
#include "power_loss/small_store.hpp"
#include "power_loss/write_recorder.hpp"

namespace airside::hal {
namespace {

void apply(FolderImage& image, const WriteOp& op, std::size_t from, std::size_t to) {
  FileImage& file = image[op.file];
  if (op.kind == WriteOp::Kind::truncate) {
    file.resize(op.offset);
    return;
  }
  if (op.kind != WriteOp::Kind::write || from >= to) return;
  if (file.size() < op.offset + to) file.resize(op.offset + to);
  std::copy(op.bytes.begin() + static_cast<std::ptrdiff_t>(from), op.bytes.begin() + static_cast<std::ptrdiff_t>(to),
            file.begin() + static_cast<std::ptrdiff_t>(op.offset + from));
}

/// Folder image before a commit, and the writes of that commit, for each step of the script.
struct History {
  std::vector<FolderImage> before;
  std::vector<std::vector<WriteOp>> ops;
  FolderImage end;
};

History record_history(const TestFolder& folder) {
  History history;
  DurableStore store = open_store(folder);
  StateScript script(layout);
  for (std::uint64_t i = 0; i < steps; ++i) {
    script.advance();
    history.before.push_back(folder.image());
    WriteRecorder recorder;
    const auto done = store.commit(script.stored());
    EXPECT_TRUE(done.has_value());
    history.ops.push_back(recorder.ops);
  }
  history.end = folder.image();
  return history;
}

/// The cut image must load as step `old_step` or `old_step + 1`; must_be_new when the commit had returned.
void expect_old_or_new(const TestFolder& folder, const FolderImage& image, std::uint64_t old_step, bool must_be_new) {
  folder.restore(image);
  const Recovered r = recover(folder);
  if (r.loaded.outcome == LoadOutcome::none) {
    ASSERT_EQ(old_step, 0u) << "a committed generation was lost";
    ASSERT_FALSE(must_be_new);
    return;
  }
  // The very first learning record may stand before any row does: it is a whole generation, found by its copy.
  ASSERT_TRUE(old_step == 0 || r.loaded.outcome == LoadOutcome::newest);
  ASSERT_TRUE(r.script.is_whole(r.loaded.replay_count));
  const std::uint64_t step = r.script.step_in_row();
  StateScript want(layout);
  want.advance_to(step);
  ASSERT_EQ(r.loaded.log, want.log());
  if (must_be_new) {
    ASSERT_EQ(step, old_step + 1);
  } else if (old_step == 0) {
    ASSERT_EQ(step, 1u);
  } else {
    ASSERT_TRUE(step == old_step || step == old_step + 1) << step;
  }
}

TEST(DurableStore, Row35WithoutACutEveryStepComesBackWhole) {
  const TestFolder folder("store_steps");
  StateScript script(layout);
  for (std::uint64_t i = 1; i <= 60; ++i) {
    {
      DurableStore store = open_store(folder);
      StateScript buffers(layout);
      ASSERT_TRUE(store.load(buffers.buffers()).has_value());
      script.advance();
      ASSERT_TRUE(store.commit(script.stored()).has_value());
    }
    const Recovered r = recover(folder);
    ASSERT_EQ(r.loaded.outcome, LoadOutcome::newest);
    ASSERT_EQ(r.loaded.generation, i);
    ASSERT_EQ(r.script.step_in_row(), i);
    ASSERT_TRUE(r.script.is_whole(r.loaded.replay_count));
    ASSERT_EQ(r.loaded.log, script.log());
  }
}

TEST(DurableStore, Row34CutAtEveryByteGivesTheOldGenerationOrTheNew) {
  const TestFolder folder("store_cut");
  const History history = record_history(folder);
  std::size_t states = 0;
  for (std::uint64_t step = 0; step < steps; ++step) {
    FolderImage image = history.before[step];
    for (const WriteOp& op : history.ops[step]) {
      for (std::size_t cut = 0; cut < op.bytes.size(); ++cut) {
        FolderImage torn = image;
        apply(torn, op, 0, cut);
        expect_old_or_new(folder, torn, step, false);
        if (HasFatalFailure()) FAIL() << "step " << step << " " << op.file << " cut at " << op.offset + cut;
        ++states;
      }
      apply(image, op, 0, op.bytes.size());
    }
    expect_old_or_new(folder, image, step, true);
    if (HasFatalFailure()) FAIL() << "after step " << step;
  }
  EXPECT_GT(states, 3000u);
  RecordProperty("states", static_cast<int>(states));
}

/// Splits the writes that no sync has confirmed into pieces that reach the medium in any order.
struct Piece {
  const WriteOp* op;
  std::size_t from, to;
  bool dropped = false;  ///< a sync failed after it: the kernel may have forgotten it, later syncs confirm nothing
};

std::vector<Piece> unsynced_pieces(const std::vector<WriteOp>& ops, std::size_t count, std::size_t piece_bytes) {
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < count; ++i) {
    if (ops[i].kind == WriteOp::Kind::sync) {
      std::erase_if(pieces, [&](const Piece& p) { return p.op->file == ops[i].file && !p.dropped; });
      continue;
    }
    if (ops[i].kind == WriteOp::Kind::failed_sync) {
      for (Piece& p : pieces) p.dropped = p.dropped || p.op->file == ops[i].file;
    }
    for (std::size_t from = 0; from < ops[i].bytes.size(); from += piece_bytes) {
      pieces.push_back({&ops[i], from, std::min(from + piece_bytes, ops[i].bytes.size()), false});
    }
  }
  return pieces;
}

std::uint64_t digest_of(const FolderImage& image) {
  std::uint64_t digest = 0;
  for (const auto& [name, bytes] : image) digest = digest64(bytes, digest);
  return digest;
}

TEST(DurableStore, Row35AnySubsetOfUnsyncedWritesGivesTheOldGenerationOrTheNew) {
  const char* wanted = std::getenv("AIRSIDE_POWER_CUT_STATES");
  const std::size_t subsets = wanted != nullptr ? std::strtoul(wanted, nullptr, 10) / (steps * 10) : 60;
  const TestFolder folder("store_order");
  const History history = record_history(folder);
  SplitMix64 random(2021);
  std::vector<std::uint64_t> states;  // digests of images
  for (std::uint64_t step = 0; step < steps; ++step) {
    const std::vector<WriteOp>& ops = history.ops[step];
    for (std::size_t cut = 1; cut <= ops.size(); ++cut) {
      const std::size_t piece_bytes = std::size_t{8} << random.below(4);
      const std::vector<Piece> pieces = unsynced_pieces(ops, cut, piece_bytes);
      FolderImage synced = history.before[step];
      for (std::size_t i = 0; i < cut; ++i) {
        const bool in_doubt =
            std::any_of(pieces.begin(), pieces.end(), [&](const Piece& p) { return p.op == &ops[i]; });
        if (!in_doubt) apply(synced, ops[i], 0, ops[i].bytes.size());
      }
      const bool all = pieces.size() <= 6;
      const std::size_t tries = all ? std::size_t{1} << pieces.size() : subsets;
      for (std::size_t t = 0; t < tries; ++t) {
        FolderImage image = synced;
        std::uint64_t mask = t;
        for (std::size_t i = 0; i < pieces.size(); ++i, mask >>= 1) {
          if (!all && i % 64 == 0) mask = random.next();
          if ((mask & 1) != 0) apply(image, *pieces[i].op, pieces[i].from, pieces[i].to);
        }
        expect_old_or_new(folder, image, step, cut == ops.size());
        if (HasFatalFailure()) FAIL() << "step " << step << " cut " << cut << " try " << t;
        states.push_back(digest_of(image));
      }
    }
  }
  std::sort(states.begin(), states.end());
  states.erase(std::unique(states.begin(), states.end()), states.end());
  EXPECT_GT(states.size(), 1500u);
  RecordProperty("distinct_states", static_cast<int>(states.size()));
}

TEST(DurableStore, Row33FailingWritesAndSyncsNeverLoseTheLastGoodGeneration) {
  const TestFolder folder("store_fail");
  SplitMix64 random(7);
  for (const int error : {EIO, ENOSPC, EROFS, EDQUOT}) {
    for (const int sticky : {1, 3}) {
      for (int fail_at = 0; fail_at < 14; ++fail_at) {
        for (std::uint64_t start : {1u, 4u, 6u, 10u}) {
          folder.restore({});
          DurableStore store = open_store(folder);
          StateScript script(layout);
          while (script.step < start) {
            script.advance();
            ASSERT_TRUE(store.commit(script.stored()).has_value());
          }
          const FolderImage before = folder.image();
          WriteRecorder recorder;
          recorder.fail_at = fail_at;
          recorder.fail_count = sticky;
          recorder.fail_errno = error;
          std::uint64_t good = start;
          std::size_t good_ops = 0;
          for (int i = 0; i < 4; ++i) {
            script.advance();
            const auto done = store.commit(script.stored());
            if (done.has_value()) {
              good = script.step;
              good_ops = recorder.ops.size();
            } else {
              ASSERT_EQ(done.error().error_number, error);
              ASSERT_NE(done.error().fault, StoreFault::none);
            }
          }
          recorder.fail_at = -1;
          const std::vector<WriteOp> ops = recorder.ops;
          // Power goes after the last good commit and some more writes; a sync that failed confirms nothing.
          for (int t = 0; t < 3; ++t) {
            const std::size_t cut = good_ops + random.below(static_cast<std::uint32_t>(ops.size() - good_ops + 1));
            const std::vector<Piece> pieces = unsynced_pieces(ops, cut, 32);
            FolderImage image = before;
            for (std::size_t i = 0; i < cut; ++i) {
              const WriteOp& op = ops[i];
              for (std::size_t from = 0; from < op.bytes.size(); from += 32) {
                const std::size_t to = std::min(from + 32, op.bytes.size());
                const bool in_doubt = std::any_of(pieces.begin(), pieces.end(),
                                                  [&](const Piece& p) { return p.op == &op && p.from == from; });
                if (!in_doubt || random.below(2) == 0) apply(image, op, from, to);
              }
            }
            const TestFolder cut_folder("store_fail_cut");
            cut_folder.restore(image);
            const Recovered r = recover(cut_folder);
            ASSERT_NE(r.loaded.outcome, LoadOutcome::none);
            ASSERT_NE(r.loaded.outcome, LoadOutcome::replay_incomplete);
            ASSERT_TRUE(r.script.is_whole(r.loaded.replay_count)) << "error " << error << " at " << fail_at;
            ASSERT_GE(r.script.step_in_row(), good) << "error " << error << " at " << fail_at << " from " << start;
          }
        }
      }
    }
  }
}

TEST(DurableStore, RecoveredStateGoesOnCommitting) {
  const TestFolder folder("store_go_on");
  const History history = record_history(folder);
  for (std::uint64_t step = 1; step < steps; ++step) {
    FolderImage image = history.before[step];
    const auto& ops = history.ops[step];
    for (std::size_t i = 0; i + 2 < ops.size(); ++i) apply(image, ops[i], 0, ops[i].bytes.size());
    apply(image, ops[ops.size() - 2], 0, ops[ops.size() - 2].bytes.size() / 2);
    folder.restore(image);
    DurableStore store = open_store(folder);
    StateScript script(layout);
    const auto loaded = store.load(script.buffers());
    ASSERT_TRUE(loaded.has_value());
    ASSERT_EQ(script.step_in_row(), step);
    script.resume(loaded->replay_count);
    for (int i = 0; i < 20; ++i) {
      script.advance();
      ASSERT_TRUE(store.commit(script.stored()).has_value());
    }
    StateScript again(layout);
    const auto last = store.load(again.buffers());
    ASSERT_TRUE(last.has_value());
    ASSERT_EQ(last->outcome, LoadOutcome::newest);
    ASSERT_EQ(again.step_in_row(), step + 20);
    store = open_store(TestFolder("store_other"));  // releases the lock
    const Recovered r = recover(folder);
    ASSERT_EQ(r.script.step_in_row(), step + 20);
    ASSERT_TRUE(r.script.is_whole(r.loaded.replay_count));
  }
}

TEST(DurableStore, Row36RotInAnyOneByteIsSeenAndLeavesAWholeGeneration) {
  const TestFolder folder("store_rot");
  const History history = record_history(folder);
  std::set<LoadOutcome> seen;
  for (const FolderImage& good : {history.before[5], history.before[9], history.end}) {
    for (const auto& [name, bytes] : good) {
      for (std::size_t at = 0; at < bytes.size(); ++at) {
        FolderImage rotten = good;
        rotten[name][at] ^= static_cast<std::byte>(1 << (at % 8));
        folder.restore(rotten);
        const Recovered r = recover(folder);
        ASSERT_NE(r.loaded.outcome, LoadOutcome::none) << name << " " << at;
        seen.insert(r.loaded.outcome);
        if (r.loaded.outcome != LoadOutcome::replay_incomplete) {
          ASSERT_TRUE(r.script.is_whole(r.loaded.replay_count)) << name << " " << at;
          continue;
        }
        ASSERT_EQ(name.substr(0, 6), "replay");
        StateScript want(layout);
        want.advance_to(r.script.step_in_row());
        ASSERT_EQ(r.script.learning, want.learning);
        ASSERT_EQ(r.script.row, want.row);
        const std::uint64_t first = want.count > layout.ring_capacity ? want.count - layout.ring_capacity : 0;
        ASSERT_EQ(r.loaded.dropped_transitions, 1u) << name << " " << at;
        ASSERT_EQ(r.loaded.replay_count, want.count - first - 1);
        std::uint64_t found = 0;  // the others are there, in their order
        for (std::uint64_t number = first; number < want.count && found < r.loaded.replay_count; ++number) {
          const auto slot = static_cast<std::size_t>(number % layout.ring_capacity) * layout.transition_bytes;
          const bool is_there = std::memcmp(&r.script.replay[found * layout.transition_bytes], &want.replay[slot],
                                            layout.transition_bytes) == 0;
          if (is_there) ++found;
        }
        ASSERT_EQ(found, r.loaded.replay_count) << name << " " << at;
      }
    }
  }
  EXPECT_EQ(seen.size(), 3u) << "newest, older and replay_incomplete each occur";
}

TEST(DurableStore, Row37BothRowSlotsBadFallsBackToTheLearningRecordAndAllBadIsNone) {
  const TestFolder folder("store_both");
  const FolderImage good = record_history(folder).end;
  const auto rotten = [&](std::initializer_list<const char*> names) {
    FolderImage image = good;
    for (const char* name : names) image[name][130] ^= std::byte{1};
    folder.restore(image);
    return recover(folder);
  };
  const Recovered rows = rotten({"row.a", "row.b"});
  EXPECT_EQ(rows.loaded.outcome, LoadOutcome::older);
  EXPECT_TRUE(rows.script.is_whole(rows.loaded.replay_count));
  EXPECT_EQ(rows.script.step_in_row(), 13u);  // the last step that changed learning
  EXPECT_EQ(rows.loaded.damaged_records, 2u);
  EXPECT_EQ(rotten({"row.a", "row.b", "learning.a", "learning.b"}).loaded.outcome, LoadOutcome::none);
  EXPECT_EQ(rotten({"learning.a", "learning.b"}).loaded.outcome, LoadOutcome::none);
}

TEST(DurableStore, PayloadsOfBothLearningRecordsThatAreGoneAreADamageWhoseRowIsWhole) {
  const TestFolder folder("store_lost");
  const FolderImage good = record_history(folder).end;
  const auto damaged = [&](const auto& damage) {
    FolderImage image = good;
    for (const char* name : {"learning.a", "learning.b"}) damage(image[name]);
    folder.restore(image);
    return recover(folder);
  };
  using Bytes = FileImage;
  const std::function<void(Bytes&)> damages[] = {
      [](Bytes& bytes) { bytes[150] ^= std::byte{4}; }, [](Bytes& bytes) { bytes.resize(128); },
      [](Bytes& bytes) { bytes.resize(200); }, [](Bytes& bytes) { bytes.clear(); },
      [](Bytes& bytes) { bytes.assign(bytes.size(), std::byte{0}); }};
  for (const auto& damage : damages) {
    const Recovered r = damaged(damage);
    EXPECT_EQ(r.loaded.outcome, LoadOutcome::none);
    EXPECT_GT(r.loaded.damaged_records, 0u);
    ASSERT_TRUE(r.loaded.row_is_whole);
    EXPECT_EQ(r.script.step_in_row(), steps);
  }
}

TEST(DurableStore, Row38LearningRecordsThatAPersonMadeAlikeAreLoadedAsOne) {
  const TestFolder folder("store_alike");
  StateScript script(layout);
  {
    DurableStore store = open_store(folder);
    for (int i = 0; i < 3; ++i) script.advance();
    StoredState state = script.stored();
    for (const bool changed : {true, false, false}) {
      state.learning_changed = changed;
      ASSERT_TRUE(store.commit(state));
    }
  }
  // Both rows name one learning record; its copy in the other slot fits each of them, too.
  FolderImage image = folder.image();
  const bool in_a = std::ranges::any_of(image["learning.a"], [](auto byte) { return byte != decltype(byte){}; });
  image[in_a ? "learning.b" : "learning.a"] = image[in_a ? "learning.a" : "learning.b"];
  folder.restore(image);
  const Recovered r = recover(folder);
  EXPECT_EQ(r.loaded.outcome, LoadOutcome::newest);
  EXPECT_EQ(r.loaded.generation, 3U);
  EXPECT_TRUE(r.script.is_whole(r.loaded.replay_count));
}

TEST(DurableStore, StateOfAnotherTopologyIsRefusedAndNotTouched) {
  const TestFolder folder("store_layout");
  const FolderImage good = record_history(folder).end;
  StoreLayout other = layout;
  other.meaning = 2;
  {
    DurableStore store = open_store(folder, other);
    StateScript script(other);
    const auto loaded = store.load(script.buffers());
    ASSERT_FALSE(loaded.has_value());
    EXPECT_EQ(loaded.error().fault, StoreFault::other_layout);
    EXPECT_NE(describe(loaded.error()).find("folder of its own"), std::string::npos);
  }
  EXPECT_EQ(folder.image(), good);
}

TEST(DurableStore, StateOfAnotherTopologyCanBeSetAsideAndIsWholeThere) {
  const TestFolder folder("store_aside");
  const FolderImage good = record_history(folder).end;
  StoreLayout other = layout;
  other.meaning = 2;
  for (int times = 0; times < 2; ++times) {
    DurableStore store = open_store(folder, other);
    StateScript script(other);
    if (times == 0) {
      ASSERT_FALSE(store.load(script.buffers()).has_value());
      ASSERT_TRUE(store.archive_foreign_state().has_value());
      EXPECT_EQ(store.load(script.buffers())->outcome, LoadOutcome::none);
    } else {
      EXPECT_EQ(store.load(script.buffers())->outcome, LoadOutcome::newest);
    }
    script.advance_to(8);
    ASSERT_TRUE(store.commit(script.stored()).has_value());
  }
  const FolderImage now = folder.image();
  for (const auto& [name, bytes] : good) {
    if (name == "lock") continue;
    EXPECT_EQ(now.at("other-" + name), bytes) << name;
  }
  // A power cut after so many renames: the next start makes those files anew, sees that there is more, and goes on.
  const char* const order[] = {"replay.a", "replay.b", "learning.a", "learning.b", "row.a", "row.b"};
  for (std::size_t cut_after = 0; cut_after <= 6; ++cut_after) {
    const TestFolder cut("store_aside_cut");
    cut.restore(good);
    for (std::size_t i = 0; i < cut_after; ++i) {
      std::filesystem::rename(cut.file(order[i]), cut.file(std::string("other-") + order[i]));
    }
    DurableStore store = open_store(cut, other);
    StateScript script(other);
    const auto loaded = store.load(script.buffers());
    EXPECT_EQ(store.keeps_other(), cut_after > 4) << cut_after;
    if (cut_after < 6) {
      ASSERT_FALSE(loaded.has_value()) << cut_after;
      script.advance_to(8);
      EXPECT_EQ(store.commit(script.stored()).error().fault, StoreFault::unread) << "nothing is written over";
      ASSERT_TRUE(store.archive_foreign_state().has_value());
    }
    EXPECT_TRUE(store.keeps_other());
    for (const auto& [name, bytes] : good) {
      if (name == "lock") continue;
      EXPECT_EQ(cut.image().at("other-" + name), bytes) << name << " after " << cut_after;
    }
    script.advance_to(8);
    EXPECT_TRUE(store.commit(script.stored()).has_value());
  }
  std::filesystem::remove(folder.file("row.b"));
  DurableStore again = open_store(folder);
  for (const char* name : {"row.b", "other-row.b"}) std::filesystem::remove(folder.file(name));
  EXPECT_EQ(again.archive_foreign_state().error().fault, StoreFault::not_found);
}

TEST(DurableStore, AReplacedReplayIsWrittenWhole) {
  const TestFolder folder("store_replaced");
  {
    DurableStore store = open_store(folder);
    StateScript script(layout);
    script.advance_to(8);
    ASSERT_TRUE(store.commit(script.stored()).has_value());
    for (std::byte& b : script.replay) b = std::byte{0xAB};
    store.replay_replaced();
    ASSERT_TRUE(store.commit(script.stored()).has_value());
    // Fewer transitions than before can only be a new ring.
    for (std::byte& b : script.replay) b = std::byte{0xCD};
    script.count = 3;
    ASSERT_TRUE(store.commit(script.stored()).has_value());
  }
  const Recovered r = recover(folder);
  EXPECT_EQ(r.loaded.outcome, LoadOutcome::newest);
  EXPECT_EQ(r.loaded.replay_count, 3u);
  for (std::size_t i = 0; i < 3 * layout.transition_bytes; ++i) EXPECT_EQ(r.script.replay[i], std::byte{0xCD});
}

TEST(DurableStore, SpansOfAnotherSizeAreRefused) {
  const TestFolder folder("store_size");
  DurableStore store = open_store(folder);
  StateScript script(layout);
  script.advance();
  for (int part = 0; part < 3; ++part) {
    StoredState state = script.stored();
    StateBuffers into = script.buffers();
    if (part == 0) state.learning = state.learning.first(3), into.learning = into.learning.first(3);
    if (part == 1) state.row = state.row.first(3), into.row = into.row.first(3);
    if (part == 2) state.replay = state.replay.first(3), into.replay = into.replay.first(3);
    const auto committed = store.commit(state);
    ASSERT_FALSE(committed.has_value()) << part;
    EXPECT_EQ(committed.error().fault, StoreFault::wrong_size);
    const auto loaded = store.load(into);
    ASSERT_FALSE(loaded.has_value()) << part;
    EXPECT_EQ(loaded.error().fault, StoreFault::wrong_size);
  }
}

TEST(DurableStore, ASecondOneIsTurnedAway) {
  const TestFolder folder("store_two");
  const DurableStore first = open_store(folder);
  const auto second = DurableStore::open(folder.c_str(), layout);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().fault, StoreFault::locked);
}

TEST(DurableStore, AFileThatCanBeHadLaterIsWrittenThen) {
  const TestFolder folder("store_late");
  std::filesystem::create_directory(folder.file("row.a"));
  DurableStore store = open_store(folder);
  EXPECT_FALSE(store.ready());
  StateScript script(layout);
  script.advance();
  EXPECT_FALSE(store.commit(script.stored()));
  std::filesystem::remove(folder.file("row.a"));
  ASSERT_TRUE(store.commit(script.stored()));
  EXPECT_TRUE(store.ready());
}

TEST(DurableStore, EachOutcomeOfALoadHasAWord) {
  std::set<std::string> words;
  for (int outcome = 0; outcome < 5; ++outcome) words.insert(text_of(static_cast<LoadOutcome>(outcome)));
  EXPECT_EQ(words.size(), 5u);
  EXPECT_EQ(words.count("unknown"), 1u) << "of the fifth, which there is not";
}

}  // namespace
}  // namespace airside::hal
