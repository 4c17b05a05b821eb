#include "sim/energyplus/replay/replay.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "hal/text/input_error.hpp"
#include "hal/text/unfinished.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/energyplus/replay/eso.hpp"
#include "sim/energyplus/replay/own_outputs.hpp"
#include "sim/energyplus/replay/replay_cache.hpp"
#include "sim/energyplus/replay/replay_files.hpp"
#include "sim/energyplus/words.hpp"
#include "sim/weather/epw.hpp"

namespace airside::sim {
namespace {

constexpr const char* replay_format = "airside replay 3";  ///< changes when the same inputs give another table
constexpr const char* repeat_command = "energyplus -w weather.epw -d out model.epJSON";

/// "!IDD_Version 25.2.0 !IDD_BUILD cf7368216c", and the engine's size.
std::string engine_version(const EnergyPlusInstall& install) {
  std::ifstream dictionary(install.folder / "Energy+.idd");
  std::string version, build;
  std::getline(dictionary, version);
  std::getline(dictionary, build);
  std::error_code absent;
  return version + " " + build + " " + std::to_string(std::filesystem::file_size(install.library, absent));
}

std::string_view bytes_of(const std::vector<double>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)};
}

/// Of everything that the table depends on, before any of it is written as text.
ReplayKey key_of(const std::vector<std::string>& texts, const EnergyPlusTwin& twin, const Recording& recording,
                 const ReplayDays& days, const ReplayCommands& commands, const Weather& weather) {
  ReplayKey key;
  key.add(replay_format);
  for (const auto& text : texts) key.add(text);
  for (const auto& schedule : commands.schedules) key.add(schedule);
  for (const auto column : commands.columns) key.add(bytes_of(commands.values[column]));
  const Location& place = weather.location();
  key.add(bytes_of({static_cast<double>(recording.from.seconds), static_cast<double>(recording.rows.size()),
                    twin.loops.supply_bias_k, static_cast<double>(days.first_step), static_cast<double>(days.days),
                    place.latitude_deg, place.longitude_deg, place.utc_offset_h, place.elevation_m}));
  static_assert(sizeof(WeatherRecord) == 8 * sizeof(double), "a record without padding");
  key.add({reinterpret_cast<const char*>(weather.records().data()), weather.records().size() * sizeof(WeatherRecord)});
  return key;
}

/// Runs the engine's own program in the folder, as the README there says, and waits for its end.
void run_engine(const EnergyPlusInstall& install, const std::filesystem::path& folder) {
  const std::filesystem::path log = folder / "energyplus.log";
  std::string arguments[] = {
      (install.folder / "energyplus").string(), "-w", "weather.epw", "-d", "out", "model.epJSON"};
  char* argv[std::size(arguments) + 1] = {};
  for (std::size_t i = 0; i < std::size(arguments); ++i) argv[i] = arguments[i].data();
  std::error_code ignored;
  std::filesystem::remove_all(folder / "out", ignored);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t pid = -1;
  const int failed = posix_spawn(&pid, argv[0], &actions, nullptr, argv, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    throw hal::InputError(arguments[0], std::string("that it does not start (") + std::strerror(failed) + ")",
                          "the program of EnergyPlus 25.2", "run tools/setup again: the install is incomplete");
  }
  const hal::UnfinishedChild unfinished(pid);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) throw std::runtime_error("EnergyPlus replay: the engine's process is gone");
  }
  if (status != 0) {
    throw std::runtime_error("EnergyPlus replay: the engine's process " + ending_text(status) +
                             engine_words(folder / "out" / "eplusout.err", log));
  }
}

/// The steps' values of the outputs, picked at the recorded rows.
class TableMaker {
 public:
  TableMaker(const EnergyPlusTwin& twin, const Recording& recording, const ReplayDays& days, EsoFile outputs)
      : twin_(twin), recording_(recording), days_(days), outputs_(std::move(outputs)) {}

  ChannelTable table(bool thermostats) {
    const Channels channels = channels_of(twin_);
    if (twin_.own) return own_table(channels);
    table_.setConstant(static_cast<Eigen::Index>(recording_.rows.size()), channels.count(), 0.0);
    for (int i = 0; i < channels.rooms; ++i) take(i, zone_temp(twin_.names.interior_zones, i), 1, 0);
    for (int i = 0; i < channels.fcus; ++i)
      take(channels.fcu_temp() + i, zone_temp(twin_.names.perimeter_zones, i), 1, 0);
    take(channels.mau_temp(), twin_.names.mau_outlet_node + ",System Node Temperature", 1, 0);
    // The AHU's own sensor, which the plant too reports.
    take(channels.supply_temp(), twin_.names.supply_air_node + ",System Node Temperature", 1,
         -twin_.loops.supply_bias_k);
    constexpr double kw_of_joule = 1 / (1000.0 * replay_step_s);
    take(channels.power(), "Electricity:HVAC", kw_of_joule, 0);
    take(channels.power() + 1, "Electricity:Plant", kw_of_joule, 0);
    for (int i = 0; i < channels.fcus; ++i) {
      if (thermostats)
        take_duty(channels.fcu_duty() + i, i);
      else
        take_recorded_duty(channels.fcu_duty() + i, i);
    }
    return std::move(table_);
  }

 private:
  /// NaN where the model shows nothing.
  ChannelTable own_table(const Channels& channels) {
    table_.setConstant(static_cast<Eigen::Index>(recording_.rows.size()), channels.count(),
                       std::numeric_limits<double>::quiet_NaN());
    constexpr double runs_w = 1;
    for (const ChannelOutput& output : own_outputs(twin_)) {
      take(output.column, output.series(), output.factor, output.offset);
      if (output.kind != ChannelOutput::Kind::runs) continue;
      auto column = table_.col(output.column).array();
      column = (column > runs_w).select(Eigen::ArrayXd::Ones(column.size()), 0.0);
    }
    return std::move(table_);
  }

