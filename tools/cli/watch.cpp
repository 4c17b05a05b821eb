// airside watch: the box's rooms and setpoint in a terminal, with a line of the last day beside each.

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_log.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

constexpr int columns = 48;  ///< of a line: half an hour each

/// Mean of each column's values in eighths of the range, a space where there is none.
/// Shape: values: equally spaced, the newest last; NaN: missing.
std::string sparkline(std::span<const double> values, double low, double high) {
  constexpr const char* eighths[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::string line;
  for (int c = 0; c < columns; ++c) {
    const std::size_t begin = values.size() * static_cast<std::size_t>(c) / columns;
    const std::size_t end = values.size() * static_cast<std::size_t>(c + 1) / columns;
    double sum = 0;
    int count = 0;
    for (const double v : values.subspan(begin, end - begin)) {
      if (!std::isfinite(v)) continue;
      sum += v;
      ++count;
    }
    if (count == 0) {
      line += ' ';
      continue;
    }
    const double share = high > low ? (sum / count - low) / (high - low) : 0.5;
    line += eighths[std::clamp(static_cast<int>(share * 8), 0, 7)];
  }
  return line;
}

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
};

/// Rows of the last day, in places of 6 min; a row that is missing leaves a NaN.
class LastDay {
 public:
  static constexpr std::size_t places = 240;

  explicit LastDay(const hal::SiteFile& site) : dir_(site.log_dir) {
    const hal::TopologyCounts bare = hal::counts_of(parse_shape(site.topology.c_str()));
    if (site.modbus) {
      map_ = hal::PointMap::load(site.modbus->points);
      counts_ = hal::counts_of(bare, map_, site.stand_ins);
    } else {
      counts_ = bare;
    }
    rooms_ = static_cast<std::size_t>(counts_.vavs);
  }

  /// What the log has now; a row that is being written is left for later.
  std::string text() const {
    std::vector<hal::LogRow> rows;
    for (const fs::path& file : newest_files()) read(file, rows);
    if (rows.empty()) return "No row in " + dir_ + " yet.\n";
    const std::int64_t last_s = rows.back().time.seconds;
    std::vector<std::vector<double>> lines(rooms_ + 2, std::vector<double>(places, none));
    for (const hal::LogRow& row : rows) {
      const std::int64_t back = (last_s - row.time.seconds) / row_s;
      if (back < 0 || back >= static_cast<std::int64_t>(places)) continue;
      const std::size_t at = places - 1 - static_cast<std::size_t>(back);
      double sum = 0;
      for (std::size_t room = 0; room < rooms_; ++room) {
        lines[room][at] = row.value[room];
        sum += row.value[room];
      }
      lines[rooms_][at] = sum / static_cast<double>(rooms_);
      lines[rooms_ + 1][at] = row.setpoint_degc;
    }
    return draw(lines);
  }

