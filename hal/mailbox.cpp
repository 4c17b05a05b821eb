#include "hal/mailbox.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstring>
#include <string_view>

namespace airside::hal {
namespace {

/// As the kernel writes it; getdents64(2). opendir() would ask the heap.
struct DirectoryEntry {
  std::uint64_t inode;
  std::int64_t next;
  std::uint16_t length;
  std::uint8_t type;
};
constexpr std::size_t name_offset = 19;

bool is_blob_name(std::string_view name) { return name.size() > 5 && name.ends_with(".blob") && name.front() != '.'; }

}  // namespace

Mailbox::Mailbox(const std::string& dir) {
  if (dir.empty()) return;
  auto opened = StorageFile::open_dir(dir.c_str());
  if (opened) dir_ = std::move(*opened);
}

bool Mailbox::take(const char* name) { return ::unlinkat(dir_.descriptor(), name, 0) == 0; }

bool Mailbox::find_blob() {
  alignas(8) char entries[4096];
  if (::lseek(dir_.descriptor(), 0, SEEK_SET) < 0) return false;
  for (int round = 0; round < 64; ++round) {
    const long got = ::syscall(SYS_getdents64, dir_.descriptor(), entries, sizeof entries);
    if (got <= 0) return false;
    for (long at = 0; at < got;) {
      DirectoryEntry entry;
      std::memcpy(&entry, entries + at, sizeof entry);
      const std::string_view name(entries + at + name_offset);
      if (is_blob_name(name) && name.size() < sizeof blob_) {
        std::memcpy(blob_, name.data(), name.size());
        blob_[name.size()] = '\0';
        return true;
      }
      at += entry.length;
    }
  }
  return false;
}

void Mailbox::read_blob(std::span<std::byte> blob, Mail& mail) {
  mail.has_blob = true;
  // Neither a link out of the folder nor a pipe that would block.
  const StorageFile file(::openat(dir_.descriptor(), blob_, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.descriptor(), &status) != 0 || !S_ISREG(status.st_mode)) return;
  if (static_cast<std::uint64_t>(status.st_size) > blob.size()) return;
  const auto got = file.read_at(blob.first(static_cast<std::size_t>(status.st_size)), 0, "read pushed blob");
  if (got) mail.blob_bytes = *got;
}

Mail Mailbox::collect(std::span<std::byte> blob) {
  Mail mail;
  if (!dir_.is_open()) return mail;
  mail.hand_back = take(hand_back_name);
  mail.release = take(release_name);
  mail.rollback = take(rollback_name);
  if (find_blob()) read_blob(blob, mail);
  return mail;
}

void Mailbox::finish(bool accepted) {
  if (blob_[0] == '\0') return;
  const bool kept = !accepted && ::renameat(dir_.descriptor(), blob_, dir_.descriptor(), refused_name) == 0;
  if (!kept) take(blob_);
  blob_[0] = '\0';
}

}  // namespace airside::hal
