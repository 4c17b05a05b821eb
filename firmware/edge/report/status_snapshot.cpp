#include "firmware/edge/report/status_snapshot.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>

#include "firmware/edge/report/fixed_text.hpp"
#include "firmware/edge/report/say.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::edge {

namespace {

/// `"alarms":[{"reason":"sensor drifts","since":"2026-..."}]`, gravest numbers last.
void add_alarms(FixedText& text, CivilTime now, const StatusSnapshot& s) {
  text.add(",\"alarms\":[");
  const char* between = "";
  for (int i = 1; i < reason_count; ++i) {
    const auto reason = static_cast<Reason>(i);
    const bool lasts = s.mode_arbiter != nullptr && s.mode_arbiter->active(reason, now);
    if (!lasts && s.met != reason) continue;
    std::array<char, hal::civil_text_size> since{};
    hal::write_civil_text(since.data(), lasts ? CivilTime{s.mode_arbiter->since_s(reason)} : s.met_since);
    text.add("{}{{\"reason\":\"{}\",\"since\":\"{}\"}}", between, text_of(reason),
             std::string_view(since.data(), since.size()));
    between = ",";
  }
  text.add("]");
}

void add_rooms(FixedText& text, std::span<const double> room_temp_degc) {
  text.add(",\"room_temp_degc\":[");
  for (std::size_t i = 0; i < room_temp_degc.size(); ++i) {
    if (std::isfinite(room_temp_degc[i])) {
      text.add("{}{:.2f}", i == 0 ? "" : ",", room_temp_degc[i]);
    } else {
      text.add("{}null", i == 0 ? "" : ",");
    }
  }
  text.add("]");
}

/// `,"name":[25.31,...]`
void add_values(FixedText& text, const char* name, const CandidateRecord& record,
                const CandidateRecord::Values& values) {
  text.add(",\"{}\":[", name);
  for (int i = 0; i < record.count; ++i) {
    const auto value = static_cast<double>(values[static_cast<std::size_t>(i)]);
    text.add("{}", i == 0 ? "" : ",");
    if (std::isfinite(value)) {
      text.add("{:.5g}", value);
    } else {
      text.add("null");
    }
  }
  text.add("]");
}

/// `"candidates":{...}`, null where nothing was decided since the start.
void add_candidates(FixedText& text, const CandidateRecord* record, const Decision& decision) {
  if (record == nullptr || record->time.seconds == 0 || decision.time.seconds != record->time.seconds) {
    text.add(",\"candidates\":null");
    return;
  }
  std::array<char, hal::civil_text_size> time{};
  hal::write_civil_text(time.data(), record->time);
  text.add(",\"candidates\":{{\"time\":\"{}\"", std::string_view(time.data(), time.size()));
  text.number("from_degc", record->from_degc);
  text.number("step_k", record->step_k);
  if (record->has_network) {
    add_values(text, "network_held_degc", *record, record->network_degc);
    add_values(text, "network_score_k", *record, record->score);
  }
  if (record->has_cost) add_values(text, "cost_kw", *record, record->cost_kw);
  text.number("head_from_degc", record->head_from_degc);
  text.number("head_gain", record->head_gain);
  text.number("head_aim_degc", record->head_aim_degc);
  text.number("head_share", decision.head_share);
  text.number("schedule_share", record->schedule_share);
  text.number("proposed_degc", record->proposed_degc);
  text.number("commanded_degc", decision.command.setpoint_degc());
  text.add("}}");
}

}  // namespace

StatusFile::StatusFile(std::string dir) : path_(std::move(dir)) {}

