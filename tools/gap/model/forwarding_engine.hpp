#pragma once
// An engine around another one.

#include "tools/gap/model/engine.hpp"

namespace airside::tools::gap {

/// Answers what the other one does; who derives from it says how it simulates.
class ForwardingEngine : public Engine {
 public:
  /// `engine` is kept by reference.
  explicit ForwardingEngine(const Engine& engine) : engine_(engine) {}
  sim::ChannelTable simulate_differing(std::uint64_t seed, const Changes& changes,
                                       const sim::Recording& recording) const override {
    return engine_.simulate_differing(seed, changes, recording);
  }
  bool draws_buildings() const override { return engine_.draws_buildings(); }
  int usual_buildings() const override { return engine_.usual_buildings(); }
  sim::Channels channels() const override { return engine_.channels(); }
  std::array<bool, sim::facades> has_facade() const override { return engine_.has_facade(); }
  bool can(const sim::Effect& effect) const override { return engine_.can(effect); }
  std::string why_not(const sim::EffectAt& at) const override { return engine_.why_not(at); }
  bool plays_commands() const override { return engine_.plays_commands(); }
  bool plays_setpoint() const override { return engine_.plays_setpoint(); }
  std::vector<std::string> played_schedules() const override { return engine_.played_schedules(); }
  bool doubts(const sim::Effect& effect) const override { return engine_.doubts(effect); }
  bool only_shows(const sim::Effect& effect) const override { return engine_.only_shows(effect); }
  bool spares_runs() const override { return engine_.spares_runs(); }
  std::optional<sim::RcRoom> stand_in() const override { return engine_.stand_in(); }
  std::string description() const override { return engine_.description(); }

 protected:
  const Engine& engine() const { return engine_; }

 private:
  const Engine& engine_;
};

}  // namespace airside::tools::gap
