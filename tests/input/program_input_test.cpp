// Broken input given to the built programs: each is refused with exit code 1 and a complaint that says where, what
// was found, what was expected and what to do; nothing but JSON on standard output with --json; no file left behind.

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "input/program_desk.hpp"
#include "sim/energyplus/install.hpp"

namespace airside {
namespace {

using hal::Complaint;

using Break = std::function<void(const Desk&)>;

struct Case {
  const char* name;
  const char* command;  ///< words after `airside`, or beginning with airsided
  Break prepare;
  Complaint want;
  bool engine = false;  ///< needs the EnergyPlus schema
};

/// How GoogleTest names a case when it fails.
void PrintTo(const Case& c, std::ostream* out) { *out << "airside " << c.command; }

Break site(const char* from, const char* to) {
  return [=](const Desk& d) { d.site(), d.edit("site.toml", from, to); };
}
Break points(const char* from, const char* to) {
  return [=](const Desk& d) { d.site(), d.edit("points.csv", from, to); };
}
Break log(int line, int column, const char* to) {
  return [=](const Desk& d) { d.blob(), d.set_column("log.csv", line, column, to); };
}
Break short_log(int lines) {
  return [=](const Desk& d) { d.blob(), d.keep_lines("log.csv", lines); };
}
Break weather(int line, int column, const char* to) {
  return [=](const Desk& d) { d.weather(), d.set_column("w.epw", line, column, to); };
}
Break twin(const char* lines) {
  return [=](const Desk& d) {
    d.site();
    d.write("site.toml", text_of_file(d.path("site.toml")) + "[twin]\n" + lines + "\n");
  };
}
Break file(const char* name, const char* text) {
  return [=](const Desk& d) { d.write(name, text); };
}
template <class Value>
Break blob(std::size_t offset, Value value, bool mend) {
  return [=](const Desk& d) { d.blob(), d.poke(offset, value, mend); };
}
void whole(const Desk&) {}

constexpr const char* check = "check site.toml";
constexpr const char* fit = "transfer --log log.csv -o x.blob";
constexpr const char* train = "pretrain --plant rc --weather w.epw --days 2 -o x.blob --log y.csv";
constexpr const char* train_twin = "pretrain --plant energyplus --weather w.epw --days 2 -o x.blob --log y.csv";
constexpr const char* try_twin =
    "simulate --plant energyplus --weather w.epw --method expert --expert-days 0 --days 1 --log y.csv";
constexpr const char* from_blob = "transfer --from a.blob --log log.csv -o x.blob";
constexpr const char* try_blob =
    "simulate --plant rc --expert-days 0 --days 1 --weights a.blob --log y.csv --report rep";
constexpr const char* try_room =
    "simulate --plant rc --room room.json --method expert --expert-days 0 --days 1 --log y.csv";
constexpr std::size_t scaler_at = sizeof(BlobHeader);
constexpr std::size_t weights_at = scaler_at + 2 * 8 * Layout<FiveZone>::inputs;
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      // Site files
      {"SiteMissing", "check no/site.toml", whole, {"no/site.toml", "no file", "site file in TOML", "check the path"}},
      {"SiteIsAFolder", "simulate --site . --days 1", whole, {".", "a directory", "site file", "the file in it"}},
      {"SiteEmpty", check, file("site.toml", ""), {"site.toml: site", "nothing", "[site]", "airside init"}},
      {"SiteNoToml", check, site("min_degc = 20.0", "min_degc = = 2"), {"site.toml:16:", "not TOML", "key", "correct"}},
      {"SiteBinary",
       check,
       [](const Desk& d) { d.write("site.toml", std::string("\x7f\0ELF", 5)); },
       {"site.toml:1:1", "not text", "TOML", ".toml file"}},
      {"SiteTopology",
       check,
       site("5vav-5fcu-2power", "6vav-2fcu-1power"),
       {"site.toml:6:1: site.topology", "6vav-2fcu-1power", "one of 5vav", "AIRSIDE_TOPOLOGIES"}},
      {"SiteUnknownKey", check, site("step_k", "stepk"), {"setpoint.stepk", "unknown key", "step_k", "did you mean"}},
      {"SiteFahrenheit",
       check,
       site("room_temp_degc = 25.25", "room_temp_degc = 77"),
       {"site.toml:10:1: target.room_temp_degc", "77", "10 to 40 degC", "default is 25.25"}},
      {"SiteOverride",
       "pretrain --plant rc --site site.toml --days 2 -o x.blob",
       site("# move_penalty = 0.1", "move_penalti = 1"),
       {"override.move_penalti", "unknown", "setting", "move_penalty"}},
      {"SiteCandidates",
       check,
       [](const Desk& d) {
         d.site(), d.edit("site.toml", "step_k = 0.1", "step_k = 0.05"), d.edit("site.toml", "= 26.0", "= 36.0");
       },
       {"site.toml: [setpoint]", "20 to 36 degC in steps of 0.05 K", "at most 192", "widen step_k"}},
      {"SiteOfDaemon",
       "airsided --site site.toml --check",
       site("port = 502", "port = 70000"),
       {"site.toml:37:1: modbus.port", "70000", "1 to 65535", "default is 502"}},
      {"SiteWithoutModbusOfDaemon",
       "airsided --site site.toml --check",
       file("site.toml", "[site]\nname = \"a\"\ntopology = \"5vav-5fcu-2power\"\n"),
       {"site.toml: [modbus]", "no such section", "reach the AHU", "add [modbus]"}},
      {"SiteNamesMissingWeights",
       check,
       site("blob = \"\"", "blob = \"none.blob\""),
       {"none.blob", "No such file", "weight blob", "airside pretrain"}},
      {"SiteNamesMissingHistory",
       check,
       site("log = \"\"", "log = \"none.csv\""),
       {"none.csv", "no file", "CSV log", "check the path"}},

