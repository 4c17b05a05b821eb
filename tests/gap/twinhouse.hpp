#pragma once
// The Twin Houses at Holzkirchen (IEA EBC Annex 58) as an engine of the gap workflow: measured heaters, ventilation,
// attic, cellar and weather act on a network of two zones whose numbers are fields of sim::RcRoom, so that the files of
// sim/effects/library change this house as they change an office. The measurements are not part of the project.

#include <filesystem>
#include <map>
#include <string>

#include "tools/gap/inference/parameter_fit.hpp"
#include "tools/gap/verdict/workflow.hpp"

namespace airside::tools::gap {

/// One house: a series a column, 10-min means.
struct HouseLog {
  std::string name;  ///< "O5", "N2"
  CivilTime from;
  std::size_t rows = 0;
  std::map<std::string, std::vector<double>> column;

  /// Mean over columns of the 10 min in which t lies.
  double at(const std::string& name, CivilTime t) const;
};

/// AIRSIDE_TWINHOUSE, else ../shared/data/twinhouse beside the source folder; empty where there is none.
std::filesystem::path find_twin_house();

/// Errors: hal::InputError for a file that is not as its README says.
HouseLog read_house(const std::filesystem::path& folder, const std::string& name);

/// Zones: south (living, corridor, bath, child's room: doors open), north (kitchen, lobby, bedroom: doors sealed).
constexpr int house_zones = 2;

/// From the start of day `from` to the end of day `to`. What was measured before day `counted` is lived through, but
/// missing in `measured`: the house remembers its days for long. In each row: fcu_on: heat into each zone in kW, then
/// attic, cellar, supply air in degC; vav_on: ventilation flow over the usual 120 m3/h.
Window house_window(const HouseLog& log, CivilTime from, CivilTime counted, CivilTime to);

class TwinHouseEngine final : public Engine {
 public:
  /// `attic_share` of the neighbours' temperature, the rest is the cellar's.
  TwinHouseEngine(sim::RcRoom house, double attic_share) : house_(std::move(house)), attic_share_(attic_share) {}

  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override;
  sim::Channels channels() const override { return {house_zones, 0, 0}; }
  std::array<bool, sim::facades> has_facade() const override { return {true, true, true, true}; }
  bool can(const sim::Effect& effect) const override;
  std::string description() const override { return "twin house"; }

 private:
  sim::RcRoom house_;
  double attic_share_;
};

/// What is known of such a house before anybody measures: areas, usual constructions.
sim::RcRoom usual_house();

/// The house's numbers from a window in which nothing is hidden.
struct HouseFit {
  TwinHouseEngine engine;
  ParameterFit fit;
  std::vector<FitParameter> parameters;
};
HouseFit fit_house(const Window& window, int jobs);

/// Parameters of this house beside those of sim/effects: each zone's masses and conductances.
std::vector<sim::Effect> house_effects();

}  // namespace airside::tools::gap
