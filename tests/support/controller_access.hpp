#pragma once
// What tests may reach into that nobody else may: the memory of a controller, to put faults into it.

#include "airside/controller/controller.hpp"

namespace airside {

template <Topology T, class Scalar>
struct ControllerAccess {
  explicit ControllerAccess(ControllerMemory<T, Scalar>& memory)
      : learning(memory.learning_), cycle(memory.cycle_), replay(memory.replay_), scratch(memory.scratch_) {}
  LearningState<T, Scalar>& learning;
  CycleState<T>& cycle;
  ReplayRing<T, Scalar>& replay;
  NetworkScratch<T, Scalar>& scratch;
};

template <Topology T, class Scalar>
ControllerAccess<T, Scalar> inside(Controller<T, Scalar>& controller) {
  return ControllerAccess<T, Scalar>(controller);
}

/// As after a restart of the process, whose state was read back whole.
template <Topology T, class Scalar>
Fault restart(Controller<T, Scalar>& controller) {
  const CycleState<T> cycle = controller.cycle();
  return controller.restore(cycle, controller.replay().total_pushed(), controller.decision());
}

}  // namespace airside