      // Point maps
      {"PointsMissing",
       check,
       [](const Desk& d) { d.site(), fs::remove(d.path("points.csv")); },
       {"points.csv", "no readable file", "point map in CSV", "airside init"}},
      {"PointsEmpty", "check --points p.csv", file("p.csv", ""), {"p.csv", "no header", "", ""}},
      {"PointsUnknownColumn", check, points("name,", "nmae,"), {"points.csv:", "nmae", "", ""}},
      {"PointsType", check, points("uint16", "uint61"), {"column type", "uint61", "", ""}},
      {"PointsUnit", check, points("degc", "degf"), {"column unit", "degf", "", ""}},
      {"PointsSignalMissing", check, points("outdoor_temp,", "weather_temp,"), {"points.csv", "outdoor_temp", "", ""}},
      {"PointsOfAnotherRoom",
       "check --topology 3vav-0fcu-1power --points points.csv",
       [](const Desk& d) { d.site(); },
       {"points.csv", "", "3", ""}},
      {"PointsOfDaemon",
       "airsided --site site.toml --check",
       points("uint16", "uint61"),
       {"column type", "uint61", "", ""}},

      // Logs
      {"LogMissing", fit, whole, {"log.csv", "no file", "CSV log", "check the path"}},
      {"LogEmpty", fit, file("log.csv", ""), {"log.csv:1", "empty file", "header", "export"}},
      {"LogNoTime", fit, log(0, 0, "when"), {"log.csv:1", "no column `time`", "`time`", "ISO"}},
      {"LogColumnMissing", fit, log(0, 1, "office"), {"log.csv:1: room_temp_1_degc", "no such", "room_temp_1", "add"}},
      {"LogFahrenheit", fit, log(0, 1, "room_temp_1_degf"), {"room_temp_1_degf", "degf", "degc", "convert"}},
      {"LogText", fit, log(3, 1, "warm"), {"log.csv:4: room_temp_1_degc", "`warm`", "25.3", "correct"}},
      {"LogNotANumber", fit, log(3, 2, "nan"), {"log.csv:4: room_temp_2_degc", "`nan`", "0 to 50", "gaps"}},
      {"LogSentinel", fit, log(5, 2, "3276.7"), {"log.csv:6: room_temp_2_degc", "3276.7", "0 to 50", "sensor"}},
      {"LogGermanDate", fit, log(2, 0, "01.07.2021 00:06"), {"log.csv:3: time", "01.07.2021", "2021-", "ISO"}},
      {"LogTwice", fit, log(2, 0, "2021-07-01T00:00:00"), {"log.csv:3: time", "same as line 2", "once", "remove"}},
      {"LogFiveMinutes", fit, log(2, 0, "2021-07-01T00:05:00"), {"log.csv:3: time", "300 s", "6 min", "resample"}},
      {"LogOfAnotherRoom",
       "transfer --topology 3vav-0fcu-1power --log log.csv -o x.blob",
       [](const Desk& d) { d.blob(); },
       {"log.csv:1", "5vav-5fcu-2power", "3vav-0fcu-1power", "topology"}},
      {"LogTooShort", fit, short_log(3), {"log.csv", "2 rows, less than a day", "240 rows", "run longer"}},
      {"LogOfReport",
       "report log.csv -o rep",
       log(3, 1, "warm"),
       {"log.csv:4: room_temp_1_degc", "`warm`", "25.3", ""}},
      {"LogOfReportWithoutWork",
       "report log.csv -o rep",
       short_log(60),
       {"log.csv: metrics", "no cycle in working hours", "at least one", "scored day"}},
      {"LogOfCheck", "check --log log.csv", log(3, 1, "warm"), {"log.csv:4: room_temp_1_degc", "`warm`", "25.3", ""}},

