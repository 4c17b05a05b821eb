#pragma once
// The only lines that touch the bus: one guarded Modbus client, TCP or serial. libmodbus opens and configures
// the connection; requests and answers are framed here, because its raw requests carry no transaction number
// and its receiver has no total deadline. Whatever the peer does, an exchange is over at its deadline.

#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "hal/modbus/frame.hpp"

namespace airside::hal {

/// Host name or address; names are looked up once, at construction, where waiting hurts nobody.
struct TcpAddress {
  std::string host = "127.0.0.1";
  int port = 502;
  std::string place = "modbus host";  ///< who named it, for messages
};

/// Serial line of Modbus RTU.
struct SerialAddress {
  std::string device;
  int baud = 19200;
  char parity = 'E';  ///< N, E or O
  int data_bits = 8;
  int stop_bits = 1;
};

struct LinkSettings {
  std::variant<TcpAddress, SerialAddress> address;
  int unit = 1;                      ///< 0..255 on TCP, 1..247 on a serial line
  double exchange_deadline_s = 2.0;  ///< connecting, sending, waiting and retries together; (0, 10]
  double backoff_first_s = 1.0;      ///< wait after a failed exchange, doubled by each further one
  /// Up to this: a wait and the exchange after it are over within 30 s.
  double backoff_max_s = 20.0;
};

/// Since construction; wrong_ids counts transactions, units and late answers found on an idle line.
struct LinkCounters {
  std::uint64_t exchanges = 0, connects = 0, timeouts = 0, bad_frames = 0, wrong_ids = 0, exceptions = 0;
};

class ModbusLink {
 public:
  /// Opens nothing yet. Errors: InputError for settings out of range or a host name nobody knows.
  explicit ModbusLink(LinkSettings settings);
  ~ModbusLink();
  ModbusLink(const ModbusLink&) = delete;
  ModbusLink& operator=(const ModbusLink&) = delete;

  /// Reads out.size() registers (function 3, 4) or bits (1, 2, as 0/1), at most 125 or 2000.
  /// Errors: LinkFault. Cost: at most exchange_deadline_s; no heap once connected.
  LinkResult<void> read(int function, int addr, std::span<std::uint16_t> out);
  /// Writes one coil (5, 0/1), one register (6) or up to 123 registers (16); with `only_on`, on the connection of that
  /// generation() and no other, which may lead to another device.
  /// Errors: LinkFault. Cost: at most exchange_deadline_s; no heap once connected.
  LinkResult<void> write(int function, int addr, std::span<const std::uint16_t> values,
                         std::optional<std::uint64_t> only_on = std::nullopt);

  bool connected() const { return fd_ >= 0; }
  /// Rises with each new connection, so that a caller knows when to verify and re-read.
  std::uint64_t generation() const { return counters_.connects; }
  /// Seconds until the next attempt is due; 0 where one may be made now.
  double backoff_left_s() const;
  /// Seconds until another attempt could be made if one was made now and failed: its deadline and the wait after it.
  double failure_costs_s() const { return settings_.exchange_deadline_s + next_backoff_s(); }
  const LinkCounters& counters() const { return counters_; }
  const LinkSettings& settings() const { return settings_; }
  /// `127.0.0.1:502 unit 1`, for messages.
  const std::string& description() const { return description_; }
  void close();

 private:
  bool is_tcp() const { return std::holds_alternative<TcpAddress>(settings_.address); }
  using OnlyOn = std::optional<std::uint64_t>;
  LinkResult<void> transact(std::span<const std::uint8_t> pdu, std::size_t answer_bytes, OnlyOn only_on = {});
  LinkResult<void> attempt(std::span<const std::uint8_t> pdu, std::size_t answer_bytes, std::int64_t deadline_ns,
                           OnlyOn only_on);
  LinkResult<void> ensure_connected(std::int64_t deadline_ns, OnlyOn only_on);
  LinkResult<void> exchange_tcp(std::span<const std::uint8_t> pdu, std::int64_t deadline_ns);
  LinkResult<void> exchange_rtu(std::span<const std::uint8_t> pdu, std::size_t answer_bytes, std::int64_t deadline_ns);
  void quiet_line(std::int64_t deadline_ns);
  void account(const LinkResult<void>& result);
  double next_backoff_s() const {
    return backoff_s_ == 0 ? settings_.backoff_first_s : std::min(2 * backoff_s_, settings_.backoff_max_s);
  }
  void start_backoff();

  LinkSettings settings_;
  std::string description_;
  std::unique_ptr<modbus_t, void (*)(modbus_t*)> context_;
  int fd_ = -1;
  bool proven_ = false;       ///< this connection has given a valid answer
  bool late_answer_ = false;  ///< serial: an answer to an earlier request may still come
  std::uint16_t transaction_ = 0;
  std::int64_t silence_ns_ = 0;  ///< serial: 3.5 characters
  std::int64_t not_before_ns_ = 0;
  double backoff_s_ = 0;
  std::array<std::uint8_t, max_frame_bytes> request_{};
  std::array<std::uint8_t, max_frame_bytes> answer_{};
  std::span<const std::uint8_t> answer_pdu_;
  LinkCounters counters_;
};

}  // namespace airside::hal
