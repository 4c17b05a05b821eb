#pragma once
// A Modbus/TCP proxy that stands between a client and a true server and answers as broken and hostile peers do, by
// rules. Real sockets on both sides; what reached the server and what it really answered can be asked for.

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tools/chaos/chaos_script.hpp"

namespace airside::tools {

struct ChaosSettings {
  std::string listen = "127.0.0.1";
  int port = 0;  ///< 0: the system chooses, see ChaosProxy::port()
  std::string to_host = "127.0.0.1";
  int to_port = 502;
  std::vector<ChaosRule> rules;
  std::uint64_t seed = 1;
};

/// One request and what became of it. Frames are whole, from the transaction number on.
struct ChaosExchange {
  ChaosRequest request;
  std::uint64_t connection = 0;  ///< counted from 1
  ChaosFault fault;
  std::vector<std::uint8_t> asked;      ///< as the client sent it
  std::vector<std::uint8_t> forwarded;  ///< as the server got it; empty: it did not
  std::vector<std::uint8_t> answered;   ///< what the server said; empty: nothing
  /// The server's answer is no exception.
  bool taken() const { return answered.size() > 8 && (answered[7] & 0x80U) == 0; }
};

struct ChaosCounters {
  std::uint64_t exchanges = 0, connections = 0, faults = 0, writes_forwarded = 0;
  std::map<std::string, std::uint64_t> by_fault;
};

class ChaosProxy {
 public:
  /// Called once an exchange is decided and the server has answered, before the client sees anything; one at a time.
  using OnExchange = std::function<void(const ChaosExchange&)>;

  /// Listens at once.
  /// Errors: hal::InputError where the address cannot be had or the server's name is unknown.
  explicit ChaosProxy(ChaosSettings settings, OnExchange on_exchange = {});
  ~ChaosProxy();
  ChaosProxy(const ChaosProxy&) = delete;
  ChaosProxy& operator=(const ChaosProxy&) = delete;

  int port() const { return port_; }
  ChaosCounters counters() const;
  /// Other rules from the next request on.
  void use(std::vector<ChaosRule> rules);
  /// The newest request that the server has answered.
  ChaosExchange last_answered() const;

 private:
  struct Connection;

  bool open_listener();
  void accept_all();
  void serve(Connection& c);
  bool exchange(Connection& c);
  bool forward(Connection& c, ChaosExchange& e);
  bool act(Connection& c, const ChaosExchange& e);
  void note(const ChaosExchange& e);
  bool send_to(const Connection& c, std::vector<std::uint8_t> bytes) const;
  bool trickle(const Connection& c, const std::vector<std::uint8_t>& bytes, double gap_s) const;
  bool flood(const Connection& c, std::uint64_t number, double seconds) const;
  bool pause(const Connection& c, double seconds) const;
  void swallow_until_gone(const Connection& c) const;
  double now_s() const;

  ChaosSettings settings_;
  OnExchange on_exchange_;
  std::string to_numeric_;
  int listener_ = -1;
  std::atomic<int> port_ = 0;  ///< found when the listener opens, also again after it refused
  std::int64_t began_ns_ = 0;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> refuse_until_ns_{0};
  mutable std::mutex mutex_;  ///< rules, counters, the newest answer, and calls of on_exchange_
  ChaosCounters counters_;
  ChaosExchange newest_;
  std::list<Connection> connections_;  ///< of the accepting thread alone
  std::thread acceptor_;
};

/// One line on an exchange, as `12.345 s, exchange 120: late, read fc 4 addr 0 count 31`.
std::string describe(const ChaosExchange& e);

}  // namespace airside::tools