      // Weather files
      {"WeatherMissing", train, whole, {"w.epw", "", "", ""}},
      {"WeatherEmpty", train, file("w.epw", ""), {"w.epw", "empty file", "", ""}},
      {"WeatherNoLocation",
       train,
       [](const Desk& d) { d.weather(), d.drop_line("w.epw", 0); },
       {"w.epw:1: LOCATION", "DESIGN", "", ""}},
      {"WeatherLatitude", train, weather(0, 6, "95"), {"w.epw:1: latitude", "95", "", ""}},
      {"WeatherText", train, weather(11, 6, "warm"), {"w.epw:12: dry bulb", "warm", "", ""}},
      {"WeatherTooHot", train, weather(11, 6, "85"), {"w.epw:12: dry bulb", "85", "", ""}},
      {"WeatherColumns", train, weather(11, 6, "1,2"), {"w.epw:12: columns", "36 columns", "", ""}},
      {"WeatherHourMissing",
       train,
       [](const Desk& d) { d.weather(), d.drop_line("w.epw", 13); },
       {"w.epw:14: date", "", "", ""}},
      {"WeatherPartYear",
       train,
       [](const Desk& d) { d.weather(), d.keep_lines("w.epw", 8 + 72); },
       {"w.epw", "records", "8760", "whole year"}},
      {"WeatherOfCheck", "check --weather w.epw", weather(11, 8, "-3"), {"w.epw:12: relative humidity", "-3", "", ""}},

      // The same for the engine, which takes a dry bulb of 85 degC and ends over others in words of its own
      {"EngineWeatherMissing", train_twin, whole, {"w.epw", "no readable file", "EPW", "path"}, true},
      {"EngineWeatherEmpty", train_twin, file("w.epw", ""), {"w.epw", "empty file", "", ""}, true},
      {"EngineWeatherNoLocation",
       train_twin,
       [](const Desk& d) { d.weather(), d.drop_line("w.epw", 0); },
       {"w.epw:1: LOCATION", "DESIGN", "", ""},
       true},
      {"EngineWeatherLatitude", train_twin, weather(0, 6, "95"), {"w.epw:1: latitude", "95", "", ""}, true},
      {"EngineWeatherText", try_twin, weather(11, 6, "warm"), {"w.epw:12: dry bulb", "warm", "", ""}, true},
      {"EngineWeatherTooHot", try_twin, weather(11, 6, "85"), {"w.epw:12: dry bulb", "85", "", ""}, true},
      {"EngineWeatherHumidity", try_twin, weather(11, 8, "-3"), {"w.epw:12: relative humidity", "-3", "", ""}, true},
      {"EngineWeatherDewPoint", try_twin, weather(11, 7, "dew"), {"w.epw:12: column 8", "dew", "a number", ""}, true},
      {"EngineWeatherColumns", train_twin, weather(11, 6, "1,2"), {"w.epw:12: columns", "36 columns", "", ""}, true},
      {"EngineWeatherHourMissing",
       try_twin,
       [](const Desk& d) { d.weather(), d.drop_line("w.epw", 13); },
       {"w.epw:14: date", "", "", ""},
       true},
      {"EngineWeatherPartYear",
       try_twin,
       [](const Desk& d) { d.weather(), d.keep_lines("w.epw", 8 + 72); },
       {"w.epw", "weather of 2021-07-31", "a time from 01-01", "covers the period"},
       true},
      {"EngineWeatherOfARoomThatChangesIt",
       "simulate --plant energyplus --room 301-real --weather w.epw --method expert --expert-days 0 --days 1 --log "
       "y.csv",
       weather(11, 6, "85"),
       {"w.epw:12: dry bulb", "85", "", ""},
       true},

