#pragma once
// An engine that counts its runs.

#include <functional>
#include <string>
#include <utility>

#include "tools/gap/model/engine.hpp"

namespace airside::tools::gap {

/// The same model; done() is called after each run, from the thread that made it.
class CountedEngine final : public Engine {
 public:
  CountedEngine(const Engine& engine, std::function<void()> done) : engine_(engine), done_(std::move(done)) {}
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override {
    sim::ChannelTable table = engine_.simulate(changes, recording);
    if (done_) done_();
    return table;
  }
  sim::Channels channels() const override { return engine_.channels(); }
  std::array<bool, sim::facades> has_facade() const override { return engine_.has_facade(); }
  bool can(const sim::Effect& effect) const override { return engine_.can(effect); }
  bool doubts(const sim::Effect& effect) const override { return engine_.doubts(effect); }
  bool only_shows(const sim::Effect& effect) const override { return engine_.only_shows(effect); }
  bool spares_runs() const override { return engine_.spares_runs(); }
  std::string description() const override { return engine_.description(); }

 private:
  const Engine& engine_;
  std::function<void()> done_;
};

}  // namespace airside::tools::gap