std::size_t StatusFile::format(CivilTime now, const StatusSnapshot& s) {
  FixedText text(text_);
  std::array<char, hal::civil_text_size> time{};
  hal::write_civil_text(time.data(), now);
  text.add("{{\"time\":\"{}\"", std::string_view(time.data(), time.size()));
  text.string("site", s.site);
  text.string("topology", s.topology);
  text.add(",\"stopped\":{}", s.stopped_at.seconds != 0);
  if (s.stopped_at.seconds != 0) hal::write_civil_text(time.data(), s.stopped_at);
  text.string("stopped_at",
              s.stopped_at.seconds != 0 ? std::string_view(time.data(), time.size()) : std::string_view{});
  if (s.first_row.seconds != 0) hal::write_civil_text(time.data(), s.first_row);
  text.string("first_row", s.first_row.seconds != 0 ? std::string_view(time.data(), time.size()) : std::string_view{});
  text.string("state", text_of(s.control_mode.mode));
  text.string("reason", text_of(s.control_mode.reason));
  text.string("why", why_of(s.control_mode));
  std::array<char, hal::civil_text_size> ends{};
  const bool has_end = s.release_ends.seconds != 0 && s.control_mode.reason == Reason::released_by_hand;
  if (has_end) {
    hal::write_civil_text(ends.data(), s.release_ends);
    text.add(",\"way_out\":\"ends at {}, or when it is handed back\"", std::string_view(ends.data(), ends.size()));
  } else if (s.control_mode.reason == Reason::storage_failed && !s.storage_remedy.empty()) {
    text.add(",\"way_out\":\"ends with the first write that succeeds; {}\"", s.storage_remedy);
  } else {
    text.string("way_out", way_out_of(s.control_mode));
  }
  text.string("release_ends", std::string_view(ends.data(), has_end ? ends.size() : 0));
  add_alarms(text, now, s);
  text.string("fault", text_of(s.fault));
  text.string("fault_signal", s.fault_signal);
  text.add(",\"has_weights\":{}", s.has_weights);
  text.number("target_degc", s.target_degc);
  text.number("room_mean_degc", s.room_mean_degc);
  text.string("hold", text_of(s.hold));
  text.number("held_degc", s.held_degc);
  add_rooms(text, s.room_temp_degc);
  text.number("setpoint_degc", s.setpoint_degc);
  text.number("network_setpoint_degc", s.decision.network_degc);
  text.number("head_setpoint_degc", s.decision.head_degc);
  text.number("expert_setpoint_degc", s.decision.expert_degc);
  text.number("g36_setpoint_degc", s.decision.g36_degc);
  text.number("mean_error_k", s.ours_error_k);
  text.number("schedule_mean_error_k", s.schedule_error_k);
  text.string("objective", s.serves_band ? "band" : "mean");
  if (s.serves_band) {
    text.count("band_cycles", s.band_cycles);
    text.count("band_ready_cycles", s.band_ready_cycles);
    text.number("warmest_zone_above_setpoint_k", s.warmest_above_k);
    text.number("most_open_damper", s.most_open_damper);
  }
  add_candidates(text, s.candidates, s.decision);
  text.number("confidence", s.decision.confidence);
  text.number("expected_held_degc", s.decision.expected_degc);
  text.number("expected_room_mean_degc", s.hold == HoldRule::mean ? s.decision.expected_degc : Decision::none);
  text.number("expected_error_k", s.decision.expected_error_k);
  text.number("residual_forecast_k", s.decision.residual_k);
  text.number("residual_share", s.decision.residual_share);
  text.count("cycles", s.cycles);
  text.count("rejected_updates", s.rejected_updates);
  text.count("replay_transitions", s.replay_transitions);
  text.count("generation", s.generation);
  std::array<char, hal::civil_text_size> lost{};
  if (s.lost_until.seconds != 0) hal::write_civil_text(lost.data(), s.lost_until);
  text.string("lost_until", std::string_view(lost.data(), s.lost_until.seconds != 0 ? lost.size() : 0));
  text.string("pushed_weights", s.trial);
  text.add(",\"pushed_crc\":\"{:08x}\"", s.pushed_crc);
  text.string("pushed_refusal", s.trial_refusal);
  text.string("pushed_refusal_field", s.trial_refusal_field);
  text.string("storage", s.storage);
  text.string("clock", s.clock);
  text.number("row_late_ms", s.row_late_ms);
  text.number("row_done_ms", s.row_done_ms);
  text.count("link_timeouts", s.link_timeouts);
  text.count("link_bad_frames", s.link_bad_frames);
  text.count("link_wrong_ids", s.link_wrong_ids);
  text.count("link_exceptions", s.link_exceptions);
  text.count("setpoint_writes", s.setpoint_writes);
  text.add("}}\n");
  return text.fits() ? text.size() : 0;
}

hal::StoreResult<void> StatusFile::clear(int dir, const char* name) {
  struct stat status {};
  if (::fstatat(dir, name, &status, AT_SYMLINK_NOFOLLOW) != 0) {
    if (errno == ENOENT) return {};
    return tl::make_unexpected(hal::store_error(errno, "look at status"));
  }
  if (S_ISREG(status.st_mode)) return {};
  if (S_ISDIR(status.st_mode)) return tl::make_unexpected(hal::store_error(EISDIR, "replace status"));
  if (::unlinkat(dir, name, 0) != 0) return tl::make_unexpected(hal::store_error(errno, "replace status"));
  cleared_ = true;
  return {};
}

hal::StoreResult<void> StatusFile::stage(int dir, const char* name, std::span<const std::byte> bytes) {
  const auto file = hal::StorageFile::open(dir, name, true, "open status");
  if (!file) return tl::make_unexpected(file.error());
  if (const auto done = file->write_at(bytes, 0, "write status"); !done) return done;
  return file->truncate(bytes.size(), "cut status");
}

hal::StoreResult<void> StatusFile::write(CivilTime now, const StatusSnapshot& status) {
  if (path_.empty()) return {};
  const auto written = replace(now, status);
  if (cleared_) say("a link, a pipe or a device was at status.json in {}; it was taken away", path_);
  const hal::StoreFault failure = written ? hal::StoreFault::none : written.error().fault;
  if (!written && failure != failure_) {
    say("status cannot be written: {} ({}); look into {}", hal::text_of(failure), written.error().step, path_);
  }
  failure_ = failure;
  return written;
}

hal::StoreResult<void> StatusFile::replace(CivilTime now, const StatusSnapshot& status) {
  constexpr const char* name = "status.json";
  cleared_ = false;
  // Each time: a folder that was made anew or mounted later is the one that people look into.
  const auto folder = hal::StorageFile::open_dir(path_.c_str());
  if (!folder) return tl::make_unexpected(folder.error());
  const int dir = folder->descriptor();
  const std::size_t size = format(now, status);
  if (size == 0) return tl::make_unexpected(hal::StoreError{hal::StoreFault::wrong_size, 0, "format status"});
  if (const auto done = clear(dir, name); !done) return done;
  const char* staged = "status.json.new";
  const auto free = clear(dir, staged);
  if (!free) staged = "status.json.other";  // the status must say so, and not stop
  if (const auto done = stage(dir, staged, std::as_bytes(std::span(text_.data(), size))); !done) return done;
  // The two files change places, so that each keeps its block: a full disk does not silence the status.
  if (::renameat2(dir, staged, dir, name, RENAME_EXCHANGE) != 0 && ::renameat(dir, staged, dir, name) != 0) {
    return tl::make_unexpected(hal::store_error(errno, "rename status"));
  }
  return free;
}

}  // namespace airside::edge
