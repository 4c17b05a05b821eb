// Site files, point maps, and words on the command line.

#include "input/program_input_cases.hpp"

namespace airside::broken {

std::vector<Case> sites() {
  return {
      {"SiteMissing", "check no/site.toml", whole, {"no/site.toml", "no file", "site file in TOML", "check the path"}},
      {"SiteIsAFolder", "simulate --site . --days 1", whole, {".", "a directory", "site file", "the file in it"}},
      {"SiteEmpty", check, file("site.toml", ""), {"site.toml: site", "nothing", "[site]", "airside init"}},
      {"SiteNoToml", check, site("min_degc = 20.0", "min_degc = = 2"), {"site.toml:17:", "not TOML", "key", "correct"}},
      {"SiteBinary",
       check,
       [](const Desk& d) { d.write("site.toml", std::string("\x7f\0ELF", 5)); },
       {"site.toml:1:1", "not text", "TOML", ".toml file"}},
      {"SiteTopology",
       check,
       site("5vav-5fcu-2power", "36vav-2fcu-1power"),
       {"site.toml:6:1: site.topology", "36vav-2fcu-1power", "1 to 32 VAV boxes", "write it like 6vav"}},
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
       {"site.toml:40:1: modbus.port", "70000", "1 to 65535", "default is 502"}},
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
  };
}

std::vector<Case> point_maps() {
  return {
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
  };
}

std::vector<Case> wrong_words() {
  return {
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
       {"--method", "pdi", "one of ours, expert", "choose a name"}},
      {"NoWeights",
       "simulate --plant rc --expert-days 0 --days 1 --log y.csv",
       whole,
       {"--weights", "no weights", "blob", "airside pretrain"}},
  };
}

}  // namespace airside::broken
