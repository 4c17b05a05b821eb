// Logs that lie in several files, a day each, as one.
#include <algorithm>
#include <filesystem>
#include <iterator>

#include "hal/log/log_csv.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"

namespace airside::hal {
namespace {

void append_log(Log& all, Log&& part, const std::string& name) {
  if (part.extra_columns != all.extra_columns || part.has_controller != all.has_controller) {
    throw InputError(name + ":1", "other columns than in the files before", "the same header in every file",
                     "read the files one by one");
  }
  for (std::size_t i = 0; i < all.stood_in.size(); ++i) all.stood_in[i] = all.stood_in[i] || part.stood_in[i];
  const CivilTime last = all.summary.last, first = part.summary.first;
  if (first <= last) {
    throw InputError(name + ":2: time", civil_text(first),
                     "a time after " + civil_text(last) + ", where the file before ends",
                     "remove the rows that two files share");
  }
  const std::int64_t missing = (first.seconds - last.seconds) / row_s - 1;
  if (missing > 0) {
    all.summary.missing_rows += static_cast<std::size_t>(missing);
    all.summary.gaps.push_back({last, first, 2});
  }
  std::move(part.rows.begin(), part.rows.end(), std::back_inserter(all.rows));
  all.summary.gaps.insert(all.summary.gaps.end(), part.summary.gaps.begin(), part.summary.gaps.end());
  all.summary.missing_rows += part.summary.missing_rows;
  all.summary.missing_values += part.summary.missing_values;
  all.summary.rows = all.rows.size();
  all.summary.last = part.summary.last;
}

}  // namespace

Log read_log_files(const std::vector<std::string>& files, const TopologyCounts& counts, const LogReadOptions& options) {
  Log all = read_log_text(read_text_file(files.front(), "a CSV log"), files.front(), counts, options);
  for (std::size_t i = 1; i < files.size(); ++i) {
    append_log(all, read_log_text(read_text_file(files[i], "a CSV log"), files[i], counts, options), files[i]);
  }
  return all;
}

Log read_log(const std::string& path, const TopologyCounts& counts, const LogReadOptions& options) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return read_log_text(read_text_file(path, "a CSV log"), path, counts, options);
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) {
    throw InputError(path, "a directory without *.csv", "log files", "give the directory that the daemon logs to");
  }
  return read_log_files(files, counts, options);
}

}  // namespace airside::hal
