#pragma once
// The proposed tests, done on the hidden rooms of blind cases: who knows the key commands, and writes down what the
// room logs; who judges sees commands and log alone.

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "airside/supervision/envelope.hpp"
#include "sim/effects/effect.hpp"

namespace airside::tools::gap {

/// Power below which a proposed test is not worth its days.
constexpr double least_power_of_test = 0.3;

struct BlindTests {
  std::filesystem::path folder;  ///< of the cases
  nlohmann::json verdicts, key;
  int most_tests = 1;  ///< of a case
  int jobs = 1;
  std::filesystem::path cache;  ///< of finished EnergyPlus runs; empty: none
};

/// What became of a case: the test that was done, or why none was.
struct TestedCase {
  std::string name, test;
  std::string why_not;  ///< empty: done
};

/// The tests that a verdict's case wants next: the proposed ones, best first, that were not done yet, keep rooms within
/// the rules' temperatures and have least_power_of_test. `why_not` where there is none.
struct WantedTests {
  std::vector<std::string> names;
  std::string why_not;
};
/// Errors: hal::InputError for a verdict that is open and lists no proposals.
WantedTests wanted_tests(const nlohmann::json& verdict, int done, int most_tests);

/// Each room is lived on from its measured days, with weather, people and noise of their own; the log of the test's
/// days, the two before them included, is written beside the others with tests.json. Cases whose last test was not
/// judged yet are left as they are, so that a run that was ended goes on.
/// The setpoint passes `envelope` in every cycle after the measured days. A test that its limits do not let be done is
/// passed over for the next one.
/// Errors: hal::InputError for a case without verdict, a verdict that lists no proposals, a key that is another
/// drawing's: the measured days are lived again, and must be those of the case's log.
/// Cost: a simulation of the measured days and the test's.
std::vector<TestedCase> do_blind_tests(const BlindTests& tests, const std::vector<sim::Effect>& effects,
                                       const SafetyEnvelope& envelope, const std::function<void()>& done = {});

}  // namespace airside::tools::gap
