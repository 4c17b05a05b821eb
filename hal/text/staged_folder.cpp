#include "hal/text/staged_folder.hpp"

#include <unistd.h>

#include <string>
#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::hal {

namespace fs = std::filesystem;

StagedFolder::StagedFolder(fs::path target) : target_(std::move(target)) {
  if (target_.empty()) target_ = ".";
  target_ = target_.lexically_normal();
  if (!target_.has_filename()) target_ = target_.parent_path();  // "out/"
  const std::string part = "." + std::to_string(::getpid()) + ".part";
  std::error_code error;
  if (fs::exists(target_, error)) {
    staging_ = target_ / part;
  } else {
    if (target_.has_parent_path()) fs::create_directories(target_.parent_path(), error);
    if (error) fail(error);
    staging_ = target_.string() + part;
  }
  fs::remove_all(staging_, error);
  unfinished_.emplace(staging_.string());
  if (!fs::create_directory(staging_, error)) fail(error);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (unfinished_) fs::remove_all(staging_, ignored);
}

void StagedFolder::commit(const fs::path& last) {
  std::error_code error;
  if (!fs::exists(target_, error)) {
    fs::rename(staging_, target_, error);
    if (error) fail(error);
    unfinished_.reset();
    return;
  }
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(staging_)) {
    if (entry.path().filename() != last) names.push_back(entry.path().filename());
  }
  names.push_back(last);
  for (const fs::path& name : names) {
    fs::rename(staging_ / name, target_ / name, error);
    if (error) fail(error);
  }
  fs::remove_all(staging_, error);
  unfinished_.reset();
}

void StagedFolder::fail(const std::error_code& error) const {
  throw InputError(target_.string(), "a folder that cannot be written: " + error.message(),
                   "a writable place with free space", "choose another output folder");
}

}  // namespace airside::hal
