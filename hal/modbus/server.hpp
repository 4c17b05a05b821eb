#pragma once
// Serves a point map's registers to any Modbus client: the desk's stand-in for an AHU. libmodbus frames and
// answers; which register exists, and who may write what, is checked here.

#include <modbus/modbus.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "hal/modbus/link.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// Port 0: the system chooses, see ModbusServer::port().
struct TcpListen {
  std::string address = "127.0.0.1";
  int port = 0;
};

/// A pseudo-terminal; the client opens ModbusServer::device(), or the symlink if one is named.
struct PtyListen {
  std::string symlink;
};

struct ServerSettings {
  std::variant<TcpListen, PtyListen, SerialAddress> listen;
  int unit = 1;  ///< on a serial line; over TCP every unit number is answered
};

class ModbusServer {
 public:
  /// A client wrote `value` to a writable point. Returns the value that the device takes, which is what a client
  /// reads back; NaN refuses the write with exception 3.
  using OnWrite = std::function<double(const Point&, double value)>;
  /// Called before each request is answered, to bring the registers up to date.
  using Refresh = std::function<void()>;

  /// Listens at once. Every point starts invalid, writable ones at their default, `map_fingerprint` at the map's.
  /// Errors: InputError where the address, device or symlink cannot be had.
  ModbusServer(PointMap map, ServerSettings settings);
  ~ModbusServer();
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  /// Without one, writable points take what is written, clamped to min and max.
  void on_write(OnWrite callback) { on_write_ = std::move(callback); }
  void refresh(Refresh callback) { refresh_ = std::move(callback); }

  /// Publishes a value; one that the point cannot hold, or NaN, is published as "no value".
  /// Errors: InputError for a name that the map lacks.
  void set(std::string_view name, double value);
  /// What a client would decode; NaN where it would refuse.
  double get(std::string_view name) const;

  /// Waits up to timeout_s and answers what came. Returns the number of requests answered.
  int serve_once(double timeout_s);
  /// serve_once() until the flag is raised.
  void run(const StopFlag& stop);

  const PointMap& map() const { return map_; }
  int port() const { return port_; }                     ///< 0 on serial lines
  const std::string& device() const { return device_; }  ///< path of the pseudo-terminal or device
  std::uint64_t requests() const { return requests_; }

 private:
  struct Request {
    int function, addr, count;
    const std::uint8_t* content;
  };
  struct Touched {
    const Point* point;
    double value;
  };

  void listen_tcp(const TcpListen& where);
  void listen_pty(const PtyListen& where);
  void open_serial(const SerialAddress& where);
  void accept_client();
  bool answer(int fd);
  int check(const Request& request) const;
  int take_writes(const Request& request);
  std::uint16_t* cell(int table, int addr);
  void store(const Point& point, const std::uint16_t* words);

  static constexpr int tables = 4;
  PointMap map_;
  ServerSettings settings_;
  std::unique_ptr<modbus_t, void (*)(modbus_t*)> context_;
  std::unique_ptr<modbus_mapping_t, void (*)(modbus_mapping_t*)> image_;
  std::array<std::vector<std::int16_t>, tables> owner_;  ///< by address: index of the point, -1 unmapped
  std::vector<Touched> touched_;
  int listener_ = -1;
  int line_ = -1;         ///< serial line or pty master
  int line_keeper_ = -1;  ///< pty slave, held open so that a leaving client does not hang up the line
  std::vector<int> clients_;
  int port_ = 0;
  std::string device_, symlink_;
  OnWrite on_write_;
  Refresh refresh_;
  std::uint64_t requests_ = 0;
};

}  // namespace airside::hal