      // Rooms of the RC plant
      {"RoomUnknown",
       "simulate --plant rc --room 999 --method expert --days 1",
       whole,
       {"--room", "room \"999\"", "one of rc", "path of a .json"}},
      {"RoomUnknownWithoutWeights",
       "simulate --plant rc --room 999 --days 1",
       whole,
       {"--room", "room \"999\"", "one of rc", "path of a .json"}},
      {"RoomUnknownToTheEngine",
       "simulate --plant energyplus --room 999 --days 1",
       whole,
       {"--room", "'999'", "one of twin, 301", "choose one"},
       true},
      {"RoomNoJson", try_room, file("room.json", "{\n\"shgc\": 0.4,\n}"), {"room.json:3", "JSON", "", ""}},
      {"RoomField", try_room, file("room.json", "{\"shcg\": 0.4}"), {"room.json: shcg", "unknown field", "", "shgc"}},
      {"RoomRange", try_room, file("room.json", "{\"shgc\": 1.4}"), {"room.json: shgc", "1.4", "", ""}},
      {"RoomCount",
       try_room,
       file("room.json", "{\"vav_damper\": [0.5, 0.5]}"),
       {"room.json: vav_damper", "2 values", "", ""}},
      {"RoomKeyTwice",
       try_room,
       file("room.json", "{\"shgc\": 0.4, \"shgc\": 0.5}"),
       {"room.json: shgc", "twice", "", ""}},
      {"RoomOfAnotherShape",
       try_room,
       file("room.json", "{\"vavs\": 3, \"fcus\": 0, \"powers\": 1}"),
       {"room.json", "3", "5", ""}},
      {"RoomOfCheck", "check --room-file room.json", file("room.json", "[1]"), {"room.json", "array", "", ""}},

      // Weight blobs
      {"BlobMissing", from_blob, whole, {"a.blob", "No such file", "weight blob", "airside pretrain"}},
      {"BlobEmpty", from_blob, file("a.blob", ""), {"a.blob", "0 bytes", "192 to", "copy the file again"}},
      {"BlobOtherFile",
       from_blob,
       [](const Desk& d) { d.write("a.blob", std::string(300, 'x')); },
       {"a.blob: magic", "another kind of file", "weight blob", "airside pretrain"}},
      {"BlobCutInHeader",
       try_blob,
       [](const Desk& d) { d.blob(), d.cut("a.blob", 100); },
       {"a.blob", "100 bytes", "192", "copy"}},
      {"BlobCutInPayload",
       try_blob,
       [](const Desk& d) { d.blob(), d.cut("a.blob", 60000); },
       {"a.blob: payload_bytes", "ends early", "header says", "copy"}},
      {"BlobTooLong",
       try_blob,
       [](const Desk& d) { d.blob(), d.write("a.blob", text_of_file(d.path("a.blob")) + "x"); },
       {"a.blob: payload_bytes", "length", "", ""}},
      {"BlobVersion",
       from_blob,
       blob(8, std::uint16_t{9}, true),
       {"a.blob: format_version", "version", "version 1", "airside"}},
      {"BlobByteOrder",
       from_blob,
       blob(12, std::uint32_t{0x04030201}, true),
       {"a.blob: endian_mark", "byte order", "little", "machine"}},
      {"BlobFlippedWeight",
       try_blob,
       blob(weights_at + 4000, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "undamaged", "copy"}},
      {"BlobFlippedHeader",
       try_blob,
       blob(136, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "undamaged", "copy"}},
      {"BlobOtherTopology",
       try_blob,
       [](const Desk& d) { d.small_blob(); },
       {"a.blob: topology_hash", "another topology", "site's", "pretrain"}},
      {"BlobOtherUnits", from_blob, blob(32, std::uint64_t{7}, true), {"a.blob: units_hash", "units", "", "again"}},
      {"BlobScope",
       from_blob,
       blob(56, std::array<char, 9>{"Room 999"}, true),
       {"a.blob: site_scope", "another site", "scope", "transfer"}},
      {"BlobNanWeight",
       try_blob,
       blob(weights_at, std::numeric_limits<float>::quiet_NaN(), true),
       {"a.blob: weights", "not finite", "finite", "train again"}},
      {"BlobHugeWeight",
       from_blob,
       blob(weights_at + 400, 1e6f, true),
       {"a.blob: weights", "out of bounds", "1000", "train again"}},
      {"BlobNanScaler",
       from_blob,
       blob(scaler_at, nan_value, true),
       {"a.blob: scaler", "not finite", "", "train again"}},
      {"BlobZeroScale",
       from_blob,
       blob(scaler_at + 8 * Layout<FiveZone>::inputs, 0.0, true),
       {"a.blob: scaler", "", "", ""}},
      {"BlobOfCheck",
       "check --weights a.blob",
       blob(weights_at, std::numeric_limits<float>::infinity(), true),
       {"a.blob: weights", "finite", "", ""}},
      {"BlobOfInspect",
       "blob inspect a.blob",
       blob(weights_at + 4000, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "", "copy"}},
      {"BlobOfDiff",
       "blob diff a.blob a.blob",
       blob(weights_at + 4000, std::uint8_t{0x55}, false),
       {"a.blob: digest", "checksum", "", "copy"}},
      {"BlobOfDaemon",
       "airsided --site site.toml --check",
       [](const Desk&
              d) { d.blob(), d.cut("a.blob", 60000), d.site(), d.edit("site.toml", "blob = \"\"", "blob = \"a.blob\""); },
       {"a.blob: payload_bytes", "ends early", "header says", "copy"}},

