#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "energyplus/engine.hpp"
#include "hal/text/input_error.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim {
namespace {

namespace fs = std::filesystem;

/// Sets a variable of the environment for one scope.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Environment() {
    if (before_.empty()) {
      unsetenv(name_);
    } else {
      setenv(name_, before_.c_str(), 1);
    }
  }

 private:
  const char* name_;
  std::string before_;
};

std::string construct(const EnergyPlusOptions& options) {
  return message_of([&options] { EnergyPlusPlant plant(options); });
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

fs::path own_folder() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const fs::path folder =
      fs::path(testing::TempDir()) / ("airside-" + std::string(test->name()) + "-" + std::to_string(getpid()));
  fs::create_directories(folder);
  return folder;
}

TEST(EnergyPlusFailure, SaysHowToInstallAnAbsentEngine) {
  const Environment nowhere("AIRSIDE_ENERGYPLUS", "/nonexistent");
  EXPECT_FALSE(have_energyplus());
  const std::string message = construct(one_day());
  EXPECT_TRUE(has(message, "/nonexistent") && has(message, "tools/setup")) << message;
}

TEST(EnergyPlusFailure, NamesAScheduleThatTheModelHasNot) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusOptions options = one_day();
  options.names.supply_setpoint_schedule = "Supply Air Setpoimt";
  const std::string message = construct(options);
  EXPECT_TRUE(has(message, "Supply Air Setpoimt") && has(message, "Schedule:Constant")) << message;
}

TEST(EnergyPlusFailure, NamesAVariableThatTheModelHasNot) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusOptions options = one_day();
  options.names.interior_zones[2] = "Interior 33";
  const std::string message = construct(options);
  EXPECT_TRUE(has(message, "Zone Mean Air Temperature") && has(message, "Interior 33")) << message;
}

TEST(EnergyPlusFailure, PassesOnTheEnginesOwnWords) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusOptions options = one_day();
  options.lint = false;
  options.patches.push_back(
      {"bad pump", {{"Pump:ConstantSpeed", {{"ChW Supply Pump", {{"design_power_consumption", 1.0}}}}}}});
  const std::string message = construct(options);
  EXPECT_TRUE(has(message, "process ended with code 1; the engine says:\n")) << message;
  EXPECT_TRUE(has(message, "** Severe  ** Check input.  Calculated Pump Efficiency=")) << message;
  EXPECT_TRUE(has(message, "which is bigger than 100%, for pump=CHW SUPPLY PUMP\n")) << message;
  EXPECT_TRUE(has(message, "**   ~~~   ** Total_Efficiency % =")) << "the lines that continue it: " << message;
  EXPECT_TRUE(has(message, "**  Fatal  ** Errors found in Pump input")) << message;
}

/// An engine that breaks down in the middle of a run leaves its last words in its error file, not in an answer.
TEST(EnergyPlusFailure, PassesOnTheLastWordsOfAnEngineThatCrashed) {
  AIRSIDE_NEEDS_ENGINE();
  const fs::path folder = own_folder();
  {
    const Environment here("TMPDIR", folder.string());
    EnergyPlusPlant plant(one_day());
    plant.advance_to({plant.time().seconds + cycle_s});
    const fs::path words = fs::directory_iterator(folder)->path() / "eplusout.err";
    ASSERT_TRUE(fs::exists(words)) << "where the engine itself writes";
    std::ofstream(words, std::ios::app) << "   ** Warning ** a node is warm\n"
                                        << "   **   ~~~   ** but not too warm\n"
                                        << "   ** Severe  ** Plant loop CHW Loop diverges\n"
                                        << "   **   ~~~   ** at 07/01 00:18\n";
    kill(plant.worker_pid(), SIGSEGV);
    const std::string message = message_of([&] { plant.advance_to({plant.time().seconds + cycle_s}); });
    EXPECT_TRUE(has(message,
                    "was ended by signal 11 (Segmentation fault); the engine says:\n"
                    "  ** Severe  ** Plant loop CHW Loop diverges\n"
                    "  **   ~~~   ** at 07/01 00:18"))
        << message;
    EXPECT_FALSE(has(message, "warm")) << message;
  }
  fs::remove_all(folder);
}

