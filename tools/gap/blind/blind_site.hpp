#pragma once
// The two engines that can measure, as the generator of blind cases sees them: what can be hidden at a site, how far
// it shows above the noise there, and what the site logs.

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/gap/blind/blind.hpp"
#include "tools/gap/blind/blind_energyplus.hpp"
#include "tools/gap/inference/reference_fit.hpp"
#include "tools/gap/model/energyplus_engine.hpp"

namespace airside::tools::gap {

/// A stretch of weather and a way of control: what cases share.
struct BlindWindow {
  int number = 0;  ///< 0 ..
  bool feedback = true;
  auto operator<=>(const BlindWindow&) const = default;
};

/// What all sites are given once.
struct BlindSetup {
  std::string twin;
  std::uint64_t seed = 1;
  int days = 14, jobs = 2;
  bool rough = false;                          ///< noise from a table instead of a fit
  std::map<bool, Eigen::VectorXd> noise = {};  ///< with feedback and without; given: instead of fits, RC only
  std::filesystem::path cache;
  std::vector<CivilTime> starts;               ///< of the reference, one a window
  std::vector<std::filesystem::path> weather;  ///< EPW, one a window
  const std::vector<sim::Effect>* effects = nullptr;
  std::function<void()> done;  ///< after each window of a site
};

/// What a case logs.
struct BlindLogs {
  std::vector<hal::LogRow> reference, measured;
};

/// How far something shows: rms of its response over the noise, in the channel that shows it most.
struct Shown {
  double ratio = 0;
  std::string channel;
};

/// How far it shows where control answers it: of the measured log less the same room's log without it, by kind of
/// channel. Empty: the site cannot tell.
using ShownLive = std::map<std::string, Shown>;

class BlindSite {
 public:
  virtual ~BlindSite() = default;
  /// By name, each with its places.
  using Kinds = std::map<std::string, std::vector<sim::EffectAt>>;
  const Kinds& kinds() const { return kinds_; }
  virtual hal::TopologyCounts counts() const = 0;
  /// The work that cases share.  Errors: of the engine.
  virtual void prepare(const std::vector<BlindWindow>& windows) = 0;
  /// Thread-safe after prepare().  NaN: this site cannot tell.
  virtual Shown shown(const Hidden& hidden, const BlindWindow& window) const = 0;
  /// Places of an outside kind; 0: it is at no place.
  virtual int outside_places(const std::string& kind) const = 0;
  /// Whether a room that is run so can have this outside kind.
  virtual bool has_outside(const std::string& /*kind*/, const BlindWindow& /*window*/) const { return true; }
  /// Thread-safe after prepare(). `logs`: what live() made of it.
  virtual ShownLive shown_live(const BlindLogs& /*logs*/, const BlindWindow& /*window*/, std::uint64_t /*seed*/) const {
    return {};
  }
  /// Thread-safe after prepare().
  virtual BlindLogs live(const std::vector<Hidden>& hidden, const BlindWindow& window, std::uint64_t seed) const = 0;
  /// The measured log of live(), lived on to `days` in all, with tests in the later ones. Needs no prepare().
  /// Thread-safe.
  virtual std::vector<hal::LogRow> lived_on(const std::vector<Hidden>& hidden, const BlindWindow& window,
                                            std::uint64_t seed, int days,
                                            std::shared_ptr<const TestCommands> tests) const = 0;

 protected:
  Kinds kinds_;
};

std::unique_ptr<BlindSite> make_rc_site(const BlindSetup& setup);
/// For BlindSetup::noise: of five rooms one in each window the median, which many drawings may share.
/// Shape: one a channel.  Units: K, kW, -.  Errors: of the engine.  Cost: 200 s, on setup.jobs threads.
std::map<bool, Eigen::VectorXd> usual_rc_noise(const BlindSetup& setup);
std::unique_ptr<BlindSite> make_energyplus_site(const BlindSetup& setup);

}  // namespace airside::tools::gap