      // Models and patches
      {"ModelMissing",
       "check --twin none.epJSON",
       whole,
       {"none.epJSON", "no readable file", "JSON", "check the path"}},
      {"ModelNoJson",
       "check --twin m.epJSON",
       file("m.epJSON", "{\"Zone\": {\n"),
       {"m.epJSON:2", "not JSON", "JSON object", "correct"}},
      {"ModelIsAnIdf",
       "check --twin m.idf",
       file("m.idf", "Version,25.2;\n"),
       {"m.idf", "an IDF", "epJSON", "--convert-only m.idf"}},
      {"ModelOfPretrainIsAnIdf",
       "pretrain --plant energyplus --twin m.idf --days 2 -o x.blob",
       file("m.idf", "Version,25.2;\n"),
       {"m.idf", "an IDF", "epJSON", "give the file m.epJSON"},
       true},
      {"ModelKeyTwice",
       "check --twin m.epJSON",
       file("m.epJSON", "{\"Zone\": {}, \"Zone\": {}}"),
       {"m.epJSON: Zone", "twice", "once", "rename"}},
      {"PatchNoObject", "check --patch p.json", file("p.json", "[]"), {"p.json", "array", "object", "start the file"}},
      {"ModelIncomplete",
       "check --twin m.epJSON",
       file("m.epJSON", "{\"Zone\": {\"a\": {}}}"),
       {"m.epJSON: Building", "no such object", "one", "cannot run"},
       true},
      {"PatchFieldMistyped",
       "check --patch p.json",
       file("p.json", "{\"Zone\": {\"a\": {\"x_orign\": 1}}}"),
       {"p.json: Zone / a / x_orign", "does not know", "a field of that object", "x_origin"},
       true},
      {"PatchTypeUnknown",
       "check --patch p.json",
       file("p.json", "{\"Zonne\": {\"a\": {}}}"),
       {"p.json: Zonne", "object type", "Energy+.schema", "Zone"},
       true},
      {"PatchNoNumber",
       "check --patch p.json",
       file("p.json", "{\"Zone\": {\"a\": {\"x_origin\": \"left\"}}}"),
       {"p.json", "left", "number", ""},
       true},
      {"PatchOfPretrain",
       "pretrain --plant energyplus --patch p.json --days 2 -o x.blob",
       file("p.json", "{\"Zonne\": {\"a\": {}}}"),
       {"p.json: Zonne", "object type", "Energy+.schema", "Zone"},
       true},

      {"LogToNowhere",
       "simulate --plant rc --method expert --expert-days 0 --days 1 --log no/y.csv",
       whole,
       {"no/y.csv", "cannot be written: No such file", "writable place", "choose another"}},

