// Whether a setpoint is worth controlling: each verdict from the figures that call for it, and from no others.

#include <gtest/gtest.h>

#include <fstream>

#include "support/program.hpp"
#include "tools/adopt/advice.hpp"
#include "tools/adopt/site_text.hpp"

namespace airside::tools {
namespace {

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Comparison season_of(Season season, double room_gain, DayFigures own, const std::vector<HeldDays>& constants) {
  Comparison c;
  c.season = season;
  c.response.known = true;
  c.response.supply_gain = 1;
  c.response.room_gain = room_gain;
  c.own = c.schedule = own;
  c.constants = constants;
  c.zones = 1;
  return c;
}

/// One zone of fixed flow, range 12 to 20 degC, two seasons; the best constants take 100 and 50 kWh a day.
Adoption loop_with(double room_gain, DayFigures own_in_summer, DayFigures own_in_winter) {
  Adoption a;
  a.model_name = "haus.idf";
  a.loop.name = "Lüftung";
  a.loop.terminals.push_back({.type = "t", .name = "t", .zone = "Saal"});
  a.choices.powers = {"Loop Cooling:Electricity"};
  a.choices.min_degc = 12;
  a.choices.max_degc = 20;
  a.seasons = {
      season_of(Season::summer, room_gain, own_in_summer, {{12, {120, 0}}, {16, {100, 0}}, {20, {60, 9}}}),
      season_of(Season::winter, room_gain, own_in_winter, {{12, {40, 5}}, {16, {55, 0.02}}, {20, {50, 0.04}}})};
  return a;
}

/// As loop_with(), a box that shows damper and thermostat.
Adoption modulating_loop() {
  Adoption a = loop_with(0.05, {110, 0}, {60, 0});
  a.loop.terminals[0].kind = TerminalKind::modulating;
  a.loop.terminals[0].damper = a.loop.terminals[0].thermostat = true;
  return a;
}

TEST(Advice, BestConstantTakesLeastOfThoseThatHoldTheZones) {
  const Adoption a = loop_with(0.5, {}, {});
  EXPECT_EQ(a.seasons[0].best().setpoint_degc, 16) << "20 degC takes less and leaves the zone too warm";
  EXPECT_EQ(a.seasons[1].best().setpoint_degc, 20) << "0.02 degree-hours more are within the allowance";
}

TEST(Advice, RoomsThatTheSetpointMovesAreWorthControlling) {
  const Advice advice = advice_on(loop_with(0.5, {100, 0}, {50, 0}));
  EXPECT_EQ(advice.verdict, Verdict::control);
  EXPECT_EQ(advice.objective, "mean");
  EXPECT_TRUE(says(advice.why, "0.50 K in summer and 0.50 K in winter")) << advice.why;
  EXPECT_FALSE(says(advice.why, "same step"));
  Adoption foresees = loop_with(0.5, {100, 0}, {50, 0});
  foresees.setpoint.knew_the_load = true;
  EXPECT_TRUE(says(advice_on(foresees).why, "takes the zone's load of the same step"));
}

TEST(Advice, RoomsThatTheWholeRangeMovesLessThanASensorsToleranceAreLeftToASchedule) {
  const Advice advice = advice_on(loop_with(0.024, {110, 0}, {40, 0}));  // 8 K times this: 0.19 K
  EXPECT_EQ(advice.verdict, Verdict::schedule);
  EXPECT_EQ(advice.objective, "");
  EXPECT_TRUE(says(advice.why, "at most 0.024 K, its whole range of 8.0 K by 0.19 K, less than the 0.2 K"))
      << advice.why;
  EXPECT_TRUE(says(advice.why, "16.0 degC (100.0 kWh a day, 9.1 % less than")) << advice.why;
  EXPECT_TRUE(says(advice.why, "20.0 degC (50.0 kWh a day, 25.0 % more than")) << advice.why;
  EXPECT_EQ(advice_on(loop_with(0.026, {110, 0}, {40, 0})).verdict, Verdict::control) << "0.21 K";
}

TEST(Advice, UnitThatTakesLessUnderLoadStaysThere) {
  Adoption a = loop_with(0.5, {60, 0}, {45, 0});
  a.setpoint.unit_switched = true;
  const Advice advice = advice_on(a);
  EXPECT_EQ(advice.verdict, Verdict::own_control);
  EXPECT_TRUE(says(advice.why, "60.0 kWh in summer and 45.0 kWh in winter")) << advice.why;
  EXPECT_TRUE(says(advice.why, "22.5 kWh a day more, mean of these days, which is 42.9 % more")) << advice.why;
  a.setpoint.unit_switched = false;
  EXPECT_EQ(advice_on(a).verdict, Verdict::control) << "a loop that has a setpoint of its own has no such choice";
}

TEST(Advice, UnitThatSavesLittleUnderLoadOrHoldsLessThereIsWorthControlling) {
  Adoption little = loop_with(0.5, {91, 0}, {45, 0});  // 9 % less
  little.setpoint.unit_switched = true;
  EXPECT_EQ(advice_on(little).verdict, Verdict::control);
  Adoption colder = loop_with(0.5, {60, 0}, {45, 3});
  colder.setpoint.unit_switched = true;
  EXPECT_EQ(advice_on(colder).verdict, Verdict::control);
}

TEST(Advice, BoxesThatShowThemselvesAreWorthControllingWhereTheBestConstantMoves) {
  Adoption a = modulating_loop();
  const Advice advice = advice_on(a);
  EXPECT_EQ(advice.verdict, Verdict::control);
  EXPECT_EQ(advice.objective, "band") << "though the rooms hardly move";
  for (Comparison& c : a.seasons) c.constants = {{12, {50, 0}}, {16, {55, 0}}, {20, {60, 0}}};
  EXPECT_EQ(advice_on(a).verdict, Verdict::schedule);
  EXPECT_TRUE(says(advice_on(a).why, "coldest air of the range was the best constant in every season"));
  a.seasons[1].constants = {{12, {55, 0}}, {16, {50, 0}}, {20, {60, 0}}};
  a.seasons[1].response.supply_gain = 0;
  EXPECT_EQ(advice_on(a).verdict, Verdict::schedule) << "a season in which the supply does not follow says nothing";
  a.seasons[1].response.supply_gain = 1;
  for (Comparison& c : a.seasons) c.constants = {{12, {55, 0}}, {16, {50, 0}}, {20, {60, 0}}};
  EXPECT_EQ(advice_on(a).verdict, Verdict::control) << "between the ends the weather of a day still moves it";
}

TEST(Advice, BoxesThatModulateUnseenAreLeftToASchedule) {
  Adoption a = modulating_loop();
  a.loop.terminals[0].damper = false;
  EXPECT_EQ(advice_on(a).verdict, Verdict::schedule);
  EXPECT_TRUE(says(advice_on(a).why, "would work against the boxes"));
}

TEST(Advice, SupplyThatDoesNotFollowIsLeftToASchedule) {
  Adoption a = loop_with(0.5, {100, 0}, {50, 0});
  for (Comparison& c : a.seasons) c.response.supply_gain = 0.1;
  EXPECT_EQ(advice_on(a).verdict, Verdict::schedule);
  EXPECT_TRUE(says(advice_on(a).why, "does not follow the setpoint: 0.10 K per K in summer"));
  a.seasons[1].response.supply_gain = 1;
  EXPECT_EQ(advice_on(a).verdict, Verdict::control) << "it follows in one season";
}

TEST(Advice, NothingIsSaidWhereNothingIsKnown) {
  Adoption a = loop_with(0.5, {100, 0}, {50, 0});
  for (Comparison& c : a.seasons) c.response.known = false;
  EXPECT_EQ(advice_on(a).verdict, Verdict::undecided);
  EXPECT_TRUE(json_of(a.seasons[0]).is_null());
  Adoption unmetered = loop_with(0.5, {}, {});
  unmetered.choices.powers.clear();
  EXPECT_EQ(advice_on(unmetered).verdict, Verdict::control);
  unmetered.setpoint.unit_switched = true;
  EXPECT_EQ(advice_on(unmetered).verdict, Verdict::undecided);
}

TEST(Advice, IsFoundAgainOnThePageAndNamedInTheSiteFile) {
  const Adoption a = loop_with(0.001, {110, 0}, {40, 0});
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "adopt.md") << "# haus.idf\n\n" << advice_section(a) << "\n## Found\n";
  const Advice advice = advice_on(a);
  EXPECT_EQ(advice_of_page(folder.path() / "adopt.md"), advice.headline + ". " + advice.why);
  EXPECT_TRUE(says(adopted_site_text(a), "\n# Its advice: leave the setpoint to a schedule.\n"));
  std::ofstream(folder.path() / "adopt.md") << "mine\n## Is a setpoint worth it\n\nNo.\n";
  EXPECT_EQ(advice_of_page(folder.path() / "adopt.md"), "") << "what somebody else wrote is not repeated";
  EXPECT_EQ(advice_of_page(folder.path() / "none" / "adopt.md"), "");
}

/// Two days at one step an hour, one zone with people from 8 to 12 who want 20 to 24 degC.
Observation two_days(double room_degc, double kw) {
  Observation days;
  days.steps_per_day = 24;
  for (auto* series : {&days.supply_degc, &days.flow_kg_s}) series->assign(48, 1.0);
  days.room_degc = {std::vector<double>(48, room_degc)};
  days.cooling_sp = {std::vector<double>(48, 24.0)};
  days.heating_sp = {std::vector<double>(48, 20.0)};
  days.people = {std::vector<double>(48, 0.0)};
  for (std::size_t i = 0; i < 48; ++i) days.people[0][i] = i % 24 >= 8 && i % 24 < 12 ? 5.0 : 0.2;
  days.meter_kw["m"] = std::vector<double>(48, kw);
  return days;
}

TEST(Advice, FiguresOfADayCountEnergyAndHoursOutsideWhilePeopleAreThere) {
  SiteChoices choices;
  choices.powers = {"m", "a meter that was always zero"};
  choices.people = true;
  const DayFigures warm = day_figures(two_days(26, 2), choices), cold = day_figures(two_days(19, 2), choices);
  EXPECT_DOUBLE_EQ(warm.kwh, 48);
  EXPECT_DOUBLE_EQ(warm.outside_degch, 4 * 1.5);
  EXPECT_DOUBLE_EQ(cold.outside_degch, 4 * 0.5);
  EXPECT_DOUBLE_EQ(day_figures(two_days(24.4, 2), choices).outside_degch, 0);
  Observation cooled_only = two_days(19, 2);
  cooled_only.heating_sp = {std::vector<double>(48, 0.0)};
  EXPECT_DOUBLE_EQ(day_figures(cooled_only, choices).outside_degch, 0) << "the engine shows 0 for no setpoint";
  choices.people = false;
  choices.work = {8, 10, false, false};
  EXPECT_DOUBLE_EQ(day_figures(two_days(26, 2), choices).outside_degch, 2 * 1.5) << "working hours";
}

TEST(Advice, OfALongerWeekTheSameDaysCount) {
  SiteChoices choices;
  choices.powers = {"m"};
  Observation week = two_days(22, 1);
  for (auto* series : {&week.supply_degc, &week.flow_kg_s, &week.room_degc[0], &week.cooling_sp[0], &week.heating_sp[0],
                       &week.people[0]})
    series->resize(168, 30.0);
  week.meter_kw["m"].resize(168, 99.0);
  const Comparison c = comparison_of(week, two_days(22, 3), {{14, two_days(22, 4)}}, choices);
  EXPECT_DOUBLE_EQ(c.own.kwh, 24);
  EXPECT_DOUBLE_EQ(c.own.outside_degch, 0);
  EXPECT_DOUBLE_EQ(c.schedule.kwh, 72);
  EXPECT_DOUBLE_EQ(c.constants.at(0).figures.kwh, 96);
}

TEST(Advice, SchedulesDayIsTheSites) {
  SiteChoices choices;
  choices.work = {7.5, 18, true, false};
  choices.work_degc = 14;
  choices.off_degc = 20;
  const nlohmann::json model = {{"Schedule:Constant", {{"s", {{"hourly_value", 1}}}, {"t", {{"hourly_value", 2}}}}}};
  const nlohmann::json day = scheduled(model, "s", choices);
  EXPECT_EQ(day["Schedule:Constant"].size(), 1U);
  std::string fields;
  for (const auto& field : day["Schedule:Compact"]["s"]["data"]) fields += field["field"].dump() + " ";
  EXPECT_EQ(fields,
            "\"Through: 12/31\" \"For: Weekdays\" \"Until: 07:30\" 20.0 \"Until: 18:00\" 14.0 \"Until: 24:00\" 20.0 "
            "\"For: AllOtherDays\" \"Until: 24:00\" 20.0 ");
  choices.work = {0, 24, false, false};
  EXPECT_EQ(scheduled(model, "s", choices)["Schedule:Compact"]["s"]["data"].size(), 4U);
}

}  // namespace
}  // namespace airside::tools
