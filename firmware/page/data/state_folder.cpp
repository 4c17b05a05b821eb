#include "firmware/page/data/state_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <ctime>
#include <span>

namespace airside::page {

hal::StorageFile open_in(const std::string& folder, const char* name, std::uint64_t max_bytes, std::uint64_t& bytes) {
  const std::string path = folder + "/" + name;
  hal::StorageFile file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.descriptor(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  bytes = static_cast<std::uint64_t>(status.st_size);
  if (bytes > max_bytes) return {};
  return file;
}

nlohmann::json json_in(const hal::StorageFile& file, std::uint64_t bytes) {
  std::string text(static_cast<std::size_t>(bytes), '\0');
  const auto got = file.read_at(std::as_writable_bytes(std::span(text)), 0, "read a file of the page");
  return got && *got == bytes ? nlohmann::json::parse(text, nullptr, false) : nlohmann::json();
}

bool StatusReader::refresh() {
  struct stat status {};
  const std::string path = dir_ + "/status.json";
  const bool is_there = ::lstat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode);
  const std::int64_t changed_ns =
      is_there ? std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec : 0;
  const std::uint64_t inode = is_there ? static_cast<std::uint64_t>(status.st_ino) : 0;
  if (inode == inode_ && changed_ns == changed_ns_) return false;
  std::uint64_t size = 0;
  const hal::StorageFile file = open_in(dir_, "status.json", max_status_bytes, size);
  std::string text(file.is_open() ? static_cast<std::size_t>(size) : 0, '\0');
  const auto got = file.is_open() ? file.read_at(std::as_writable_bytes(std::span(text)), 0, "read status")
                                  : hal::StoreResult<std::size_t>(std::size_t{0});
  if (!got || *got != text.size()) text.clear();
  inode_ = inode;
  changed_ns_ = changed_ns;
  text_ = std::move(text);
  object_ = nlohmann::json::parse(text_, nullptr, false);
  if (!object_.is_object()) {
    object_ = nullptr;
    inode_ = 0;  // a file that was just being replaced: the next look reads it again
  }
  return true;
}

double StatusReader::age_s() const {
  if (text_.empty()) return std::numeric_limits<double>::quiet_NaN();
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<double>(std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec - changed_ns_) * 1e-9;
}

}  // namespace airside::page
