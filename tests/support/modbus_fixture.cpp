#include "support/modbus_fixture.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>

#include "hal/modbus/wire.hpp"

namespace airside::hal::testing_peers {

void ServerThread::start() {
  thread_ = std::thread([this] { server_.run(StopFlag(&stop_)); });
}

void ServerThread::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

HostilePeer::HostilePeer(Behaviour behave) : behave_(std::move(behave)) {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  sockaddr generic{};
  std::memcpy(&generic, &here, sizeof(here));
  socklen_t length = sizeof(generic);
  if (bind(listener_, &generic, length) != 0 || listen(listener_, 8) != 0 ||
      getsockname(listener_, &generic, &length) != 0) {
    std::perror("hostile peer");
  }
  std::memcpy(&here, &generic, sizeof(here));
  port_ = ntohs(here.sin_port);
  thread_ = std::thread([this] {
    while (!stop_) {
      pollfd entry = {listener_, POLLIN, 0};
      if (poll(&entry, 1, 20) <= 0) continue;
      const int fd = accept(listener_, nullptr, nullptr);
      if (fd < 0) continue;
      ++connections_;
      behave_(*this, fd);
      ::close(fd);
    }
  });
}

HostilePeer::~HostilePeer() {
  stop_ = true;
  thread_.join();
  ::close(listener_);
}

std::vector<std::uint8_t> HostilePeer::request(int fd) const {
  std::vector<std::uint8_t> bytes(260);
  while (!stop_) {
    pollfd entry = {fd, POLLIN, 0};
    if (poll(&entry, 1, 20) <= 0) continue;
    const ssize_t got = recv(fd, bytes.data(), bytes.size(), 0);
    if (got <= 0) return {};
    bytes.resize(static_cast<std::size_t>(got));
    return bytes;
  }
  return {};
}

void HostilePeer::send(int fd, const std::vector<std::uint8_t>& bytes) const {
  if (::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0) return;
}

void HostilePeer::pause(double seconds) const {
  const std::int64_t end = monotonic_ns() + to_ns(seconds);
  while (!stop_ && monotonic_ns() < end) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

std::vector<std::uint8_t> honest_answer(const std::vector<std::uint8_t>& request) {
  if (request.size() < 12) return {};
  const unsigned addr = unsigned{request[8]} << 8 | request[9];
  const unsigned count = unsigned{request[10]} << 8 | request[11];
  std::vector<std::uint8_t> answer(request.begin(), request.begin() + 8);
  answer[4] = static_cast<std::uint8_t>((3 + 2 * count) >> 8);
  answer[5] = static_cast<std::uint8_t>((3 + 2 * count) & 0xFFU);
  answer.push_back(static_cast<std::uint8_t>(2 * count));
  for (unsigned i = 0; i < count; ++i) {
    answer.push_back(static_cast<std::uint8_t>((addr + i) >> 8));
    answer.push_back(static_cast<std::uint8_t>((addr + i) & 0xFFU));
  }
  return answer;
}

LinkSettings tcp_settings(int port, double deadline_s) {
  LinkSettings settings;
  settings.address = TcpAddress{"127.0.0.1", port};
  settings.exchange_deadline_s = deadline_s;
  settings.backoff_first_s = 0.0;
  settings.backoff_max_s = 0.0;
  return settings;
}

ProgramResult run_program(const std::string& command) {
  ProgramResult result{-1, {}};
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> chunk{};
  while (const std::size_t got = fread(chunk.data(), 1, chunk.size(), pipe)) result.output.append(chunk.data(), got);
  const int status = pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

std::string csv_header() {
  return "name,unit,fc,addr,type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,write_policy,"
         "fc_write,default,readback\n";
}

double seconds_since(std::int64_t start_ns) { return static_cast<double>(monotonic_ns() - start_ns) * 1e-9; }

}  // namespace airside::hal::testing_peers
