#pragma once
// The messages between EnergyPlusPlant and its worker process: fixed size, one packet each, over a SOCK_SEQPACKET
// pair. Both ends come from one build on one machine, so the bytes are the structs' own.

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace airside::sim {

constexpr int max_zones = 32;                         ///< interior or perimeter zones of a model
constexpr int max_powers = 8;                         ///< meters of a model
constexpr std::uint32_t protocol_magic = 0x41450004;  ///< changes with any struct here
constexpr double not_offered = std::numeric_limits<double>::quiet_NaN();
constexpr int worker_socket = 3;  ///< the worker's end of the pair

enum class RequestKind : std::uint32_t {
  advance = 1,  ///< simulate to until_s, then answer with the state there
  branch = 2,   ///< simulate a forked copy to until_s, answer with its mean room temperature
};

struct WorkerRequest {
  std::uint32_t magic = protocol_magic;
  RequestKind kind = RequestKind::advance;
  std::int64_t until_s = 0;
  double setpoint_degc = 0;
};

enum class ReplyKind : std::uint32_t {
  state = 1,   ///< sensors at time_s
  branch = 2,  ///< branch_mean_degc
  error = 3,   ///< text; the worker ends
};

struct WorkerReply {
  std::uint32_t magic = protocol_magic;
  ReplyKind kind = ReplyKind::state;
  std::int64_t time_s = 0;
  std::int32_t vavs = 0, fcus = 0, powers = 0;
  std::int32_t dampers = 0, zone_setpoints = 0;  ///< 0 or vavs
  std::array<double, max_zones> room_temp_degc{}, true_room_temp_degc{}, fcu_temp_degc{}, vav_on{}, fcu_on{};
  std::array<double, max_zones> damper{}, zone_setpoint_degc{}, heating_setpoint_degc{};
  std::array<double, max_powers> power_kw{};
  double mau_temp_degc = 0, outdoor_temp_degc = 0, rain = 0, supply_temp_degc = 0, setpoint_degc = 0;
  double occupied = not_offered, supply_flow_m3s = not_offered, ahu_on = not_offered;
  double branch_mean_degc = 0;
  std::array<char, 1024> text{};
};

static_assert(std::is_trivially_copyable_v<WorkerRequest> && std::is_trivially_copyable_v<WorkerReply>);

}  // namespace airside::sim
