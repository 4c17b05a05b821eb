#include "tools/report/logged_method.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <set>

#include "hal/text/input_error.hpp"
#include "tools/report/run_record.hpp"

namespace airside::tools {

namespace fs = std::filesystem;

namespace {

/// A name that hal::RowLog gives.
bool is_daily_file(const fs::path& path) {
  static const std::regex daily(R"(airside-\d{4}-\d{2}-\d{2}(_\d{2})?\.csv)");
  return std::regex_match(path.filename().string(), daily);
}

/// "log" of log/airside-2021-07-01.csv; "airside" where no folder is named.
std::string name_of_folder(const fs::path& folder) {
  const std::string name = folder.filename().string();
  return name.empty() || name == "." || name == ".." ? "airside" : name;
}

std::vector<LogGroup> natural_groups(const std::vector<std::string>& logs) {
  std::vector<LogGroup> groups;
  std::vector<fs::path> folders;  // of each group of daily files; empty for others
  for (const std::string& log : logs) {
    const fs::path path = fs::path(log).lexically_normal();
    if (!is_daily_file(path)) {
      const fs::path last = path.has_filename() ? path : path.parent_path();
      groups.push_back({last.stem().string(), {log}});
      folders.emplace_back();
      continue;
    }
    const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
    const auto at = std::find(folders.begin(), folders.end(), folder);
    if (at != folders.end()) {
      groups[static_cast<std::size_t>(at - folders.begin())].paths.push_back(log);
    } else {
      groups.push_back({name_of_folder(folder), {log}});
      folders.push_back(folder);
    }
  }
  return groups;
}

std::vector<LogGroup> named_one_by_one(const std::vector<std::string>& logs, const std::vector<std::string>& names) {
  std::vector<LogGroup> groups;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const std::string name = i < names.size() ? names[i] : fs::path(logs[i]).stem().string();
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const LogGroup& g) { return g.name == name; });
    if (same != groups.end() && i < names.size()) {
      same->paths.push_back(logs[i]);
    } else {
      groups.push_back({name, {logs[i]}});
    }
  }
  return groups;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What a log holds in a column that has no value within its bounds; throws where that tells why nothing is whole.
void explain_column(const std::string& place, const std::string& column, hal::LogLimits limits,
                    const std::vector<double>& as_read, const std::vector<double>& as_written) {
  const auto finite = [](double v) { return std::isfinite(v); };
  if (std::any_of(as_read.begin(), as_read.end(), finite)) return;
  std::vector<double> written;
  std::copy_if(as_written.begin(), as_written.end(), std::back_inserter(written), finite);
  const std::string bounds = fmt::format("numbers from {:g} to {:g} degC", limits.min, limits.max);
  if (written.empty()) {
    throw hal::InputError(place + ": " + column, "no number in any row", bounds,
                          "export the log with this sensor, or with a room temperature in its place");
  }
  const double typical = median(written), degc = (typical - 32) / 1.8;
  if (typical >= 50 && typical <= 110) {
    throw hal::InputError(place + ": " + column, fmt::format("values around {:.1f}, which look like degF", typical),
                          fmt::format("{}; {:.1f} degF are {:.1f} degC", bounds, typical, degc),
                          "convert every temperature, (F - 32) / 1.8, or export the log in degC");
  }
  throw hal::InputError(place + ": " + column, fmt::format("values around {:g}", typical), bounds,
                        "see which unit and scale this column was exported in");
}

hal::Log read_group(const Site& site, const LogGroup& group, const hal::LogReadOptions& options) {
  if (group.paths.size() == 1) return hal::read_log(group.paths.front(), site.counts, options);
  return hal::read_log_files(group.paths, site.counts, options);
}

/// Puts the files of a group into the order of their first rows.
void sort_by_time(const Site& site, LogGroup& group, const hal::LogReadOptions& options) {
  if (group.paths.size() == 1) return;
  std::vector<std::pair<CivilTime, std::string>> order;
  for (const std::string& path : group.paths) {
    order.emplace_back(hal::read_log(path, site.counts, options).summary.first, path);
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < order.size(); ++i) group.paths[i] = order[i].second;
}

/// Says why a log has no whole cycle, where a column tells.
void explain_no_cycle(const Site& site, const LogGroup& group, const hal::Log& log, const std::string& place) {
  hal::LogReadOptions all;
  all.keep_missing = true;
  for (hal::LogLimits& limits : all.limits) limits = {-1e300, 1e300};
  const hal::Log written = read_group(site, group, all);
  for (int i = 0; i < site.counts.vavs; ++i) {
    const auto column = [i](const hal::Log& of) {
      std::vector<double> values;
      for (const hal::LogRow& row : of.rows) values.push_back(row.value[static_cast<std::size_t>(i)]);
      return values;
    };
    const SignalId id = site.counts.signal(i);
    explain_column(place, hal::column_of(id), hal::default_log_limits[static_cast<std::size_t>(id.kind)], column(log),
                   column(written));
  }
  const auto setpoint = [](const hal::Log& of) {
    std::vector<double> values;
    for (const hal::LogRow& row : of.rows) values.push_back(row.setpoint_degc);
    return values;
  };
  explain_column(place, "setpoint_degc", hal::default_log_limits.back(), setpoint(log), setpoint(written));
}

}  // namespace

std::string LoggedMethod::place() const {
  if (paths.size() == 1) return paths.front();
  return fmt::format("{} .. {} ({} files)", paths.front(), paths.back(), paths.size());
}

std::vector<LogGroup> group_logs(const std::vector<std::string>& logs, const std::vector<std::string>& names) {
  if (names.size() > logs.size()) {
    throw hal::InputError("--name", fmt::format("{} names for {} logs", names.size(), logs.size()),
                          "at most one name a log, in the order of the logs", "leave the last names out");
  }
  std::vector<LogGroup> groups = natural_groups(logs);
  if (names.size() > groups.size()) {
    groups = named_one_by_one(logs, names);
  } else {
    for (std::size_t i = 0; i < names.size(); ++i) groups[i].name = names[i];
  }
  std::set<std::string> seen;
  for (const LogGroup& group : groups) {
    if (!seen.insert(group.name).second) {
      throw hal::InputError(group.paths.front(), "a second method named \"" + group.name + '"', "one name a method",
                            "name them with --name, once for each method in order");
    }
  }
  return groups;
}

std::vector<LoggedMethod> read_logged_methods(const Site& site, const std::vector<LogGroup>& groups) {
  hal::LogReadOptions options;
  options.keep_missing = true;
  std::vector<LoggedMethod> methods;
  for (LogGroup group : groups) {
    sort_by_time(site, group, options);
    LoggedMethod m{group.name, group.paths, {}, {}, {}};
    const std::string place = m.place();
    m.log = read_group(site, group, options);
    try {
      m.run = run_of_log(site, m.log, place);
    } catch (const hal::InputError&) {
      explain_no_cycle(site, group, m.log, place);
      throw;
    }
    try {
      m.metrics = metrics_of(site, m.run);
    } catch (const hal::InputError& e) {
      throw hal::InputError(place + ": " + e.place(), e.found(), e.expected(), e.remedy());
    }
    methods.push_back(std::move(m));
  }
  return methods;
}

}  // namespace airside::tools
