#include "tools/chaos/chaos_proxy.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "airside/splitmix64.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"
#include "tools/chaos/chaos_frame.hpp"

namespace airside::tools {
namespace {

using Bytes = std::vector<std::uint8_t>;
using hal::get16;
using hal::monotonic_ns;
using hal::put16;
using hal::to_ns;
using hal::WireResult;

constexpr std::size_t mbap_bytes = 7;
constexpr std::size_t most_adu_bytes = 260;
constexpr std::int64_t slice_ns = 20'000'000;  ///< how long a stop may take to be heard
constexpr double server_patience_s = 30;

sockaddr_in address_of(const std::string& numeric, int port) {
  sockaddr_in a{};
  a.sin_family = AF_INET;
  a.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, numeric.c_str(), &a.sin_addr);
  return a;
}
sockaddr generic_of(const sockaddr_in& a) {
  sockaddr generic{};
  std::memcpy(&generic, &a, sizeof a);
  return generic;
}

std::string look_up(const std::string& host, const char* field) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), nullptr, &hints, &found);
  if (error != 0 || found == nullptr) {
    throw hal::InputError(field, "\"" + host + "\" (" + gai_strerror(error) + ")",
                          "an IPv4 address or a name that this machine can look up", "correct the host");
  }
  std::array<char, NI_MAXHOST> text{};
  getnameinfo(found->ai_addr, found->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST);
  freeaddrinfo(found);
  return text.data();
}

/// RST instead of FIN when it is closed.
void abort_on_close(int fd) {
  const linger hard = {1, 0};
  setsockopt(fd, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
}

/// One frame. False: the peer has gone, was silent until `patience_s`, sent what is no Modbus, or it is time to stop.
bool receive_frame(int fd, Bytes& frame, const std::atomic<bool>& stop, double patience_s) {
  const std::int64_t end_ns = monotonic_ns() + to_ns(patience_s);
  frame.clear();
  std::size_t wanted = mbap_bytes;
  while (!stop && monotonic_ns() < end_ns) {
    std::array<std::uint8_t, most_adu_bytes> chunk{};
    std::size_t got = 0;
    const WireResult r =
        hal::receive_exact(fd, {chunk.data(), wanted - frame.size()}, std::min(end_ns, monotonic_ns() + slice_ns), got);
    frame.insert(frame.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(got));
    if (r == WireResult::closed) return false;
    if (frame.size() < wanted) continue;
    if (wanted > mbap_bytes) return true;
    const std::size_t length = get16(&frame[4]);
    if (length < 3 || mbap_bytes - 1 + length > most_adu_bytes) return false;
    wanted = mbap_bytes - 1 + length;
  }
  return false;
}

}  // namespace

struct ChaosProxy::Connection {
  std::uint64_t number = 0;
  int client = -1, server = -1;
  std::int64_t began_ns = 0;
  std::atomic<bool> done{false};
  std::thread thread;
};

std::string describe(const ChaosExchange& e) {
  const ChaosRequest& r = e.request;
  return fmt::format("{:.3f} s, exchange {}: {}, {} fc {} addr {} count {}", r.t_s, r.number, text_of(e.fault.kind),
                     r.writes() ? "write" : "read", r.function, r.addr, r.count);
}

ChaosProxy::ChaosProxy(ChaosSettings settings, OnExchange on_exchange)
    : settings_(std::move(settings)),
      on_exchange_(std::move(on_exchange)),
      to_numeric_(look_up(settings_.to_host, "chaos: the server's host")),
      port_(settings_.port),
      began_ns_(monotonic_ns()) {
  settings_.listen = look_up(settings_.listen, "chaos: the address to listen at");
  if (!open_listener()) {
    throw hal::InputError(fmt::format("{}:{}", settings_.listen, settings_.port),
                          std::string("an address that cannot be listened at (") + std::strerror(errno) + ")",
                          "a free port of this machine", "choose another --listen port");
  }
  acceptor_ = std::thread([this] { accept_all(); });
}

ChaosProxy::~ChaosProxy() {
  stop_ = true;
  acceptor_.join();
  for (Connection& c : connections_) c.thread.join();
  if (listener_ >= 0) ::close(listener_);
}

ChaosCounters ChaosProxy::counters() const {
  const std::scoped_lock lock(mutex_);
  return counters_;
}

void ChaosProxy::use(std::vector<ChaosRule> rules) {
  const std::scoped_lock lock(mutex_);
  settings_.rules = std::move(rules);
}

ChaosExchange ChaosProxy::last_answered() const {
  const std::scoped_lock lock(mutex_);
  return newest_;
}

double ChaosProxy::now_s() const { return static_cast<double>(monotonic_ns() - began_ns_) * 1e-9; }

bool ChaosProxy::open_listener() {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const int yes = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr generic = generic_of(address_of(settings_.listen, port_));
  socklen_t length = sizeof generic;
  if (::bind(fd, &generic, length) != 0 || ::listen(fd, 64) != 0 || getsockname(fd, &generic, &length) != 0) {
    ::close(fd);
    return false;
  }
  sockaddr_in bound{};
  std::memcpy(&bound, &generic, sizeof bound);
  port_ = ntohs(bound.sin_port);
  listener_ = fd;
  return true;
}

