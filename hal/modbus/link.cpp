#include "hal/modbus/link.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <ctime>
#include <new>

#include "hal/modbus/baud_rates.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"

namespace airside::hal {
namespace {

constexpr int busy_retries = 3;
constexpr std::uint8_t exception_failure = 4, exception_acknowledge = 5, exception_busy = 6;

LinkResult<void> failed(LinkError error, std::uint8_t exception = 0) {
  return tl::unexpected(LinkFault{error, exception});
}

/// The numeric form of a host, so that connecting later never asks a name server.
std::string numeric_host(const TcpAddress& address, bool& is_ipv4) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(address.host.c_str(), nullptr, &hints, &found);
  if (error != 0) {
    throw InputError(address.place, "\"" + address.host + "\" (" + gai_strerror(error) + ")",
                     "an address or a name that this machine can look up",
                     "give the numeric address, such as 192.168.1.20, or add the name to /etc/hosts");
  }
  const addrinfo* chosen = found;
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    if (entry->ai_family == AF_INET) {
      chosen = entry;
      break;
    }
  }
  std::array<char, NI_MAXHOST> text{};
  getnameinfo(chosen->ai_addr, chosen->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST);
  is_ipv4 = chosen->ai_family == AF_INET;
  freeaddrinfo(found);
  return text.data();
}

modbus_t* new_context(const LinkSettings& settings) {
  if (const auto* tcp = std::get_if<TcpAddress>(&settings.address)) {
    bool is_ipv4 = true;
    const std::string host = numeric_host(*tcp, is_ipv4);
    return is_ipv4 ? modbus_new_tcp(host.c_str(), tcp->port)
                   : modbus_new_tcp_pi(host.c_str(), std::to_string(tcp->port).c_str());
  }
  const auto& serial = std::get<SerialAddress>(settings.address);
  return modbus_new_rtu(serial.device.c_str(), serial.baud, serial.parity, serial.data_bits, serial.stop_bits);
}

void check(bool ok, const char* field, const std::string& found, const std::string& expected) {
  if (!ok) throw InputError(std::string("modbus ") + field, found, expected, "correct it in the site file");
}

std::string check_settings(const LinkSettings& s) {
  check(s.exchange_deadline_s > 0 && s.exchange_deadline_s <= 10, "exchange deadline",
        fmt::format("{} s", s.exchange_deadline_s), "more than 0 and at most 10 s");
  check(s.backoff_first_s >= 0 && s.backoff_max_s >= s.backoff_first_s && s.backoff_max_s <= 3600, "back-off",
        fmt::format("{} to {} s", s.backoff_first_s, s.backoff_max_s), "0 <= first <= max <= 3600 s");
  if (const auto* tcp = std::get_if<TcpAddress>(&s.address)) {
    check(tcp->port > 0 && tcp->port < 65536, "port", std::to_string(tcp->port), "1 to 65535");
    check(s.unit >= 0 && s.unit <= 255, "unit", std::to_string(s.unit), "0 to 255 on TCP");
    return fmt::format("{}:{} unit {}", tcp->host, tcp->port, s.unit);
  }
  const auto& serial = std::get<SerialAddress>(s.address);
  check(s.unit >= 1 && s.unit <= 247, "unit", std::to_string(s.unit), "1 to 247 on a serial line");
  check(!serial.device.empty(), "device", "an empty name", "a serial device as /dev/ttyUSB0");
  check(std::ranges::find(baud_rates, serial.baud) != baud_rates.end(), "baud", std::to_string(serial.baud),
        fmt::format("one of {}", fmt::join(baud_rates, ", ")));
  check(serial.parity == 'N' || serial.parity == 'E' || serial.parity == 'O', "parity", std::string(1, serial.parity),
        "N, E or O");
  check(serial.data_bits == 8, "data bits", std::to_string(serial.data_bits), "8, as RTU needs");
  check(serial.stop_bits == 1 || serial.stop_bits == 2, "stop bits", std::to_string(serial.stop_bits), "1 or 2");
  return fmt::format("{} {} {}{}{} unit {}", serial.device, serial.baud, serial.data_bits, serial.parity,
                     serial.stop_bits, s.unit);
}

}  // namespace

ModbusLink::ModbusLink(LinkSettings settings)
    : settings_(std::move(settings)),
      description_(check_settings(settings_)),
      context_(new_context(settings_), &modbus_free) {
  // libmodbus refuses nothing that check_settings() lets pass, short of memory.
  if (context_ == nullptr) throw std::bad_alloc();  // uncovered: a 64-bit Linux overcommits
  modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
  modbus_set_slave(context_.get(), settings_.unit);
  if (const auto* serial = std::get_if<SerialAddress>(&settings_.address)) {
    // 3.5 characters of 11 bits; a fixed 1.75 ms above 19200 baud (serial line specification, 2.5.1.1).
    silence_ns_ = serial->baud > 19200 ? 1'750'000 : to_ns(3.5 * 11.0 / serial->baud);
  }
}

