// Scenarios: each changes the room it is put on, on the plants that it names, and a run can be repeated.

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/rc/rc_plant.hpp"
#include "sim/scenarios/scenario.hpp"
#include "support/program.hpp"
#include "tools/run/plant_choice.hpp"

namespace airside::tools {
namespace {

PlantChoice under(const std::string& scenario) {
  PlantChoice choice;
  choice.kind = "rc";
  choice.room = "301-real";
  choice.start = "2021-08-02";
  choice.scenario = scenario;
  return choice;
}

/// Rooms and fan coils of a day, each 6 min, at a setpoint of 23 degC.
std::vector<double> day_of(const PlantChoice& choice) {
  const auto plant = make_plant(choice, built_in_site(), 1);
  plant->set_setpoint(23);
  std::vector<double> seen;
  for (int row = 0; row < 240; ++row) {
    plant->advance_to({plant->time().seconds + row_s});
    for (const double t : plant->sensors().room_temp_degc) seen.push_back(t);
  }
  return seen;
}

TEST(Scenario, NamesAreUniqueAndDatesAreDates) {
  std::set<std::string_view> names;
  for (const sim::Scenario& s : sim::scenarios()) {
    EXPECT_TRUE(names.insert(s.name).second) << s.name;
    EXPECT_TRUE(hal::parse_civil_text(std::string(s.start) + "T00:00:00")) << s.name << ": " << s.start;
    EXPECT_TRUE(s.on_rc || s.on_energyplus) << s.name;
  }
}

TEST(Scenario, ChangesTheRoomAndIsRepeated) {
  const std::vector<double> usual = day_of(under(""));
  EXPECT_EQ(day_of(under("summer")), usual) << "summer is the room as it is";
  for (const sim::Scenario& s : sim::scenarios()) {
    const bool by_date = s.change_room == nullptr && s.fan_start_h == s.fan_stop_h;
    if (!s.on_rc || by_date) continue;
    const std::vector<double> seen = day_of(under(std::string(s.name)));
    EXPECT_NE(seen, usual) << s.name;
    EXPECT_EQ(seen, day_of(under(std::string(s.name)))) << s.name;
  }
}

TEST(Scenario, OutagesAreManyAndABoxThatIsClosedShowsIt) {
  const auto closed = [](const PlantChoice& choice) {
    const auto plant = make_plant(choice, built_in_site(), 7);
    int rows = 0;
    for (int row = 0; row < 7 * 240; ++row) {
      plant->advance_to({plant->time().seconds + row_s});
      for (const double on : plant->sensors().vav_on) rows += on < 0.5 ? 1 : 0;
    }
    return rows;
  };
  EXPECT_GT(closed(under("outages")), 4 * closed(under("")));
}

TEST(Scenario, OfTheOtherPlantOrOfNoNameIsRefused) {
  const auto refused = [](PlantChoice choice) {
    try {
      (void)make_plant(choice, built_in_site(), 1);
    } catch (const hal::InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(refused(under("storms")).find("--plant energyplus"), std::string::npos) << refused(under("storms"));
  EXPECT_NE(refused(under("stroms")).find("one of summer, april"), std::string::npos) << refused(under("stroms"));
}

TEST(Scenario, GivesASimulationItsFirstDay) {
  const TemporaryFolder folder, scratch;
  const auto first_row = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"simulate",      "--plant", "rc",      "--method",   "expert",
                                   "--expert-days", "0",       "--days",  "1",          "--room",
                                   "301",           "--log",   "log.csv", "--scenario", "january"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = run_program(std::string(AIRSIDE_BIN_DIR) + "/airside", words, folder.path(), scratch.path());
    EXPECT_EQ(o.code, 0) << o.err;
    std::ifstream log(folder.path() / "log.csv");
    std::string line;
    std::getline(log, line);
    std::getline(log, line);
    return line.substr(0, 10);
  };
  EXPECT_EQ(first_row({}), "2021-01-10");
  EXPECT_EQ(first_row({"--start", "2021-02-03"}), "2021-02-03");
}

}  // namespace
}  // namespace airside::tools
