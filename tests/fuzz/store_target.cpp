// Durable state: whatever the files hold, loading ends, gives a whole generation or none, and the next commit stands.

#include <sys/stat.h>
#include <unistd.h>

#include <cstring>

#include "fuzz/folder.hpp"
#include "fuzz/target.hpp"
#include "hal/storage/durable_store.hpp"
#include "hal/storage/start_ledger.hpp"
#include "hal/storage/state_copy.hpp"

namespace airside::fuzz {
namespace {

constexpr hal::StoreLayout layout{16, 8, 8, 4, 2, 7};
constexpr std::size_t row_file = hal::payload_offset + layout.row_bytes;
constexpr std::size_t learning_file = row_file + layout.learning_bytes;
constexpr std::size_t stride = sizeof(hal::JournalEntry) + 8;
constexpr std::size_t replay_file = (layout.ring_capacity + layout.spare_slots) * stride;
constexpr std::array<const char*, 6> names = {"row.a", "row.b", "learning.a", "learning.b", "replay.a", "replay.b"};
constexpr std::array<std::size_t, 6> sizes = {row_file,      row_file,    learning_file,
                                              learning_file, replay_file, replay_file};
constexpr std::size_t all_files = 2 * (row_file + learning_file + replay_file);

const Folder& folder() {
  static const Folder one("fuzz_store");
  return one;
}

/// What a process holds of its state.
struct Memory {
  std::array<std::byte, layout.learning_bytes> learning{};
  std::array<std::byte, layout.row_bytes> row{};
  std::array<std::byte, layout.ring_capacity * layout.transition_bytes> replay{};
  hal::StateBuffers buffers() { return {learning, row, replay}; }
  bool operator==(const Memory&) const = default;
};

/// The transitions that exist are equal; slots never pushed may hold anything.
bool same_replay(const Memory& a, const Memory& b, std::uint64_t count) {
  const std::uint64_t first = count > layout.ring_capacity ? count - layout.ring_capacity : 0;
  for (std::uint64_t k = first; k < count; ++k) {
    const std::size_t at = k % layout.ring_capacity * layout.transition_bytes;
    if (std::memcmp(a.replay.data() + at, b.replay.data() + at, layout.transition_bytes) != 0) return false;
  }
  return true;
}

bool load(View input) {
  Cursor in(input);
  for (std::size_t i = 0; i < names.size(); ++i) folder().write(names[i], in.take(sizes[i]));
  Memory found;
  hal::LoadedState loaded;
  {
    auto store = hal::DurableStore::open(folder().path(), layout, hal::Sync::none);
    FUZZ_CLAIM(store.has_value());
    const auto state = store->load(found.buffers());
    if (!state) FUZZ_CLAIM(state.error().fault == hal::StoreFault::other_layout);
    if (state) loaded = *state;
    if (loaded.outcome == hal::LoadOutcome::none) found = {}, loaded = {};
    Memory again;
    const auto second = store->load(again.buffers());
    FUZZ_CLAIM(second.has_value() == state.has_value());
    if (loaded.outcome != hal::LoadOutcome::none) {
      FUZZ_CLAIM(second->outcome == loaded.outcome && second->generation == loaded.generation);
      FUZZ_CLAIM(loaded.generation > 0 && second->replay_count == loaded.replay_count && second->log == loaded.log);
      FUZZ_CLAIM(again.row == found.row && again.learning == found.learning);
      FUZZ_CLAIM(same_replay(again, found, loaded.replay_count));
    }
    if (!state) {
      // What is another's is not written over, and makes room once it was set aside.
      FUZZ_CLAIM(!store->commit({found.learning, found.row, found.replay, 0, {}, true}));
      FUZZ_CLAIM(store->archive_foreign_state() && store->keeps_other());
    }
    // The next row: one transition is pushed, learning moves, and all of it is committed.
    found.row[0] ^= std::byte{1};
    found.learning[3] ^= std::byte{1};
    found.replay[loaded.replay_count % layout.ring_capacity * layout.transition_bytes] ^= std::byte{1};
    loaded.replay_count += 1;
    loaded.log.bytes += 100;
    FUZZ_CLAIM(store->commit({found.learning, found.row, found.replay, loaded.replay_count, loaded.log, true}));
    loaded.generation = store->generation();
  }
  // No box counts so far, and what does is not read back: also where a record that was not chosen bore the number.
  if (loaded.generation > hal::largest_count || loaded.replay_count > hal::largest_count) return true;
  auto store = hal::DurableStore::open(folder().path(), layout, hal::Sync::none);
  FUZZ_CLAIM(store.has_value());
  Memory after;
  const auto state = store->load(after.buffers());
  FUZZ_CLAIM(state.has_value() && state->outcome == hal::LoadOutcome::newest);
  FUZZ_CLAIM(state->generation == loaded.generation && state->replay_count == loaded.replay_count);
  FUZZ_CLAIM(state->log == loaded.log && after.row == found.row && after.learning == found.learning);
  FUZZ_CLAIM(same_replay(after, found, loaded.replay_count));
  return loaded.generation > 1;
}

/// The six files after `commits` rows, learning in every second one.
Bytes files_after(int commits) {
  for (const char* name : names) folder().remove(name);
  auto store = hal::DurableStore::open(folder().path(), layout, hal::Sync::none);
  Memory memory;
  FUZZ_CLAIM(store && store->load(memory.buffers()));
  for (int k = 0; k < commits; ++k) {
    memory.row[0] = memory.learning[0] = static_cast<std::byte>(k);
    memory.replay[static_cast<std::size_t>(k) % layout.ring_capacity * layout.transition_bytes] =
        static_cast<std::byte>(k);
    const hal::LogPosition log{18000, 0, 100 * static_cast<std::uint64_t>(k)};
    const auto count = static_cast<std::uint64_t>(k + 1);
    FUZZ_CLAIM(store->commit({memory.learning, memory.row, memory.replay, count, log, k % 2 == 0}));
  }
  Bytes all;
  for (const char* name : names) {
    const Bytes bytes = folder().read(name);
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  return all;
}

std::vector<Bytes> seeds() { return {files_after(3), files_after(1), files_after(8), Bytes(all_files), {}}; }

/// Digests fit again: of the headers, and by choice of payloads, links and journal entries.
void repair(Bytes& input, std::uint32_t choice) {
  input.resize(all_files);
  const auto at = [&](std::size_t offset, std::size_t n) {
    return std::as_writable_bytes(std::span(input)).subspan(offset, n);
  };
  std::array<hal::RecordHeader, 4> header;
  std::array<std::uint64_t, 2> learning_digest{};
  const auto place = [](std::size_t i) { return i < 2 ? i * row_file : 2 * row_file + (i - 2) * learning_file; };
  for (std::size_t i = 0; i < 2; ++i) {
    learning_digest[i] = hal::digest64(at(place(2 + i) + hal::payload_offset, layout.learning_bytes));
  }
  for (std::size_t i = 0; i < 4; ++i) {
    hal::RecordHeader& h = header[i];
    std::memcpy(&h, input.data() + place(i), sizeof h);
    const bool learning = i >= 2;
    if ((choice >> i & 1U) != 0) {
      h.magic = hal::record_magic, h.version = hal::record_version, h.layout = layout.hash();
      h.kind = learning ? 2 : 1;
      h.payload_bytes = layout.row_bytes + (learning ? layout.learning_bytes : 0);
    }
    if ((choice >> 4 & 1U) != 0) {
      const std::size_t from = learning ? i - 2 : h.generation % 2;
      h.learning_digest = learning_digest[from];
      if (learning) h.learning_generation = h.generation;
      const auto row = at(place(i) + hal::payload_offset + (learning ? layout.learning_bytes : 0), layout.row_bytes);
      h.payload_digest = hal::digest64(row, learning ? h.learning_digest : 0);
    }
  }
  if ((choice >> 5 & 1U) != 0) header[0].learning_generation = header[2].generation;
  if ((choice >> 6 & 1U) != 0) header[1].learning_generation = header[3].generation;
  for (std::size_t i = 0; i < 4; ++i) {
    header[i].header_digest = header[i].digest();
    std::memcpy(input.data() + place(i), &header[i], sizeof header[i]);
  }
  if ((choice >> 7 & 1U) == 0) return;
  for (const hal::RecordHeader& h : header) {  // the journal as one of the records names it
    const std::size_t file = 2 * (row_file + learning_file) + (h.epoch & 1) * replay_file;
    const std::uint64_t slots = layout.ring_capacity + layout.spare_slots;
    for (std::uint64_t k = h.replay_count; k-- > 0 && h.replay_count - k <= layout.ring_capacity;) {
      const std::size_t slot = file + k % slots * stride;
      const hal::JournalEntry entry{k, hal::digest64(at(slot + sizeof(hal::JournalEntry), 8), k ^ (h.epoch << 40))};
      std::memcpy(input.data() + slot, &entry, sizeof entry);
    }
  }
}

// ---- the copy of an older state, and the ledger of starts

const Folder& small_folder() {
  static const Folder one("fuzz_records");
  return one;
}

bool read_small(View input) {
  Cursor in(input);
  small_folder().write("starts", in.take(152));
  small_folder().write("previous", in.rest());
  hal::StartLedger ledger(small_folder().path(), hal::Sync::none);
  const int starts = ledger.record(600);
  FUZZ_CLAIM(starts >= 1 && starts <= 8);
  FUZZ_CLAIM(ledger.record(600) >= 2);
  ledger.clear();
  FUZZ_CLAIM(ledger.record(600) == 1);
  hal::StateCopy copy(small_folder().path(), 7, hal::Sync::none);
  std::array<std::byte, 24> state{};
  small_folder().remove("previous.new");
  std::uint64_t named = 0;  // by the row record: the digest that stands in the copy
  if (in.rest().size() >= 32) std::memcpy(&named, &in.rest()[24], sizeof named);
  const bool loaded = copy.load(state, named).has_value();
  if (loaded)
    FUZZ_CLAIM(in.rest().size() >= 32 + state.size() && std::memcmp(state.data(), &in.rest()[32], state.size()) == 0);
  const auto saved = copy.save(state, named);
  FUZZ_CLAIM(saved && (!loaded || copy.load(state, named)));
  FUZZ_CLAIM(copy.settle(*saved));
  std::array<std::byte, 24> again{};
  FUZZ_CLAIM(copy.load(again, *saved) && again == state);
  return loaded;
}

std::vector<Bytes> small_seeds() {
  for (const char* name : {"starts", "previous", "previous.new"}) small_folder().remove(name);
  hal::StartLedger ledger(small_folder().path(), hal::Sync::none);
  for (int i = 0; i < 3; ++i) ledger.record(600);
  std::array<std::byte, 24> state{std::byte{5}};
  hal::StateCopy copy(small_folder().path(), 7, hal::Sync::none);
  const auto saved = copy.save(state, 0);
  FUZZ_CLAIM(saved && copy.settle(*saved));
  Bytes all = small_folder().read("starts");
  const Bytes previous = small_folder().read("previous");
  FUZZ_CLAIM(all.size() == 152);
  all.insert(all.end(), previous.begin(), previous.end());
  return {all, Bytes(100)};
}

void repair_small(Bytes& input, std::uint32_t choice) {
  const auto put = [&](std::size_t offset, std::uint64_t value) { std::memcpy(input.data() + offset, &value, 8); };
  if (input.size() < 152 + 56) input.resize(152 + 56);
  if ((choice & 1) != 0) put(0, 0x3153545241545341u), put(8, input[8] % 10U);
  put(144, hal::digest64(raw(input).first(144)));
  if ((choice & 2) != 0) put(152, 0x3156455250524941u), put(160, 7), put(168, 24);
  put(176, hal::digest64(raw(input).subspan(184, 24), 7));
}

}  // namespace

const Target durable_store{"durable_store", all_files, load, repair, seeds, nullptr};
const Target small_records{"small_records", 220, read_small, repair_small, small_seeds, nullptr};

}  // namespace airside::fuzz
