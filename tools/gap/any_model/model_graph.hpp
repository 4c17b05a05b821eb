#pragma once
// Where things are in an EnergyPlus model that somebody else wrote: the air loop, or those of all its zones, with
// equipment and terminals, and what is in the zones of a site.

#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "sim/energyplus/adopted/model_index.hpp"
#include "sim/energyplus/adopted/own_model.hpp"
#include "sim/weather/weather.hpp"
#include "tools/adopt/loop/air_loop.hpp"
#include "tools/adopt/model/model_view.hpp"

namespace airside::tools::gap {

/// A window or an outside wall of a zone.
struct OuterSurface {
  ModelObject object;
  std::string zone;          ///< as sim::engine_case() has it
  std::string construction;  ///< its name
  bool window = false;
  int facade = -1;  ///< order of sim's façades: north, east, south, west; -1: none, such as a roof
};

class ModelGraph {
 public:
  /// The model must outlive it. A model whose loop cannot be walked has no equipment.
  /// Errors: hal::InputError of a model that is no EnergyPlus model.
  ModelGraph(const nlohmann::json& model, const sim::OwnNames& names);

  const ModelView& view() const { return view_; }
  /// The site's zones, as the model writes them: rooms, then zones with fan coils.
  const std::vector<std::string>& zones() const { return zones_; }
  /// Objects of a type (`*` matches anything) whose zone, list of zones or space is in these; one that is elsewhere
  /// too is left out where `alone`.
  std::vector<ModelObject> in_zones(const std::string& type, const std::vector<std::string>& zones, bool alone) const;
  std::vector<ModelObject> terminals_of(const std::string& type, const std::vector<std::string>& zones) const;
  /// Supply fans, coils and outdoor-air controllers.
  std::vector<ModelObject> on_air_loop(const std::string& type) const;
  std::vector<ModelObject> all(const std::string& type) const;
  /// Windows and outer walls and roofs of these zones.
  std::vector<OuterSurface> outer_surfaces(const std::vector<std::string>& zones) const;
  /// Of the zone's own field, else of its floors; 0 where neither is there.  m2.
  double floor_area_m2(const std::string& zone) const;
  /// The layers of a construction, from outside; empty where it has none.
  std::vector<ModelObject> layers_of(const std::string& construction) const;
  /// Façades with windows of the site's zones.
  std::array<bool, sim::facades> has_facade() const;

 private:
  bool may_be_wanted(const ModelObject& loop, const sim::OwnNames& names) const;
  bool is_wanted(const AirLoop& loop, const sim::OwnNames& names) const;
  std::vector<ModelObject> equipment() const;

  ModelView view_;
  sim::ModelIndex index_;
  std::vector<std::string> zones_;
  std::vector<AirLoop> loops_;  // one, or those of all zones
};

}  // namespace airside::tools::gap
