// `airside init` from a person's answers: a site that `airside check` accepts, or a complaint and no file.

#include <fmt/format.h>

#include <map>

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
                            "no site can do without it", "found function '7'; expected 1 (coils)"})
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
      "printf '%s\\n' 'AHU 8' 2 0 1 band '' '' '' '' '' '' '' 10.1.1.1 '' '' 100 '' '' '' '' '' 200 '' '' '' - 300 '' "
      "'' "
      "'' '' '' '' '' '' - - 4:500:float64 4:500:float32:0.01 4:600 - - - 4:700 | $airside init asked --ask");
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

TEST(InitAnswers, OfATerminalAreCheckedWhenTheyAreGivenForModbusTcp) {
  const Desk desk;
  const Outcome asked = desk.shell(
      "printf '%s\\n' 'AHU <6>' 'AHU 6' 2 0 1 maen '' 24,5 '' '' 06:00 '' 26 25.9 26.5 '' '' '' 192.168.1.5:502 "
      "192.168.1.5 '' '' 100 3 float32 0 0.5555555556 -17.77777778 lttle little '' 101 '' '' '' 3:200:int16:0.1 201 "
      "'' '' '' - 4:300:uint32:0.001:0:little back 4:310:uint32:0.001:0:little 4:320:int16:0.1 '' '' - "
      "| $airside init asked --ask");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* again :
       {"found the text \"AHU <6>\"; expected a name without control characters", "found 'maen'; expected mean or band",
        "found '24,5'; expected a number from 10 to 35; write the decimal mark as a point",
        "found 06:00; the end must be after the beginning, 07:00; 'back' asks",
        "found 25.9; warmest must be above coldest (26)", "leave scheme, path and port out",
        "found '0'; expected a number other than 0",
        "found word order 'lttle'; expected big (abcd, high word first) or little (cdab, swapped); did you mean "
        "little?",
        "setpoint, column addr: found fc 3 addr 101..101, which overlaps room_temp_1 at 100..101"})
    EXPECT_TRUE(says(asked.err, again)) << again << "\n" << asked.err;
  for (const char* shown : {"Name of the room or AHU [AHU 1]: ", "Port [502]: ", "Working hours begin [07:00]: "})
    EXPECT_TRUE(says(asked.err, shown)) << shown;
  const std::string points = text_of_file(desk.path("asked/points.csv"));
  for (const char* there : {"\nroom_temp_2,degc,3,102,float32,big,little,0.5555555556,-17.77777778,",
                            "\nsetpoint,degc,3,200,int16,big,big,0.1,", "\npower_1,kw,4,310,uint32,big,little,0.001,",
                            "\nheartbeat,,3,201,"})
    EXPECT_TRUE(says(points, there)) << there << "\n" << points;
  EXPECT_TRUE(says(text_of_file(desk.path("asked/site.toml")), "host = \"192.168.1.5\""));
  EXPECT_EQ(desk.run("airside", {"check", "asked/site.toml"}).code, 0);
  ASSERT_EQ(desk.run("airside", {"init", "again", "--answers", "asked/answers.toml"}).code, 0);
  EXPECT_EQ(text_of_file(desk.path("again/points.csv")), points);
}

TEST(InitAnswers, OfATerminalMakeABacnetSiteThatCheckAccepts) {
  const Desk desk;
  const Outcome asked = desk.shell(
      "printf '%s\\n' 'AHU 9' 2 0 1 '' '' '' '' '' '' '' '' bacnet 192.168.1.30 192.168.1.30/24 '' 7 9 1201 "
      "1201@192.168.1.50 '' '' AI:3 1201:analog-input:3 0.5555555556 -17.77777778 0 1 1201:analog-input:9 "
      "1201:analog-output:1 '' '' 1203:binary-value:4 - 1201:analog-input:50 0 0.001 '' back 1201:analog-input:51 "
      "0.001 '' 1201:analog-input:9 '' '' '' '' '' | $airside init asked --ask");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* again :
       {"length of its prefix, 8 to 32", "found '7'; expected a whole number from 8 to 16",
        "found \"1201\"; expected INSTANCE@ADDRESS", "found nothing; expected an answer",
        "found \"AI:3\"; expected DEVICE:TYPE:INSTANCE", "column object: found \"1201:analog-input:9\"",
        "found '0'; expected a number other than 0"})
    EXPECT_TRUE(says(asked.err, again)) << again << "\n" << asked.err;
  const std::string points = text_of_file(desk.path("asked/points.csv")),
                    site = text_of_file(desk.path("asked/site.toml"));
  for (const char* there :
       {"\nroom_temp_2,degc,bacnet,1202:analog-input:3,5,45,0.5555555556,-17.77777778,",
        "\nsetpoint,degc,bacnet,1201:analog-output:1,8,32,", "\nheartbeat,,bacnet,1203:binary-value:4,0,1,",
        "\npower_1,kw,bacnet,1201:analog-input:51,0,500,0.001,0,", "\nmap_fingerprint,,bacnet,gateway,"})
    EXPECT_TRUE(says(points, there)) << there << "\n" << points;
  for (const char* there :
       {"\n[bacnet] ", "\naddress = \"192.168.1.30/24\"", "\npriority = 9 ", "\ndevices = [\"1201@192.168.1.50\"]",
        "\nhost = \"127.0.0.1\"", "\nport = 1502\n", "\noutdoor_temp = ", "\nvav_on = "})
    EXPECT_TRUE(says(site, there)) << there << "\n" << site;
  EXPECT_EQ(desk.run("airside", {"check", "asked/site.toml"}).code, 0);
  ASSERT_EQ(desk.run("airside", {"init", "again", "--answers", "asked/answers.toml"}).code, 0);
  for (const char* name : {"site.toml", "points.csv", "answers.toml"})
    EXPECT_EQ(text_of_file(desk.path(std::string("again/") + name)),
              text_of_file(desk.path(std::string("asked/") + name)));
}

