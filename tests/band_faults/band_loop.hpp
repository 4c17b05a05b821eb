#pragma once
// A room whose boxes modulate under the objective band, with every fault at hand that reaches what band sees: dampers,
// zone setpoints, meters, fan, supply air, bus and box. A watchman looks at every write.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "airside/controller/controller.hpp"
#include "airside/splitmix64.hpp"
#include "sim/faults/faulty_model.hpp"
#include "sim/rc/modulating_plant.hpp"
#include "sim/simulated_plant.hpp"

namespace airside::band_faults {

using BandSite = UpTo8;

/// What every decision is held against.
struct BandWatch {
  std::uint64_t cycles = 0, writes = 0;
  std::uint64_t not_finite = 0, outside = 0, beyond_a_step = 0, while_released = 0;
  std::uint64_t blind = 0;         ///< decisions with most dampers or zone setpoints lost while air flows
  std::uint64_t blind_chosen = 0;  ///< of them those that were not the schedule's
  std::uint64_t model_broken = 0;  ///< cycles with a power model that is not finite
  std::uint64_t unsafe() const { return not_finite + outside + beyond_a_step + while_released; }
  std::string first;  ///< what was wrong first
  void add(const BandWatch& other);
};

/// Five zones in a mild climate with eight days behind them; made once.
struct BandBefore {
  BandBefore();
  ControllerSettings settings;
  hal::TopologyCounts counts;
  hal::PointMap points;
  std::unique_ptr<sim::ModulatingPlant> plant;
  std::unique_ptr<Controller<BandSite>> controller;
};
const BandBefore& band_before();

class BandLoop {
 public:
  BandLoop();

  void cycles(int count);
  /// Faults of sensors and AHU, by the name of the signal; see sim/faults.
  void begin(sim::FaultKind kind, double for_h, const std::string& signal = "", double magnitude = 0);
  /// The same for all signals `stem`1 to `stem`5.
  void begin_all(sim::FaultKind kind, double for_h, const std::string& stem, double magnitude = 0);
  void no_answer(double for_h) { silent_until_h_ = hours() + for_h; }
  void stop_fan(double for_h);
  void hold_damper(std::size_t zone, double opening, double for_h);
  /// The box is killed and goes on from the bytes that a commit has.
  void kill();
  void clear();
  /// As a person does after an override.
  void hand_back() { controller_->hand_back(); }

  sim::ModulatingPlant& plant() { return plant_; }
  const Controller<BandSite>& controller() const { return *controller_; }
  const BandWatch& watch() const { return watch_; }
  /// Decisions other than the schedule's.
  int moved() const { return moved_; }
  ControlMode mode() const { return controller_->decision().mode; }

 private:
  struct Bus;
  struct Sink;

  double hours() const { return static_cast<double>(plant_.time().seconds) / 3600; }
  Expected<Reading<BandSite>> sense();
  Expected<Applied> actuate(const Command& command);
  void look(const Expected<Reading<BandSite>>& sensed);
  void complain(std::uint64_t& count, const std::string& what);
  void end_what_is_over();

  sim::ModulatingPlant plant_;
  sim::FaultyModel model_;
  sim::SimulatedPlant<BandSite> registers_;
  std::unique_ptr<Controller<BandSite>> controller_;
  double silent_until_h_ = 0, fan_until_h_ = 0;
  std::vector<std::pair<std::size_t, double>> held_;  // zone, until when
  double seen_standing_degc_;  // what the box last saw or did in the register; NaN: it cannot know
  double found_degc_ = 0;      // the same before it wrote
  int cycles_left_ = 0, moved_ = 0;
  BandWatch watch_;
};

/// A fault with drawn details; returns how many hours it takes.
struct BandFault {
  const char* name;
  double (*begin)(BandLoop& loop, SplitMix64& draw);
};
const std::vector<BandFault>& band_faults();

}  // namespace airside::band_faults