      // A model that the plant cannot use
      {"TwinOnRc",
       "simulate --plant rc --twin m.epJSON --method expert --expert-days 0 --days 1 --log y.csv",
       whole,
       {"--twin m.epJSON", "--plant rc beside it", "EnergyPlus", "leave --plant rc out"}},
      {"PatchOnRc",
       "pretrain --plant rc --patch p.json --days 2 -o x.blob",
       whole,
       {"--patch p.json", "--plant rc beside it", "EnergyPlus", "leave --plant rc out"}},
      {"TwinOfAnotherShape",
       "pretrain --topology 3vav-0fcu-1power --twin m.epJSON --days 2 -o x.blob",
       whole,
       {"--twin m.epJSON", "topology 3vav-0fcu-1power", "EnergyPlus", "leave it out"}},
      {"TwinOfSiteOnRc",
       "pretrain --plant rc --site site.toml --days 2 -o x.blob",
       twin("model = \"m.epJSON\"\npatches = [\"p.json\"]"),
       {"site.toml: [twin]", "--plant rc beside it", "EnergyPlus", "--room"}},
      {"TwinOfSiteMissing",
       "pretrain --plant energyplus --site site.toml --days 2 -o x.blob",
       twin("model = \"m.epJSON\""),
       {"m.epJSON", "no readable file", "JSON", "check the path"},
       true},
      {"TwinOfSiteIsRcWithPatches",
       "pretrain --site site.toml --days 2 -o x.blob",
       twin("model = \"rc\"\npatches = [\"p.json\"]"),
       {"site.toml: twin.patches", "patches on model = \"rc\"", "epJSON", "leave the patches out"}},
      {"TwinOfSiteHasWeather",
       "pretrain --plant rc --room 301 --site site.toml --days 2 -o x.blob",
       twin("model = \"m.epJSON\"\nweather = \"none.epw\""),
       {"none.epw", "no readable file", "EPW", "check the path"}},

      // What the box shows, and names on the command line
      {"StatusMissing", "status .", whole, {"status.json", "no such file", "airsided", "state folder"}},
      {"StatusCut",
       "status status.json",
       file("status.json", "{\"time\":\"2021-"),
       {"status.json:1", "not JSON", "", ""}},
      {"StatusNotAStatus",
       "status status.json",
       file("status.json", "{\"a\": 1}"),
       {"status.json: time", "nothing", "", "airsided"}},
      {"InitTwice", "init .", [](const Desk& d) { d.site(); }, {"site.toml", "already there", "", "--force"}},
      {"NameOfInit", "init new --name <b>", whole, {"site.name", "<b>", "without", "use letters"}},
      {"StartDay",
       "pretrain --plant rc --start 2021-02-30 --days 2 -o x.blob",
       whole,
       {"--start", "2021-02-30", "2021-07-01", "correct"}},
      {"MethodUnknown",
       "simulate --plant rc --method pdi --expert-days 0 --days 1 --log y.csv",
       whole,
       {"--method", "pdi", "one of expert", "choose a name"}},
      {"NoWeights",
       "simulate --plant rc --expert-days 0 --days 1 --log y.csv",
       whole,
       {"--weights", "no weights", "blob", "airside pretrain"}},
  };
  return all;
}

void expect_said(const Complaint& want, const Said& said, const std::string& all) {
  EXPECT_FALSE(said.place.empty() || said.found.empty() || said.expected.empty() || said.remedy.empty()) << all;
  EXPECT_NE(said.place.find(want.place), std::string::npos) << all;
  EXPECT_NE(said.found.find(want.found), std::string::npos) << all;
  EXPECT_NE(said.expected.find(want.expected), std::string::npos) << all;
  EXPECT_NE(said.remedy.find(want.remedy), std::string::npos) << all;
}

class ProgramInput : public testing::TestWithParam<Case> {};

TEST_P(ProgramInput, IsRefusedWithACompleteComplaintAndLeavesNoFile) {
  const Case& c = GetParam();
  if (c.engine && !sim::have_energyplus()) {
    GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed, its schema is needed; run tools/setup";
  }
  const Desk desk;
  c.prepare(desk);
  if (HasFatalFailure()) return;
  std::vector<std::string> words = Desk::split(c.command);
  const std::string program = words.front() == "airsided" ? "airsided" : "airside";
  if (program == "airsided") words.erase(words.begin());
  const std::set<std::string> before = names_in(desk.folder());

  const Outcome plain = desk.run(program, words);
  EXPECT_EQ(plain.code, 1) << plain.err;
  // `check` prints its list, complaints included, on standard output.
  expect_said(c.want, complaint_in(plain.err.find(": found ") == std::string::npos ? plain.out : plain.err),
              plain.out + plain.err);
  EXPECT_EQ(names_in(desk.folder()), before);
  if (program == "airsided") return;

  words.push_back("--json");
  const Outcome machine = desk.run(program, words);
  EXPECT_EQ(machine.code, 1) << machine.err;
  EXPECT_EQ(names_in(desk.folder()), before);
  if (machine.out.empty()) return;
  const auto object = nlohmann::json::parse(machine.out, nullptr, false);
  ASSERT_TRUE(object.is_object()) << machine.out;
  EXPECT_FALSE(object.value("ok", true)) << machine.out;
}

