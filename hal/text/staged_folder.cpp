#include "hal/text/staged_folder.hpp"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>
#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::hal {

namespace fs = std::filesystem;

namespace {

/// Signals that end a program are delivered when this is over.
class EndingSignalsWait {
 public:
  EndingSignalsWait() {
    sigset_t ending;
    ::sigemptyset(&ending);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&ending, number);
    ::pthread_sigmask(SIG_BLOCK, &ending, &before_);
  }
  ~EndingSignalsWait() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  EndingSignalsWait(const EndingSignalsWait&) = delete;
  EndingSignalsWait& operator=(const EndingSignalsWait&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

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
  remove_left_over();
  unfinished_.emplace(staging_.string());
  if (!fs::create_directory(staging_, error)) fail(error);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  if (unfinished_) fs::remove_all(staging_, ignored);
}

void StagedFolder::commit(const fs::path& last, std::initializer_list<const char*> superseded) {
  const EndingSignalsWait wait;
  std::error_code error;
  if (fs::exists(target_, error)) {
    replace_files(last, superseded);
    fs::remove_all(staging_, error);
  } else {
    fs::rename(staging_, target_, error);
    if (error) fail(error);
  }
  unfinished_.reset();
}

/// Without `last` meanwhile, so that it never lies beside files that are not its.
void StagedFolder::replace_files(const fs::path& last, std::initializer_list<const char*> superseded) const {
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(staging_)) {
    if (entry.path().filename() != last) names.push_back(entry.path().filename());
  }
  names.push_back(last);
  std::error_code error;
  if (names.size() > 1) fs::remove(target_ / last, error);
  for (const char* name : superseded) {
    if (!error && !fs::exists(staging_ / name)) fs::remove(target_ / name, error);
  }
  for (const fs::path& name : names) {
    if (!error) fs::rename(staging_ / name, target_ / name, error);
  }
  if (error) fail(error);
}

/// Staging folders whose process runs no more.
void StagedFolder::remove_left_over() const {
  const bool inside = staging_.parent_path() == target_;
  const std::string before = inside ? "." : target_.filename().string() + ".";
  constexpr std::string_view after = ".part";
  std::vector<fs::path> left_over;
  std::error_code error;
  const fs::path folder = staging_.has_parent_path() ? staging_.parent_path() : fs::path(".");
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(before) || !name.ends_with(after) || name.size() <= before.size() + after.size()) continue;
    const std::string number = name.substr(before.size(), name.size() - before.size() - after.size());
    if (number.size() > 9 || number.find_first_not_of("0123456789") != std::string::npos) continue;
    const bool runs = ::kill(std::stoi(number), 0) == 0 || errno != ESRCH;
    if (!runs || at->path().filename() == staging_.filename()) left_over.push_back(at->path());
  }
  for (const fs::path& path : left_over) fs::remove_all(path, error);
}

void StagedFolder::fail(const std::error_code& error) const {
  throw InputError(target_.string(), "a folder that cannot be written: " + error.message(),
                   "a writable place with free space", "choose another output folder");
}

}  // namespace airside::hal
