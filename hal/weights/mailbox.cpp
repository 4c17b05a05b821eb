#include "hal/weights/mailbox.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <string_view>

#include "hal/storage/folder_names.hpp"

namespace airside::hal {
namespace {

bool is_blob_name(std::string_view name) { return name.size() > 5 && name.ends_with(".blob") && name.front() != '.'; }

}  // namespace

Mailbox::Mailbox(const std::string& dir) : path_(dir) { open(); }

/// What was reported of another folder's files says nothing of those here. The folder is shared with other users: a
/// link at its path is not followed, or whoever made it would choose where this process renames and removes files.
void Mailbox::open() {
  auto opened = StorageFile::open_dir(path_.c_str(), FolderLink::refused);
  fault_ = opened ? StoreFault::none : opened.error().fault;
  dir_ = opened ? std::move(*opened) : StorageFile();
  tell_anew();
}

void Mailbox::tell_anew() {
  std::ranges::fill(told_, Seen{});
  handed_back_ = false;
  blob_[0] = '\0';
}

std::optional<Mailbox::Seen> Mailbox::look(const StorageFile& dir, const char* name) {
  struct stat status {};
  if (::fstatat(dir.descriptor(), name, &status, AT_SYMLINK_NOFOLLOW) != 0) {
    return errno == ENOENT ? std::optional(Seen{}) : std::nullopt;
  }
  return S_ISDIR(status.st_mode) ? Seen{} : Seen{status.st_ino, status.st_ctim};
}

bool Mailbox::is_as_seen(const char* name, const Seen& seen) const {
  return seen.inode != 0 && look(dir_, name) == seen;
}

bool Mailbox::tell(int wish, const std::optional<Seen>& seen) {
  const bool differs = is_new(wish, seen);
  if (seen) told_[wish] = *seen;
  return differs;
}

bool Mailbox::release_waits() const {
  if (stands()) return is_new(wish_release, look(dir_, release_name));
  const auto other = StorageFile::open_existing_dir(path_.c_str(), FolderLink::refused);
  return other && look(*other, release_name).value_or(Seen{}).inode != 0;
}

bool Mailbox::take(const char* name) { return ::unlinkat(dir_.descriptor(), name, 0) == 0; }

bool Mailbox::is_arriving(const char* name) const {
  const StorageFile file(::openat(dir_.descriptor(), name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.descriptor(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  const std::int64_t age_s = std::int64_t{::time(nullptr)} - status.st_mtim.tv_sec;
  if (age_s < 0 || age_s >= arriving_s) return false;
  BlobHeader header{};
  const auto got = file.read_at(std::as_writable_bytes(std::span(&header, 1)), 0, "look at pushed blob");
  const std::size_t seen = got ? *got : sizeof header;
  const auto magic = BlobHeader{}.magic;
  if (!std::equal(magic.begin(), magic.begin() + std::min(seen, magic.size()), header.magic.begin())) return false;
  const std::uint64_t whole = sizeof header + std::uint64_t{header.payload_bytes} + blob_signature_bytes;
  return seen < sizeof header || static_cast<std::uint64_t>(status.st_size) < whole;
}

bool Mailbox::find_blob() {
  (void)for_each_name(dir_.descriptor(), [this](const char* entry) {
    const std::string_view name(entry);
    // A folder cannot be taken away, and must not stand before the blobs behind it for ever.
    if (name.size() >= sizeof blob_) return true;  // uncovered: foreign file systems alone have names so long
    if (!is_blob_name(name) || look(dir_, entry).value_or(Seen{}).inode == 0 || is_arriving(entry)) return true;
    std::memcpy(blob_, name.data(), name.size());
    blob_[name.size()] = '\0';
    return false;
  });
  return blob_[0] != '\0';
}

bool Mailbox::may_be_later() {
  if (++unread_times_ <= patience) return true;
  unread_times_ = 0;
  return false;
}

void Mailbox::read_blob(std::span<std::byte> blob, Mail& mail) {
  mail.has_blob = true;
  mail.unread = "no file that this user may read";
  const Seen last = blob_seen_;
  blob_seen_ = look(dir_, blob_).value_or(Seen{});
  if (!(blob_seen_ == last)) unread_times_ = 0;
  // Neither a link out of the folder nor a pipe that would block.
  const StorageFile file(::openat(dir_.descriptor(), blob_, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.descriptor(), &status) != 0) {
    mail.later = errno != ELOOP && may_be_later();
    return;
  }
  blob_seen_ = {status.st_ino, status.st_ctim};
  if (!S_ISREG(status.st_mode)) return;
  mail.unread = "longer than any blob of this topology";
  if (static_cast<std::uint64_t>(status.st_size) > blob.size()) return;
  const auto got = file.read_at(blob.first(static_cast<std::size_t>(status.st_size)), 0, "read pushed blob");
  if (!got) {
    mail.unread = "a medium that cannot be read";
    mail.later = may_be_later();
    return;
  }
  mail.unread = nullptr;
  mail.blob_bytes = *got;
  unread_times_ = 0;
}

Mail Mailbox::collect(std::span<std::byte> blob) {
  Mail mail;
  if (!stands()) open();
  if (!dir_.is_open()) return mail;
  const std::optional<Seen> release = look(dir_, release_name);
  mail.release = tell(wish_release, release);
  // Reported without the release that it ends, a hand-back would be gone when that one is reported.
  mail.hand_back = release && tell(wish_hand_back, look(dir_, hand_back_name));
  mail.rollback = tell(wish_rollback, look(dir_, rollback_name));
  if (mail.hand_back && mail.release) {
    mail.hand_back = told_[wish_hand_back].is_after(told_[wish_release]);
    mail.release = !mail.hand_back;
  }
  if (mail.release) mail.release_s = release_left_s();
  if (mail.release || mail.hand_back) release_over_ = false;
  handed_back_ = mail.hand_back || (handed_back_ && !mail.release);
  if (blob_[0] == '\0' && find_blob()) read_blob(blob, mail);
  mail.blob_is_older = mail.has_blob && mail.rollback && !blob_seen_.is_after(told_[wish_rollback]);
  return mail;
}

std::optional<int> Mailbox::hours_of(std::string_view text) {
  while (text.ends_with('\n') || text.ends_with('\r')) text.remove_suffix(1);
  if (text.size() > 3) return {};
  int hours = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return {};
    hours = 10 * hours + (c - '0');
  }
  const bool good = text.empty() || (hours >= 1 && hours <= longest_release_h);
  return good ? std::optional(hours) : std::nullopt;
}

/// What is left of its time: it counts from the file's last change, so that a restart does not begin it anew, and never
/// more than was asked for, whatever the clock says. What cannot be read has no end but a hand-back.
std::int64_t Mailbox::release_left_s() const {
  const StorageFile file(::openat(dir_.descriptor(), release_name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.descriptor(), &status) != 0 || !S_ISREG(status.st_mode)) return 0;
  std::array<char, 8> text{};
  const auto got = file.read_at(std::as_writable_bytes(std::span(text)), 0, "read release");
  const int hours = got ? hours_of({text.data(), *got}).value_or(0) : 0;
  if (hours == 0) return 0;
  const std::int64_t asked_s = std::int64_t{hours} * 3600;
  constexpr std::int64_t year_2024_s = 1'704'067'200;  // a file of before was written by a clock that was not set
  if (status.st_mtim.tv_sec < year_2024_s) return asked_s;
  const std::int64_t left_s = asked_s - (std::int64_t{::time(nullptr)} - status.st_mtim.tv_sec);
  return left_s <= 0 ? -1 : std::min(left_s, asked_s);
}

bool Mailbox::waits(const std::string& path, const BlobHeader& header) {
  const StorageFile file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (!file.is_open()) return false;
  BlobHeader waiting;
  const auto got = file.read_at(std::as_writable_bytes(std::span(&waiting, 1)), 0, "read waiting blob");
  if (!got || *got != sizeof waiting || waiting.magic != BlobHeader{}.magic) return false;
  return waiting.key_id != header.key_id || waiting.security_counter >= header.security_counter;
}

bool Mailbox::finish(bool accepted) {
  bool changed = false;
  // The release first, and for good: alone in the inbox it would be reported again at the next start.
  const std::optional<Seen> release = look(dir_, release_name);
  const bool released = told_[wish_release].inode != 0 && (!release || *release == told_[wish_release]);
  const bool ended = handed_back_ && released && release && take(release_name) && ::fsync(dir_.descriptor()) == 0;
  const auto take_as_seen = [this](Wish wish) {
    return is_as_seen(wish_names[wish], told_[wish]) && take(wish_names[wish]);
  };
  for (const Wish wish : {wish_hand_back, wish_rollback}) {
    if (wish == wish_hand_back && handed_back_ && released && !ended) continue;
    if (take_as_seen(wish)) changed = true;
  }
  handed_back_ = handed_back_ && released && !ended;
  if (release_over_ && take_as_seen(wish_release)) changed = true;
  release_over_ = false;
  if (blob_[0] != '\0' && is_as_seen(blob_, blob_seen_)) {
    const bool kept = !accepted && ::renameat(dir_.descriptor(), blob_, dir_.descriptor(), refused_name) == 0;
    changed = kept || take(blob_) || changed;
  }
  blob_[0] = '\0';
  // What was done must not come back with a power cut, long after another wish was done.
  if (changed) (void)::fsync(dir_.descriptor());
  return !handed_back_;
}

}  // namespace airside::hal
