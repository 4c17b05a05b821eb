#pragma once
// The EnergyPlus twin as an engine of the gap workflow.

#include "sim/energyplus/replay/replay.hpp"
#include "sim/energyplus/replay/replay_cache.hpp"
#include "tools/gap/model/engine.hpp"

namespace airside::tools::gap {

class EnergyPlusEngine final : public Engine {
 public:
  /// `cache`: folder of finished runs; `duties`: a second run each, in which the fan coils follow their thermostats.
  EnergyPlusEngine(sim::EnergyPlusTwin twin, std::string name, std::filesystem::path cache, bool duties)
      : twin_(std::move(twin)), name_(std::move(name)), cache_(std::move(cache)), duties_(duties) {}
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override;
  sim::Channels channels() const override { return sim::channels_of(twin_); }
  std::array<bool, sim::facades> has_facade() const override;
  bool can(const sim::Effect& e) const override { return twin_.own ? e.on_any_model : e.on_energyplus; }
  std::string why_not(const sim::EffectAt& at) const override;
  bool plays_commands() const override { return !twin_.own; }
  bool plays_setpoint() const override { return !twin_.names.supply_setpoint_schedule.empty(); }
  std::vector<std::string> played_schedules() const override {
    return twin_.own ? twin_.own->commands : std::vector<std::string>{};
  }
  bool doubts(const sim::Effect& e) const override { return e.prior_sd > 0 && e.prior_on_energyplus; }
  bool only_shows(const sim::Effect& e) const override {
    return (twin_.own ? e.any_model : e.energyplus).empty() && only_on_sensors(e.common);
  }
  bool spares_runs() const override { return true; }
  /// The built-in RC room of the twin's name, else the default room of its counts; none for a model with controls of
  /// its own.
  std::optional<sim::RcRoom> stand_in() const override;
  std::string description() const override { return "EnergyPlus twin " + name_; }
  const sim::EnergyPlusTwin& twin() const { return twin_; }
  /// The twin with the changes that it can hold.
  sim::EnergyPlusTwin changed_twin(const Changes& changes) const;

 private:
  sim::EnergyPlusTwin twin_;
  std::string name_;
  std::filesystem::path cache_;
  bool duties_;
  mutable sim::ReplayMemory memory_;
};

}  // namespace airside::tools::gap
