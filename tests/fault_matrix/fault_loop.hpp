#pragma once
// One room under the product's controller, with every fault of the matrix that reaches the control loop at hand:
// sensors and AHU by sim's scripts, bus and box here. What a bus or disk really does is shown by the tests of single
// rows; here each stands for what the loop sees of it. A watchman looks at every write.

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "airside/controller/cycle.hpp"
#include "airside/controller/instances.hpp"
#include "firmware/edge/weights/weights_trial.hpp"
#include "sim/faults/faulty_model.hpp"
#include "sim/rc/rc_plant.hpp"
#include "sim/simulated_plant.hpp"
#include "support/controller_access.hpp"
#include "support/test_folder.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::fault_matrix {

using T = FiveZone;
using L = Layout<T>;

/// What bus and box can do to the loop, each for a time.
enum class LoopFault {
  no_answer,          ///< nothing can be read or written
  answers_fail,       ///< every other row cannot be read, and the connection is made anew
  register_refused,   ///< one signal is missing
  late_confirmation,  ///< writes are done, but not confirmed
  stale,              ///< one signal is hours old
  other_device,       ///< the fingerprint differs: nothing is read or written
  write_refused,      ///< the device refuses every setpoint
  write_only,         ///< the setpoint cannot be read
  clock_off,          ///< the box's clock is wrong by hours
  clock_not_set,      ///< and known to be
  asleep,             ///< the box stands still
  disk_fails,         ///< nothing can be saved
};

/// What every write that reached the AHU is held against.
struct Watchman {
  std::uint64_t cycles = 0, writes = 0;
  std::uint64_t not_finite = 0, outside = 0, beyond_a_step = 0, while_released = 0;
  std::uint64_t learned_bad = 0;     ///< transitions with a number that is none, or outside its signal's limits
  std::uint64_t weights_broken = 0;  ///< cycles with weights that are not finite
  std::uint64_t unsafe() const { return not_finite + outside + beyond_a_step + while_released; }
  std::string first;  ///< what was wrong first
};

/// What a room and its weights are before anything is disturbed; made once, and shared.
struct PreparedRoom {
  explicit PreparedRoom(int steps = 300, const std::string& room = "301-real", std::uint64_t seed = 1);
  tools::Trial trial;
  tools::Prepared begun;  ///< the schedule's days have been
  std::unique_ptr<Controller<T>> controller;
  hal::SecretKey key;
  hal::TestFolder folder;
  mutable int loops = 0;
};

/// One for all tests of a program.
const PreparedRoom& prepared_room();

class FaultLoop {
 public:
  explicit FaultLoop(const PreparedRoom& prepared);

  /// Runs until so many decisions were made.
  void cycles(int count);
  /// Does something so many hours from now, between two rows.
  void in_hours(double hours, std::function<void()> what);

  void begin(sim::FaultKind kind, double for_h, int signal = -1, double magnitude = 0);
  void begin(LoopFault fault, double for_h, int signal = 0, double magnitude = 0);
  /// The box is killed and goes on from what was saved last, or up to ten cycles before.
  void kill(bool from_older = false);
  /// The box is killed and nothing that was saved is whole: it begins from its weights and its history.
  void lose_state();
  using Payload = WeightBlob<T>::Payload;
  using Bytes = std::vector<std::byte>;
  /// Weights that arrive: those in use, each times `factor`, and what is done to them on their way.
  struct Push {
    float factor = 0.9F;
    std::function<void(Payload&)> payload = {};
    std::function<void(BlobHeader&)> header = {};  ///< before they are signed
    std::function<void(Bytes&)> bytes = {};        ///< after it
    bool old_counter = false;
    bool by_a_stranger = false;
  };
  void push(const Push& how);
  /// The watchman's look at a setpoint that is about to reach the AHU.
  void look_at_write(double setpoint_degc);
  /// Every fault ends now.
  void clear();

  Controller<T>& controller() { return *controller_; }
  const Decision& decision() const { return controller_->decision(); }
  const edge::TrialRecord& trial() const { return record_; }
  const Watchman& watchman() const { return watchman_; }
  double standing_degc() const { return model_->standing_degc(); }
  CivilTime box_time() const { return {model_->time().seconds + clock_off_s()}; }
  /// Mean |room mean - target| in working hours since this was last called.  K.
  double take_dae_k();
  std::uint64_t reason_rows(Reason reason) const { return reason_rows_[static_cast<std::size_t>(reason)]; }
  ControlMode gravest() const { return gravest_; }  ///< control mode of any decision so far
  std::vector<double> setpoint_degc;                ///< that stood after each decision

 private:
  struct Running {
    LoopFault fault;
    double until_h;
    int signal;
    double magnitude;
  };
  struct Saved {  // a controller is too large for a stack
    std::shared_ptr<const Controller<T>> controller;
    edge::TrialRecord record;
  };
  struct Bus;
  struct Clock;
  struct Sink;

  const Running* find(LoopFault fault) const;
  bool has(LoopFault fault) const { return find(fault) != nullptr; }
  std::int64_t clock_off_s() const;
  double hours() const { return static_cast<double>(model_->time().seconds) / 3600; }
  Expected<Reading<T>> sense();
  Expected<Applied> actuate(const Command& command);
  void look_at_memory();
  bool row(CivilTime t);
  void complain(std::uint64_t& count, const std::string& what);
  Saved present() const { return {std::make_shared<Controller<T>>(*controller_), record_}; }
  void restart(const Saved& from);

  const PreparedRoom& prepared_;
  std::unique_ptr<sim::RcPlant> plant_;
  std::unique_ptr<sim::FaultyModel> model_;
  std::unique_ptr<sim::SimulatedPlant<T>> registers_;
  std::unique_ptr<Controller<T>> controller_;
  std::optional<Saved> older_, before_disk_failed_;
  std::filesystem::path folder_;
  std::unique_ptr<edge::WeightsTrial<T>> trial_;
  edge::TrialRecord record_;
  std::uint64_t counter_ = 0;
  std::vector<Running> running_;
  std::vector<std::pair<double, std::function<void()>>> due_;
  std::uint64_t contact_ = 0, rows_ = 0, pushed_ = 0;
  CivilTime next_;
  int cycles_left_ = 0;
  double seen_standing_degc_;  ///< what the box last saw or did in the register
  Watchman watchman_;
  ControlMode gravest_ = ControlMode::learn;
  std::array<std::uint64_t, reason_count> reason_rows_{};
  double error_sum_k_ = 0;
  int error_count_ = 0;
};

/// A row of the matrix as the loop meets it: begins the fault with drawn details, and returns how many hours it takes.
/// Null where the row cannot reach the loop (a page, another process, memory).
struct MatrixRow {
  int row;
  const char* fault;
  double (*begin)(FaultLoop& loop, SplitMix64& draw);
};
const std::array<MatrixRow, 60>& matrix_rows();

}  // namespace airside::fault_matrix
