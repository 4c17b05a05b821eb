#include "firmware/edge/weights/weights_trial.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "firmware/edge/report/say.hpp"
#include "hal/storage/digest64.hpp"
#include "hal/weights/blob_file.hpp"

namespace airside::edge {

template <Topology T>
WeightsTrial<T>::WeightsTrial(const std::string& keys_dir, const std::string& inbox_dir, const std::string& state_dir,
                              std::uint64_t meaning, hal::Sync sync, std::string scope, const std::string& log_dir)
    : keys_dir_(keys_dir),
      inbox_dir_(inbox_dir),
      copy_(state_dir, meaning, sync),
      counters_(state_dir, log_dir, sync),
      scope_(std::move(scope)),
      bytes_(std::make_unique<std::array<std::byte, WeightBlob<T>::max_bytes>>()),
      payload_(std::make_unique<Payload>()),
      weights_(std::make_unique<NetworkWeights<T, float>>()) {
  read_keys();
}

template <Topology T>
void WeightsTrial<T>::open_inbox() {
  mailbox_ = hal::Mailbox(inbox_dir_);
  say_inbox();
  counters_.read();
}

template <Topology T>
void WeightsTrial<T>::tell_anew() {
  mailbox_.tell_anew();
  staged_copy_ = 0;
  finish_mail_ = false;
  exchange_waits_ = false;
}

template <Topology T>
void WeightsTrial<T>::join_counters(const TrialRecord& record, bool is_known) {
  counters_.join(record.counter, is_known);
  if (!counters_.is_known()) say("what was pushed before is unknown: weights are refused until their key is listed");
}

template <Topology T>
bool WeightsTrial<T>::row(CivilTime t, Controller<T>& controller, TrialRecord& record) {
  const hal::Mail mail = mailbox_.collect(*bytes_);
  say_inbox();
  take_wishes(t, mail, controller);
  const bool has_begun = record.tries_back > 0;
  bool exchanged = has_begun && roll_back(controller, record, "as was begun");
  // Whoever asks for a rollback before a blob was tried means that blob. One that was taken already lies here still
  // where the daemon ended between the commit and this.
  const bool is_in_use =
      record.state != TrialState::none && crc32c({bytes_->data(), mail.blob_bytes}) == record.blob_crc;
  const bool taken_back = mail.blob_is_older && !is_in_use;
  if (mail.rollback && !taken_back && !has_begun) exchanged = roll_back_as_asked(controller, record);
  if (mail.has_blob) {
    read_keys();  // each time, so that a key that was revoked is refused at once, and a new one known
    const BlobError refusal = taken_back ? BlobError{Fault::blob_taken_back, "rollback"}
                              : mail.unread != nullptr
                                  ? BlobError{Fault::blob_truncated, mail.unread}
                                  : install(t, {bytes_->data(), mail.blob_bytes}, controller, record);
    accepted_ = refusal.fault == Fault::none;
    exchanged = exchanged || accepted_;
    // Without a rollback image there is no trial; and what could not be read now may be the next time.
    const bool waits = refusal.fault == Fault::state_invalid || (mail.later && !taken_back);
    const bool said = waits && record.refusal == refusal.fault;
    if (!accepted_ && !said) say_why(mail, refusal, waits);
    note_refusal(refusal, record);
    if (waits) mailbox_.leave_blob();
  }
  finish_mail_ = finish_mail_ || mail.has_blob || mail.rollback || mail.release || mail.hand_back;
  return supervise(t, controller, record) || exchanged;
}

/// A release holds until a hand-back, or until its time is over, which rows find out.
template <Topology T>
void WeightsTrial<T>::take_wishes(CivilTime t, const hal::Mail& mail, Controller<T>& controller) {
  // A clock that is set, or set back, moves the end with it: nobody waited for so long.
  const std::int64_t passed_s = last_row_.seconds == 0 ? row_s : t.seconds - last_row_.seconds;
  const bool was_set = passed_s < 0 || passed_s > clock_leap_s;
  if (release_ends_.seconds != 0 && was_set) release_ends_.seconds += passed_s - row_s;
  last_row_ = t;
  if (mail.release) controller.hold(Reason::released_by_hand, t, 0);
  if (mail.hand_back) controller.hand_back();
  if (mail.hand_back) say("an operator asked: hand-back");
  if (mail.release && mail.release_s == 0) say("an operator asked: release");
  if (mail.release && mail.release_s > 0) say("an operator asked: release for {} min", (mail.release_s + 59) / 60);
  if (mail.release || mail.hand_back) release_ends_ = {mail.release_s == 0 ? 0 : t.seconds + mail.release_s};
  if (release_ends_.seconds == 0 || t < release_ends_) return;
  controller.report(Reason::released_by_hand, false, t);
  mailbox_.end_release();
  finish_mail_ = true;
  release_ends_ = {};
  say("the time of the release is over; the AHU is taken again");
}

template <Topology T>
hal::StoreResult<void> WeightsTrial<T>::committed() {
  if (finish_mail_) finish_mail_ = !mailbox_.finish(accepted_);
  if (staged_copy_ != 0) (void)copy_.settle(staged_copy_);  // where it fails, load() finds it as it is
  staged_copy_ = 0;
  if (exchange_waits_) counters_.settle(exchanged_key_);
  exchange_waits_ = false;
  const hal::StoreResult<void> kept = counters_.keep();
  return kept ? copy_.blocked() : kept;
}

template <Topology T>
void WeightsTrial<T>::read_keys() {
  keys_.reload(keys_dir_.c_str(), [](const char* file, const char* what) { say("keys: {} {}", file, what); });
}

template <Topology T>
BlobError WeightsTrial<T>::install(CivilTime t, std::span<const std::byte> bytes, Controller<T>& controller,
                                   TrialRecord& record) {
  const auto key = hal::verify_blob(bytes, keys_);
  if (!key) return key.error();
  payload_->site = controller.settings().shape;
  payload_->cycle = control_cycle(controller.settings());
  const auto header = WeightBlob<T>::read(bytes, scope_, *payload_);
  if (!header) return header.error();
  TrialRecord::Counter* counter = counter_of(record, header->key_id);
  const BlobError old{Fault::blob_counter, "security_counter"};
  if (counter == nullptr) return old;  // uncovered: a ring holds no more keys than there are counters
  if (header->security_counter <= counter->highest) return old;
  const std::uint64_t digest = std::max<std::uint64_t>(hal::digest64(bytes), 1);
  const hal::CounterLedger::Verdict age = counters_.judge(**key, header->security_counter, digest);
  if (age == hal::CounterLedger::Verdict::old) return old;
  if (age == hal::CounterLedger::Verdict::unknown) return {Fault::counter_unknown, "security_counter"};
  const BlobError unfit = WeightTrial<T>::refusal_of(controller, *payload_, *weights_);
  if (unfit.fault != Fault::none) return unfit;
  // Before anything is exchanged: a power cut may leave the counter ahead of the weights, never behind them.
  if (!counters_.raise(header->key_id, header->security_counter, digest, keys_)) {
    return {Fault::state_invalid, "counter of pushed weights"};
  }
  if (WeightTrial<T>::needs_image(record)) {
    const hal::StoreResult<std::uint64_t> kept = copy_.save(controller.saved_bytes().learning, record.previous_digest);
    if (!kept) return {Fault::state_invalid, "copy of the weights before"};
    staged_copy_ = *kept;
    WeightTrial<T>::keep_image(controller, *kept, record);
  }
  WeightTrial<T>::begin(t, controller, *payload_, crc32c(bytes), record);
  counter->highest = header->security_counter;
  exchanged_key_ = header->key_id;
  exchange_waits_ = true;
  say("weights {:08x} of {} taken; {}", record.blob_crc, (*key)->name.view(), text_of(record.state));
  return {Fault::none, ""};
}

template <Topology T>
bool WeightsTrial<T>::supervise(CivilTime t, Controller<T>& controller, TrialRecord& record) {
  const TrialVerdict verdict = WeightTrial<T>::row(t, controller, record);
  if (verdict == TrialVerdict::confirmed) {
    say("weights {:08x} confirmed after a day: {} cycles predicted within {:.2f} K", record.blob_crc,
        record.tried_cycles, WeightTrial<T>::error_k(record));
  }
  if (!ends_in_rollback(verdict)) return false;
  return roll_back(controller, record, why_of(verdict));
}

template <Topology T>
bool WeightsTrial<T>::roll_back_as_asked(Controller<T>& controller, TrialRecord& record) {
  if (record.state == TrialState::none) {
    say("no weights were pushed, so there are none to roll back to; all stays as it is");
    return false;
  }
  if (record.state == TrialState::rolled_back) {
    say("weights {:08x} are rolled back already", record.blob_crc);
    return false;
  }
  return roll_back(controller, record, "an operator asked for it");
}

template <Topology T>
void WeightsTrial<T>::say_why(const hal::Mail& mail, const BlobError& refusal, bool waits) const {
  const hal::BlobComplaint why = hal::complaint_of(refusal.fault);
  const std::string_view name = mailbox_.blob_file();
  const bool is_plain = std::ranges::all_of(name, [](char c) { return c > ' ' && c <= '~'; });  // log lines are lines
  if (mail.unread != nullptr && refusal.fault == Fault::blob_truncated) {
    return say("pushed weights {}: {}: {}; put a whole file there that this user may read", waits ? "wait" : "refused",
               is_plain ? name : "a blob", mail.unread);
  }
  say("pushed weights {}: {} ({}): found {}; expected {}; {}", waits ? "wait" : "refused", is_plain ? name : "a blob",
      refusal.field, why.found, why.expected, why.remedy);
}

template <Topology T>
void WeightsTrial<T>::note_refusal(const BlobError& refusal, TrialRecord& record) {
  record.refusal = refusal.fault;
  record.refusal_field = {};
  std::string_view(refusal.field).copy(record.refusal_field.data(), record.refusal_field.size() - 1);
}

template <Topology T>
bool WeightsTrial<T>::roll_back(Controller<T>& controller, TrialRecord& record, const char* why) {
  // Read to a place of its own first: a damaged copy must not harm what is in use.
  const hal::StoreResult<void> read =
      copy_.load(std::as_writable_bytes(std::span(before_.get(), 1)), record.previous_digest);
  const bool may_pass = !read && hal::may_pass(read.error());
  const Rollback done =
      WeightTrial<T>::roll_back(controller, read ? before_.get() : nullptr, may_pass, hal::Mailbox::patience, record);
  if (done == Rollback::waits) {
    if (record.tries_back == 1) {
      say("the weights before cannot be read: {} ({}); the next row tries again", hal::text_of(read.error().fault),
          read.error().step);
    }
    return true;
  }
  if (done == Rollback::impossible || done == Rollback::image_gone) {
    say("the weights before cannot be read: {} ({})", hal::text_of(read.error().fault), read.error().step);
    note_refusal({Fault::no_way_back, "copy of the weights before"}, record);
  }
  if (done == Rollback::impossible) return false;
  if (done == Rollback::not_finite) say("the weights before are not finite");
  say("weights {:08x} rolled back: {}", record.blob_crc, why);
  return true;
}

template <Topology T>
TrialRecord::Counter* WeightsTrial<T>::counter_of(TrialRecord& record, const hal::KeyId& key) const {
  for (auto& counter : record.counter) {
    if (counter.key == key) return &counter;
  }
  for (auto& counter : record.counter) {
    if (counter.key == hal::KeyId{}) return &(counter = {.key = key, .highest = 0});
  }
  for (auto& counter : record.counter) {  // uncovered: as above, one of theirs is gone
    if (keys_.find(counter.key) == nullptr) return &(counter = {.key = key, .highest = 0});
  }
  return nullptr;
}

template <Topology T>
void WeightsTrial<T>::say_inbox() {
  if (inbox_dir_.empty() || mailbox_.fault() == said_inbox_) return;
  said_inbox_ = mailbox_.fault();
  if (said_inbox_ == hal::StoreFault::none) return;
  say("inbox {}: {}; nothing is taken from there, each row tries again", inbox_dir_, hal::text_of(said_inbox_));
}

#define AIRSIDE_INSTANTIATE(Tag) template class WeightsTrial<Tag>;
AIRSIDE_FOR_EACH_TOPOLOGY(AIRSIDE_INSTANTIATE)
#undef AIRSIDE_INSTANTIATE

}  // namespace airside::edge
