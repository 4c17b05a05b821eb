#pragma once
// A folder in memory that a target writes files of its input to.

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <string>

#include "fuzz/target.hpp"
#include "support/test_folder.hpp"

namespace airside::fuzz {

class Folder {
 public:
  explicit Folder(const std::string& name) : folder_(name), fd_(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY)) {}
  ~Folder() { ::close(fd_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const char* path() const { return folder_.c_str(); }
  int fd() const { return fd_; }
  void write(const char* name, View bytes) const {
    const int file = ::openat(fd_, name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0640);
    FUZZ_CLAIM(file >= 0 && ::write(file, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
    ::close(file);
  }
  Bytes read(const char* name) const {
    const int file = ::openat(fd_, name, O_RDONLY | O_CLOEXEC);
    if (file < 0) return {};
    Bytes bytes(1 << 20);
    const ssize_t got = ::read(file, bytes.data(), bytes.size());
    ::close(file);
    bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return bytes;
  }
  void remove(const char* name) const { ::unlinkat(fd_, name, 0); }

 private:
  hal::TestFolder folder_;
  int fd_;
};

}  // namespace airside::fuzz
