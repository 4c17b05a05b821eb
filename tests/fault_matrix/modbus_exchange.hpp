#pragma once
// Exchanges of the default map of the five-zone room, as tests speak of them.

#include <string>
#include <vector>

#include "tools/chaos/chaos_proxy.hpp"

namespace airside::fault_matrix {

constexpr int power_1_addr = 20, fingerprint_addr = 30;

inline bool writes_setpoint(const tools::ChaosExchange& e) { return e.request.writes() && e.request.addr == 0; }
inline bool writes_heartbeat(const tools::ChaosExchange& e) { return e.request.writes() && e.request.addr == 1; }
/// The block of all signals.
inline bool reads_inputs(const tools::ChaosExchange& e) { return e.request.function == 4 && e.request.addr == 0; }

/// Every fault of the proxy that does not lie about values, each with probability `p`.
inline std::string every_fault(double p) {
  const std::vector<std::string> faults = {"late:s=0.2",
                                           "duplicate",
                                           "duplicate:times=5",
                                           "unit",
                                           "transaction",
                                           "protocol",
                                           "function",
                                           "trickle:gap=0.01",
                                           "trickle:gap=0.05",
                                           "endless:gap=0.004",
                                           "truncate",
                                           "length",
                                           "trailing:bytes=1",
                                           "trailing:bytes=300",
                                           "reset:bytes=0",
                                           "reset:bytes=9",
                                           "fin",
                                           "halfopen",
                                           "drop",
                                           "mute",
                                           "exception:code=1",
                                           "exception:code=2",
                                           "exception:code=3",
                                           "exception:code=4",
                                           "exception:code=5",
                                           "exception:code=6",
                                           "exception:code=10",
                                           "exception:code=11",
                                           "exception:code=0",
                                           "exception:code=200",
                                           "flood:s=0.3",
                                           "noise",
                                           "noise:bytes=9",
                                           "refuse:s=0.05"};
  std::string script;
  for (const std::string& f : faults) script += "p=" + std::to_string(p) + " " + f + "\n";
  return script;
}

}  // namespace airside::fault_matrix
