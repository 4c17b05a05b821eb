#pragma once
// A folder in which `airside gap` is run as a person would: a site of a small room, its weather, some effects, and logs
// in which something is hidden.

#include <gtest/gtest.h>

#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "sim/json/json_file.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/program.hpp"
#include "tools/gap/blind/blind.hpp"

namespace airside::tools::gap {

using nlohmann::json;

/// A small room, so that hundreds of simulations take seconds.
inline const sim::RcRoom& small_room() {
  static const sim::RcRoom room = sim::make_room(3, 0, 1);
  return room;
}

/// A folder in which `airside gap` runs.
class Desk {
 public:
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  json read(const std::string& name) const { return sim::read_json(path(name)); }
  std::set<std::string> names() const { return names_in(folder_.path()); }
  Outcome run(const std::string& words) const {
    std::istringstream in("gap " + words);
    return run_program("airside", {std::istream_iterator<std::string>(in), {}}, folder_.path(), scratch_.path());
  }

 private:
  TemporaryFolder folder_, scratch_;
};

/// A folder with a site, weather, effects and logs of the small room, in which a box has half its flow.
class GapDesk : public Desk {
 public:
  explicit GapDesk(int days = 8) : effects_(sim::load_effects(sim::find_effects())) {
    sim::write_epw(path("w.epw").string(), *weather_, 2021);
    write("site.toml",
          "[site]\nname = \"Small\"\ntopology = \"3vav-0fcu-1power\"\n[twin]\nmodel = \"rc\"\nweather = \"w.epw\"\n");
    fs::create_directory(path("effects"));
    for (const char* name : {"vav_flow", "solar_gain", "infiltration", "gain_occupied", "room_sensor_bias"}) {
      fs::copy_file(sim::find_effects() / (std::string(name) + ".json"),
                    path("effects") / (std::string(name) + ".json"));
    }
    const MeasuredRun before{sim::civil_midnight(2021, 7, 1), days, 5, false, 0.001};
    MeasuredRun after = before;
    after.start.seconds += days * seconds_per_day;
    after.seed = 6;
    log("reference.csv", measure(small_room(), weather_, before));
    const std::vector<Hidden> hidden{{"vav_flow", 1, 0.5}};
    log("measured.csv", measure(hide(small_room(), hidden, effects_), weather_, after, hidden));
  }

  /// Two columns under each other's names.
  void exchange(const std::string& file, const std::string& a, const std::string& b) const {
    std::string text = text_of_file(path(file));
    const auto header_end = text.find('\n');
    std::string header = text.substr(0, header_end);
    header = std::regex_replace(header, std::regex("\\b" + a + "\\b"), "@@");
    header = std::regex_replace(header, std::regex("\\b" + b + "\\b"), a);
    header = std::regex_replace(header, std::regex("@@"), b);
    write(file, header + text.substr(header_end));
  }

 private:
  void log(const std::string& name, const std::vector<hal::LogRow>& rows) const {
    hal::LogWriter writer(path(name).string(), {"", 3, 0, 1}, false);
    for (const hal::LogRow& row : rows) writer.append(row);
    writer.close();
  }

  std::vector<sim::Effect> effects_;
  std::shared_ptr<const sim::Weather> weather_ = sim::synthetic_weather(3);
};

inline constexpr const char* usual_words =
    "--site site.toml --measured measured.csv --reference reference.csv --effects effects";

}  // namespace airside::tools::gap