ModbusLink::~ModbusLink() { close(); }

void ModbusLink::close() {
  if (fd_ >= 0) modbus_close(context_.get());
  fd_ = -1;
  proven_ = false;
  late_answer_ = false;
}

double ModbusLink::backoff_left_s() const {
  return std::max(0.0, static_cast<double>(not_before_ns_ - monotonic_ns()) * 1e-9);
}

void ModbusLink::start_backoff() {
  backoff_s_ = next_backoff_s();
  not_before_ns_ = monotonic_ns() + to_ns(backoff_s_);
}

LinkResult<void> ModbusLink::read(int function, int addr, std::span<std::uint16_t> out) {
  const bool bits = function == 1 || function == 2;
  const std::size_t limit = bits ? MODBUS_MAX_READ_BITS : MODBUS_MAX_READ_REGISTERS;
  if (function < 1 || function > 4 || addr < 0 || out.empty() || out.size() > limit ||
      static_cast<std::size_t>(addr) + out.size() > 65536) {
    return failed(LinkError::bad_request);
  }
  std::array<std::uint8_t, 5> pdu = {static_cast<std::uint8_t>(function)};
  put16(&pdu[1], static_cast<unsigned>(addr));
  put16(&pdu[3], static_cast<unsigned>(out.size()));
  const std::size_t content = bits ? (out.size() + 7) / 8 : 2 * out.size();
  const LinkResult<void> done = transact(pdu, 2 + content);
  if (!done) return done;
  const std::uint8_t* content_at = answer_pdu_.data() + 2;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const unsigned value = bits ? unsigned{content_at[i / 8]} >> (i % 8) & 1U : get16(content_at + 2 * i);
    out[i] = static_cast<std::uint16_t>(value);
  }
  return {};
}

LinkResult<void> ModbusLink::write(int function, int addr, std::span<const std::uint16_t> values,
                                   std::optional<std::uint64_t> only_on) {
  const bool single = function == 5 || function == 6;
  if ((!single && function != 16) || addr < 0 || values.empty() || values.size() > (single ? 1U : 123U) ||
      static_cast<std::size_t>(addr) + values.size() > 65536 || (function == 5 && values[0] > 1)) {
    return failed(LinkError::bad_request);
  }
  std::array<std::uint8_t, max_pdu_bytes> pdu = {static_cast<std::uint8_t>(function)};
  put16(&pdu[1], static_cast<unsigned>(addr));
  if (single) {
    put16(&pdu[3], function == 5 && values[0] != 0 ? 0xFF00U : values[0]);
    return transact({pdu.data(), 5}, 5, only_on);
  }
  put16(&pdu[3], static_cast<unsigned>(values.size()));
  pdu[5] = static_cast<std::uint8_t>(2 * values.size());
  for (std::size_t i = 0; i < values.size(); ++i) put16(&pdu[6 + 2 * i], values[i]);
  return transact({pdu.data(), 6 + 2 * values.size()}, 5, only_on);
}

