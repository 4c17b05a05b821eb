#pragma once
// What `airside doctor` found on a machine.

#include <string>
#include <vector>

namespace airside::tools {

enum class DoctorState {
  ok,
  advice,   ///< works without it
  missing,  ///< does not work without it
};

struct DoctorFinding {
  std::string what;
  DoctorState state = DoctorState::ok;
  std::string found;   ///< one line
  std::string remedy;  ///< the line that fixes it; "" where nothing is to be done
};

}  // namespace airside::tools
