#include "tools/gap/surrogate/surrogate_engine.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "hal/storage/digest64.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

constexpr double farthest = 1.5;   // of what was learned
constexpr double same_size = 0.8;  // of another, or over it: the later run takes the earlier one's place

/// Of commands, hours and weather; heat that is added to a zone is the RC room's matter.
std::uint64_t key_of(const sim::Recording& recording) {
  std::vector<double> all{static_cast<double>(recording.from.seconds), static_cast<double>(recording.rows.size())};
  for (const sim::LaterStretch& stretch : recording.later) {
    all.push_back(static_cast<double>(stretch.row));
    all.push_back(static_cast<double>(stretch.from.seconds));
  }
  for (const sim::RecordedRow& row : recording.rows) {
    all.insert(all.end(), {row.setpoint_degc, row.outdoor_temp_degc, row.rain});
    all.insert(all.end(), row.vav_on.begin(), row.vav_on.end());
    all.insert(all.end(), row.fcu_on.begin(), row.fcu_on.end());
  }
  return hal::digest64(std::as_bytes(std::span(all)));
}

/// Duties as their means over the days, by 3 h of the day: when a thermostat switches is another chance in each run.
void smooth_duties(sim::ChannelTable& lack, Eigen::Index fcus) {
  constexpr Eigen::Index blocks = 8, rows_per_block = rows_per_day / blocks;
  for (Eigen::Index block = 0; block < blocks; ++block) {
    const auto in_block = [&](Eigen::Index row) { return row % rows_per_day / rows_per_block == block; };
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(fcus);
    Eigen::Index count = 0;
    for (Eigen::Index row = 0; row < lack.rows(); ++row) {
      if (!in_block(row)) continue;
      sum += lack.row(row).tail(fcus);
      ++count;
    }
    for (Eigen::Index row = 0; row < lack.rows(); ++row)
      if (in_block(row)) lack.row(row).tail(fcus) = sum / static_cast<double>(count);
  }
}

double offset_of(const sim::EffectChange& change) { return change.magnitude - change.at.effect->null_value; }

std::map<std::string, double> offsets_of(const Changes& changes, double sign, std::map<std::string, double> sum) {
  for (const sim::EffectChange& c : changes) sum[c.at.id()] += sign * offset_of(c);
  return sum;
}

}  // namespace

SurrogateEngine::SurrogateEngine(const Engine& model, sim::RcRoom room)
    : ForwardingEngine(model), rc_(std::move(room)), room_(rc_) {}

std::pair<Changes, Changes> SurrogateEngine::divided(const Changes& changes) const {
  std::pair<Changes, Changes> parts;
  for (const sim::EffectChange& c : changes) (only_shows(*c.at.effect) ? parts.second : parts.first).push_back(c);
  return parts;
}

SurrogateEngine::Known& SurrogateEngine::known(const sim::Recording& recording) const {
  const std::lock_guard lock(mutex_);
  std::unique_ptr<Known>& at = known_[key_of(recording)];
  if (!at) {
    auto made = std::make_unique<Known>();
    made->lack = engine().simulate({}, recording) - room_.simulate({}, recording);
    at = std::move(made);
  }
  return *at;
}

const std::vector<SurrogateEngine::Learned>* SurrogateEngine::find(const Known& at, const std::string& id,
                                                                   double offset) {
  const auto& side = offset > 0 ? at.up : at.down;
  const auto found = side.find(id);
  return offset == 0 || found == side.end() ? nullptr : &found->second;
}

sim::ChannelTable SurrogateEngine::lack_at(const std::vector<Learned>& sizes, double offset) {
  const auto beyond =
      std::ranges::find_if(sizes, [offset](const Learned& size) { return std::abs(size.offset) >= std::abs(offset); });
  if (beyond == sizes.begin()) return offset / beyond->offset * beyond->lack;
  const Learned& within = *std::prev(beyond);
  if (beyond == sizes.end()) return std::min(farthest, offset / within.offset) * within.lack;
  const double way = (offset - within.offset) / (beyond->offset - within.offset);
  return (1 - way) * within.lack + way * beyond->lack;
}

sim::ChannelTable SurrogateEngine::corrected(sim::ChannelTable table, const Changes& lived, const Changes& shown,
                                             const sim::Recording& recording) const {
  const Known& at = known(recording);
  table += at.lack;
  for (const auto& [id, offset] : offsets_of(lived, 1, offsets_of(at.anchor, -1, {}))) {
    if (const auto* sizes = find(at, id, offset)) table += lack_at(*sizes, offset);
  }
  auto duties = table.rightCols(channels().fcus);
  duties = (duties.array() < 0).select(0.0, (duties.array() > 1).select(1.0, duties));
  return shown.empty() ? table : sim::changed_sensors(std::move(table), channels(), shown);
}

sim::ChannelTable SurrogateEngine::simulate(const Changes& changes, const sim::Recording& recording) const {
  const auto [lived, shown] = divided(changes);
  return corrected(room_.simulate(lived, recording), lived, shown, recording);
}

sim::ChannelTable SurrogateEngine::simulate_differing(std::uint64_t seed, const Changes& changes,
                                                      const sim::Recording& recording) const {
  const auto [lived, shown] = divided(changes);
  return corrected(room_.simulate_differing(seed, lived, recording), lived, shown, recording);
}

void SurrogateEngine::anchor(const Changes& at, const sim::Recording& recording) {
  Known& here = known(recording);
  here.anchor = divided(at).first;
  here.lack = engine().simulate(here.anchor, recording) - room_.simulate(here.anchor, recording);
}

void SurrogateEngine::learn(const std::vector<sim::EffectChange>& changes, const sim::Recording& recording, int jobs) {
  Known& here = known(recording);
  std::vector<Learned> learned(changes.size());
  in_parallel(changes.size(), jobs, [&](std::size_t i) {
    Changes with = here.anchor;
    with.push_back(changes[i]);
    learned[i] = {offset_of(changes[i]),
                  engine().simulate(with, recording) - room_.simulate(with, recording) - here.lack};
    smooth_duties(learned[i].lack, channels().fcus);
  });
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const double offset = learned[i].offset;
    auto& sizes = (offset > 0 ? here.up : here.down)[changes[i].at.id()];
    std::erase_if(sizes, [offset](const Learned& size) {
      const double share = size.offset / offset;
      return share > same_size && share < 1 / same_size;
    });
    const auto after =
        std::ranges::find_if(sizes, [offset](const Learned& size) { return std::abs(size.offset) > std::abs(offset); });
    sizes.insert(after, std::move(learned[i]));
  }
}

double SurrogateEngine::learned(const sim::EffectChange& change, const sim::Recording& recording) const {
  const auto* sizes = find(known(recording), change.at.id(), offset_of(change));
  if (sizes == nullptr) return 0;
  const auto share = [&change](const Learned& size) { return size.offset / offset_of(change); };
  return share(
      *std::ranges::min_element(*sizes, {}, [&share](const Learned& size) { return std::abs(std::log(share(size))); }));
}

sim::ChannelTable SurrogateEngine::added_response(const sim::EffectChange& change,
                                                  const sim::Recording& recording) const {
  const auto* sizes = find(known(recording), change.at.id(), offset_of(change));
  return sizes == nullptr ? sim::ChannelTable{} : lack_at(*sizes, offset_of(change));
}

}  // namespace airside::tools::gap
