#include "tools/cli/probe/proposals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "hal/points/register_codec.hpp"

namespace airside::tools {

namespace {

using hal::Point;

constexpr std::size_t most_named = 4;  ///< readings of one row in a line of text
constexpr int least_block = 3;         ///< points that tell that a block is shifted

/// As stated, the row shows what its name cannot have.
bool is_doubtful(const ProbedPoint& row) {
  if (!row.was_asked || row.is_unwritten || row.has_no_value || !can_be_judged(*row.point)) return false;
  if (!row.in_order) return true;
  const PlausibleRange limits = limits_of_name(row.point->name);
  return row.value < limits.least || row.value > limits.most;
}

/// What a shifted block shows in the place of one row.
enum class Shown { sense, nonsense, nothing };
Shown shown_at(const Point& stated, int step, const hal::PointMap& map, ProbedDevice& device) {
  Point p = stated;
  p.addr += step;
  if (p.addr < 0 || p.addr + p.width() > 65536) return Shown::nonsense;
  const auto raw = device.read(p);
  if (!raw) return Shown::nonsense;
  if (p.name == "map_fingerprint") {
    const auto value = hal::decode(p, *raw);
    return value && *value == expected_fingerprint(map) ? Shown::sense : Shown::nonsense;
  }
  const PlausibleRange limits = limits_of_name(p.name);
  p.min = std::max(p.min, limits.least);
  p.max = std::min(p.max, limits.most);
  const auto value = hal::decode(p, *raw);
  if (!value && value.error() == Fault::not_finite) return Shown::nothing;
  return hal::makes_sense(p, *raw) ? Shown::sense : Shown::nonsense;
}

struct Maker {
  const std::vector<ProbedPoint>& sheet;
  const hal::PointMap& map;
  ProbedDevice& device;
  ClaimedRegisters claimed{map};
  std::vector<Proposal> made;

  bool has_proposal(const ProbedPoint& row) const {
    return std::ranges::any_of(made, [&](const Proposal& p) { return p.probed == &row; });
  }

  /// Proposes to move all rows of a function by one register where that makes sense of all of them.
  void shift_block(int function) {
    std::vector<const ProbedPoint*> block;
    int wrong = 0;
    for (const ProbedPoint& row : sheet) {
      if (row.point->fc != function || !row.point->readable()) continue;
      if (!row.was_asked) return;
      block.push_back(&row);
      if ((!row.in_order && !row.has_no_value) || is_doubtful(row)) ++wrong;
    }
    if (wrong == 0 || static_cast<int>(block.size()) < least_block) return;
    for (const int step : {-1, 1}) {
      int sense = 0;
      bool all = true;
      for (std::size_t i = 0; all && i < block.size(); ++i) {
        const Shown shown = shown_at(*block[i]->point, step, map, device);
        all = shown != Shown::nonsense;
        sense += shown == Shown::sense && can_be_judged(*block[i]->point) ? 1 : 0;
      }
      if (!all || sense < least_block) continue;
      const std::string evidence =
          fmt::format("all {} points of function {} make sense one register {}, {} of them do not as stated",
                      block.size(), function, step < 0 ? "lower" : "higher", wrong);
      for (const ProbedPoint* row : block) {
        Point p = *row->point;
        p.addr += step;
        Point unlimited = p;
        unlimited.min = -HUGE_VAL, unlimited.max = HUGE_VAL;
        const auto raw = device.read(p);
        made.push_back(
            {row, {{p, raw ? hal::decode(unlimited, *raw).value_or(std::nan("")) : std::nan(""), 1}}, evidence});
      }
      return;
    }
  }

  /// The readings of the first that every other has too, those with the fewest changes.
  static std::vector<OtherReading> common(const std::vector<const ProbedPoint*>& rows,
                                          const std::map<const ProbedPoint*, std::vector<OtherReading>>& all) {
    for (const int changes : {1, 2}) {
      std::vector<OtherReading> found;
      for (const OtherReading& r : all.at(rows.front())) {
        if (r.changes != changes) continue;
        const bool shared = std::ranges::all_of(rows, [&](const ProbedPoint* row) {
          return std::ranges::any_of(all.at(row), [&](const OtherReading& o) {
            return is_same_change(r, *rows.front()->point, o, *row->point);
          });
        });
        if (shared) found.push_back(r);
      }
      if (!found.empty()) return found;
    }
    return {};
  }

