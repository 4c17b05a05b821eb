#pragma once
// A word to the service manager (systemd's notify protocol: a datagram of NAME=value lines), so that a stuck control
// thread is restarted. Own lines instead of libsystemd: it may ask the heap, and this is one sendto().

#include <string>
#include <string_view>

namespace airside::hal {

class ServiceManager {
 public:
  /// Takes the socket from NOTIFY_SOCKET; without one every call does nothing.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// `READY=1`, `WATCHDOG=1`, `STATUS=...`. Never blocks. Cost: one system call, no heap.
  void tell(std::string_view words) const;
  /// Interval within which WATCHDOG=1 is expected, s; 0 where nobody waits for it.
  double watchdog_s() const { return watchdog_s_; }

 private:
  int socket_ = -1;
  std::string path_;
  double watchdog_s_ = 0;
};

}  // namespace airside::hal
