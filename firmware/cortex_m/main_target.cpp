// The microcontroller's half of the comparison. Lines of the day go to standard output, figures about the machine to
// standard error. Arguments: `sound` or `faulty`, and `count` to count instructions (QEMU -icount shift=0).

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>

#include "airside/presets.hpp"
#include "firmware/cortex_m/board.hpp"
#include "firmware/cortex_m/day.hpp"
#include "firmware/cortex_m/semihosting.hpp"

// The blob, as a flash sector would hold it.
asm(".section .rodata.room_blob, \"a\"\n"
    ".balign 8\n"
    ".global room_blob\n"
    "room_blob:\n"
    ".incbin \"" AIRSIDE_WEIGHTS_BLOB
    "\"\n"
    ".global room_blob_end\n"
    "room_blob_end:\n"
    ".previous\n");
extern "C" const std::byte room_blob, room_blob_end;

namespace airside::cortex_m {
namespace {

// Built in place: nothing is constructed before run_image().
template <class Object>
struct Place {
  alignas(Object) std::array<std::byte, sizeof(Object)> bytes;
  Object& construct(auto&&... arguments) {
    return *std::construct_at(reinterpret_cast<Object*>(bytes.data()), arguments...);
  }
};
AIRSIDE_LARGE_RAM Place<Box> box_place;
static_assert(std::is_trivially_destructible_v<Box>);

void print(std::string_view line) { semihosting_write(Stream::output, line); }
void remark(std::string_view line) { semihosting_write(Stream::remarks, line); }

/// Counts the instructions between reading and writing (a decision) and between writing and the row's end (learning).
class CountedRoom {
 public:
  explicit CountedRoom(RoomModel& room) : room_(room) {}
  CivilTime now() const { return room_.now(); }
  bool sleep_until(CivilTime t) {
    if (written_) learning_ = std::max(learning_, instructions() - at_);
    written_ = false;
    return room_.sleep_until(t);
  }
  CivilTime woke() const { return room_.woke(); }
  Expected<Reading<Topo>> sense() {
    const auto sensed = room_.sense();
    at_ = instructions();
    return sensed;
  }
  Expected<Applied> actuate(const Command& command) {
    decision_ = std::max(decision_, instructions() - at_);
    const auto applied = room_.actuate(command);
    written_ = true;
    at_ = instructions();
    return applied;
  }
  std::uint64_t decision() const { return decision_; }
  std::uint64_t learning() const { return learning_; }

 private:
  RoomModel& room_;
  bool written_ = false;
  std::uint64_t at_ = 0, decision_ = 0, learning_ = 0;
};

int run() {
  std::array<char, 80> buffer{};
  const std::string_view arguments = semihosting_arguments(buffer);
  const bool faulty = arguments.find("faulty") != std::string_view::npos;
  const bool counts = arguments.find("count") != std::string_view::npos;
  if (counts) start_instruction_counter();

  Box& box = box_place.construct();
  box.configure(product_settings(), default_limits<Topo>(), strict_kernels<float>(), 9);
  static_assert(sizeof(Payload) <= sizeof(NetworkScratch<Topo, float>) && alignof(Payload) <= 64);
  Payload& work = *std::construct_at(reinterpret_cast<Payload*>(box.lend_scratch().data()));
  RoomModel room(schedule_day, 2021);
  CountedRoom counted(room);
  LineWriter out(print), remarks(remark);
  const std::span<const std::byte> blob(&room_blob, &room_blob_end);
  const bool good = run_day(box, work, blob, counted, counted, room, faulty ? Scenario::faulty : Scenario::sound, out);

  remarks.text("stack ").number(static_cast<std::int64_t>(stack_deepest()));
  remarks.text(" of ").number(static_cast<std::int64_t>(stack_size())).end();
  remarks.text("controller ").number(sizeof(Box)).text(" bytes").end();
  if (counts) {
    remarks.text("decision ").number(static_cast<std::int64_t>(counted.decision())).text(" instructions").end();
    remarks.text("learning ").number(static_cast<std::int64_t>(counted.learning())).text(" instructions").end();
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace airside::cortex_m

int run_image() { return airside::cortex_m::run(); }
