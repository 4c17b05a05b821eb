#pragma once
// Weights that arrive while the box is in control: their mail, keys, counters and the rollback image, around the policy
// of weight_trial.hpp. And an operator's wishes, which come the same way.

#include <array>
#include <memory>
#include <span>
#include <string>

#include "airside/controller/instances.hpp"
#include "airside/controller/weight_trial.hpp"
#include "hal/storage/state_copy.hpp"
#include "hal/weights/counter_ledger.hpp"
#include "hal/weights/mailbox.hpp"
#include "hal/weights/signature.hpp"

namespace airside::edge {

using airside::text_of;
using TrialState = airside::TrialState;

/// Of the blobs that were taken, by key.
struct TakenCounters {
  using Counter = hal::KeyCounter;
  std::array<Counter, hal::KeyRing::max_keys> counter{};
};

/// What is known of pushed weights. Plain bytes; part of the row record, so that weights and counter change in one
/// commit.
struct TrialRecord : TakenCounters, WeightTrialRecord {};
static_assert(sizeof(TrialRecord) == sizeof(TakenCounters) + sizeof(WeightTrialRecord), "no gap in what is saved");

/// Cost: no heap after construction.  Source: docs/box-and-safety.md, rows 44-50.
template <Topology T>
class WeightsTrial {
 public:
  WeightsTrial(const std::string& keys_dir, const std::string& inbox_dir, const std::string& state_dir,
               std::uint64_t meaning, hal::Sync sync, std::string scope, const std::string& log_dir = {});

  /// Opens or makes the inbox, and reads the counters that lie apart; before, nothing is collected.
  void open_inbox();
  /// Whether a person has asked for release and no row has reported it yet.
  /// When the release that holds ends by itself; 0: there is none, or it waits for a hand-back.
  CivilTime release_ends() const { return release_ends_; }
  bool release_waits() const { return mailbox_.release_waits(); }
  /// The state is another one, to which nothing of the inbox was reported yet.
  void tell_anew();
  /// Whether this box has committed before, by the counters that lie apart.
  bool has_counters() const { return counters_.exists(); }
  /// Joins the counters of the state with those that lie apart. `is_known`: the record is whole, or the box is new.
  void join_counters(const TrialRecord& record, bool is_known);
  /// Once a row, before its commit. Returns whether the learning state was exchanged.
  bool row(CivilTime t, Controller<T>& controller, TrialRecord& record);
  /// After the commit: what it holds may go from the inbox, and the copy that it names becomes the only one. Errors: of
  /// the counters that lie apart; wrong_kind where the copy cannot be written.
  hal::StoreResult<void> committed();

 private:
  using Payload = typename WeightBlob<T>::Payload;
  using Learning = LearningState<T, float>;

  void take_wishes(CivilTime t, const hal::Mail& mail, Controller<T>& controller);
  void read_keys();
  /// Length, key, signature, topology, units and finite numbers, counter, canary: in this order.
  BlobError install(CivilTime t, std::span<const std::byte> bytes, Controller<T>& controller, TrialRecord& record);
  /// Once a row. Returns whether the weights were taken back.
  bool supervise(CivilTime t, Controller<T>& controller, TrialRecord& record);
  bool roll_back_as_asked(Controller<T>& controller, TrialRecord& record);
  void say_why(const hal::Mail& mail, const BlobError& refusal, bool waits) const;
  static void note_refusal(const BlobError& refusal, TrialRecord& record);
  /// Returns whether learning state or control mode changed.
  bool roll_back(Controller<T>& controller, TrialRecord& record, const char* why);
  /// Where the key's counter stands, or a place for it: an empty one, else that of a key which lies there no more.
  TrialRecord::Counter* counter_of(TrialRecord& record, const hal::KeyId& key) const;
  /// Once, when it cannot be had or is another thing than a folder.
  void say_inbox();

  hal::StoreFault said_inbox_ = hal::StoreFault::none;
  std::string keys_dir_, inbox_dir_;
  hal::KeyRing keys_;
  hal::Mailbox mailbox_{""};
  hal::StateCopy copy_;
  hal::CounterLedger counters_;
  std::string scope_;
  std::unique_ptr<std::array<std::byte, WeightBlob<T>::max_bytes>> bytes_;
  std::unique_ptr<Payload> payload_;
  std::unique_ptr<NetworkWeights<T, float>> weights_;
  std::unique_ptr<Learning> before_ = std::make_unique<Learning>();
  hal::KeyId exchanged_key_{};
  CivilTime release_ends_;  ///< 0: no release, or one without an end of its own
  CivilTime last_row_;
  bool finish_mail_ = false, accepted_ = false, exchange_waits_ = false;  ///< the last: for its commit
  std::uint64_t staged_copy_ = 0;  ///< digest of a copy that waits for the commit that names it
};

}  // namespace airside::edge