void ChaosProxy::accept_all() {
  while (!stop_) {
    for (auto c = connections_.begin(); c != connections_.end();) {
      if (!c->done) {
        ++c;
        continue;
      }
      c->thread.join();
      c = connections_.erase(c);
    }
    if (monotonic_ns() < refuse_until_ns_) {
      if (listener_ >= 0) ::close(listener_);
      listener_ = -1;
      hal::sleep_until_ns(std::min(refuse_until_ns_.load(), monotonic_ns() + slice_ns), {});
      continue;
    }
    if (listener_ < 0 && !open_listener()) {
      hal::sleep_until_ns(monotonic_ns() + slice_ns, {});
      continue;
    }
    pollfd entry = {listener_, POLLIN, 0};
    if (::poll(&entry, 1, static_cast<int>(slice_ns / 1'000'000)) <= 0) continue;
    const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (fd < 0) continue;
    const int yes = 1;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    Connection& c = connections_.emplace_back();
    c.client = fd;
    c.began_ns = monotonic_ns();
    {
      const std::scoped_lock lock(mutex_);
      c.number = ++counters_.connections;
    }
    c.thread = std::thread([this, &c] { serve(c); });
  }
}

void ChaosProxy::serve(Connection& c) {
  while (!stop_ && exchange(c)) {
  }
  ::close(c.client);
  if (c.server >= 0) ::close(c.server);
  c.done = true;
}

void ChaosProxy::note(const ChaosExchange& e) {
  const std::scoped_lock lock(mutex_);
  if (e.fault.kind != ChaosKind::none) {
    ++counters_.faults;
    ++counters_.by_fault[text_of(e.fault.kind)];
  }
  if (e.request.writes() && e.taken()) ++counters_.writes_forwarded;
  if (!e.answered.empty() && e.request.number > newest_.request.number) newest_ = e;
  if (on_exchange_) on_exchange_(e);
}

/// One request from arrival to answer. False: the connection is over.
bool ChaosProxy::exchange(Connection& c) {
  ChaosExchange e;
  e.connection = c.number;
  if (!receive_frame(c.client, e.asked, stop_, 1e6)) return false;
  if (c.began_ns < refuse_until_ns_) {  // the server that took this connection is gone
    abort_on_close(c.client);
    return false;
  }
  e.request = parsed(e.asked);
  {
    const std::scoped_lock lock(mutex_);
    e.request.number = ++counters_.exchanges;
    e.request.t_s = now_s();
    e.fault = choose_fault(settings_.rules, settings_.seed, e.request);
  }
  if (!touches(e.fault, e.request)) e.fault = {};
  const ChaosKind kind = e.fault.kind;
  const bool reaches = kind != ChaosKind::drop && kind != ChaosKind::exception && kind != ChaosKind::swallow &&
                       kind != ChaosKind::half_open && kind != ChaosKind::refuse;
  if (reaches && !forward(c, e)) {
    note(e);
    return false;  // the true server is gone
  }
  note(e);
  return act(c, e);
}

