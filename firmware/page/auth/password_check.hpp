#pragma once
// One password at a time is verified, beside the thread that serves: argon2id takes a tenth of a second and more.

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "hal/storage/storage_file.hpp"

namespace airside::page {

/// Of a verification. no_memory: it could not be made, so nothing is known of the password.
enum class PasswordResult : std::uint8_t { wrong, right, no_memory };

class PasswordCheck {
 public:
  PasswordCheck();
  ~PasswordCheck();
  PasswordCheck(const PasswordCheck&) = delete;
  PasswordCheck& operator=(const PasswordCheck&) = delete;

  /// Begins to verify; false while another one is under way. An empty hash takes as long and is never right.
  bool begin(std::string hash, std::string password);
  /// Whether the password was right, once; nothing while that is not known.
  std::optional<PasswordResult> result();
  bool is_busy();
  /// Readable when a result is there.
  int descriptor() const { return event_.descriptor(); }

 private:
  void work();

  hal::StorageFile event_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::string hash_, password_;
  bool asked_ = false, busy_ = false, stop_ = false;
  std::optional<PasswordResult> result_;
  std::thread thread_;
};

}  // namespace airside::page
