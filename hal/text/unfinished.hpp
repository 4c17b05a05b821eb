#pragma once
// What a host program would leave behind when a signal ends it: files and folders that are not finished, and the
// processes that it started. Who makes one registers it here for as long as it is unfinished.

#include <sys/types.h>
#include <string>

namespace airside::hal {

/// A file, or a folder with all that lies in it, that is of no use unless it is finished.
/// Cost: one allocation. Safe from several threads; beyond 256 paths at a time nothing is registered.
class UnfinishedPath {
 public:
  explicit UnfinishedPath(const std::string& path);
  ~UnfinishedPath() { release(); }
  UnfinishedPath(const UnfinishedPath&) = delete;
  UnfinishedPath& operator=(const UnfinishedPath&) = delete;
  /// The path is finished, or its owner has removed it.
  void release();

 private:
  int slot_ = -1;
};

/// A child process that must not outlive this one.
class UnfinishedChild {
 public:
  explicit UnfinishedChild(pid_t pid);
  ~UnfinishedChild() { release(); }
  UnfinishedChild(UnfinishedChild&& other) noexcept;
  UnfinishedChild& operator=(UnfinishedChild&& other) noexcept;
  /// To be called before the child is waited for: afterwards its number may be another process's.
  void release();

 private:
  int slot_ = -1;
};

/// From now on SIGINT, SIGTERM and SIGHUP first pass SIGTERM to the registered children and wait for them (those that
/// still run after 5 s are killed), then remove the registered paths, then end this process as the signal would have.
/// A signal that was ignored stays ignored: nohup and background jobs rely on it.
void clean_up_on_signals();

/// To be called in a forked child, before it registers anything: what the parent registered is the parent's.
void forget_unfinished();

}  // namespace airside::hal
