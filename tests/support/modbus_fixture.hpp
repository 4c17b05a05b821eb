#pragma once
// Real peers for the Modbus tests: the project's server in a thread, hostile TCP servers, and other people's programs.

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "hal/modbus/link.hpp"
#include "hal/modbus/server.hpp"

namespace airside::hal::testing_peers {

/// Runs a server until it goes out of scope. Configure server() before start().
class ServerThread {
 public:
  ServerThread(const PointMap& map, ServerSettings settings) : server_(map, std::move(settings)) {}
  ~ServerThread() { stop(); }
  ModbusServer& server() { return server_; }
  void start();
  void stop();

 private:
  ModbusServer server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A TCP server that does with each connection what `behave` says; it reads nothing by itself.
class HostilePeer {
 public:
  using Behaviour = std::function<void(HostilePeer&, int fd)>;
  explicit HostilePeer(Behaviour behave);
  ~HostilePeer();
  int port() const { return port_; }
  int connections() const { return connections_; }
  bool stopping() const { return stop_; }
  /// One request ADU; empty when the client hangs up or the peer stops.
  std::vector<std::uint8_t> request(int fd) const;
  void send(int fd, const std::vector<std::uint8_t>& bytes) const;
  /// Sleeps, but not beyond the peer's end.
  void pause(double seconds) const;

 private:
  Behaviour behave_;
  std::atomic<bool> stop_{false};
  std::atomic<int> connections_{0};
  int listener_ = -1;
  int port_ = 0;
  std::thread thread_;
};

constexpr double slack_s = 0.2;  ///< that a busy machine may add to a deadline

/// The bytes with one of them replaced.
inline std::vector<std::uint8_t> with(std::vector<std::uint8_t> bytes, std::size_t at, std::uint8_t value) {
  bytes[at] = value;
  return bytes;
}

/// The right answer to a read of holding registers: each register holds its address.
std::vector<std::uint8_t> honest_answer(const std::vector<std::uint8_t>& request);

LinkSettings tcp_settings(int port, double deadline_s = 0.5);

struct ProgramResult {
  int status;  ///< exit status
  std::string output;
};
/// Runs a shell command with stderr joined to stdout.
ProgramResult run_program(const std::string& command);

/// Point map text: header and one row.
std::string csv_header();

double seconds_since(std::int64_t start_ns);

}  // namespace airside::hal::testing_peers
