#include "hal/text/staged_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "hal/text/input_error.hpp"

namespace airside::hal {

namespace fs = std::filesystem;

StagedFile::StagedFile(const std::string& path) : path_(path), target_(path) {
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  const bool there = fs::exists(status);
  if (there && fs::is_symlink(path, failed)) target_ = fs::canonical(path, failed).string();
  part_ = there && !fs::is_regular_file(status) ? target_ : target_ + ".part";
  if (part_ != target_) unfinished_.emplace(part_);
  file_.reset(std::fopen(part_.c_str(), "wb"));
  if (!file_) fail(errno);
}

StagedFile::~StagedFile() {
  if (!file_) return;
  file_.reset();
  std::error_code ignored;
  if (part_ != target_) fs::remove(part_, ignored);
}

void StagedFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) fail(errno);
}

void StagedFile::commit() {
  if (!file_) return;
  std::error_code failed;
  const int error = std::fclose(file_.release()) == 0 ? 0 : errno;
  if (part_ == target_) {
    if (error != 0) fail(error);
    return;
  }
  if (error == 0) fs::rename(part_, target_, failed);
  if (error == 0 && !failed) {
    unfinished_.reset();
    return;
  }
  std::error_code ignored;
  fs::remove(part_, ignored);
  fail(error != 0 ? error : failed.value());
}

void StagedFile::fail(int error) const {
  throw InputError(path_, std::string("a file that cannot be written: ") + std::strerror(error),
                   "a writable place with free space", "choose another, or make room");
}

}  // namespace airside::hal
