#pragma once
// The table of broken input: what is broken, how a program is called with it, and what it must say.

#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "input/program_desk.hpp"

namespace airside::broken {

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
inline void PrintTo(const Case& c, std::ostream* out) { *out << "airside " << c.command; }

inline Break site(const char* from, const char* to) {
  return [=](const Desk& d) { d.site(), d.edit("site.toml", from, to); };
}
inline Break points(const char* from, const char* to) {
  return [=](const Desk& d) { d.site(), d.edit("points.csv", from, to); };
}
inline Break log(int line, int column, const char* to) {
  return [=](const Desk& d) { d.blob(), d.set_column("log.csv", line, column, to); };
}
inline Break short_log(int lines) {
  return [=](const Desk& d) { d.blob(), d.keep_lines("log.csv", lines); };
}
inline Break weather(int line, int column, const char* to) {
  return [=](const Desk& d) { d.weather(), d.set_column("w.epw", line, column, to); };
}
inline Break twin(const char* lines) {
  return [=](const Desk& d) {
    d.site();
    d.write("site.toml", text_of_file(d.path("site.toml")) + "[twin]\n" + lines + "\n");
  };
}
inline Break file(const char* name, const char* text) {
  return [=](const Desk& d) { d.write(name, text); };
}
template <class Value>
Break blob(std::size_t offset, Value value, bool mend) {
  return [=](const Desk& d) { d.blob(), d.poke(offset, value, mend); };
}
inline void whole(const Desk&) {}

inline constexpr const char* check = "check site.toml";
inline constexpr const char* fit = "transfer --log log.csv -o x.blob";
inline constexpr const char* train = "pretrain --plant rc --weather w.epw --days 2 -o x.blob --log y.csv";
inline constexpr const char* train_twin = "pretrain --plant energyplus --weather w.epw --days 2 -o x.blob --log y.csv";
inline constexpr const char* try_twin =
    "simulate --plant energyplus --weather w.epw --method expert --expert-days 0 --days 1 --log y.csv";
inline constexpr const char* from_blob = "transfer --from a.blob --log log.csv -o x.blob";
inline constexpr const char* try_blob =
    "simulate --plant rc --expert-days 0 --days 1 --weights a.blob --log y.csv --report rep";
inline constexpr const char* try_room =
    "simulate --plant rc --room room.json --method expert --expert-days 0 --days 1 --log y.csv";
inline constexpr std::size_t scaler_at = sizeof(BlobHeader);
inline constexpr std::size_t weights_at = scaler_at + 2 * 8 * Layout<FiveZone>::inputs;
inline constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

// A part of the table each.
std::vector<Case> sites();
std::vector<Case> point_maps();
std::vector<Case> wrong_words();
std::vector<Case> logs();
std::vector<Case> weather_files();
std::vector<Case> engine_weather();
std::vector<Case> rooms();
std::vector<Case> models();
std::vector<Case> foreign_models();
std::vector<Case> blobs();
std::vector<Case> blobs_of_wrong_content();

}  // namespace airside::broken
