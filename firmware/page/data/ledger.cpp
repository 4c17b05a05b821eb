#include "firmware/page/data/ledger.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <span>

#include "firmware/page/data/state_folder.hpp"
#include "hal/storage/atomic_file.hpp"

namespace airside::page {

using nlohmann::json;

namespace {

/// 1 in files of versions that merged none.
std::uint64_t times_of(const json& alarm) {
  const double times = number_of(alarm, "times");
  return times >= 2 && times < 1e9 ? static_cast<std::uint64_t>(times) : 1;
}

}  // namespace

Ledger::Ledger(std::string dir) : dir_(std::move(dir)) { load(); }

void Ledger::load() {
  std::uint64_t size = 0;
  const hal::StorageFile file = open_in(dir_, file_name, max_bytes, size);
  if (!file.is_open()) return;
  const json all = json_in(file, size);
  if (!all.is_object()) return;  // begun anew, as at the first start
  weights_ = text_in(all, "weights");
  refusal_ = text_in(all, "refusal");
  has_seen_status_ = !weights_.empty();
  for (const json& a : all.value("alarms", json::array())) {
    Alarm alarm{++last_id_,          text_in(a, "reason"),  text_in(a, "since"),
                text_in(a, "ended"), text_in(a, "seen_by"), text_in(a, "seen_at"),
                times_of(a)};
    if (!alarm.reason.empty()) alarms_.push_back(std::move(alarm));
  }
  for (const json& e : all.value("events", json::array())) {
    events_.push_back({text_in(e, "at"), text_in(e, "what"), text_in(e, "detail"), text_in(e, "by")});
  }
  make_room();
}

void Ledger::save() {
  json all{{"weights", weights_}, {"refusal", refusal_}, {"alarms", json::array()}, {"events", json::array()}};
  for (const Alarm& a : alarms_) {
    all["alarms"].push_back(
        {{"reason", a.reason}, {"since", a.since}, {"ended", a.ended}, {"seen_by", a.seen_by}, {"seen_at", a.seen_at}});
    if (a.times > 1) all["alarms"].back()["times"] = a.times;
  }
  for (const Event& e : events_) {
    all["events"].push_back({{"at", e.at}, {"what", e.what}, {"detail", e.detail}, {"by", e.by}});
  }
  const std::string text = dumped(all);
  const auto folder = hal::StorageFile::open_existing_dir(dir_.c_str());
  const hal::StoreResult<void> written =
      folder ? hal::write_file_atomically(*folder, file_name, std::as_bytes(std::span(text)))
             : hal::StoreResult<void>(tl::make_unexpected(folder.error()));
  trouble_ = written ? "" : dir_ + ": " + hal::text_of(written.error().fault);
}

void Ledger::watch(const json& status) {
  if (!status.is_object()) return;
  now_ = text_in(status, "time");
  const bool changed = follow_alarms(status);
  if (follow_weights(status) || changed) save();
}

bool Ledger::follow_alarms(const json& status) {
  std::set<std::string> active;
  bool changed = false;
  const auto raise = [&](const std::string& reason, const std::string& since) {
    if (reason.empty() || reason == "none" || !active.insert(reason).second) return;
    const auto open = [&reason](const Alarm& a) { return a.reason == reason && a.ended.empty(); };
    if (std::ranges::any_of(alarms_, open)) return;
    alarms_.push_back({++last_id_, reason, since, "", "", "", 1});
    changed = true;
  };
  const auto listed = status.find("alarms");
  if (listed != status.end() && listed->is_array()) {
    for (const json& alarm : *listed) raise(text_in(alarm, "reason"), text_in(alarm, "since"));
  }
  raise(text_in(status, "reason"), now_);  // what one decision met is there alone
  for (Alarm& a : alarms_) {
    if (!a.ended.empty() || active.contains(a.reason)) continue;
    a.ended = now_;
    changed = true;
  }
  if (changed) make_room();
  return changed;
}

bool Ledger::follow_weights(const json& status) {
  const std::string state = text_in(status, "pushed_weights"), crc = text_in(status, "pushed_crc");
  const std::string weights = state + " " + crc;
  std::string refusal = text_in(status, "pushed_refusal");
  if (refusal == "none") refusal.clear();
  if (!refusal.empty()) refusal += " (" + text_in(status, "pushed_refusal_field") + ")";
  if (has_seen_status_ && weights == weights_ && refusal == refusal_) return false;
  if (weights != weights_ && state != "none" && !state.empty()) add_event({now_, state, crc, ""});
  if (refusal != refusal_ && !refusal.empty()) add_event({now_, "refused", refusal, ""});
  weights_ = weights;
  refusal_ = refusal;
  has_seen_status_ = true;
  return true;
}

/// Two of the reason that waits most often become one, whose number is that of the newer: who has seen the older alone
/// has not seen it. False: there is no reason with two.
bool Ledger::merge_two() {
  std::map<std::string_view, std::size_t> waiting;
  for (const Alarm& a : alarms_) {
    if (a.is_waiting()) ++waiting[a.reason];
  }
  const auto most = std::ranges::max_element(waiting, {}, [](const auto& entry) { return entry.second; });
  if (most == waiting.end() || most->second < 2) return false;
  const auto is_one = [reason = std::string(most->first)](const Alarm& a) {
    return a.is_waiting() && a.reason == reason;
  };
  const auto older = std::ranges::find_if(alarms_, is_one);
  const auto newer = std::find_if(older + 1, alarms_.end(), is_one);
  newer->since = older->since;
  newer->times += older->times;
  alarms_.erase(older);
  return true;
}

/// Those that have ended and were seen go first, the oldest of them first; then what comes again and again is made one,
/// so that one sensor cannot push out what happened once.
void Ledger::make_room() {
  while (alarms_.size() > max_alarms) {
    auto at = std::ranges::find_if(alarms_, [](const Alarm& a) { return !a.ended.empty() && !a.seen_at.empty(); });
    if (at == alarms_.end() && merge_two()) continue;
    if (at == alarms_.end()) at = std::ranges::find_if(alarms_, [](const Alarm& a) { return !a.ended.empty(); });
    alarms_.erase(at == alarms_.end() ? alarms_.begin() : at);
  }
  if (events_.size() > max_events) events_.erase(events_.begin(), events_.end() - max_events);
}

bool Ledger::see(AlarmIds ids, std::string_view by, const std::string& at) {
  bool found = false;
  for (Alarm& a : alarms_) {
    if (a.id < ids.first || a.id > ids.last || !a.seen_at.empty()) continue;
    a.seen_by = by;
    a.seen_at = at;
    found = true;
  }
  if (found) save();
  return found;
}

void Ledger::add_event(Event event) {
  events_.push_back(std::move(event));
  make_room();
}

void Ledger::note(const std::string& what, const std::string& detail, const std::string& by, const std::string& at) {
  add_event({at, what, detail, by});
  save();
}

json Ledger::alarms() const {
  std::vector<const Alarm*> order;
  for (auto at = alarms_.rbegin(); at != alarms_.rend(); ++at) order.push_back(&*at);
  const auto rank = [](const Alarm* a) { return (a->ended.empty() ? 0 : 2) + (a->seen_at.empty() ? 0 : 1); };
  std::ranges::stable_sort(order, {}, rank);
  json list = json::array();
  for (const Alarm* a : order) {
    list.push_back({{"id", a->id},
                    {"reason", a->reason},
                    {"since", a->since},
                    {"ended", a->ended},
                    {"times", a->times},
                    {"seen_by", a->seen_by},
                    {"seen_at", a->seen_at}});
  }
  return {{"alarms", list}, {"kept", trouble_.empty()}};
}

json Ledger::events() const {
  json list = json::array();
  for (auto at = events_.rbegin(); at != events_.rend(); ++at) {
    list.push_back({{"at", at->at}, {"what", at->what}, {"detail", at->detail}, {"by", at->by}});
  }
  return list;
}

}  // namespace airside::page