  static std::string zone_temp(const std::vector<std::string>& zones, int place) {
    return zones[static_cast<std::size_t>(place)] + ",Zone Mean Air Temperature";
  }

  const std::vector<double>& steps_of(const std::string& name) const {
    const auto& values = outputs_.of(name);
    if (values.size() != static_cast<std::size_t>(days_.steps())) {
      throw hal::InputError("EnergyPlus replay: " + name, std::to_string(values.size()) + " values",
                            std::to_string(days_.steps()) + ", one a step", "look for warnings in eplusout.err");
    }
    return values;
  }

  /// A value is that of the step that ends at the row's time.
  void take(int column, const std::string& name, double factor, double offset) {
    const auto& values = steps_of(name);
    for (Eigen::Index row = 0; row < table_.rows(); ++row) {
      const int step = days_.step_at(recording_.time(static_cast<std::size_t>(row))) - 1;
      table_(row, column) = values[static_cast<std::size_t>(step)] * factor + offset;
    }
  }

  void take_duty(int column, int fcu) {
    std::string schedule = twin_.names.fcu_on_schedule;
    if (const auto mark = schedule.find('#'); mark != std::string::npos)
      schedule.replace(mark, 1, std::to_string(fcu + 1));
    const auto& values = steps_of(schedule + ",Schedule Value");
    for (Eigen::Index row = 0; row < table_.rows(); ++row) {
      const auto step = static_cast<std::size_t>(days_.step_at(recording_.time(static_cast<std::size_t>(row))));
      table_(row, column) = (values[step] + values[step + 1]) / 2;
    }
  }

  void take_recorded_duty(int column, int fcu) {
    for (Eigen::Index row = 0; row < table_.rows(); ++row)
      table_(row, column) = recording_.rows[static_cast<std::size_t>(row)].fcu_on[static_cast<std::size_t>(fcu)];
  }

  const EnergyPlusTwin& twin_;
  const Recording& recording_;
  const ReplayDays& days_;
  EsoFile outputs_;
  ChannelTable table_;
};

}  // namespace

EnergyPlusTwin twin_of(const EnergyPlusOptions& options) {
  EnergyPlusTwin twin{compose_model(options, find_energyplus().schema), options.rooms, options.names};
  if (!options.own) return twin;
  free_command_schedules(twin.model, *options.own);
  twin.own = options.own;
  twin.step_s = 60 * options.step_min;
  twin.names.interior_zones = options.own->zones;
  twin.names.perimeter_zones = options.own->fcu_zones;
  twin.names.supply_setpoint_schedule = options.own->supply_setpoint_schedule;
  twin.names.powers = options.own->powers;
  twin.loops.dampers.assign(options.own->zones.size(), 1);
  return twin;
}

Channels channels_of(const EnergyPlusTwin& twin) {
  Channels channels{static_cast<int>(twin.names.interior_zones.size()),
                    static_cast<int>(twin.names.perimeter_zones.size()), 2};
  if (!twin.own) return channels;
  channels.powers = static_cast<int>(twin.own->powers.size());
  const auto& terminals = twin.own->terminals;
  if (std::any_of(terminals.begin(), terminals.end(), [](const std::string& name) { return !name.empty(); }))
    channels.dampers = channels.rooms;
  channels.grain = twin.own->grain;
  return channels;
}

ChannelTable replay_energyplus(const EnergyPlusTwin& twin, const Recording& recording, const ReplayOptions& options) {
  const EnergyPlusInstall install = find_energyplus();
  const ReplayDays days = replay_days(twin, recording);
  const ReplayCommands commands = replay_commands(twin, recording, days, options.thermostats);
  nlohmann::json model = replay_model(twin, days, commands, options.thermostats);
  const Weather weather = replay_weather(recording, days);

  const auto run = [&](const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    follow_commands(model, days, commands);
    write_epw((folder / "weather.epw").string(), weather, days.year);
    std::ofstream(folder / "model.epJSON", std::ios::binary) << model.dump(1) << '\n';
    std::ofstream(folder / "README.txt") << "A replay by EnergyPlus 25.2. This command, in this folder, repeats it:\n"
                                         << repeat_command << "\n";
    if (options.engine_runs != nullptr) ++*options.engine_runs;
    run_engine(install, folder);
    const auto periods = twin.own ? EsoFile::Periods::last : EsoFile::Periods::one;
    EsoFile outputs(folder / "out" / "eplusout.eso", periods);
    return TableMaker(twin, recording, days, std::move(outputs)).table(options.thermostats);
  };
  const ReplayCache cache(options.cache);
  const bool keyed = options.memory != nullptr || !options.cache.empty();
  const ReplayKey key =
      keyed ? key_of({engine_version(install), model.dump()}, twin, recording, days, commands, weather) : ReplayKey{};
  const auto find_or_run = [&] {
    const auto rows = static_cast<Eigen::Index>(recording.rows.size());
    if (auto known = cache.find(key, rows, channels_of(twin).count())) return *std::move(known);
    ChannelTable table = run(RunFolder().path());
    cache.put(key, table);
    return table;
  };
  if (!options.keep.empty()) {
    ChannelTable table = run(options.keep);
    cache.put(key, table);
    return table;
  }
  return options.memory != nullptr ? *options.memory->get(key, find_or_run) : find_or_run();
}

}  // namespace airside::sim