bool ChaosProxy::forward(Connection& c, ChaosExchange& e) {
  if (c.server < 0) {
    c.server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr generic = generic_of(address_of(to_numeric_, settings_.to_port));
    if (c.server < 0 || ::connect(c.server, &generic, sizeof generic) != 0) return false;
    const int yes = 1;
    setsockopt(c.server, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  }
  e.forwarded = e.asked;
  const std::array<double, 2>& p = e.fault.param;
  if (e.fault.kind == ChaosKind::clamp) {
    change_written(e.forwarded, [&](double raw) { return std::clamp(raw, p[0], p[1]); });
  }
  if (e.fault.kind == ChaosKind::alter) {
    change_written(e.forwarded, [&](double raw) { return raw + p[0]; });
  }
  if (hal::send_all(c.server, e.forwarded, monotonic_ns() + to_ns(server_patience_s)) != WireResult::done) return false;
  return receive_frame(c.server, e.answered, stop_, server_patience_s);
}

/// Answers the client as the fault has it. False: the connection is over.
bool ChaosProxy::act(Connection& c, const ChaosExchange& e) {
  const std::array<double, 2>& p = e.fault.param;
  const auto whole = [&](std::size_t i) { return static_cast<unsigned>(p[i]); };
  Bytes answer = e.answered;
  const auto first_bytes = [&](unsigned n) {
    const std::size_t least = n < answer.size() ? n : 1 + (n - 1) % (answer.size() - 1);
    return Bytes(answer.begin(), answer.begin() + static_cast<std::ptrdiff_t>(least));
  };
  switch (e.fault.kind) {
    case ChaosKind::none: break;
    case ChaosKind::late:
      if (!pause(c, p[0])) return false;
      break;
    case ChaosKind::duplicate:
      for (unsigned i = 1; i < whole(0); ++i) answer.insert(answer.end(), e.answered.begin(), e.answered.end());
      break;
    case ChaosKind::unit: answer[6] = static_cast<std::uint8_t>(answer[6] + whole(0)); break;
    case ChaosKind::transaction: put16(answer.data(), (get16(answer.data()) + whole(0)) & 0xFFFFU); break;
    case ChaosKind::protocol: put16(&answer[2], whole(0)); break;
    case ChaosKind::function: answer[7] = static_cast<std::uint8_t>((answer[7] + whole(0)) & 0x7FU); break;
    case ChaosKind::trickle: return trickle(c, answer, p[0]);
    case ChaosKind::endless: {
      put16(&answer[4], 254);
      answer.resize(100'000, 0x55);
      return trickle(c, answer, p[0]);
    }
    case ChaosKind::truncate: return send_to(c, first_bytes(whole(0)));
    case ChaosKind::length: {
      const unsigned says = whole(0) == get16(&answer[4]) ? whole(0) ^ 1U : whole(0);
      put16(&answer[4], says);
      break;
    }
    case ChaosKind::trailing: answer.resize(answer.size() + whole(0), 0x2A); break;
    case ChaosKind::reset:
    case ChaosKind::fin:
      if (whole(0) > 0) (void)send_to(c, first_bytes(whole(0)));
      if (e.fault.kind == ChaosKind::reset) {
        if (whole(0) > 0) (void)pause(c, 0.005);  // RST overtakes what is still in the buffer
        abort_on_close(c.client);
      }
      return false;
    case ChaosKind::half_open: swallow_until_gone(c); return false;
    case ChaosKind::drop:
    case ChaosKind::mute: return true;
    case ChaosKind::exception: answer = exception_to(e.asked, static_cast<int>(p[0])); break;
    case ChaosKind::clamp:
    case ChaosKind::alter:
      if (e.taken()) answer = confirmation_of(e.asked);
      break;
    case ChaosKind::swallow: answer = confirmation_of(e.asked); break;
    case ChaosKind::flood: return flood(c, e.request.number, p[0]);
    case ChaosKind::noise: {
      SplitMix64 random(settings_.seed ^ e.request.number);
      answer.resize(whole(0));
      for (std::uint8_t& b : answer) b = static_cast<std::uint8_t>(random.next() >> 56);
      break;
    }
    case ChaosKind::refuse:
      refuse_until_ns_ = monotonic_ns() + to_ns(p[0]);
      abort_on_close(c.client);
      return false;
    case ChaosKind::swap:
      for (int pair = 0; pair < static_cast<int>(p[1]); ++pair) {
        const int addr = static_cast<int>(p[0]) + 2 * pair;
        const std::size_t a = place_of(e.request, answer, addr), b = place_of(e.request, answer, addr + 1);
        if (a == 0 || b == 0) continue;
        std::swap(answer[a], answer[b]);
        std::swap(answer[a + 1], answer[b + 1]);
      }
      break;
    case ChaosKind::set:
      if (const std::size_t at = place_of(e.request, answer, static_cast<int>(p[0])); at != 0)
        put16(&answer[at], whole(1));
      break;
  }
  return send_to(c, std::move(answer));
}

bool ChaosProxy::send_to(const Connection& c, std::vector<std::uint8_t> bytes) const {
  return hal::send_all(c.client, bytes, monotonic_ns() + to_ns(1.0)) == WireResult::done;
}

bool ChaosProxy::trickle(const Connection& c, const Bytes& bytes, double gap_s) const {
  for (const std::uint8_t byte : bytes) {
    if (!send_to(c, {byte}) || !pause(c, gap_s)) return false;
  }
  return true;
}

bool ChaosProxy::flood(const Connection& c, std::uint64_t number, double seconds) const {
  SplitMix64 random(settings_.seed ^ number);
  std::array<std::uint8_t, 1024> chunk{};
  const std::int64_t end_ns = monotonic_ns() + to_ns(seconds);
  while (!stop_ && monotonic_ns() < end_ns) {
    for (std::uint8_t& b : chunk) b = static_cast<std::uint8_t>(random.next() >> 56);
    if (hal::send_all(c.client, chunk, monotonic_ns() + slice_ns) == WireResult::closed) return false;
  }
  return !stop_;
}

/// False: the client has gone, or it is time to stop.
bool ChaosProxy::pause(const Connection& c, double seconds) const {
  const std::int64_t end_ns = monotonic_ns() + to_ns(seconds);
  while (!stop_) {
    const std::int64_t left = end_ns - monotonic_ns();
    if (left <= 0) return true;
    const std::int64_t slice = std::min(left, slice_ns);
    const timespec wait = {0, static_cast<long>(slice)};
    pollfd entry = {c.client, POLLRDHUP, 0};
    if (::ppoll(&entry, 1, &wait, nullptr) > 0) return false;
  }
  return false;
}

void ChaosProxy::swallow_until_gone(const Connection& c) const {
  std::array<std::uint8_t, 256> dropped{};
  while (!stop_) {
    std::size_t got = 0;
    if (hal::receive_exact(c.client, dropped, monotonic_ns() + slice_ns, got) == WireResult::closed) return;
  }
}

}  // namespace airside::tools
