#include "firmware/edge/edge.hpp"

#include "airside/topologies.hpp"

namespace airside::edge {

std::unique_ptr<Daemon> make_daemon(const hal::SiteFile& site, const hal::PointMap& points, const EdgeOptions& options,
                                    hal::StopFlag stop) {
  std::unique_ptr<Daemon> daemon;
  with_topology(site.topology.c_str(),
                [&]<class T>(T) { daemon = std::make_unique<Edge<T>>(site, points, options, stop); });
  return daemon;
}

}  // namespace airside::edge
