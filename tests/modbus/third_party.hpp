#pragma once
// Modbus programs that are not ours, for tests: they are skipped, and say so, where one of them is missing.

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "support/modbus_fixture.hpp"

namespace airside::hal::testing_peers {

inline bool has_mbpoll() { return run_program("command -v mbpoll").status == 0; }

/// Interpreter with pymodbus; empty where there is none.
inline std::string python() {
  const char* venv = std::getenv("AIRSIDE_VENV");
  const std::string path =
      venv != nullptr ? std::string(venv) + "/bin/python" : std::string(AIRSIDE_SOURCE_DIR) + "/build/venv/bin/python";
  return run_program("'" + path + "' -c 'import pymodbus'").status == 0 ? path : "";
}

#define NEEDS_MBPOLL() \
  if (!has_mbpoll()) GTEST_SKIP() << "NOT TESTED: mbpoll is missing; install it (apt-get install mbpoll)"
#define NEEDS_PYMODBUS() \
  if (python().empty())  \
  GTEST_SKIP() << "NOT TESTED: pymodbus is missing; run tools/setup --for test, or set AIRSIDE_VENV"

}  // namespace airside::hal::testing_peers
