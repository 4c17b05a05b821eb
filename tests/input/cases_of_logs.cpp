// Logs and weather files.

#include "input/program_input_cases.hpp"

namespace airside::broken {

std::vector<Case> logs() {
  return {
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
  };
}

std::vector<Case> weather_files() {
  return {
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
  };
}

std::vector<Case> engine_weather() {
  return {
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
  };
}

}  // namespace airside::broken
