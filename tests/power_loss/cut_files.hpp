#pragma once
// Files and names on the disk that a power cut leaves: their content by sectors, and the parts of which any may be
// lost.

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "hal/storage/digest64.hpp"
#include "power_loss/power_cut.hpp"

namespace airside::power_loss {

using Inode = std::uint64_t;

constexpr std::size_t sector = 512;

inline std::uint64_t mixed(std::uint64_t h, std::uint64_t word) {
  h = (h ^ word) * 0x9E3779B97F4A7C15u;
  return h ^ (h >> 29);
}

inline std::uint64_t hash_of(const std::string& text) { return hal::digest64(std::as_bytes(std::span(text))); }

inline bool is_loaded(const std::string& name) {
  for (const char* prefix : {"state/row.", "state/learning.", "state/replay.", "state/previous", "log/", "inbox/"}) {
    if (name.starts_with(prefix)) return true;
  }
  return false;
}
inline bool is_store(const std::string& name) {
  return name.compare(0, 10, "state/row.") == 0 || name.compare(0, 15, "state/learning.") == 0 ||
         name.compare(0, 13, "state/replay.") == 0;
}
inline std::string folder_of(const std::string& name) { return name.substr(0, name.rfind('/')); }

/// A file's bytes with a hash over its sectors that follows changes without being made anew.
struct Content {
  Bytes bytes;
  std::vector<std::uint64_t> hash;  ///< a sector
  std::uint64_t sum = 0;

  std::uint64_t hash_of_sector(std::size_t i) const {
    const std::size_t from = i * sector, to = std::min(bytes.size(), from + sector);
    return mixed(hal::digest64(std::span(bytes).subspan(from, to - from)), i + 1);
  }
  void rehash(std::size_t from, std::size_t to) {
    const std::size_t count = (bytes.size() + sector - 1) / sector;
    for (std::size_t i = count; i < hash.size(); ++i) sum -= hash[i];
    hash.resize(count, 0);
    for (std::size_t i = from / sector; i < count && i * sector < to; ++i) {
      sum -= hash[i];
      hash[i] = hash_of_sector(i);
      sum += hash[i];
    }
  }
  /// Of sector i where it is full and zero.
  static std::uint64_t hash_of_zeros(std::size_t i) {
    static const std::uint64_t zeros = hal::digest64(std::array<std::byte, sector>{});
    return mixed(zeros, i + 1);
  }
  void resize(std::size_t size) {
    const std::size_t old = bytes.size();
    bytes.resize(size);
    if (size <= old) return rehash(size / sector * sector, size);
    const std::size_t first = (old + sector - 1) / sector, last = size / sector;
    rehash(old / sector * sector, std::min(size, first * sector));
    for (std::size_t i = first; i < last; ++i) {
      hash[i] = hash_of_zeros(i);
      sum += hash[i];
    }
    rehash(last * sector, size);
  }
  void write(std::uint64_t offset, std::span<const std::byte> from) {
    const auto at = static_cast<std::size_t>(offset);
    if (bytes.size() < at + from.size()) resize(at + from.size());
    std::copy(from.begin(), from.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
    rehash(at / sector * sector, at + from.size());
  }
  std::uint64_t digest() const { return mixed(sum, bytes.size()); }
};

/// A part of an operation that reaches the medium as one: a piece of a sector, a new size.
struct Cell {
  Inode inode = 0;
  std::uint64_t offset = 0;          ///< of the bytes; the new size
  std::span<const std::byte> bytes;  ///< none: a size
  bool grows = false;                ///< a size that is only a lower bound
  bool dropped = false;              ///< a sync failed after it: later ones confirm nothing
};

using Names = std::map<std::string, Inode>;

inline void change(Names& names, const Trace::Op& op) {
  if (op.kind == IoKind::create) names[op.name] = op.inode;
  if (op.kind == IoKind::unlink) names.erase(op.name);
  if (op.kind == IoKind::rename) {
    const auto found = names.find(op.name);
    if (found == names.end()) return;  // its creation did not reach the medium: neither did this
    const Inode inode = found->second;
    names.erase(found);
    names[op.to] = inode;
  }
}

}  // namespace airside::power_loss
