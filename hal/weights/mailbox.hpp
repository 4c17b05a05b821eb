#pragma once
// The box's inbox: a folder into which people and other programs put weights and wishes. It is looked into every row,
// without heap; a folder that stands at its path instead of the one that was opened is the inbox from then on. What
// lies there is reported once, and taken away after the commit that holds its effect: a crash in between neither loses
// a wish nor does it twice to the same state.

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "airside/controller/blob.hpp"
#include "hal/storage/storage_file.hpp"

namespace airside::hal {

/// What lay in the inbox.
struct Mail {
  bool hand_back = false, release = false, rollback = false;
  bool has_blob = false;
  std::int64_t release_s = 0;    ///< of `release`: what is left of its time, -1: nothing; 0: until a hand-back
  bool blob_is_older = false;    ///< than the rollback that lies beside it
  const char* unread = nullptr;  ///< why nothing of it could be read; nullptr where it was
  bool later = false;            ///< it may be read the next time
  std::size_t blob_bytes = 0;    ///< what `blob` holds; 0: nothing
};

class Mailbox {
 public:
  static constexpr const char* blob_name = "weights.blob";
  static constexpr const char* rollback_name = "rollback";
  static constexpr const char* release_name = "release";
  static constexpr const char* hand_back_name = "hand-back";

  /// Opens or makes the folder; a link in its place is not followed. Errors: none; one that cannot be had is empty, and
  /// tried again at each collect(), as is one whose path names another folder by now.
  explicit Mailbox(const std::string& dir);
  static constexpr const char* refused_name = "refused";
  static constexpr int longest_release_h = 168;
  static constexpr std::int64_t arriving_s = 600;
  static constexpr int patience = 3;

  /// Tells the wishes that are new (of a release and a hand-back the later one, the release where they are equally
  /// old), and reads one blob into `blob`: any file `*.blob`, as it comes from a stick too.
  /// One that cannot be read may be tried `patience` times more: a medium may fail once.
  /// One that is shorter than its own header says and was written to within arriving_s is still on its way, by scp or
  /// from a slow stick: it is left for later.
  /// Everything stays where it is until finish(). Cost: a few system calls, no heap.
  Mail collect(std::span<std::byte> blob);
  /// The next collect() finds everything new.
  void tell_anew();
  /// The blob of the last collect() stays, and is found again by the next one.
  void leave_blob() { blob_[0] = '\0'; }
  /// Takes the wishes and the blob of the last collect() away; a refused blob stands as `refused` for whoever looks.
  /// A release stays until a hand-back takes it along: it is reported anew to a start that finds no state.
  /// What was replaced or written to since is something else, and stays for the next collect(). Returns false where a
  /// hand-back waits beside a release that could not be taken away; the next finish() tries again.
  bool finish(bool accepted);
  /// Whether a wish to release lies there that no collect() has reported yet; it stays.
  bool release_waits() const;
  bool is_open() const { return dir_.is_open(); }
  /// Why it is not open; none where it is.
  StoreFault fault() const { return fault_; }
  /// Name of the blob that the last collect() reported.
  const char* blob_file() const { return blob_; }
  /// The release that was reported last is over: finish() takes its file away, unless it is another one by then.
  void end_release() { release_over_ = true; }
  /// What a file `release` says: whole hours from 1 to longest_release_h, 0 for an empty one (until a hand-back).
  /// Nothing for any other text.
  static std::optional<int> hours_of(std::string_view text);
  /// Whether a blob lies at `path` that one with this header may not replace: of another key, or not older.
  static bool waits(const std::string& path, const BlobHeader& header);

 private:
  /// A file as it was when its wish was reported or its blob read.
  struct Seen {
    std::uint64_t inode = 0;
    timespec changed{};
    bool operator==(const Seen& other) const {
      return inode == other.inode && changed.tv_sec == other.changed.tv_sec && changed.tv_nsec == other.changed.tv_nsec;
    }
    bool is_after(const Seen& other) const {
      return changed.tv_sec != other.changed.tv_sec ? changed.tv_sec > other.changed.tv_sec
                                                    : changed.tv_nsec > other.changed.tv_nsec;
    }
  };
  enum Wish { wish_hand_back, wish_release, wish_rollback };
  static constexpr const char* wish_names[3] = {hand_back_name, release_name, rollback_name};
  void open();
  /// Whether the open folder is the one at the path.
  bool stands() const { return dir_.is_open() && !dir_.is_replaced_at(path_.c_str()); }
  /// Inode 0: it is not there, or a folder. Nothing: unknown now.
  static std::optional<Seen> look(const StorageFile& dir, const char* name);
  bool is_new(int wish, const std::optional<Seen>& seen) const {
    return seen && seen->inode != 0 && !(*seen == told_[wish]);
  }
  bool is_as_seen(const char* name, const Seen& seen) const;
  bool tell(int wish, const std::optional<Seen>& seen);
  bool take(const char* name);
  bool is_arriving(const char* name) const;
  bool find_blob();
  void read_blob(std::span<std::byte> blob, Mail& mail);
  bool may_be_later();
  std::int64_t release_left_s() const;

  std::string path_;
  StorageFile dir_;
  StoreFault fault_ = StoreFault::none;
  Seen told_[3];  ///< by wish; inode 0: none
  bool handed_back_ = false, release_over_ = false;
  char blob_[256] = {};  ///< name of the blob that waits for finish()
  Seen blob_seen_;       ///< of that blob, or of the last one
  int unread_times_ = 0;
};

}  // namespace airside::hal
