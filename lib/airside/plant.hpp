#pragma once
// What the control loop needs of the world. Modbus hardware (hal) and simulation (sim) both satisfy it, so one
// loop, the same object code, drives both.

#include <concepts>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/fault.hpp"
#include "airside/reading.hpp"
#include "airside/topology.hpp"

namespace airside {

/// sense(): all signals now. actuate(): write, read back.  Neither may block longer than the plant's deadline.
template <class P, class T>
concept Plant = Topology<T> && requires(P plant, const Command& command) {
  { plant.sense() } -> std::same_as<Expected<Reading<T>>>;
  { plant.actuate(command) } -> std::same_as<Expected<Applied>>;
};

/// now(): civil time. sleep_until(t): returns true at t, false if it was asked to stop before.
/// A simulated clock makes its plant reach t; a real one waits. woke(): its time when the last sleep ended, which is
/// far past t where the machine was suspended.
template <class C>
concept Clock = requires(C clock, CivilTime t) {
  { clock.now() } -> std::same_as<CivilTime>;
  { clock.sleep_until(t) } -> std::same_as<bool>;
  { clock.woke() } -> std::same_as<CivilTime>;
};

}  // namespace airside
