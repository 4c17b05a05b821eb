#include "fault_matrix/fault_loop.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "airside/controller/history.hpp"
#include "hal/points/signal_limits.hpp"
#include "hal/weights/blob_file.hpp"
#include "support/blob_maker.hpp"
#include "support/default_cycle.hpp"
#include "tools/run/training/transfer.hpp"

namespace airside::fault_matrix {

namespace {
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

tools::Trial trial_of(const std::string& room, std::uint64_t seed) {
  tools::PlantChoice plant;
  plant.kind = "rc";
  plant.room = room;
  plant.seed = seed;
  plant.start = "2021-08-01";
  tools::Trial trial{tools::built_in_site(), plant, 5, 300};
  trial.site.file.scope = "Room 301";
  return trial;
}

}  // namespace

PreparedRoom::PreparedRoom(int steps, const std::string& room, std::uint64_t seed)
    : trial(trial_of(room, seed)),
      begun(tools::prepare(trial)),
      controller(std::make_unique<Controller<T>>()),
      key(hal::make_key("Ann")),
      folder("fault_loop_" + std::to_string(seed)) {
  tools::FineTuneOptions options;
  options.steps = steps;
  options.seed = seed;
  const tools::BlobBytes blob = tools::fine_tune(trial.site, {}, begun.history, options);
  controller->configure(trial.site.settings, hal::signal_limits<T>(trial.site.points), hal::box_kernels(), seed);
  const auto payload = std::make_unique<WeightBlob<T>::Payload>();
  hal::decode_blob<T>(blob, trial.site.file.scope, "fine-tuned", *payload);
  take_payload<T>(*controller, *payload);
  HistoryReader<T> reader(*controller, HistoryReader<T>::Head::leave);
  for (const hal::LogRow& row : begun.history) {
    reader.row(row.time, Eigen::Map<const Reading<T>::Vector>(row.value.data()), row.setpoint_degc);
  }
  std::filesystem::create_directories(folder.file("keys"));
  std::ofstream(folder.file("keys") / "ann.pub") << hal::public_key_text(key.open);
}

const PreparedRoom& prepared_room() {
  static const PreparedRoom room;
  return room;
}

// ---- What run_cycles() drives
struct FaultLoop::Bus {
  FaultLoop& loop;
  Expected<Reading<T>> sense() { return loop.sense(); }
  Expected<Applied> actuate(const Command& command) { return loop.actuate(command); }
};

struct FaultLoop::Clock {
  FaultLoop& loop;
  CivilTime now() { return loop.box_time(); }
  bool sleep_until(CivilTime t) {
    if (const Running* sleep = loop.find(LoopFault::asleep)) {
      const auto awake_s = static_cast<std::int64_t>(sleep->until_h * 3600);
      loop.model_->advance_to({(awake_s + 359) / 360 * 360});
    }
    const CivilTime then{t.seconds - loop.clock_off_s()};
    if (loop.model_->time() < then) loop.model_->advance_to(then);
    return true;
  }
  CivilTime woke() { return loop.box_time(); }
};

struct FaultLoop::Sink {
  FaultLoop& loop;
  bool row(CivilTime t, const Expected<Reading<T>>&, const Controller<T>&) { return loop.row(t); }
};

FaultLoop::FaultLoop(const PreparedRoom& prepared)
    : prepared_(prepared),
      plant_(std::make_unique<sim::RcPlant>(dynamic_cast<const sim::RcPlant&>(*prepared.begun.model))),
      model_(std::make_unique<sim::FaultyModel>(*plant_, sim::FaultScript{})),
      registers_(std::make_unique<sim::SimulatedPlant<T>>(*model_, prepared.trial.site.points)),
      controller_(std::make_unique<Controller<T>>(*prepared.controller)),
      folder_(prepared.folder.file("box" + std::to_string(prepared.loops++))),
      next_(next_row(plant_->time())),
      seen_standing_degc_(model_->standing_degc()) {
  std::filesystem::create_directories(folder_ / "inbox");
  trial_ = std::make_unique<edge::WeightsTrial<T>>(prepared.folder.file("keys").string(), (folder_ / "inbox").string(),
                                                   folder_.string(), 5, hal::Sync::none, "Room 301");
  trial_->open_inbox();
  trial_->join_counters(record_, true);
  pushed_ = controller_->replay().total_pushed();
  controller_->prepare();
}

void FaultLoop::cycles(int count) {
  cycles_left_ = count;
  Bus bus{*this};
  Clock clock{*this};
  Sink sink{*this};
  // As run_cycles() itself follows a clock that was set.
  const CivilTime now = next_row(clock.now());
  if (now < next_ && next_.seconds - now.seconds > cycle_s) next_ = now;
  if (next_ < now) next_ = now;
  next_ = run_cycles<T>(bus, clock, *controller_, sink, next_, CivilTime{std::numeric_limits<std::int64_t>::max()});
}

void FaultLoop::in_hours(double hours_from_now, std::function<void()> what) {
  due_.emplace_back(hours() + hours_from_now, std::move(what));
}

void FaultLoop::begin(sim::FaultKind kind, double for_h, int signal, double magnitude) {
  model_->begin(kind, for_h, signal, magnitude);
}

void FaultLoop::begin(LoopFault fault, double for_h, int signal, double magnitude) {
  if (fault == LoopFault::disk_fails && !before_disk_failed_) {
    before_disk_failed_ = present();
  }
  running_.push_back({fault, hours() + for_h, signal, magnitude});
}

void FaultLoop::restart(const Saved& from) {
  const Saved kept = from;  // it may be one that a later row replaces
  *controller_ = *kept.controller;
  record_ = kept.record;
  (void)airside::restart(*controller_);
  pushed_ = controller_->replay().total_pushed();
  // A new process counts its own connections, and has no mail in hand.
  contact_ = 1;
  trial_ = std::make_unique<edge::WeightsTrial<T>>(prepared_.folder.file("keys").string(), (folder_ / "inbox").string(),
                                                   folder_.string(), 5, hal::Sync::none, "Room 301");
  trial_->open_inbox();
  trial_->join_counters(record_, true);
}

void FaultLoop::kill(bool from_older) {
  if (from_older && older_) return restart(*older_);
  if (has(LoopFault::disk_fails)) return restart(*before_disk_failed_);
  restart(present());
}

void FaultLoop::lose_state() {
  restart({std::make_shared<Controller<T>>(*prepared_.controller), {}});
  CycleState<T>& cycle = inside(*controller_).cycle = CycleState<T>();
  cycle.has_weights = 1;
  cycle.validator = Validator<T>(controller_->limits(), controller_->settings());
  (void)airside::restart(*controller_);
  controller_->hold(Reason::state_lost, box_time(), 0);
}

void FaultLoop::push(const Push& how) {
  const std::uint64_t counter = how.old_counter ? counter_ : ++counter_;
  Bytes bytes = weights::blob_of<T>(*controller_, [&](Payload& payload) {
    for (float& w : payload.weights) w *= how.factor;
    if (how.payload) how.payload(payload);
  });
  if (how.header) {
    BlobHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    how.header(header);
    std::memcpy(bytes.data(), &header, sizeof header);
  }
  bytes = weights::signed_by(bytes, how.by_a_stranger ? hal::make_key("stranger") : prepared_.key, counter);
  if (how.bytes) how.bytes(bytes);
  std::ofstream out(folder_ / "inbox" / "weights.blob", std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void FaultLoop::clear() {
  running_.clear();
  due_.clear();
  before_disk_failed_.reset();
  model_->clear();
}

double FaultLoop::take_dae_k() {
  const double dae = error_count_ > 0 ? error_sum_k_ / error_count_ : 0;
  error_sum_k_ = 0;
  error_count_ = 0;
  return dae;
}

const FaultLoop::Running* FaultLoop::find(LoopFault fault) const {
  for (const Running& r : running_) {
    if (r.fault == fault && hours() < r.until_h) return &r;
  }
  return nullptr;
}

std::int64_t FaultLoop::clock_off_s() const {
  const Running* off = find(LoopFault::clock_off);
  return off == nullptr ? 0 : static_cast<std::int64_t>(off->magnitude * 20) * 180;
}

Expected<Reading<T>> FaultLoop::sense() {
  if (has(LoopFault::other_device)) return tl::unexpected(Fault::other_device);
  const bool fails = has(LoopFault::answers_fail);
  if (fails) ++contact_;
  if (has(LoopFault::no_answer) || (fails && rows_ % 2 == 0)) {
    ++contact_;
    return tl::unexpected(Fault::no_reading);
  }
  Expected<Reading<T>> reading = registers_->sense();
  reading->contact = contact_;
  if (const Running* r = find(LoopFault::register_refused)) reading->value(r->signal) = nan;
  if (const Running* r = find(LoopFault::stale)) reading->age_s(r->signal) = r->magnitude;
  if (has(LoopFault::write_only)) reading->setpoint_degc = nan;
  // A device that repeats itself may show another setpoint than stands.
  const bool shows = std::abs(reading->setpoint_degc - model_->standing_degc()) < 0.02;
  if (std::isfinite(reading->setpoint_degc)) seen_standing_degc_ = shows ? model_->standing_degc() : nan;
  return reading;
}

Expected<Applied> FaultLoop::actuate(const Command& command) {
  if (has(LoopFault::other_device)) return tl::unexpected(Fault::other_device);
  if (has(LoopFault::no_answer)) return tl::unexpected(Fault::not_applied);
  look_at_write(command.setpoint_degc());
  if (has(LoopFault::write_refused)) return tl::unexpected(Fault::write_refused);
  const Expected<Applied> applied = registers_->actuate(command);
  // Where it cannot be read, nobody sees what the AHU made of it.
  seen_standing_degc_ = has(LoopFault::write_only) && applied ? applied->setpoint_degc : model_->standing_degc();
  if (has(LoopFault::late_confirmation)) return tl::unexpected(Fault::not_applied);
  if (has(LoopFault::write_only)) return applied;
  return Applied{model_->standing_degc()};
}

void FaultLoop::complain(std::uint64_t& count, const std::string& what) {
  ++count;
  if (watchman_.first.empty()) watchman_.first = fmt::format("cycle {}: {}", watchman_.cycles, what);
}

void FaultLoop::look_at_write(double a) {
  const ControllerSettings& s = controller_->settings();
  ++watchman_.writes;
  if (!std::isfinite(a)) return complain(watchman_.not_finite, "a setpoint that is no number");
  // Outside the limits only on the way back from further outside.
  const bool way_in =
      (seen_standing_degc_ < a && a < s.limit_min_degc) || (seen_standing_degc_ > a && a > s.limit_max_degc);
  if (!way_in && (a < s.limit_min_degc || a > s.limit_max_degc)) {
    complain(watchman_.outside, fmt::format("{} degC", a));
  }
  if (controller_->decision().mode == ControlMode::release) complain(watchman_.while_released, "a write in RELEASE");
  // Somebody may have moved the register since it was last seen; nobody can know his step.
  const double standing = model_->standing_degc();
  if (standing != seen_standing_degc_) return;
  const double resolution = 0.011;
  if (std::abs(a - standing) > s.limit_change_k + resolution) {
    complain(watchman_.beyond_a_step, fmt::format("{} degC on {}", a, standing));
  }
}

void FaultLoop::look_at_memory() {
  const auto& learning = controller_->learning();
  if (!all_finite(learning.weights)) complain(watchman_.weights_broken, "weights are not finite");
  const std::uint64_t pushed = controller_->replay().total_pushed();
  if (pushed == pushed_) return;
  pushed_ = pushed;
  const auto& row = controller_->replay().newest(0);
  const Eigen::Map<const Eigen::Matrix<float, L::transition, 1>> x(row.data());
  for (const int part : {0, L::transition - L::signals}) {
    for (int i = 0; i < L::signals; ++i) {
      const double v = static_cast<double>(x(part + i)) * learning.scaler.scale(i) + learning.scaler.mean(i);
      const SignalLimits& limits = controller_->limits()[static_cast<std::size_t>(i)];
      const double slack = 1e-3 * (limits.max - limits.min);
      if (!(v >= limits.min - slack && v <= limits.max + slack)) {
        return complain(watchman_.learned_bad, fmt::format("signal {} remembered as {}", i, v));
      }
    }
  }
}

bool FaultLoop::row(CivilTime t) {
  ++rows_;
  controller_->report(Reason::map_differs, has(LoopFault::other_device), t);
  controller_->report(Reason::clock_not_set, has(LoopFault::clock_not_set), t);
  (void)trial_->row(t, *controller_, record_);
  const bool saves = !has(LoopFault::disk_fails);
  if (saves) trial_->committed();
  controller_->report(Reason::storage_failed, !saves, t);
  if (saves) before_disk_failed_.reset();
  if (starts_cycle(t)) {
    ++watchman_.cycles;
    look_at_memory();
    setpoint_degc.push_back(model_->standing_degc());
    gravest_ = std::max(gravest_, decision().mode);
    if (in_working_hours(controller_->settings(), {t})) {
      const auto& room = plant_->sensors().room_temp_degc;
      double mean = 0;
      for (const double s : room) mean += s / static_cast<double>(room.size());
      error_sum_k_ += std::abs(mean - controller_->settings().target_degc);
      ++error_count_;
    }
    if (saves && watchman_.cycles % 10 == 0) older_ = present();
    --cycles_left_;
  }
  ++reason_rows_[static_cast<std::size_t>(decision().reason)];
  for (std::size_t i = 0; i < due_.size();) {
    if (hours() + 0.05 < due_[i].first) {
      ++i;
      continue;
    }
    const auto what = std::move(due_[i].second);
    due_.erase(due_.begin() + static_cast<std::ptrdiff_t>(i));
    what();
  }
  return cycles_left_ > 0;
}

// ---- The matrix
namespace {

double hours_of(SplitMix64& draw, double longest = 10) { return 0.2 + draw.uniform() * longest; }
int any_signal(SplitMix64& draw) { return static_cast<int>(draw.below(static_cast<std::uint32_t>(L::signals))); }
int any_room(SplitMix64& draw) { return static_cast<int>(draw.below(static_cast<std::uint32_t>(L::rooms))); }
double sign(SplitMix64& draw) { return draw.below(2) == 0 ? -1.0 : 1.0; }

template <sim::FaultKind kind>
double on_signal(FaultLoop& loop, SplitMix64& draw) {
  const double h = hours_of(draw);
  const double wide = std::pow(10.0, 1 + 6 * draw.uniform()) * sign(draw);
  loop.begin(kind, h, any_signal(draw), wide);
  return h;
}

template <LoopFault fault>
double for_a_while(FaultLoop& loop, SplitMix64& draw) {
  const double h = hours_of(draw);
  loop.begin(fault, h, any_signal(draw), 2000 + 1e5 * draw.uniform());
  return h;
}

/// One exchange in a while is lost: what late, foreign, broken and repeated answers come to.
double lost_now_and_then(FaultLoop& loop, SplitMix64& draw) {
  const double h = hours_of(draw);
  for (double at = 0; at < h; at += 0.1 + draw.uniform()) {
    const bool late = draw.below(3) == 0;
    loop.in_hours(at, [&loop, late] { loop.begin(late ? LoopFault::late_confirmation : LoopFault::no_answer, 0.1); });
  }
  return h;
}

double hand(FaultLoop& loop, SplitMix64& draw) {
  loop.begin(sim::FaultKind::setpoint_by_hand, 0, -1, 10 + 25 * draw.uniform());
  return 4;
}

double truncated_push(FaultLoop& loop, SplitMix64& draw) {
  const std::uint64_t at = draw.next();
  loop.push({.bytes = [at](FaultLoop::Bytes& bytes) { bytes.resize(at % bytes.size()); }});
  return 0.2;
}

/// Signed by the right key, on a machine of other bytes or numbers.
double push_of_another_machine(FaultLoop& loop, SplitMix64& draw) {
  const bool order = draw.below(2) == 0;
  loop.push({.header = [order](BlobHeader& header) {
    if (order) header.endian_mark = 0x04030201;
    if (!order) header.float_mark = -header.float_mark;
  }});
  return 0.2;
}

/// Signed by the right key, and meant for others.
double push_for_another_room(FaultLoop& loop, SplitMix64& draw) {
  const std::uint32_t which = draw.below(3);
  loop.push({.header = [which](BlobHeader& header) {
    if (which == 0) header.topology_hash ^= 1;
    if (which == 1) header.units_hash ^= 1;
    if (which == 2) header.site_scope = {'e', 'l', 's', 'e', 'w', 'h', 'e', 'r', 'e'};
  }});
  return 0.2;
}

double wild_push(FaultLoop& loop, SplitMix64& draw) {
  if (draw.below(2) == 0) {
    loop.push({.factor = static_cast<float>(std::pow(10.0, 0.05 + 3 * draw.uniform()) * sign(draw))});
    return 24.0;
  }
  const double k = sign(draw) * std::pow(10.0, 2 * draw.uniform());
  const std::uint64_t seed = draw.next();
  // A young room takes the head too.
  inside(loop.controller()).learning.head.set_updates(1);
  loop.push({.payload = [k, seed](FaultLoop::Payload& payload) {
    SplitMix64 each(seed);
    for (double& theta : payload.head_theta) theta += k * each.symmetric();
  }});
  return 24.0;
}

constexpr std::array<MatrixRow, 60> rows = {{
    {1, "NaN, Inf, sentinel", on_signal<sim::FaultKind::not_a_number>},
    {2, "out of range", on_signal<sim::FaultKind::set_to>},
    {3, "jump",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       loop.begin(sim::FaultKind::offset, h, any_room(draw), sign(draw) * (2 + 10 * draw.uniform()));
       return h;
     }},
    {4, "stuck",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw, 40);
       loop.begin(sim::FaultKind::stuck, h, any_room(draw));
       return h;
     }},
    {5, "stale", for_a_while<LoopFault::stale>},
    {6, "sensors disagree",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw), k = sign(draw) * (8 + 10 * draw.uniform());
       const int first = any_room(draw);
       loop.begin(sim::FaultKind::offset, h, first, k);
       if (draw.below(2) == 0) loop.begin(sim::FaultKind::offset, h, (first + 1) % L::rooms, -k);
       return h;
     }},
    {7, "slow drift",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = 24 + hours_of(draw, 72);
       loop.begin(sim::FaultKind::drift, h, any_room(draw), sign(draw) * (0.3 + 2 * draw.uniform()));
       return h;
     }},
    {8, "exception 1", for_a_while<LoopFault::no_answer>},
    {9, "exception 2", for_a_while<LoopFault::register_refused>},
    {10, "exception 3", for_a_while<LoopFault::register_refused>},
    {11, "exception 4", for_a_while<LoopFault::answers_fail>},
    {12, "exceptions 5, 6", lost_now_and_then},
    {13, "exceptions 10, 11, unknown", for_a_while<LoopFault::no_answer>},
    {14, "half-open", for_a_while<LoopFault::no_answer>},
    {15, "RST, restart",
     [](FaultLoop& loop, SplitMix64& draw) {
       loop.begin(LoopFault::no_answer, 0.1 + draw.uniform());
       loop.begin(sim::FaultKind::restarted, 0, -1, 20 + 6 * draw.uniform());
       return 1.0;
     }},
    {16, "late, duplicate", lost_now_and_then},
    {17, "wrong unit, protocol", lost_now_and_then},
    {18, "short, long, trickled", lost_now_and_then},
    {19, "RTU noise", lost_now_and_then},
    {20, "map mismatch", for_a_while<LoopFault::other_device>},
    {21, "word swap",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       loop.begin(sim::FaultKind::set_to, h, L::power, draw.below(2) == 0 ? 1e-39 : -3e17);
       return h;
     }},
    {22, "write rejected", for_a_while<LoopFault::write_refused>},
    {23, "write clamped",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       loop.begin(sim::FaultKind::setpoint_clamped, h, -1, 18 + 8 * draw.uniform());
       return h;
     }},
    {24, "another hand", hand},
    {25, "two masters",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw, 30);
       loop.begin(sim::FaultKind::setpoint_fought, h, -1, 15 + 15 * draw.uniform());
       return h;
     }},
    {26, "write-only register", for_a_while<LoopFault::write_only>},
    {27, "setpoint ignored",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       loop.begin(sim::FaultKind::setpoint_ignored, h);
       return h;
     }},
    {28, "clock jumps",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       loop.begin(LoopFault::clock_off, h, 0, 60 * draw.symmetric());
       return h;
     }},
    {29, "daylight saving",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       loop.begin(LoopFault::clock_off, h, 0, sign(draw));
       return h;
     }},
    {30, "clock of 1970", for_a_while<LoopFault::clock_not_set>},
    {31, "suspend", for_a_while<LoopFault::asleep>},
    {32, "disk full", for_a_while<LoopFault::disk_fails>},
    {33, "read-only disk",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       loop.begin(LoopFault::disk_fails, h);
       loop.in_hours(0.9 * h, [&loop] { loop.kill(); });
       return h;
     }},
    {34, "torn write",
     [](FaultLoop& loop, SplitMix64&) {
       loop.kill(true);
       return 0.1;
     }},
    {35, "reordered writes",
     [](FaultLoop& loop, SplitMix64&) {
       loop.kill(true);
       return 0.1;
     }},
    {36, "slot rot",
     [](FaultLoop& loop, SplitMix64&) {
       loop.kill(true);
       return 0.1;
     }},
    {37, "both slots bad",
     [](FaultLoop& loop, SplitMix64&) {
       loop.lose_state();
       return 0.1;
     }},
    {38, "generations differ",
     [](FaultLoop& loop, SplitMix64&) {
       loop.kill(true);
       return 0.1;
     }},
    {39, "kill -9",
     [](FaultLoop& loop, SplitMix64&) {
       loop.kill();
       return 0.1;
     }},
    {40, "out of memory", nullptr},
    {41, "crash loop",
     [](FaultLoop& loop, SplitMix64& draw) {
       for (double at = 0; at < 0.5 + draw.uniform(); at += 0.1) loop.in_hours(at, [&loop] { loop.kill(); });
       loop.controller().hold(Reason::crash_loop, loop.box_time(), 3600);
       return 2.0;
     }},
    {42, "control starved", for_a_while<LoopFault::asleep>},
    {43, "descriptor leak", nullptr},
    {44, "blob truncated", truncated_push},
    {45, "blob of another machine", push_of_another_machine},
    {46, "blob of another topology", push_for_another_room},
    {47, "blob replayed",
     [](FaultLoop& loop, SplitMix64&) {
       loop.push({.old_counter = true});
       return 0.2;
     }},
    {48, "unknown key",
     [](FaultLoop& loop, SplitMix64&) {
       loop.push({.by_a_stranger = true});
       return 0.2;
     }},
    {49, "wild weights", wild_push},
    {50, "power cut in an install",
     [](FaultLoop& loop, SplitMix64& draw) {
       loop.push({.factor = 0.9F + 0.2F * static_cast<float>(draw.uniform())});
       loop.in_hours(0.1 * draw.below(4), [&loop] { loop.kill(); });
       return 24.0;
     }},
    {51, "loss NaN, gradient explosion",
     [](FaultLoop& loop, SplitMix64& draw) {
       auto& moments = inside(loop.controller()).learning.learner.first_moment();
       const float bad = draw.below(2) == 0 ? std::numeric_limits<float>::quiet_NaN() : 1e30F;
       moments.values[draw.below(static_cast<std::uint32_t>(moments.values.size()))] = bad;
       return 1.0;
     }},
    {52, "worse than the schedule",
     [](FaultLoop& loop, SplitMix64& draw) {
       auto& theta = inside(loop.controller()).learning.head.theta();
       for (int i = 0; i < theta.size(); ++i) theta(i) += 3 * draw.symmetric();
       return 24.0;
     }},
    {53, "poisoned, repeated data",
     [](FaultLoop& loop, SplitMix64& draw) {
       const double h = hours_of(draw);
       if (draw.below(2) == 0) {
         loop.begin(sim::FaultKind::all_stuck, h);
       } else {
         loop.begin(sim::FaultKind::all_offset, h, -1, 5 * draw.symmetric());
       }
       return h;
     }},
    {54, "HTTP flood", nullptr},
    {55, "oversized body", nullptr},
    {56, "traversal", nullptr},
    {57, "script in a name", nullptr},
    {58, "forged request", nullptr},
    {59, "hostile file", nullptr},
    {60, "two daemons", nullptr},
}};

}  // namespace

const std::array<MatrixRow, 60>& matrix_rows() { return rows; }

}  // namespace airside::fault_matrix
