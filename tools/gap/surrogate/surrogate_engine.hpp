#pragma once
// An RC room that answers in the stead of a model whose runs are dear, and learns from the runs that are made.

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tools/gap/model/forwarding_engine.hpp"
#include "tools/gap/model/stretches.hpp"

namespace airside::tools::gap {

/// What the model shows at an anchor, and what the RC room makes of every change from there:
///   y(c) = y_rc(c) + l + sum_e l_e(c_e),  l = y(a) - y_rc(a),  l_e(m) = y(a + e at m) - y_rc(a + e at m) - l
/// a the anchor, first the model as it is; e the effects that were learned, at one size or several; between two sizes
/// l_e goes along the line, below the first one and beyond the last in proportion, there to 1.5 times it at most. Of
/// duties l_e has the means over the days alone, by 3 h of the day: when a thermostat switches is another chance in
/// each run. Sensors come after that. Duties stay within 0..1. simulate() is thread-safe; anchor() and learn() are not.
class SurrogateEngine final : public ForwardingEngine {
 public:
  /// `model` is kept by reference and lives through stretches by itself; the room has its channels.
  SurrogateEngine(const Engine& model, sim::RcRoom room);
  /// Cost: a replay of the RC room; one run of the model for a recording that was never asked for.
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override;
  sim::ChannelTable simulate_differing(std::uint64_t seed, const Changes& changes,
                                       const sim::Recording& recording) const override;
  bool draws_buildings() const override { return true; }
  int usual_buildings() const override { return room_.usual_buildings(); }
  bool spares_runs() const override { return false; }

  /// Cost: one run of the model.  Errors: as Engine::simulate.
  void anchor(const Changes& at, const sim::Recording& recording);
  /// Runs the model with each of these changes beside its anchor in that recording, and keeps what the room lacked.
  /// Errors: as Engine::simulate.  Cost: one run of the model each, on `jobs` threads.
  void learn(const std::vector<sim::EffectChange>& changes, const sim::Recording& recording, int jobs);
  /// The size at which the change is learned in that recording, of several the nearest, over its own; 0: at none.
  double learned(const sim::EffectChange& change, const sim::Recording& recording) const;
  /// What was learned of the change adds to a response of the RC room.  Shape: rows x channels, empty for nothing.
  sim::ChannelTable added_response(const sim::EffectChange& change, const sim::Recording& recording) const;

 private:
  struct Learned {
    double offset = 0;  // magnitude less the effect's null
    sim::ChannelTable lack;
  };
  struct Known {
    Changes anchor;
    sim::ChannelTable lack;                                // at the anchor
    std::map<std::string, std::vector<Learned>> up, down;  // by id of the effect at its place; the smallest first
  };
  /// The changes that a model lives through, and those that sensors alone show.
  std::pair<Changes, Changes> divided(const Changes& changes) const;
  Known& known(const sim::Recording& recording) const;
  static const std::vector<Learned>* find(const Known& at, const std::string& id, double offset);
  static sim::ChannelTable lack_at(const std::vector<Learned>& sizes, double offset);
  sim::ChannelTable corrected(sim::ChannelTable table, const Changes& lived, const Changes& shown,
                              const sim::Recording& recording) const;

  RcEngine rc_;
  StretchedEngine room_;
  mutable std::mutex mutex_;
  mutable std::map<std::uint64_t, std::unique_ptr<Known>> known_;
};

}  // namespace airside::tools::gap
