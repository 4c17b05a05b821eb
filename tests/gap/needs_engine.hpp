#pragma once
// Tests that need EnergyPlus say loudly that they checked nothing where it is absent.

#include <gtest/gtest.h>

#include "sim/energyplus/install.hpp"

#define AIRSIDE_NEEDS_ENGINE()                                                                  \
  if (!airside::sim::have_energyplus())                                                         \
  GTEST_SKIP() << "\n*** EnergyPlus is not installed: run tools/setup, or set AIRSIDE_VENV or " \
                  "AIRSIDE_ENERGYPLUS. This test checked nothing. ***"