LinkResult<void> ModbusLink::transact(std::span<const std::uint8_t> pdu, std::size_t answer_bytes, OnlyOn only_on) {
  const std::int64_t deadline_ns = monotonic_ns() + to_ns(settings_.exchange_deadline_s);
  ++counters_.exchanges;
  LinkResult<void> result = failed(LinkError::timed_out);
  bool repeated = false;
  for (int retries_left = busy_retries;; --retries_left) {
    const bool reused = proven_;
    result = attempt(pdu, answer_bytes, deadline_ns, only_on);
    if (result) break;
    // A device may drop idle connections or restart between two polls, and a serial line catches noise. A request can
    // be repeated, and is, once; but nothing is written on a new connection before its device was read again.
    const LinkError error = result.error().error;
    const bool reads = pdu[0] <= 4;
    const bool dropped = error == LinkError::closed_by_peer && reused && reads;
    const bool noise = error == LinkError::bad_frame && !is_tcp();
    if ((dropped || noise) && !repeated) {
      if (dropped) close();
      late_answer_ = noise;
      repeated = true;
      continue;
    }
    const std::uint8_t code = result.error().exception;
    if ((code != exception_acknowledge && code != exception_busy) || retries_left == 0) break;
    const std::int64_t pause_ns = to_ns(settings_.exchange_deadline_s / 8);
    if (monotonic_ns() + pause_ns >= deadline_ns) break;
    const timespec pause = {static_cast<std::time_t>(pause_ns / 1'000'000'000),
                            static_cast<long>(pause_ns % 1'000'000'000)};
    nanosleep(&pause, nullptr);
  }
  account(result);
  return result;
}

void ModbusLink::account(const LinkResult<void>& result) {
  if (result) {
    backoff_s_ = 0;
    return;
  }
  const LinkFault fault = result.error();
  if (fault.error == LinkError::backing_off || fault.error == LinkError::other_connection) return;
  switch (fault.error) {
    case LinkError::timed_out: ++counters_.timeouts; break;
    case LinkError::bad_frame: ++counters_.bad_frames; break;
    case LinkError::wrong_transaction:
    case LinkError::wrong_unit: ++counters_.wrong_ids; break;
    case LinkError::exception_answer: ++counters_.exceptions; break;
    default: break;  // no connection, or one that ended: connects counts them
  }
  if (fault.error != LinkError::exception_answer) {
    // A serial line has nothing to reconnect to: after noise it needs silence, not a wait of seconds.
    if (is_tcp() || fault.error == LinkError::connect_failed || fault.error == LinkError::closed_by_peer) close();
    late_answer_ = fd_ >= 0;
    if (fd_ < 0 || fault.error == LinkError::timed_out) start_backoff();
    return;
  }
  // 1, 2, 3: the request is at fault and the next one may fit. 5, 6: asked again soon enough.
  // 4: the device is broken; 10, 11 and unknown codes: a gateway lost it. Both need time.
  if (fault.exception <= 3 || fault.exception == exception_acknowledge || fault.exception == exception_busy) {
    backoff_s_ = 0;
    return;
  }
  if (fault.exception == exception_failure) close();
  start_backoff();
}

LinkResult<void> ModbusLink::attempt(std::span<const std::uint8_t> pdu, std::size_t answer_bytes,
                                     std::int64_t deadline_ns, OnlyOn only_on) {
  const LinkResult<void> ready = ensure_connected(deadline_ns, only_on);
  if (!ready) return ready;
  const LinkResult<void> exchanged =
      is_tcp() ? exchange_tcp(pdu, deadline_ns) : exchange_rtu(pdu, answer_bytes, deadline_ns);
  if (!exchanged) return exchanged;
  const LinkResult<void> checked = check_answer(answer_pdu_, pdu, answer_bytes);
  if (checked || checked.error().error == LinkError::exception_answer) proven_ = true;
  return checked;
}

LinkResult<void> ModbusLink::ensure_connected(std::int64_t deadline_ns, OnlyOn only_on) {
  if (fd_ >= 0 && is_tcp()) {
    const IdleState idle = idle_state(fd_);
    if (idle == IdleState::bytes_waiting) ++counters_.wrong_ids;
    if (idle != IdleState::silent) close();
  }
  if (backoff_left_s() > 0) return failed(LinkError::backing_off);
  if (only_on && (fd_ < 0 || *only_on != generation())) return failed(LinkError::other_connection);
  if (fd_ >= 0) return {};
  const std::int64_t left_us = (deadline_ns - monotonic_ns()) / 1000;
  if (left_us <= 0) return failed(LinkError::timed_out);
  modbus_set_response_timeout(context_.get(), static_cast<std::uint32_t>(left_us / 1'000'000),
                              static_cast<std::uint32_t>(std::max<std::int64_t>(1, left_us % 1'000'000)));
  if (modbus_connect(context_.get()) != 0) {
    modbus_close(context_.get());
    return failed(LinkError::connect_failed);
  }
  fd_ = modbus_get_socket(context_.get());
  ++counters_.connects;
  return {};
}

LinkResult<void> ModbusLink::exchange_tcp(std::span<const std::uint8_t> pdu, std::int64_t deadline_ns) {
  const std::span<const std::uint8_t> request(request_.data(),
                                              frame_tcp(pdu, ++transaction_, settings_.unit, request_.data()));
  const WireResult sent = send_all(fd_, request, deadline_ns);
  if (sent != WireResult::done) return tl::unexpected(link_fault(sent));
  const auto answer = receive_tcp(request, answer_, [&](std::span<std::uint8_t> bytes, std::size_t& received) {
    return receive_exact(fd_, bytes, deadline_ns, received);
  });
  if (!answer) return tl::unexpected(answer.error());
  answer_pdu_ = *answer;
  return {};
}

void ModbusLink::quiet_line(std::int64_t deadline_ns) {
  // After a lost answer, listen for as long as a slow device may still take, within a quarter of the deadline.
  const std::int64_t listen =
      late_answer_ ? std::max(silence_ns_, to_ns(settings_.exchange_deadline_s / 4)) : silence_ns_;
  drain_until_silent(fd_, listen, deadline_ns);
  late_answer_ = false;
}

LinkResult<void> ModbusLink::exchange_rtu(std::span<const std::uint8_t> pdu, std::size_t answer_bytes,
                                          std::int64_t deadline_ns) {
  const std::span<const std::uint8_t> request(request_.data(), frame_rtu(pdu, settings_.unit, request_.data()));
  quiet_line(deadline_ns);
  const WireResult sent = send_all(fd_, request, deadline_ns);
  if (sent != WireResult::done) return tl::unexpected(link_fault(sent));
  const auto answer =
      receive_rtu(request, answer_bytes, answer_, [&](std::span<std::uint8_t> bytes, std::size_t& received) {
        return receive_exact(fd_, bytes, deadline_ns, received);
      });
  if (!answer) return tl::unexpected(answer.error());
  answer_pdu_ = *answer;
  return {};
}

}  // namespace airside::hal
