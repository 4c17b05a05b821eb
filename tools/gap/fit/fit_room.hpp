#pragma once
// An RC room identified from a log, for a site without a model of its building: which numbers of the room a log can
// tell, how sure they are, and how well the room predicts days that were locked away.

#include <functional>
#include <string>
#include <vector>

#include "sim/rc/rc_room.hpp"
#include "tools/gap/inference/parameter_fit.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// A field of the room, or some entries of one that repeats, moved together.
struct RoomKnob {
  std::string field;    ///< of sim::room_fields()
  std::string text;     ///< "mass of the core zones"
  int first = 0;        ///< entry of a repeating field
  int count = 1;        ///< entries
  bool scaled = true;   ///< entries are multiplied, prior log-normal; else something is added, prior normal
  double prior_sd = 0;  ///< scaled: of the logarithm; else in the field's unit
};

/// Everything that a log can tell of such a room. The thermostats' dials are not among them: see fit_room().
std::vector<RoomKnob> room_knobs(const sim::RcRoom& start);

/// The knob as a parameter: its value is the mean of its entries, in the field's unit.
FitParameter parameter_of(const RoomKnob& knob, const sim::RcRoom& start);

/// The start room with these values.
sim::RcRoom turned(sim::RcRoom start, const std::vector<RoomKnob>& knobs, const Eigen::VectorXd& values);

/// What a knob would be set to, if `room` were the truth: the geometric, else arithmetic mean of what its entries
/// differ by from the start room.
double value_in(const sim::RcRoom& room, const RoomKnob& knob, const sim::RcRoom& start);

struct FittedParameter {
  RoomKnob knob;
  FitParameter prior;
  double estimate = 0, sd = 0;  ///< in the prior's unit
  double learned = 0;           ///< by the data: 1 - posterior variance / prior variance

  /// Bounds of `k` standard deviations; of the logarithm where the prior is of it.
  std::pair<double, double> interval(double k) const;
};

/// How well one channel is predicted.  Units: K, kW, -.
struct ChannelFit {
  std::string name, unit;
  double start_sd = 0, fitted_sd = 0;        ///< of the replay's residual on the fitted days
  double one_step_sd = 0;                    ///< of the next half hour, knowing the last two residuals
  double locked_start = 0, locked_rmse = 0;  ///< root mean square on the locked days, mean error included
};

struct RoomFit {
  sim::RcRoom room;
  std::vector<FittedParameter> parameters;
  std::vector<ChannelFit> channels;
  int fitted_days = 0, locked_days = 0;
  double room_temp_start_k = 0, room_temp_k = 0;  ///< rms over rooms and locked days
  double inflation = 1;
  int runs = 0;
};

struct RoomFitSettings {
  int locked_days = -1;  ///< the last; -1: 30 %
  int jobs = 1;
  std::function<void(double)> progress;  ///< share done, 0..1
};

constexpr int fewest_fit_days = 7;  ///< whole days, locked ones left out

/// The room that explains a log best, close to `start` where the log says nothing.
/// Temperatures and powers are fitted with the fan coils as recorded (fit_parameters()). Thermostats' dials come
/// after that, from each day's duty of each fan coil: thermostats switch, so a duty has no useful derivative but in its
/// mean. Errors: hal::InputError naming `place` if too few days remain; as sim::replay_rc. Cost: 5-VAV room, two weeks:
/// some 1,200 replays.
RoomFit fit_room(const sim::RcRoom& start, const Window& window, const std::string& place,
                 const RoomFitSettings& settings = {});

/// A file that sim::load_room reads: every field that differs from the default room of these counts.
std::string room_file_text(const sim::RcRoom& room, const std::string& about);

}  // namespace airside::tools::gap
