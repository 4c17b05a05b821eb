#include "tools/study/method/runs_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "sim/json/json_file.hpp"
#include "tools/study/method/results.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

constexpr const char* file_kind = "runs of airside study method";

void write(const fs::path& path, const std::string& text) {
  hal::StagedFile file(path.string());
  file.write(text);
  file.commit();
}

[[noreturn]] void refuse_runs(const std::string& file, const std::string& field, const std::string& found,
                              const std::string& expected) {
  throw hal::InputError(file + ": " + field, found, expected, "give a file that airside study method --keep wrote");
}

/// A row's name, a room's and a seed make the file's name: none of them may name another folder.
bool is_name(const std::string& text) {
  return !text.empty() && text.find('/') == std::string::npos && !text.starts_with('.');
}

std::string name_of(const std::string& file, const nlohmann::json& run) {
  const auto is_text = [&run](const char* field) { return run.contains(field) && run[field].is_string(); };
  if (!run.is_object() || !is_text("row") || !is_text("room") || !run.contains("seed") ||
      !run["seed"].is_number_unsigned()) {
    refuse_runs(file, "runs", run.dump().substr(0, 60), "runs with row, room and seed");
  }
  const std::string row = run["row"], room = run["room"];
  const bool is_known =
      std::ranges::any_of(method_rows(), [&row](const MethodRow& r) { return std::string_view(r.name) == row; });
  if (!is_known) refuse_runs(file, "row", row, "a row of this program's studies");
  if (!is_name(room)) refuse_runs(file, "room", room, "the name of a room");
  return fmt::format("{}_{}_{}.json", row, room, run["seed"].get<std::uint64_t>());
}

}  // namespace

int keep_runs(const MethodStudy& study, const std::string& file) {
  nlohmann::json runs = nlohmann::json::array();
  for (const fs::path& path : run_files(study)) runs.push_back(sim::read_json(path));
  // A line a run: differences between two versions of the file stay readable.
  std::string text = fmt::format("{{\"kind\":\"{}\",\"runs\":[\n", file_kind);
  for (std::size_t i = 0; i < runs.size(); ++i) text += runs[i].dump() + (i + 1 < runs.size() ? ",\n" : "\n");
  write(file, text + "]}\n");
  return static_cast<int>(runs.size());
}

int take_runs(const MethodStudy& study, const std::string& file) {
  const nlohmann::json j = sim::read_json(file);
  if (!j.is_object() || j.value("kind", "") != file_kind)
    refuse_runs(file, "kind", "nothing", std::string("\"") + file_kind + '"');
  if (!j.contains("runs") || !j["runs"].is_array()) refuse_runs(file, "runs", "no list", "a list of runs");
  std::vector<fs::path> paths;
  for (const nlohmann::json& run : j["runs"]) {
    paths.push_back(fs::path(study.folder) / name_of(file, run));
    check_run(file, run, study);
  }
  fs::create_directories(study.folder);
  int taken = 0;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (fs::exists(paths[i])) continue;
    write(paths[i], j["runs"][i].dump(1) + "\n");
    ++taken;
  }
  return taken;
}

}  // namespace airside::tools
