#include "firmware/page/auth/password_check.hpp"

#include <pthread.h>
#include <sodium.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <utility>

#include "firmware/page/auth/access_file.hpp"

namespace airside::page {

PasswordCheck::PasswordCheck() : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  // Signals are the serving thread's.
  sigset_t all, before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { work(); });
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

PasswordCheck::~PasswordCheck() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

bool PasswordCheck::begin(std::string hash, std::string password) {
  {
    const std::lock_guard lock(mutex_);
    if (busy_) return false;
    hash_ = std::move(hash);
    password_ = std::move(password);
    busy_ = asked_ = true;
  }
  wake_.notify_one();
  return true;
}

std::optional<PasswordResult> PasswordCheck::result() {
  std::uint64_t count = 0;
  (void)!::read(event_.descriptor(), &count, sizeof count);  // before the look: what comes later wakes again
  const std::lock_guard lock(mutex_);
  if (!result_) return {};
  busy_ = false;
  return std::exchange(result_, std::nullopt);
}

bool PasswordCheck::is_busy() {
  const std::lock_guard lock(mutex_);
  return busy_;
}

void PasswordCheck::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stop_ || asked_; });
    if (stop_) return;
    asked_ = false;
    std::string password = std::exchange(password_, {}), hash = std::exchange(hash_, {});
    lock.unlock();
    PasswordResult found = PasswordResult::wrong;
    try {  // nobody above would catch it: the page would end
      if (hash.empty()) {
        (void)hash_of_password(password);  // the time must not show whether a role has a password
      } else if (is_password(password, hash)) {
        found = PasswordResult::right;
      }
    } catch (const std::exception&) {
      found = PasswordResult::no_memory;
    }
    sodium_memzero(password.data(), password.size());
    lock.lock();
    result_ = found;
    lock.unlock();
    const std::uint64_t one = 1;
    (void)!::write(event_.descriptor(), &one, sizeof one);
    lock.lock();
  }
}

}  // namespace airside::page