INSTANTIATE_TEST_SUITE_P(Table, ProgramInput, testing::ValuesIn(cases()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(TwinOfASite, IsNotDroppedWhereThereIsNoEngine) {
  const Desk desk;
  desk.site();
  desk.write("site.toml", text_of_file(desk.path("site.toml")) + "[twin]\nmodel = \"m.epJSON\"\n");
  const std::string without = "AIRSIDE_ENERGYPLUS=/nonexistent exec $airside pretrain --days 2 --updates 1 ";
  const std::set<std::string> before = names_in(desk.folder());
  const Outcome by_option = desk.shell(without + "--twin m.epJSON -o x.blob");
  EXPECT_EQ(by_option.code, 1);
  expect_said({"--twin m.epJSON", "no EnergyPlus", "EnergyPlus 25.2", "run tools/setup"}, complaint_in(by_option.err),
              by_option.err);
  const Outcome by_site = desk.shell(without + "--site site.toml -o x.blob");
  EXPECT_EQ(by_site.code, 1);
  expect_said({"site.toml: [twin]", "no EnergyPlus", "EnergyPlus 25.2", "--room"}, complaint_in(by_site.err),
              by_site.err);
  EXPECT_EQ(names_in(desk.folder()), before);
  EXPECT_EQ(desk.shell(without + "--site site.toml --room 301 -o x.blob").code, 0);
}

/// What `airside pretrain --json` says it trained on.
std::string trained_on(const Desk& desk, const std::string& words) {
  const Outcome o = desk.shell("exec $airside pretrain --days 2 --updates 1 -o x.blob --json " + words);
  const auto object = nlohmann::json::parse(o.out, nullptr, false);
  return object.is_object() ? object.value("plant", "") : o.err;
}

TEST(TwinOfASite, IsWhatPretrainingTakes) {
  const Desk desk;
  desk.site();
  const std::string site = text_of_file(desk.path("site.toml"));
  desk.weather();
  desk.write("site.toml", site + "[twin]\nmodel = \"rc\"\nweather = \"w.epw\"\n");
  const std::string rc = trained_on(desk, "--site site.toml");
  EXPECT_NE(rc.find("RC room"), std::string::npos) << rc;
  EXPECT_NE(rc.find("w.epw"), std::string::npos) << rc;
  if (!sim::have_energyplus()) GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed; run tools/setup";
  fs::copy_file(sim::find_models() / "twin.epJSON", desk.path("own.epJSON"));
  desk.write("p.json", "{\"Building\": {\"Airside Twin\": {\"north_axis\": 10}}}");
  desk.write("site.toml", site + "[twin]\nmodel = \"own.epJSON\"\npatches = [\"p.json\"]\nweather = \"w.epw\"\n");
  const std::string own = trained_on(desk, "--site site.toml");
  EXPECT_NE(own.find("EnergyPlus 25.2, twin (own.epJSON + "), std::string::npos) << own;
  EXPECT_NE(own.find("p.json), weather w.epw"), std::string::npos) << own;
  const std::string other = trained_on(desk, "--site site.toml --room 401");
  EXPECT_EQ(other.find("own.epJSON"), std::string::npos) << other;
  EXPECT_NE(other.find("room_401.patch.json), weather w.epw"), std::string::npos) << other;
}

constexpr const char* simulated = "simulate --plant rc --method expert --expert-days 0 --days 2";

TEST(LostOutput, IsNoSuccess) {
  const Desk desk;
  for (const std::string words : {"footprint", "footprint --json", "gap effects --json"}) {
    const Outcome o = desk.shell("exec $airside " + words + " >/dev/full");
    EXPECT_EQ(o.code, 1) << words << o.err;
    EXPECT_NE(o.err.find("No space left on device"), std::string::npos) << words << o.err;
  }
  const Outcome help = desk.shell("exec $airside --help >/dev/full");
  EXPECT_EQ(help.code, 1);
  EXPECT_NE(help.err.find("standard output"), std::string::npos) << help.err;
  const Outcome o = desk.shell(std::string("exec $airside ") + simulated + " --json >/dev/full");
  EXPECT_EQ(o.code, 1);
  expect_said({"standard output", "full", "the whole answer", "run again"}, complaint_in(o.err), o.err);
}

TEST(LostOutput, IsSeenBeforeALongRun) {
  const Desk desk;
  for (const char* words :
       {"pretrain --plant rc --days 300 -o no/x.blob", "pretrain --plant rc --days 300 -o /dev/null",
        "pretrain --plant rc --days 300 -o x.blob --log no/y.csv",
        "simulate --plant rc --method expert --days 300 --log no/y.csv"}) {
    const Outcome o = desk.shell(std::string("exec $airside ") + words);
    EXPECT_EQ(o.code, 1) << words;
    EXPECT_EQ(o.err.find("started"), std::string::npos) << words << o.err;
    EXPECT_TRUE(o.err.find("no/") != std::string::npos || o.err.find("/dev/null") != std::string::npos) << o.err;
    EXPECT_TRUE(names_in(desk.folder()).empty()) << words;
  }
}

TEST(LostOutput, LeavesNoLogThatIsCut) {
  const Desk desk;
  desk.write("y.csv", "of before\n");
  const Outcome o = desk.shell(std::string("ulimit -f 50; exec $airside ") + simulated + " --log y.csv");
  EXPECT_EQ(o.code, 1) << o.err;
  expect_said({"y.csv", "cannot be written: File too large", "free space", "make room"}, complaint_in(o.err), o.err);
  EXPECT_EQ(text_of_file(desk.path("y.csv")), "of before\n");
  EXPECT_EQ(names_in(desk.folder()), std::set<std::string>{"y.csv"});
}

TEST(LostOutput, LeavesNoStudyThatIsCut) {
  const Desk desk;
  const std::string study =
      "exec $airside study rooms --plant rc --rooms 301 --seeds 1 --methods expert,floor-frozen --no-paper "
      "--pretrain-days 2 --expert-days 1 --days 1 --updates 1 --steps 1 -o s.json";
  const Outcome o = desk.shell("ulimit -f 4; " + study);
  EXPECT_EQ(o.code, 1) << o.err;
  EXPECT_NE(o.err.find("File too large"), std::string::npos) << o.err;
  EXPECT_TRUE(names_in(desk.folder()).empty());
  EXPECT_EQ(desk.shell(study).code, 0);
  EXPECT_EQ(names_in(desk.folder()), std::set<std::string>{"s.json"});
  EXPECT_TRUE(nlohmann::json::parse(text_of_file(desk.path("s.json")), nullptr, false).is_object());
}

TEST(Serve, SaysInOneObjectWhatItServesAndWhere) {
  const Desk desk;
  const Outcome o = desk.shell(
      "$airside serve --plant rc --days 1 --port 0 --ready r --json & server=$!; n=0; "
      "while [ ! -e r ] && [ $n -lt 200 ]; do sleep 0.05; n=$((n + 1)); done; kill $server; wait $server");
  EXPECT_EQ(o.code, 0) << o.err;
  const auto object = nlohmann::json::parse(o.out, nullptr, false);
  ASSERT_TRUE(object.is_object()) << o.out << o.err;
  EXPECT_EQ(object.value("address", "") + "\n", text_of_file(desk.path("r")));
  EXPECT_EQ(object.value("from", ""), "2021-08-01T00:00:00");
  EXPECT_EQ(names_in(desk.folder()), std::set<std::string>{"r"});
}

TEST(Demo, RefusesWordsThatItDoesNotKnow) {
  const Desk desk;
  for (const std::string words : {"--plnat rc", "--plant mars", "--plant", "rc", "--plant rc twice"}) {
    // Without tools on its path it could not begin to install or build.
    const Outcome o = desk.shell("PATH=/nonexistent exec /bin/bash " AIRSIDE_SOURCE_DIR "/tools/demo " + words);
    EXPECT_EQ(o.code, 2) << words << o.out << o.err;
    EXPECT_NE(o.err.find("usage: tools/demo [--plant rc|energyplus]"), std::string::npos) << words << o.err;
  }
}

TEST(ProgramInputTable, HasAtLeastSixtyCases) { EXPECT_GE(cases().size(), 60u); }

TEST(ProgramInputTable, TheFilesThatCasesBreakAreAcceptedWhole) {
  const Desk desk;
  desk.site();
  desk.blob();
  desk.weather();
  desk.write("room.json", "{\"shgc\": 0.4}");
  const Outcome o = desk.run("airside", Desk::split("check site.toml --log log.csv --weights a.blob --weather w.epw "
                                                    "--room-file room.json --json"));
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  const auto object = nlohmann::json::parse(o.out);
  EXPECT_TRUE(object["ok"]);
  EXPECT_EQ(object["checked"].size(), 7u);
}

}  // namespace
}  // namespace airside
