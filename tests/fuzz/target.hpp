#pragma once
// What a fuzz target is: bytes to a reader of the project, and claims about what comes out. libFuzzer drives one target
// a program (libfuzzer.cpp); the ordinary tests replay the seeds of all of them (seeds_test.cpp).

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::fuzz {

using Bytes = std::vector<std::uint8_t>;
using View = std::span<const std::uint8_t>;

/// One reader under test.
struct Target {
  const char* name;
  std::size_t max_bytes;  ///< longer inputs show nothing more
  /// Reads the input and checks the claims; true if the reader took it.
  bool (*run)(View input);
  /// Makes checksums and lengths fit again after a mutation, so that what lies behind them is reached; may be null.
  void (*repair)(Bytes& input, std::uint32_t choice);
  /// Small inputs to begin with, made from the project's own examples. The first is taken.
  std::vector<Bytes> (*seeds)();
  /// Words of the format, for libFuzzer's dictionary; may be null.
  std::vector<std::string> (*words)();
};

extern const Target blob, blob_head, signed_blob, keys, site_file, point_map, register_codec, modbus_tcp, modbus_rtu,
    durable_store, small_records, log_csv, row_log, epw, room_file, json_patch, mailbox, readings, http_request;

/// All of them, in the order of the run script.
std::vector<const Target*> all_targets();

/// Stops the program: a claim does not hold.
[[noreturn]] inline void violated(const char* claim, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: claim violated: %s\n", file, line, claim);
  std::abort();
}
#define FUZZ_CLAIM(claim) ((claim) ? void() : ::airside::fuzz::violated(#claim, __FILE__, __LINE__))

/// Whether `read` takes its input. A refusal must say place, what was found, what was expected, and what to do;
/// exceptions of other kinds go on and are findings.
template <class Read>
bool taken(Read&& read) {
  try {
    read();
    return true;
  } catch (const hal::InputError& e) {
    FUZZ_CLAIM(!e.place().empty() && !e.found().empty() && !e.expected().empty() && !e.remedy().empty());
    return false;
  }
}

inline std::string_view text_of(View input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }
inline Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }
inline std::span<const std::byte> raw(View input) { return std::as_bytes(input); }

/// Takes numbers and the rest off the front of an input; 0 and nothing when it has ended.
class Cursor {
 public:
  explicit Cursor(View left) : left_(left) {}
  unsigned byte() {
    if (left_.empty()) return 0;
    const unsigned b = left_.front();
    left_ = left_.subspan(1);
    return b;
  }
  unsigned word() { return byte() << 8 | byte(); }
  View take(std::size_t n) {
    const View front = left_.first(n < left_.size() ? n : left_.size());
    left_ = left_.subspan(front.size());
    return front;
  }
  View rest() const { return left_; }

 private:
  View left_;
};

}  // namespace airside::fuzz
