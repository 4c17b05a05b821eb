#pragma once
// An engine that counts its runs.

#include <functional>
#include <string>
#include <utility>

#include "tools/gap/model/forwarding_engine.hpp"

namespace airside::tools::gap {

/// The same model; done() is called after each run, from the thread that made it.
class CountedEngine final : public ForwardingEngine {
 public:
  CountedEngine(const Engine& engine, std::function<void()> done) : ForwardingEngine(engine), done_(std::move(done)) {}
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override {
    sim::ChannelTable table = engine().simulate(changes, recording);
    if (done_) done_();
    return table;
  }

  sim::ChannelTable simulate_differing(std::uint64_t seed, const Changes& changes,
                                       const sim::Recording& recording) const override {
    sim::ChannelTable table = engine().simulate_differing(seed, changes, recording);
    if (done_) done_();
    return table;
  }

 private:
  std::function<void()> done_;
};

}  // namespace airside::tools::gap
