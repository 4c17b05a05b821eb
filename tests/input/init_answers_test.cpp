// `airside init` from a person's answers: a site that `airside check` accepts, or a complaint and no file.

#include <fmt/format.h>

#include "input/program_desk.hpp"

namespace airside {
namespace {

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

constexpr const char* good_answers = R"([site]
name = "AHU 3"
vavs = 3
fcus = 0
powers = 1
[room]
target_degc = 24
setpoint_min_degc = 18
[bus]
host = "192.0.2.7"
unit_id = 3
[signals.room_temp]
addr = 100
apart = 10
fc = 3
scale = 0.1
[signals.setpoint]
addr = 200
type = "float32"
scale = 1
[signals.power]
addr = 300
type = "uint32"
scale = 0.001
[signals.rain]
absent = true
[signals.heartbeat]
absent = true
)";

TEST(InitAnswers, MakeASiteThatCheckAccepts) {
  const Desk desk;
  desk.write("answers.toml", good_answers);
  const Outcome made = desk.run("airside", {"init", "ahu 3", "--answers", "answers.toml"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_TRUE(says(made.out, "airside check 'ahu 3/site.toml'")) << made.out;
  const std::string points = text_of_file(desk.path("ahu 3/points.csv")),
                    site = text_of_file(desk.path("ahu 3/site.toml"));
  EXPECT_TRUE(says(points, "\nroom_temp_3,degc,3,120,int16,big,big,0.1,")) << points;
  EXPECT_TRUE(says(points, "\nsetpoint,degc,3,200,float32,big,big,1,0,8,32,,,,on-change,16,")) << points;
  EXPECT_TRUE(says(points, "\npower_1,kw,4,300,uint32,big,big,0.001,")) << points;
  for (const char* gone : {"\nrain", "heartbeat", "clock_s", "map_fingerprint", "fcu_"})
    EXPECT_FALSE(says(points, gone)) << gone << "\n" << points;
  for (const char* there : {"name = \"AHU 3\"", "scope = \"AHU 3\"", "room_temp_degc = 24 ", "min_degc = 18 ",
                            "host = \"192.0.2.7\"", "unit_id = 3", "\nrain = 0"})
    EXPECT_TRUE(says(site, there)) << there << "\n" << site;
  EXPECT_EQ(desk.run("airside", {"check", "ahu 3/site.toml"}).code, 0);
}

TEST(InitAnswers, OfATerminalAreKeptAndMakeTheSameSiteAgain) {
  const Desk desk;
  const Outcome asked = desk.shell(
      "printf '%s\\n' 'AHU 7' four 4 2 1 '' 24.5 7 07:30 '' '' '' '' '' rtu /dev/ttyUSB1 9600 N 5 4:40:int16:0.1 - 7:7 "
      "3:7 - '' '' '' 3:90:float32 '' '' - - | $airside init asked --ask");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* again : {"found 'four'; expected a whole number from 1 to 32", "found '7'; expected a time such as",
                            "no site can do without it", "expected a register such as 40"})
    EXPECT_TRUE(says(asked.err, again)) << again << "\n" << asked.err;
  const std::string site = text_of_file(desk.path("asked/site.toml"));
  for (const char* there : {"topology = \"4vav-2fcu-1power\"", "transport = \"rtu\"", "device = \"/dev/ttyUSB1\"",
                            "baud = 9600", "parity = \"N\"", "work_start = \"07:30\"", "\nmau_temp = "})
    EXPECT_TRUE(says(site, there)) << there << "\n" << site;
  EXPECT_EQ(desk.run("airside", {"check", "asked/site.toml"}).code, 0);
  ASSERT_EQ(desk.run("airside", {"init", "again", "--answers", "asked/answers.toml"}).code, 0);
  for (const char* name : {"site.toml", "points.csv", "answers.toml"})
    EXPECT_EQ(text_of_file(desk.path(std::string("again/") + name)),
              text_of_file(desk.path(std::string("asked/") + name)));
}

TEST(InitAnswers, OfBandSayWhereDampersAndZoneSetpointsAre) {
  const Desk desk;
  const Outcome asked = desk.shell(
      "printf '%s\\n' 'AHU 8' 2 0 1 band '' '' '' '' '' '' '' 10.1.1.1 '' '' 100 200 - 300 '' '' '' - - "
      "4:500:float64 4:500:float32:0.01 4:600 - - - 4:700 | $airside init asked --ask");
  ASSERT_EQ(asked.code, 0) << asked.err;
  EXPECT_TRUE(says(asked.err, "found type 'float64'; expected int16")) << asked.err;
  const std::string points = text_of_file(desk.path("asked/points.csv"));
  for (const char* there :
       {"\ndamper_2,,4,502,float32,big,big,0.01,", "\nzone_setpoint_1,degc,4,600,", "\nahu_on,,4,700,"})
    EXPECT_TRUE(says(points, there)) << there << "\n" << points;
  for (const char* gone : {"occupied", "supply_flow", "zone_heating_setpoint"})
    EXPECT_FALSE(says(points, gone)) << gone;
  EXPECT_EQ(desk.run("airside", {"check", "asked/site.toml"}).code, 0);
}

TEST(InitAnswers, EachTopologyAndObjectiveGivesASiteThatIsInOrder) {
  const Desk desk;
  for (const char* objective : {"mean", "band"}) {
    for (const int boxes : {1, 8, 32}) {
      desk.write("a.toml", fmt::format("[site]\nvavs = {}\nfcus = {}\npowers = 1\nobjective = \"{}\"\n", boxes,
                                       boxes == 8 ? 4 : 0, objective));
      const Outcome made = desk.run("airside", {"init", "site", "--answers", "a.toml", "--force"});
      EXPECT_EQ(made.code, 0) << objective << boxes << made.err;
      EXPECT_EQ(desk.run("airside", {"check", "site/site.toml"}).code, 0) << objective << boxes;
    }
  }
}

TEST(InitAnswers, ThatAreWrongAreNamedAndNothingIsWritten) {
  const Desk desk;
  struct Wrong {
    const char *from, *to, *said;
  };
  for (const Wrong& c :
       {Wrong{"vavs = 3", "vavs = 0", "a.toml:3:1: site.vavs"}, Wrong{"vavs", "boxes", "site.boxes"},
        Wrong{"type = \"uint32\"", "type = \"uint64\"", "signals.power.type"},
        Wrong{"[signals.rain]", "[signals.rainfall]", "signals.rainfall"},
        Wrong{"fc = 3", "absent = true", "signals.room_temp"}, Wrong{"scale = 0.001", "scale = 0", "points.csv"},
        Wrong{"setpoint_min_degc = 18", "setpoint_min_degc = 30", "setpoint"},
        Wrong{"unit_id = 3", "unit_id = 3 4", "a.toml:"},
        Wrong{"host = \"192.0.2.7\"", "host = 'a\"b'", "bus: host, device"}}) {
    desk.write("a.toml", hal::replaced(good_answers, c.from, c.to));
    const Outcome refused = desk.run("airside", {"init", "site", "--answers", "a.toml"});
    EXPECT_EQ(refused.code, 1) << c.to << refused.out;
    EXPECT_TRUE(says(refused.err, c.said)) << c.to << "\n" << refused.err;
    EXPECT_TRUE(says(refused.err, "expected")) << refused.err;
    EXPECT_FALSE(fs::exists(desk.path("site"))) << c.to;
  }
  const Outcome broken_off = desk.shell("printf 'AHU 7\\n4\\n' | $airside init site --ask");
  EXPECT_EQ(broken_off.code, 1);
  EXPECT_TRUE(says(broken_off.err, "nothing was written")) << broken_off.err;
  EXPECT_FALSE(fs::exists(desk.path("site")));
  EXPECT_EQ(desk.run("airside", {"init", "site", "--answers", "none.toml"}).code, 2);
  desk.write("a.toml", good_answers);
  EXPECT_EQ(desk.run("airside", {"init", "site", "--answers", "a.toml", "--name", "AHU 4"}).code, 2)
      << "two names contradict one another";
}

TEST(InitAnswers, DoNotReplaceASiteUnasked) {
  const Desk desk;
  desk.site();
  const std::string before = text_of_file(desk.path("site.toml"));
  desk.write("a.toml", good_answers);
  EXPECT_EQ(desk.run("airside", {"init", ".", "--answers", "a.toml"}).code, 1);
  EXPECT_EQ(text_of_file(desk.path("site.toml")), before);
  EXPECT_EQ(desk.run("airside", {"init", ".", "--answers", "a.toml", "--force"}).code, 0);
  EXPECT_NE(text_of_file(desk.path("site.toml")), before);
}

}  // namespace
}  // namespace airside
