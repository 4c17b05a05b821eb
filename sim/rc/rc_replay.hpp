#pragma once
// A room lives through a recording again: what would its sensors have shown?

#include <memory>

#include "sim/rc/rc_room.hpp"
#include "sim/weather/recording.hpp"

namespace airside::sim {

/// What the sensors of `room` would have shown under the recorded commands and weather, with the people's mean
/// profile, without noise. Duties come from a second run in which the fan coils follow their own thermostats.
/// Shape: as ChannelTable. Cost: about 25 ms for two weeks, twice that with duties.
/// Errors: hal::InputError if the room is not valid or the recording is of other counts.
/// `weather`: that of the recording, where it is at hand; else it is made anew.
/// `rounded` false: exact numbers, for differences of two replays that are smaller than a sensor's resolution.
ChannelTable replay_rc(const RcRoom& room, const Recording& recording, bool duties = true, bool rounded = true,
                       std::shared_ptr<const Weather> weather = nullptr);

}  // namespace airside::sim