 private:
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  /// The last three: a day lies in two of them, and one may have been begun anew in between.
  std::vector<fs::path> newest_files() const {
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(dir_, ignored)) {
      if (entry.path().extension() == ".csv" && entry.path().filename().string().starts_with("airside-"))
        files.push_back(entry.path());
    }
    std::ranges::sort(files);
    if (files.size() > 3) files.erase(files.begin(), files.end() - 3);
    return files;
  }

  void read(const fs::path& file, std::vector<hal::LogRow>& rows) const {
    std::string text = hal::read_text_file(file.string(), "a log of airsided");
    text.resize(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
    if (std::ranges::count(text, '\n') < 2) return;  // no row yet
    hal::LogReadOptions options;
    options.keep_missing = true;
    for (hal::LogRow& row : hal::read_log_text(text, file.string(), counts_, options).rows)
      rows.push_back(std::move(row));
  }

  std::string draw(const std::vector<std::vector<double>>& lines) const {
    Range of_rooms;
    for (std::size_t room = 0; room < rooms_; ++room) {
      for (const double v : lines[room]) of_rooms.add(v);
    }
    std::string text = fmt::format("{:>16} {:>7}  {:<{}}  {}\n", "", "now", "the last 24 hours, from the left", columns,
                                   "least and most");
    const auto own_range = [](const std::vector<double>& values) {
      Range range;
      for (const double v : values) range.add(v);
      return range;
    };
    const auto add = [&](const std::string& name, const std::vector<double>& values, Range scale) {
      const std::string now = std::isfinite(values.back()) ? fmt::format("{:.2f}", values.back()) : "-";
      const Range own = own_range(values);
      text += fmt::format("{:>16} {:>7}  {}", name, now, sparkline(values, scale.low, scale.high));
      text += own.low <= own.high ? fmt::format("  {:.1f} to {:.1f} degC\n", own.low, own.high) : "  -\n";
    };
    for (std::size_t room = 0; room < rooms_; ++room) add(fmt::format("room {}", room + 1), lines[room], of_rooms);
    add("mean of rooms", lines[rooms_], of_rooms);
    add("setpoint", lines[rooms_ + 1], own_range(lines[rooms_ + 1]));
    if (of_rooms.low <= of_rooms.high) {
      text += fmt::format("Lines of rooms and their mean have one scale, {:.1f} to {:.1f} degC.\n", of_rooms.low,
                          of_rooms.high);
    }
    return text;
  }

  std::string dir_;
  hal::PointMap map_;
  hal::TopologyCounts counts_;
  std::size_t rooms_ = 0;
};

volatile std::sig_atomic_t stop = 0;

/// A screen of its own without a cursor; the one before is back at the end, however that comes.
class OwnScreen {
 public:
  OwnScreen() { fmt::print("\x1b[?1049h\x1b[?25l"); }
  ~OwnScreen() {
    std::fputs("\x1b[?25h\x1b[?1049l", stdout);
    std::fflush(stdout);
  }
  OwnScreen(const OwnScreen&) = delete;
  OwnScreen& operator=(const OwnScreen&) = delete;
};

struct WatchCommand {
  std::string site_path = "/etc/airside/site.toml";
  double every_s = 5;
  bool once = false;

  static std::string picture(const std::string& path, const LastDay& day) {
    // Each part may be missing for a while: the daemon replaces its status whole, and begins a log file at midnight.
    const auto part = [](auto&& make) -> std::string {
      try {
        return make();
      } catch (const hal::InputError& e) {
        return std::string(e.what()) + "\n";
      }
    };
    return part([&] { return status_sentences(path); }) + "\n" + part([&] { return day.text(); });
  }

  void run() const {
    const hal::SiteFile site = hal::read_site_file(site_path, hal::site_rules());
    const LastDay day(site);
    if (once || ::isatty(STDOUT_FILENO) == 0) {
      fmt::print("{}", picture(site_path, day));
      return;
    }
    std::signal(SIGINT, [](int) { stop = 1; });
    std::signal(SIGTERM, [](int) { stop = 1; });
    const OwnScreen screen;
    while (stop == 0) {
      fmt::print("\x1b[H\x1b[J{}\nevery {:g} s; Ctrl-C ends it", picture(site_path, day), every_s);
      std::fflush(stdout);
      (void)::poll(nullptr, 0, static_cast<int>(every_s * 1000));  // a signal ends it early
    }
  }
};

}  // namespace

void add_watch(CLI::App& app) {
  auto self = std::make_shared<WatchCommand>();
  CLI::App* c =
      app.add_subcommand("watch",
                         "the box's state in a terminal, drawn anew every few seconds: what airside status says, and "
                         "each room, their mean\n"
                         "and the setpoint over the last day. It reads status.json and the log, and writes nothing.");
  c->add_option("site", self->site_path, "site file")->capture_default_str();
  c->add_option("--every", self->every_s, "s between two pictures")
      ->check(CLI::Range(0.2, 3600.0))
      ->capture_default_str();
  c->add_flag("--once", self->once, "one picture, then end; so it does where its output is no terminal");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