TEST(EnergyPlusFailure, ReportsAWorkerThatIsKilled) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  plant.advance_to({plant.time().seconds + cycle_s});
  kill(plant.worker_pid(), SIGKILL);
  const std::string message = message_of([&] { plant.advance_to({plant.time().seconds + cycle_s}); });
  EXPECT_TRUE(has(message, "signal 9")) << message;
}

TEST(EnergyPlusFailure, StaysAClearErrorAfterTheWorkerHasDied) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  kill(plant.worker_pid(), SIGKILL);
  for (int i = 0; i < 2; ++i) EXPECT_THROW(plant.advance_to({plant.time().seconds + cycle_s}), std::runtime_error) << i;
}

TEST(EnergyPlusFailure, LeavesNoFolderBehind) {
  AIRSIDE_NEEDS_ENGINE();
  const fs::path folder = own_folder();
  {
    const Environment here("TMPDIR", folder.string());
    EnergyPlusPlant plant(one_day());
    EXPECT_FALSE(fs::is_empty(folder));
  }
  EXPECT_TRUE(fs::is_empty(folder));
  fs::remove_all(folder);
}

TEST(EnergyPlusFailure, EndsTheWorkerAndItsFolderWhenTheParentDies) {
  AIRSIDE_NEEDS_ENGINE();
  const fs::path folder = own_folder();
  const Environment here("TMPDIR", folder.string());
  const pid_t parent = fork();
  if (parent == 0) {
    EnergyPlusPlant plant(one_day());
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(parent, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  for (int tenth = 0; tenth < 50 && !fs::is_empty(folder); ++tenth) usleep(100'000);
  EXPECT_TRUE(fs::is_empty(folder));
  fs::remove_all(folder);
}

TEST(EnergyPlusFailure, RefusesWeatherThatIsAbsentOrNoWeather) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusOptions options = one_day();
  options.weather = "/nonexistent.epw";
  EXPECT_TRUE(has(construct(options), "/nonexistent.epw"));
  options.weather = find_models() / "twin.epJSON";
  EXPECT_TRUE(has(construct(options), "LOCATION"));
}

TEST(EnergyPlusFailure, RefusesATemporaryFolderThatIsNotThere) {
  AIRSIDE_NEEDS_ENGINE();
  const Environment nowhere("TMPDIR", "/nonexistent");
  EXPECT_TRUE(has(construct(one_day()), "TMPDIR"));
}

TEST(EnergyPlusFailure, RefusesOptionsOutOfRange) {
  AIRSIDE_NEEDS_ENGINE();
  const auto with = [](auto change) {
    EnergyPlusOptions options = one_day();
    change(options);
    return construct(options);
  };
  EXPECT_TRUE(has(with([](EnergyPlusOptions& o) { o.days = 0; }), "days"));
  EXPECT_TRUE(has(with([](EnergyPlusOptions& o) { o.step_min = 4; }), "step_min"));
  EXPECT_TRUE(has(with([](EnergyPlusOptions& o) { o.start_month = 2, o.start_day = 29; }), "day 29"));
  EXPECT_TRUE(has(with([](EnergyPlusOptions& o) { o.rooms.dampers.pop_back(); }), "dampers"));
  EXPECT_TRUE(has(with([](EnergyPlusOptions& o) { o.rooms.supply_lag_s = -1; }), "supply_lag_s"));
}

TEST(EnergyPlusFailure, RefusesASetpointThatIsNoTemperature) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  EXPECT_THROW(plant.set_setpoint(std::nan("")), hal::InputError);
  EXPECT_THROW(plant.set_setpoint(72.5), hal::InputError);
}

TEST(EnergyPlusFailure, ListsTheRoomsWhenOneIsUnknown) {
  const std::string message = message_of([] { energyplus_room("302"); });
  EXPECT_TRUE(has(message, "302") && has(message, "702_real")) << message;
  for (const char* name : {"tuning_200", "tuning_", "tuning_-1", "tuning_1x"}) {
    const std::string found = message_of([name] { energyplus_room(name); });
    EXPECT_TRUE(has(found, name) && has(found, "tuning_0 .. tuning_199")) << found;
  }
}

}  // namespace
}  // namespace airside::sim
