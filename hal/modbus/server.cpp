#include "hal/modbus/server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>

#include "hal/modbus/wire.hpp"
#include "hal/points/register_codec.hpp"

namespace airside::hal {
namespace {

constexpr int address_space = 65536;
constexpr std::size_t max_clients = 32;
constexpr int no_exception = 0;

[[noreturn]] void cannot(const std::string& place, const std::string& what) {
  throw InputError(place, what + " (" + std::strerror(errno) + ")", "an address or device that can be served",
                   "choose another, or end the program that holds it");
}

bool is_write(int function) { return function == 5 || function == 6 || function == 15 || function == 16; }

/// Table of a request: 1 coils, 2 discrete inputs, 3 holding, 4 input registers; 0 for other functions.
int table_of(int function) {
  if (function >= 1 && function <= 4) return function;
  if (function == 5 || function == 15) return 1;
  return function == 6 || function == 16 ? 3 : 0;
}

int max_count(int function) {
  switch (function) {
    case 1:
    case 2: return MODBUS_MAX_READ_BITS;
    case 3:
    case 4: return MODBUS_MAX_READ_REGISTERS;
    case 15: return MODBUS_MAX_WRITE_BITS;
    case 16: return MODBUS_MAX_WRITE_REGISTERS;
    default: return 1;
  }
}

}  // namespace

ModbusServer::ModbusServer(PointMap map, ServerSettings settings)
    : map_(std::move(map)),
      settings_(std::move(settings)),
      context_(nullptr, &modbus_free),
      image_(modbus_mapping_new(address_space, address_space, address_space, address_space), &modbus_mapping_free) {
  for (auto& table : owner_) table.assign(address_space, -1);
  for (std::size_t i = 0; i < map_.points().size(); ++i) {
    const Point& p = map_.points()[i];
    auto& table = owner_[static_cast<std::size_t>(p.fc - 1)];
    for (int k = 0; k < p.width(); ++k) table[static_cast<std::size_t>(p.addr + k)] = static_cast<std::int16_t>(i);
    set(p.name, p.name == "map_fingerprint" ? map_.told_fingerprint() : p.default_value);
  }
  touched_.reserve(map_.points().size());
  clients_.reserve(max_clients);
  if (const auto* tcp = std::get_if<TcpListen>(&settings_.listen)) listen_tcp(*tcp);
  if (const auto* pty = std::get_if<PtyListen>(&settings_.listen)) listen_pty(*pty);
  if (const auto* serial = std::get_if<SerialAddress>(&settings_.listen)) open_serial(*serial);
  modbus_set_indication_timeout(context_.get(), 0, 500'000);
  modbus_set_byte_timeout(context_.get(), 0, 100'000);
}

ModbusServer::~ModbusServer() {
  for (const int fd : clients_) ::close(fd);
  if (listener_ >= 0) ::close(listener_);
  if (line_ >= 0) ::close(line_);
  if (line_keeper_ >= 0) ::close(line_keeper_);
  if (!symlink_.empty()) ::unlink(symlink_.c_str());
}

void ModbusServer::listen_tcp(const TcpListen& where) {
  context_.reset(modbus_new_tcp(where.address.c_str(), where.port));
  const std::string place = fmt::format("{}:{}", where.address, where.port);
  if (context_ == nullptr) cannot(place, "no usable address");
  listener_ = modbus_tcp_listen(context_.get(), static_cast<int>(max_clients));
  if (listener_ < 0) cannot(place, "an address that cannot be listened at");
  sockaddr_in bound{};
  socklen_t length = sizeof(bound);
  sockaddr generic{};
  if (getsockname(listener_, &generic, &length) != 0) cannot(place, "a listener without a name");
  std::memcpy(&bound, &generic, sizeof(bound));
  port_ = ntohs(bound.sin_port);
}

void ModbusServer::listen_pty(const PtyListen& where) {
  std::array<char, 128> name{};
  termios raw{};
  cfmakeraw(&raw);
  if (openpty(&line_, &line_keeper_, name.data(), &raw, nullptr) != 0) cannot("pty", "no free pseudo-terminal");
  device_ = name.data();
  if (!where.symlink.empty()) {
    ::unlink(where.symlink.c_str());
    if (::symlink(device_.c_str(), where.symlink.c_str()) != 0) cannot(where.symlink, "a link that cannot be made");
    symlink_ = where.symlink;
  }
  context_.reset(modbus_new_rtu(device_.c_str(), 115200, 'N', 8, 1));
  modbus_set_slave(context_.get(), settings_.unit);
  modbus_set_socket(context_.get(), line_);
}

void ModbusServer::open_serial(const SerialAddress& where) {
  device_ = where.device;
  context_.reset(modbus_new_rtu(device_.c_str(), where.baud, where.parity, where.data_bits, where.stop_bits));
  if (context_ == nullptr || modbus_set_slave(context_.get(), settings_.unit) != 0 ||
      modbus_connect(context_.get()) != 0) {
    cannot(device_, "a serial device that cannot be opened");
  }
  line_ = modbus_get_socket(context_.get());
}

std::uint16_t* ModbusServer::cell(int table, int addr) {
  return (table == 3 ? image_->tab_registers : image_->tab_input_registers) + addr;
}

void ModbusServer::store(const Point& point, const std::uint16_t* words) {
  for (int k = 0; k < point.width(); ++k) {
    const int addr = point.addr + k;
    if (point.fc == 1)
      image_->tab_bits[addr] = static_cast<std::uint8_t>(words[k]);
    else if (point.fc == 2)
      image_->tab_input_bits[addr] = static_cast<std::uint8_t>(words[k]);
    else
      *cell(point.fc, addr) = words[k];
  }
}

void ModbusServer::set(std::string_view name, double value) {
  const Point& point = map_.at(name);
  const Expected<Registers> registers = encode(point, value);
  store(point, (registers ? *registers : invalid_registers(point)).word.data());
}

double ModbusServer::get(std::string_view name) const {
  const Point& p = map_.at(name);
  std::array<std::uint16_t, 2> words{};
  for (int k = 0; k < p.width(); ++k) {
    auto& word = words[static_cast<std::size_t>(k)];
    const int addr = p.addr + k;
    if (p.fc == 1) word = image_->tab_bits[addr];
    if (p.fc == 2) word = image_->tab_input_bits[addr];
    if (p.fc == 3) word = image_->tab_registers[addr];
    if (p.fc == 4) word = image_->tab_input_registers[addr];
  }
  return decode(p, words).value_or(std::numeric_limits<double>::quiet_NaN());
}

void ModbusServer::accept_client() {
  const int fd = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (fd < 0) return;
  if (clients_.size() == max_clients) {
    ::close(clients_.front());  // the oldest is the likeliest to be forgotten
    clients_.erase(clients_.begin());
  }
  const int yes = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
  clients_.push_back(fd);
}

int ModbusServer::serve_once(double timeout_s) {
  std::array<pollfd, max_clients + 1> entries{};
  entries[0] = {listener_ >= 0 ? listener_ : line_, POLLIN, 0};
  for (std::size_t i = 0; i < clients_.size(); ++i) entries[i + 1] = {clients_[i], POLLIN, 0};
  const std::size_t watched = clients_.size() + 1;
  if (poll(entries.data(), watched, static_cast<int>(std::ceil(timeout_s * 1000))) <= 0) return 0;

  const std::uint64_t before = requests_;
  for (std::size_t i = 1; i < watched; ++i) {
    if (entries[i].revents == 0 || answer(entries[i].fd)) continue;
    ::close(entries[i].fd);
    std::erase(clients_, entries[i].fd);
  }
  if ((entries[0].revents & POLLIN) != 0) {
    if (listener_ >= 0)
      accept_client();
    else if (!answer(line_))
      modbus_flush(context_.get());
  }
  return static_cast<int>(requests_ - before);
}

void ModbusServer::run(const StopFlag& stop) {
  while (!stop.raised()) serve_once(0.05);
}

/// False: the connection is of no further use.
bool ModbusServer::answer(int fd) {
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> frame{};
  modbus_set_socket(context_.get(), fd);
  const int length = modbus_receive(context_.get(), frame.data());
  if (length < 0) return false;
  if (length == 0) return true;  // serial: for another unit
  ++requests_;
  if (refresh_) refresh_();
  const std::uint8_t* pdu = frame.data() + modbus_get_header_length(context_.get());
  Request request{pdu[0], static_cast<int>(get16(pdu + 1)), 1, pdu + 3};
  const bool counted = request.function <= 4 || request.function == 15 || request.function == 16;
  if (counted) request.count = static_cast<int>(get16(pdu + 3));
  if (request.function == 15 || request.function == 16) request.content = pdu + 6;

  int exception = check(request);
  if (exception == no_exception && is_write(request.function)) exception = take_writes(request);
  const int sent = exception != no_exception
                       ? modbus_reply_exception(context_.get(), frame.data(), static_cast<unsigned>(exception))
                       : modbus_reply(context_.get(), frame.data(), length, image_.get());
  if (exception == no_exception) {
    for (const Touched& t : touched_) set(t.point->name, t.value);
  }
  touched_.clear();
  return sent >= 0;
}

int ModbusServer::check(const Request& request) const {
  const int table = table_of(request.function);
  if (table == 0) return MODBUS_EXCEPTION_ILLEGAL_FUNCTION;
  if (request.count < 1 || request.count > max_count(request.function)) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
  if (request.addr + request.count > address_space) return MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS;
  const auto& owner = owner_[static_cast<std::size_t>(table - 1)];
  for (int addr = request.addr; addr < request.addr + request.count; ++addr) {
    const int index = owner[static_cast<std::size_t>(addr)];
    if (index < 0) return MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS;
    if (!is_write(request.function)) continue;
    const Point& p = map_.points()[static_cast<std::size_t>(index)];
    if (!p.writable()) return MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS;
    // Half of a 32-bit value would stand there torn.
    if (p.addr < request.addr || p.addr + p.width() > request.addr + request.count) {
      return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    }
  }
  if (request.function == 5 && get16(request.content) != 0 && get16(request.content) != 0xFF00U) {
    return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
  }
  const unsigned bytes = request.function == 15   ? static_cast<unsigned>(request.count + 7) / 8
                         : request.function == 16 ? static_cast<unsigned>(2 * request.count)
                                                  : 0U;
  if (bytes != 0 && request.content[-1] != bytes) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
  return no_exception;
}

/// Asks on_write about every touched point; the registers change only when all were taken.
int ModbusServer::take_writes(const Request& request) {
  touched_.clear();
  const auto& owner = owner_[static_cast<std::size_t>(table_of(request.function) - 1)];
  int addr = request.addr;
  while (addr < request.addr + request.count) {
    const Point& point = map_.points()[static_cast<std::size_t>(owner[static_cast<std::size_t>(addr)])];
    std::array<std::uint16_t, 2> words{};
    for (int k = 0; k < point.width(); ++k) {
      const int at = addr - request.addr + k;
      auto& word = words[static_cast<std::size_t>(k)];
      if (request.function == 5)
        word = get16(request.content) != 0 ? 1 : 0;
      else if (request.function == 15)
        word = (request.content[at / 8] >> (at % 8)) & 1U;
      else
        word = static_cast<std::uint16_t>(get16(request.content + 2 * at));
    }
    Point unlimited = point;
    unlimited.min = -std::numeric_limits<double>::infinity();
    unlimited.max = std::numeric_limits<double>::infinity();
    const Expected<double> wish = decode(unlimited, words);
    if (!wish) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    const double taken = on_write_ ? on_write_(point, *wish) : std::clamp(*wish, point.min, point.max);
    if (std::isnan(taken)) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    touched_.push_back({&point, taken});
    addr += point.width();
  }
  return no_exception;
}

}  // namespace airside::hal
