#pragma once
// The model side of the gap workflow: what would the sensors have shown under these commands, if these changes to the
// model were true? One interface for the RC room and the EnergyPlus twin.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/effects/effect.hpp"
#include "sim/rc/rc_room.hpp"
#include "sim/weather/recording.hpp"

namespace airside::tools::gap {

using Changes = std::vector<sim::EffectChange>;

/// Whether every change is one to a sensor, and there is one.
bool only_on_sensors(const std::vector<sim::EffectOp>& ops);

class Engine {
 public:
  virtual ~Engine() = default;
  /// Thread-safe.  Shape: as sim::ChannelTable.  Errors: hal::InputError, std::runtime_error of a run that died.
  virtual sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const = 0;
  /// What a building would have shown that differs from the changed model as buildings differ from their twins: in
  /// structure that no parameter has, and a little in every number.  Empty where the engine cannot draw one.
  /// Thread-safe.  Shape, errors: as simulate().
  virtual sim::ChannelTable simulate_differing(std::uint64_t /*seed*/, const Changes& /*changes*/,
                                               const sim::Recording& /*recording*/) const {
    return {};
  }
  /// Whether simulate_differing() can.
  virtual bool draws_buildings() const { return false; }
  /// How many a verdict draws where nobody gives a number.
  virtual int usual_buildings() const { return 0; }
  virtual sim::Channels channels() const = 0;
  virtual std::array<bool, sim::facades> has_facade() const = 0;
  virtual bool can(const sim::Effect& effect) const = 0;
  /// Why an effect that it can is not to be had at one of its places, in words; empty where it is.
  virtual std::string why_not(const sim::EffectAt& /*at*/) const { return {}; }
  /// Whether recorded commands of boxes and fan coils are played; else the model's own control has them.
  virtual bool plays_commands() const { return true; }
  /// Whether a recorded supply setpoint is played.
  virtual bool plays_setpoint() const { return true; }
  /// Further schedules that follow recorded commands.
  virtual std::vector<std::string> played_schedules() const { return {}; }
  /// Whether the effect is also a parameter that this model does not know exactly.
  virtual bool doubts(const sim::Effect& effect) const { return effect.prior_sd > 0; }
  /// Whether the effect changes what sensors show and nothing else: the run is that of the model as it is, and
  /// sim::changed_sensors() of its table is all there is to simulate.
  virtual bool only_shows(const sim::Effect& /*effect*/) const { return false; }
  /// Whether a run costs so much that what other runs tell is not simulated again.
  virtual bool spares_runs() const { return false; }
  /// An RC room of the same channels that does nearly as this model does; none where runs are cheap, or none is known.
  virtual std::optional<sim::RcRoom> stand_in() const { return std::nullopt; }
  /// "rc room 301", for reports.
  virtual std::string description() const = 0;
};

class RcEngine final : public Engine {
 public:
  explicit RcEngine(sim::RcRoom room) : room_(std::move(room)), weathers_(std::make_shared<sim::MeasuredWeathers>()) {}
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override;
  sim::ChannelTable simulate_differing(std::uint64_t seed, const Changes& changes,
                                       const sim::Recording& recording) const override;
  bool draws_buildings() const override { return true; }
  int usual_buildings() const override { return 96; }
  sim::Channels channels() const override { return {room_.vavs, room_.fcus, room_.powers}; }
  std::array<bool, sim::facades> has_facade() const override;
  bool can(const sim::Effect& effect) const override { return effect.on_rc; }
  bool only_shows(const sim::Effect& e) const override { return e.rc.empty() && only_on_sensors(e.common); }
  std::string description() const override { return "rc room " + room_.name; }
  const sim::RcRoom& room() const { return room_; }

 private:
  sim::ChannelTable shown(const sim::RcRoom& room, const Changes& changes, const sim::Recording& recording) const;
  sim::RcRoom room_;
  std::shared_ptr<sim::MeasuredWeathers> weathers_;
};

/// One run.
struct Task {
  Changes changes;
  const sim::Recording* recording = nullptr;
};

/// All tasks, on `jobs` threads; done() is called from this thread's side after each.
/// Errors: the first task's that failed, after the others have ended.
std::vector<sim::ChannelTable> simulate_all(const Engine& engine, const std::vector<Task>& tasks, int jobs,
                                            const std::function<void()>& done = {});

}  // namespace airside::tools::gap
