#pragma once
// Numbers that a site gives in the place of signals for which it has no sensor.

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "airside/signals.hpp"

namespace airside::hal {

/// Whether a kind's signals are numbered: `power_1`, but `rain`.
constexpr bool has_places(SignalKind kind) { return kind <= SignalKind::power; }

/// How many of each placed signal a site has.
struct SignalCounts {
  int vavs = 0, fcus = 0, powers = 0;
  /// Of one kind; 1 for a signal that has no place.
  int of(SignalKind kind) const;
};

/// The table [stand_in] of a site file: by point name (`power_1`) or for all of a kind (`power`).
class StandIns {
 public:
  /// Bounds and a value that suits most sites. Units: signals.hpp.
  struct Plausible {
    double min, max, usual;
  };

  /// Kinds of which a signal may have a stand-in: all but room temperatures and the setpoint.
  static std::span<const SignalKind> kinds();
  /// Of a kind in kinds().
  static Plausible plausible(SignalKind kind);
  /// Every name that a site of these counts may use.
  static std::vector<std::string> names(const SignalCounts& counts);
  /// The kind that a name of names() is of; nothing for any other name.
  static std::optional<SignalKind> kind_of(std::string_view name, const SignalCounts& counts);

  void set(const std::string& name, double value) { by_name_[name] = value; }
  /// Of the signal's own name, else of its kind; nothing where the site must have a sensor.
  std::optional<double> of(SignalId id) const;
  /// The name that gives of(id).
  std::string name_for(SignalId id) const;
  bool empty() const { return by_name_.empty(); }
  const std::map<std::string, double>& by_name() const { return by_name_; }

 private:
  std::map<std::string, double> by_name_;
};

}  // namespace airside::hal