constexpr const char* bacnet_answers = R"([site]
vavs = 2
fcus = 0
powers = 0
[bus]
transport = "bacnet"
address = "192.168.1.30/24"
[signals.room_temp]
object = "1201:analog-input:3"
[signals.setpoint]
object = "1201:analog-output:1"
)";

TEST(InitAnswers, OfBacnetThatAreWrongAreNamed) {
  const Desk desk;
  desk.write("a.toml", bacnet_answers);
  const Outcome made = desk.run("airside", {"init", "site", "--answers", "a.toml"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_TRUE(says(made.out, "taken for absent")) << made.out;
  EXPECT_EQ(desk.run("airside", {"check", "site/site.toml"}).code, 0);
  EXPECT_TRUE(says(text_of_file(desk.path("site/points.csv")), "\nheartbeat,,bacnet,gateway,"));
  struct Wrong {
    const char *from, *to, *said;
  };
  for (const Wrong& c : {Wrong{"address = \"192.168.1.30/24\"", "", "bus.address"},
                         Wrong{"address = \"192.168.1.30/24\"", "address = \"192.168.1.30\"", "bacnet.address"},
                         Wrong{"transport = \"bacnet\"", "transport = \"tcp\"", "bus.address"},
                         Wrong{"object = \"1201:analog-output:1\"", "addr = 3", "signals.setpoint.addr"},
                         Wrong{"object = \"1201:analog-output:1\"", "object = \"1201:AO:1\"", "column object"},
                         Wrong{"[signals.room_temp]", "[signals.supply_temp]", "signals.room_temp"},
                         Wrong{"[signals.setpoint]", "apart = 0\n[signals.setpoint]", "first on line"}}) {
    desk.write("a.toml", hal::replaced(bacnet_answers, c.from, c.to));
    const Outcome refused = desk.run("airside", {"init", "other", "--answers", "a.toml"});
    EXPECT_EQ(refused.code, 1) << c.to << refused.out;
    EXPECT_TRUE(says(refused.err, c.said)) << c.to << "\n" << refused.err;
    EXPECT_TRUE(says(refused.err, "a.toml")) << refused.err;
    EXPECT_FALSE(fs::exists(desk.path("other"))) << c.to;
  }
}

TEST(InitAnswers, GiveMadeUpRegistersWayToThoseThatAreSaid) {
  const Desk desk;
  desk.write("a.toml", "[site]\nvavs = 3\nfcus = 0\npowers = 1\n[signals.supply_temp]\naddr = 0\n");
  ASSERT_EQ(desk.run("airside", {"init", "site", "--answers", "a.toml"}).code, 0);
  EXPECT_TRUE(says(text_of_file(desk.path("site/points.csv")), "\nsupply_temp,degc,4,0,"));
  EXPECT_EQ(desk.run("airside", {"check", "site/site.toml"}).code, 0);
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
  for (const Wrong& c : {Wrong{"vavs = 3", "vavs = 0", "a.toml:3:1: site.vavs"}, Wrong{"vavs", "boxes", "site.boxes"},
                         Wrong{"type = \"uint32\"", "type = \"uint64\"", "signals.power.type"},
                         Wrong{"[signals.rain]", "[signals.rainfall]", "signals.rainfall"},
                         Wrong{"fc = 3", "absent = true", "signals.room_temp"},
                         Wrong{"scale = 0.001", "scale = 0", "signals.power.scale"},
                         Wrong{"scale = 0.001", "scale = 0.001\nword_order = \"middle\"", "signals.power.word_order"},
                         Wrong{"scale = 0.001", "scale = 1e-9", "points.csv"},
                         Wrong{"unit_id = 3", "unit_id = 3\ntransport = \"rtu\"\nbaud = 300", "bus.baud"},
                         Wrong{"unit_id = 3", "unit_id = 3\ntransport = \"rtu\"\nbaud = 9601", "one of 1200, 2400"},
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

/// What is said where `lines` are typed, one after the other, into `airside init asked --ask`.
Outcome typed(const Desk& desk, const std::string& lines) {
  return desk.shell("printf '%s\\n' " + lines + " | $airside init asked --ask");
}

/// Up to the first signal: two boxes, a meter, Modbus TCP.
constexpr const char* small_site = "'AHU 5' 2 0 1 '' '' '' '' '' '' '' '' '' 10.1.1.1 '' '' ";

TEST(InitAnswers, ThatWereGivenAreInBracketsAfterBack) {
  const Desk desk;
  const Outcome asked = typed(
      desk, std::string(small_site) + "3:10:float32:0.5:-1:cdab:4 3:40 back back '' '' 41 '' '' '' 1:7 - - - - -");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* there :
       {"room temperature 1 [3:10:float32:0.5:-1:little:4]: ", "setpoint [3:40:int16:0.01]: ",
        "taken: holding register 10, float32, scale 0.5, offset -1, word order little (cdab, the low word first); 2 of",
        "taken: holding register 40, int16, scale 0.01, offset 0\n", "taken: coil 7; 2 of them", "taken: none\n"})
    EXPECT_TRUE(says(asked.err, there)) << there << "\n" << asked.err;
  const std::string points = text_of_file(desk.path("asked/points.csv"));
  for (const char* there : {"\nroom_temp_2,degc,3,14,float32,big,little,0.5,-1,", "\nsetpoint,degc,3,40,int16,",
                            "\nheartbeat,,3,41,uint16,", "\nvav_on_2,,1,8,coil,"})
    EXPECT_TRUE(says(points, there)) << there << "\n" << points;
}

TEST(InitAnswers, OfBacnetAreInBracketsAfterBack) {
  const Desk desk;
  const Outcome asked =
      typed(desk,
            "'AHU 9' 1 0 0 '' '' '' '' '' '' '' '' bacnet 192.168.1.30/24 '' '' '' '' 1201:analog-input:3 0.5 -1 back "
            "'' '' '' 1201:analog-input:3 1201:analog-output:1 '' '' '' '' '' '' '' '' ''");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* there : {"room temperature 1 [1201:analog-input:3]: ", "value = number * scale + offset [0.5]: ",
                            "offset [-1]: ", "taken: 1201:analog-input:3, scale 0.5, offset -1\n", " [gateway]: "})
    EXPECT_TRUE(says(asked.err, there)) << there << "\n" << asked.err;
  EXPECT_TRUE(says(text_of_file(desk.path("asked/points.csv")), "bacnet,1201:analog-input:3,5,45,0.5,-1,"));
}

TEST(InitAnswers, OfWhatIsWrittenAreNotMadeUp) {
  const Desk desk;
  const Outcome asked = typed(
      desk, "'AHU 5' 2 0 1 '' '' '' '' 26 40 back 40 '' 42 back '' '' '' 10.1.1.1 '' '' '' '' 3:50 '' - - - - - -");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* there :
       {"setpoint:   found nothing; expected an answer", "gone [-]:   taken: none",
        "And outside of them, degC [26]: ", "found '42'; expected a number from 5 to 40", "Warmest, degC [40]: "})
    EXPECT_TRUE(says(asked.err, there)) << there << "\n" << asked.err;
  const std::string points = text_of_file(desk.path("asked/points.csv"));
  EXPECT_TRUE(says(points, "\nsetpoint,degc,3,50,int16,big,big,0.01,0,8,40,")) << points;
  EXPECT_FALSE(says(points, "heartbeat,")) << points;
  const std::string base = good_answers;
  for (const auto& [room, limits] :
       std::map<std::string, std::string>{{"setpoint_min_degc = 7\nsetpoint_max_degc = 20", "7,32"},
                                          {"schedule_off_degc = 34.5", "8,34.5"},
                                          {"schedule_work_degc = 6.5", "6.5,32"},
                                          {"setpoint_min_degc = 18", "8,32"}}) {
    desk.write("a.toml", hal::replaced(base, "setpoint_min_degc = 18", room));
    const Outcome made = desk.run("airside", {"init", "site", "--answers", "a.toml", "--force"});
    ASSERT_EQ(made.code, 0) << room << made.err;
    const std::string rows = text_of_file(desk.path("site/points.csv"));
    EXPECT_TRUE(says(rows, "\nsetpoint,degc,3,200,float32,big,big,1,0," + limits + ",")) << room << "\n" << rows;
  }
}

TEST(InitAnswers, AreExplainedWhereSomebodyAsks) {
  const Desk desk;
  const Outcome asked =
      typed(desk,
            "help 'AHU 5' '?' 2 0 1 '?' '' '?' '' 8:00 07:30 19:00 '?' '' '' '' '' '?' '' '?' 10.1.1.1 "
            "'?' '' '' '?' 3:10:int16 3:40 - - - - - - -");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* there : {"'?' explains, 'back' goes one", "as people call it, for", "one each room temperature",
                            "brings the mean of the rooms", "in working hours, the mean of all rooms",
                            "found 07:30; the end must be after the beginning, 08:00; 'back'",
                            "nothing colder is ever written", "through the gateway airside-bacnet", "without port",
                            "most devices have 502", "a register, counted from 0, such as 40"})
    EXPECT_TRUE(says(asked.err, there)) << there << "\n" << asked.err;
  EXPECT_FALSE(says(asked.err, "work_start")) << asked.err;
  EXPECT_TRUE(says(text_of_file(desk.path("asked/site.toml")), "name = \"AHU 5\""));
}

TEST(InitAnswers, InOtherWordsAreTakenAsMeantOrGetAHint) {
  const Desk desk;
  const Outcome asked = typed(
      desk,
      "back 'AHU 5' 2 0 1 MEAN '' '' '' '' '' '' '' RTU ttyUSB0 9601 57600 x e 1 40031 '' '' '' '' '' '' 3:60 "
      "3:70:int16 "
      "- 3:60 1:7 4:8:float 4:8:BOOL 4:8:float32:0,5556:1 4:8:float32:5/9 4:8:float32:1:0:dcba 4:8:FLOAT32:1:0:swapped "
      "4:30021 40020 4:9 - - -");
  ASSERT_EQ(asked.code, 0) << asked.err;
  for (const char* there :
       {"this is the first question", "taken: /dev/ttyUSB0", "found '9601'; expected one of 1200, 2400, 4800, 9600,",
        "found 'x'; expected E or N or O\n", "in a vendor's table 40001 is usually register 0 of function 3; 40031 ",
        "counted from 0 (40031 if it is really meant) [30]: ", "4 input registers) [3]: ", "use uint16\n",
        "vav_on_1, column addr: found fc 3 addr 60..60, which overlaps setpoint at 60..60", "did you mean float32?",
        "did you mean a coil (function 1)?", "found scale '0,5556'; expected a number other than 0; write the decimal",
        "write the fraction as a decimal number: 0.5555555556", "whose bytes are swapped too", "word order little (cda",
        "(30021 if it is really meant) [20]: ", "taken: input register 40020, int16"})
    EXPECT_TRUE(says(asked.err, there)) << there << "\n" << asked.err;
  const std::string points = text_of_file(desk.path("asked/points.csv")),
                    site = text_of_file(desk.path("asked/site.toml"));
  EXPECT_TRUE(says(points, "\nroom_temp_2,degc,3,31,int16,")) << points;
  for (const char* there : {"device = \"/dev/ttyUSB0\"", "baud = 57600", "parity = \"E\"", "transport = \"rtu\""})
    EXPECT_TRUE(says(site, there)) << there << "\n" << site;
}

TEST(InitAnswers, AreNotAskedForAFolderThatCannotBeMade) {
  const Desk desk;
  desk.write("file", "");
  for (const char* folder : {"file", "file/site", "/proc/site"}) {
    const Outcome refused = desk.shell(std::string("$airside init ") + folder + " --ask < /dev/null");
    EXPECT_EQ(refused.code, 1) << folder;
    EXPECT_TRUE(says(refused.err, "expected a folder that can be made and written")) << refused.err;
    EXPECT_FALSE(says(refused.err, "Name of")) << refused.err;
  }
  EXPECT_EQ(desk.shell("$airside init new/site --ask < /dev/null").code, 1);
  EXPECT_FALSE(fs::exists(desk.path("new"))) << "a trial leaves nothing behind";
}

TEST(InitAnswers, DoNotReplaceASiteUnasked) {
  const Desk desk;
  desk.site();
  const std::string before = text_of_file(desk.path("site.toml"));
  const Outcome unasked = desk.shell("$airside init . --ask < /dev/null");
  EXPECT_EQ(unasked.code, 1);
  EXPECT_TRUE(says(unasked.err, "already there") && !says(unasked.err, "Name of")) << "asked in vain: " << unasked.err;
  desk.write("a.toml", good_answers);
  EXPECT_EQ(desk.run("airside", {"init", ".", "--answers", "a.toml"}).code, 1);
  EXPECT_EQ(text_of_file(desk.path("site.toml")), before);
  EXPECT_EQ(desk.run("airside", {"init", ".", "--answers", "a.toml", "--force"}).code, 0);
  EXPECT_NE(text_of_file(desk.path("site.toml")), before);
}

}  // namespace
}  // namespace airside