  /// Rows of one kind that are encoded alike, some of them doubtful.
  void judge_kind(const std::vector<const ProbedPoint*>& kind) {
    std::vector<const ProbedPoint*> doubtful;
    std::map<const ProbedPoint*, std::vector<OtherReading>> all;
    for (const ProbedPoint* row : kind) {
      if (!is_doubtful(*row) || has_proposal(*row)) continue;
      doubtful.push_back(row);
      all[row] = other_readings(*row->point, claimed, device);
    }
    if (doubtful.empty()) return;
    const std::vector<OtherReading> together = common(doubtful, all);
    if (doubtful.size() > 1 && !together.empty()) {
      for (const ProbedPoint* row : doubtful)
        add_shared(*row, *doubtful.front(), together, all.at(row), doubtful.size());
      if (together.size() == 1) add_companions(kind, *doubtful.front(), together.front());
      return;
    }
    for (const ProbedPoint* row : doubtful) {
      const std::vector<OtherReading> own = common({row}, all);
      made.push_back({row, own, own.empty() ? "" : "it alone of its kind fits so"});
      if (doubtful.size() == 1) made.back().evidence.clear();
      if (doubtful.size() == 1 && own.size() == 1) add_companions(kind, *row, own.front());
    }
  }

  void add_shared(const ProbedPoint& row, const ProbedPoint& first, const std::vector<OtherReading>& together,
                  const std::vector<OtherReading>& own, std::size_t count) {
    Proposal p{&row, {}, fmt::format("so do all {} doubtful rows of its kind", count)};
    for (const OtherReading& r : together) {
      for (const OtherReading& o : own) {
        if (is_same_change(r, *first.point, o, *row.point)) p.readings.push_back(o);
      }
    }
    made.push_back(p);
  }

  /// Rows of the kind that are in order as stated, and usual in the other reading too: a damper that is shut.
  void add_companions(const std::vector<const ProbedPoint*>& kind, const ProbedPoint& decided,
                      const OtherReading& change) {
    if (change.point.fc != decided.point->fc || change.point.addr != decided.point->addr) return;
    for (const ProbedPoint* row : kind) {
      if (!row->was_asked || has_proposal(*row) || row->raw.empty()) continue;
      Point p = *row->point;
      p.type = change.point.type, p.fc_write = change.point.fc_write;
      p.byte_order = change.point.byte_order, p.word_order = change.point.word_order;
      p.scale = change.point.scale, p.offset = change.point.offset;
      if (p.type != row->point->type) p.sentinels = 0;
      if (p.width() > row->point->width() && claimed.are_others_in(p, *row->point)) continue;
      const auto raw = device.read(p);
      const PlausibleRange usual = usual_range(p);
      Point narrow = p;
      narrow.min = usual.least, narrow.max = usual.most;
      if (!raw || !hal::makes_sense(narrow, *raw)) continue;
      made.push_back({row, {{p, *hal::decode(narrow, *raw), change.changes}}, "encoded as the others of its kind"});
    }
  }
};

std::string encoding_of(const Point& p) {
  return fmt::format("{}|{}|{}|{}|{}|{}|{}", stem_of_name(p.name), p.fc, static_cast<int>(p.type),
                     static_cast<int>(p.byte_order), static_cast<int>(p.word_order), p.scale, p.offset);
}

}  // namespace

std::vector<Proposal> propose(const std::vector<ProbedPoint>& sheet, const hal::PointMap& map, ProbedDevice& device) {
  Maker maker{sheet, map, device, ClaimedRegisters(map), {}};
  if (map.protocol() == hal::Protocol::modbus) {
    for (const int function : {1, 2, 3, 4}) maker.shift_block(function);
  }
  std::map<std::string, std::vector<const ProbedPoint*>> kinds;
  for (const ProbedPoint& row : sheet) kinds[encoding_of(*row.point)].push_back(&row);
  for (const auto& [encoding, kind] : kinds) maker.judge_kind(kind);
  std::ranges::sort(maker.made, {}, &Proposal::probed);  // in the order of the sheet
  return maker.made;
}

std::string text_of(const Proposal& proposal) {
  const Point& p = *proposal.probed->point;
  const auto unit = [&] { return p.unit.empty() ? std::string() : " " + p.unit; };
  std::string line = fmt::format("  {:<18} ", p.name);
  if (proposal.readings.empty()) {
    return line + "no other scale, unit, order, type, function or neighbouring register fits; compare with the list\n";
  }
  if (proposal.is_decided()) {
    const OtherReading& r = proposal.readings.front();
    const std::string before = std::isnan(proposal.probed->value) || proposal.probed->raw.empty()
                                   ? std::string("nothing")
                                   : fmt::format("{:.6g}", proposal.probed->value);
    line += fmt::format("{}: ", change_text(p, r.point));
    line += std::isnan(r.value) ? "moves with its block"
                                : fmt::format("reads {:.6g}{} instead of {}", r.value, unit(), before);
    return line + (proposal.evidence.empty() ? "" : "; " + proposal.evidence) + "\n";
  }
  line += "left as it is, several readings fit: ";
  for (std::size_t i = 0; i < std::min(most_named, proposal.readings.size()); ++i) {
    const OtherReading& r = proposal.readings[i];
    line += fmt::format("{}{} gives {:.6g}{}", i == 0 ? "" : "; ", change_text(p, r.point), r.value, unit());
  }
  if (proposal.readings.size() > most_named)
    line += fmt::format("; and {} more", proposal.readings.size() - most_named);
  return line + ". Compare with the AHU's own display\n";
}

}  // namespace airside::tools
