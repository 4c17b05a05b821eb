#include "tools/run/site.hpp"

#include "airside/topology.hpp"
#include "hal/site/objective.hpp"
#include "hal/site/site_log.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools {

namespace {

hal::TopologyCounts counts_of_name(const std::string& topology) {
  const Shape shape = parse_shape(topology.c_str());
  if (!hal::site_rules().holds(topology)) {
    throw hal::InputError("topology", "'" + topology + "'", "a topology of this build, such as 5vav-5fcu-2power",
                          "write the counts of VAV boxes, fan coil units and power meters like that");
  }
  return hal::counts_of(shape);
}

}  // namespace

Site load_site(const std::string& path) {
  Site site;
  site.file = hal::read_site_file(path, hal::site_rules());
  site.counts = counts_of_name(site.file.topology);
  site.points = site.file.modbus ? hal::PointMap::load(site.file.modbus->points)
                                 : hal::PointMap::parse(hal::default_point_map(site.counts.vavs, site.counts.fcus,
                                                                               site.counts.powers, site.file.stand_ins),
                                                        "built-in");
  // First: a stand-in, which check_topology advises, is no remedy for what the objective needs.
  if (site.file.modbus) {
    hal::refuse_objective(site.file.objective, site.points, site.counts.vavs, path + ": [controller] objective");
  }
  site.points.check_topology(site.counts.vavs, site.counts.fcus, site.counts.powers, site.file.stand_ins);
  site.counts = hal::counts_of(site.counts, site.points, site.file.stand_ins);
  site.settings = hal::controller_settings(site.file, site.points);
  return site;
}

Site built_in_site(const std::string& topology, hal::ControllerPreset preset) {
  Site site;
  site.counts = counts_of_name(topology);
  site.file.path = "built-in";
  site.file.name = site.file.scope = "built-in";
  site.file.topology = site.counts.name;
  site.file.preset = preset;
  site.points =
      hal::PointMap::parse(hal::default_point_map(site.counts.vavs, site.counts.fcus, site.counts.powers), "built-in");
  site.settings = hal::controller_settings(site.file, site.points);
  return site;
}

Site with_stand_ins(Site built_in, const hal::StandIns& stand_ins) {
  const hal::TopologyCounts& c = built_in.counts;
  built_in.file.stand_ins = stand_ins;
  built_in.points =
      hal::PointMap::parse(hal::default_point_map(c.vavs, c.fcus, c.powers, stand_ins), built_in.points.file());
  built_in.points.check_topology(c.vavs, c.fcus, c.powers, stand_ins);
  built_in.counts = hal::counts_of(c, built_in.points, stand_ins);
  return built_in;
}

Site with_preset(const Site& site, hal::ControllerPreset preset) {
  Site other = site;
  other.file.preset = preset;
  other.settings = hal::controller_settings(other.file, other.points);
  return other;
}

}  // namespace airside::tools
