// Files of the simulator: weather, rooms and merge patches.

#include <algorithm>
#include <cmath>

#include "fuzz/target.hpp"
#include "hal/text/text_file.hpp"
#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/epw.hpp"

namespace airside::fuzz {
namespace {

bool read_weather(View input) {
  return taken([&] {
    const auto weather =
        sim::read_epw_text(std::string(text_of(input)), "w.epw", {.whole_year = false, .from = {}, .to = {}});
    FUZZ_CLAIM(!weather->records().empty() && 3600 % weather->interval_s() == 0);
    for (const sim::WeatherRecord& r : weather->records()) {
      FUZZ_CLAIM(std::abs(r.outdoor_temp_degc) <= 70 && r.relative_humidity_pct >= 0 && r.relative_humidity_pct <= 100);
      FUZZ_CLAIM(r.direct_normal_w_m2 >= 0 && r.direct_normal_w_m2 <= 1600 && std::isfinite(r.global_horizontal_w_m2));
      FUZZ_CLAIM(r.diffuse_horizontal_w_m2 >= 0 && r.wind_speed_m_s >= 0 && r.wind_speed_m_s <= 40);
      FUZZ_CLAIM(r.pressure_pa > 10000 && r.pressure_pa <= 130000 && (r.rain == 0 || r.rain == 1));
    }
    const CivilTime first{sim::civil_midnight(2023, 1, 1).seconds +
                          std::int64_t{weather->first_interval()} * weather->interval_s()};
    taken([&] { FUZZ_CLAIM(std::isfinite(weather->at(first).outdoor_temp_degc)); });
  });
}

std::vector<Bytes> weather_seeds() {
  const std::string text = hal::read_text_file(AIRSIDE_SOURCE_DIR "/tests/weather/three_july_days.epw", "weather");
  std::size_t end = 0;
  for (int line = 0; line < 14; ++line) end = text.find('\n', end) + 1;
  std::string gap = text.substr(0, end);
  const auto dry_bulb = gap.find(",26.0,");
  if (dry_bulb != std::string::npos) gap.replace(dry_bulb, 6, ",99.9,");
  return {bytes_of(text.substr(0, end)), bytes_of(gap)};
}

std::vector<std::string> weather_words() {
  return {"LOCATION",
          "DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31",
          "DATA PERIODS,1,4",
          "99.9",
          "999",
          "9999",
          "999999",
          "2021,7,1,1,60",
          "2,29",
          "1e9",
          "-40",
          ",,"};
}

// ---- rooms

bool read_room(View input) {
  return taken([&] {
    const sim::RcRoom room = sim::parse_room(std::string(text_of(input)), "room.json", "fuzzed");
    sim::check_room(room, "again");
    FUZZ_CLAIM(room.name == "fuzzed");
  });
}

std::vector<Bytes> room_seeds() {
  std::vector<Bytes> all = {bytes_of(R"({"base":"rc"})"), bytes_of(R"({"vavs":3,"fcus":0,"powers":1,"seed":7})"),
                            bytes_of(R"({"base":"rc","perturb_seed":4,"about":"x"})")};
  for (const sim::EmbeddedRoom& room : sim::embedded_rooms()) {
    if (room.json.size() < 1000) all.push_back(bytes_of(room.json));
  }
  all.push_back(bytes_of("{\"seed\":" + std::string(90, '[') + std::string(90, ']') + "}"));
  return all;
}

std::vector<std::string> room_words() {
  std::vector<std::string> words = {"\"base\"",   "\"about\"",        "\"seed\"", "\"vavs\"", "\"fcus\"",
                                    "\"powers\"", "\"perturb_seed\"", "null",     "1e999",    "-1",
                                    "[1,2]",      "\\ud800",          "\"rc\"",   "\"701\""};
  for (const sim::RoomField& field : sim::room_fields()) words.push_back("\"" + std::string(field.name) + "\":");
  return words;
}

// ---- merge patches

bool patch(View input) {
  const auto cut = static_cast<std::size_t>(std::ranges::find(input, std::uint8_t{0x1E}) - input.begin());
  return taken([&] {
    const nlohmann::json model = sim::parse_json(std::string(text_of(input.first(cut))), "model.json");
    const nlohmann::json change =
        sim::parse_json(std::string(text_of(input.subspan(cut < input.size() ? cut + 1 : cut))), "patch.json");
    const nlohmann::json once = sim::merge_patched(model, change, "patch");
    FUZZ_CLAIM(once.is_object());
    FUZZ_CLAIM(sim::merge_patched(once, change, "patch") == once);
    FUZZ_CLAIM(sim::merge_patched(model, nlohmann::json::object(), "patch") == model);
    for (const auto& [key, value] : change.items()) FUZZ_CLAIM(value.is_null() != once.contains(key));
    FUZZ_CLAIM(nlohmann::json::parse(once.dump()) == once);
  });
}

std::vector<Bytes> patch_seeds() {
  return {bytes_of("{\"Zone\":{\"A\":{\"x\":1,\"y\":[1,2]}}}\x1E{\"Zone\":{\"A\":{\"x\":null,\"y\":3},\"B\":{}}}"),
          bytes_of("{\"a\":1,\"a\":2}\x1E{}"), bytes_of("{}\x1E[]"),
          bytes_of("{\"a\":" + std::string(90, '[') + std::string(90, ']') + "}\x1E{\"a\":{\"b\":{}}}")};
}

std::vector<std::string> patch_words() {
  return {"\"Zone\"", "null", "{}", "[]", "1e999", "\\u0000", "\\ud800\\udc00", "true"};
}

}  // namespace

const Target epw{"epw", 3000, read_weather, nullptr, weather_seeds, weather_words};
const Target room_file{"room_file", 1000, read_room, nullptr, room_seeds, room_words};
const Target json_patch{"json_patch", 600, patch, nullptr, patch_seeds, patch_words};

}  // namespace airside::fuzz
