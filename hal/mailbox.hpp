#pragma once
// The box's inbox: a folder into which people and other programs put weights and wishes. It is looked into every row,
// without heap, and whatever lies there is taken away, so that it cannot fill up or be done twice.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/storage_file.hpp"

namespace airside::hal {

/// What lay in the inbox.
struct Mail {
  bool hand_back = false, release = false, rollback = false;
  bool has_blob = false;
  std::size_t blob_bytes = 0;  ///< what `blob` holds; 0: too long to be one, or unreadable
};

class Mailbox {
 public:
  static constexpr const char* blob_name = "weights.blob";
  static constexpr const char* rollback_name = "rollback";
  static constexpr const char* release_name = "release";
  static constexpr const char* hand_back_name = "hand-back";

  /// Opens or makes the folder; one that cannot be had stays empty for ever. Errors: none.
  explicit Mailbox(const std::string& dir);
  static constexpr const char* refused_name = "refused";

  /// Takes wishes out, and reads one blob into `blob`: any file `*.blob`, as it comes from a stick too. The blob itself
  /// stays until finish(), so that a crash in between loses nothing. Cost: a few system calls, no heap.
  Mail collect(std::span<std::byte> blob);
  /// Takes the blob of the last collect() away; a refused one stands as `refused` for whoever looks for it.
  void finish(bool accepted);
  bool is_open() const { return dir_.is_open(); }

 private:
  bool take(const char* name);
  bool find_blob();
  void read_blob(std::span<std::byte> blob, Mail& mail);

  StorageFile dir_;
  char blob_[256] = {};  ///< name of the blob that waits for finish()
};

}  // namespace airside::hal
