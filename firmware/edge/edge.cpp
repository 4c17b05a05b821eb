#include "firmware/edge/edge.hpp"

#include "airside/topologies.hpp"

namespace airside::edge {

hal::LinkSettings link_settings(const hal::ModbusSection& modbus, const EdgeOptions& options) {
  hal::LinkSettings settings;
  if (modbus.transport == hal::ModbusTransport::tcp) {
    settings.address = hal::TcpAddress{modbus.host, modbus.port};
  } else {
    settings.address = hal::SerialAddress{modbus.device, modbus.baud, modbus.parity};
  }
  settings.unit = modbus.unit_id;
  settings.exchange_deadline_s = modbus.deadline_s;
  settings.backoff_first_s = options.backoff_first_s;
  settings.backoff_max_s = std::max(settings.backoff_max_s, settings.backoff_first_s);
  return settings;
}

std::unique_ptr<Daemon> make_daemon(const hal::SiteFile& site, const hal::PointMap& points, const EdgeOptions& options,
                                    hal::StopFlag stop) {
  std::unique_ptr<Daemon> daemon;
  with_topology(site.topology.c_str(),
                [&]<class T>(T) { daemon = std::make_unique<Edge<T>>(site, points, options, stop); });
  return daemon;
}

}  // namespace airside::edge
