#include "firmware/edge/edge.hpp"

#include "airside/topologies.hpp"

namespace airside::edge {

// Every build must read what every other has saved: strict or not, 32 or 64 bits. Where one of these changes on
// purpose, state_version does too.
static_assert(sizeof(LearningState<FiveZone, float>) == 706112 && sizeof(RowRecord<FiveZone>) == 4672);

std::unique_ptr<Daemon> make_daemon(const hal::SiteFile& site, const hal::PointMap& points,
                                    const DaemonOptions& options, hal::StopFlag stop) {
  std::unique_ptr<Daemon> daemon;
  with_topology(site.topology.c_str(),
                [&]<class T>(T) { daemon = std::make_unique<Edge<T>>(site, points, options, stop); });
  return daemon;
}

}  // namespace airside::edge
