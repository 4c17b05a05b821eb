#include "tools/adopt/model/transitions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <regex>

#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "sim/energyplus/process.hpp"
#include "tools/adopt/model/engine_run.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct Transition {
  fs::path program;
  std::string from, to;              ///< short
  std::string from_whole, to_whole;  ///< "9-6-0"
};

std::vector<Transition> transitions_in(const fs::path& folder) {
  static const std::regex name(R"(Transition-V(\d+)-(\d+)-(\d+)-to-V(\d+)-(\d+)-(\d+)(\.exe)?)");
  std::vector<Transition> found;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string file = entry.path().filename().string();
    std::smatch v;
    if (!std::regex_match(file, v, name)) continue;
    found.push_back({entry.path(), fmt::format("{}.{}", v[1].str(), v[2].str()),
                     fmt::format("{}.{}", v[4].str(), v[5].str()),
                     fmt::format("{}-{}-{}", v[1].str(), v[2].str(), v[3].str()),
                     fmt::format("{}-{}-{}", v[4].str(), v[5].str(), v[6].str())});
  }
  return found;
}

constexpr const char* inside_an_install = "PreProcess/IDFVersionUpdater";

/// The folder itself or that of the install; empty where neither has programs.
fs::path programs_of(const fs::path& folder) {
  for (const fs::path& place : {folder, folder / inside_an_install}) {
    if (!transitions_in(place).empty()) return place;
  }
  return {};
}

std::vector<Transition> chain(const fs::path& programs, const std::string& from, const std::string& to) {
  const std::vector<Transition> all = transitions_in(programs);
  std::vector<Transition> steps;
  std::string at = from;
  while (at != to) {
    const auto next =
        std::ranges::find_if(all, [&](const Transition& t) { return t.from == at && is_older(at, t.to); });
    if (next == all.end()) {
      throw hal::InputError(programs.string(), fmt::format("no program that leads on from version {}", at),
                            fmt::format("a chain of Transition programs from {} to {}", from, to),
                            fmt::format("name the folder of an EnergyPlus {} install", to));
    }
    steps.push_back(*next);
    at = next->to;
  }
  return steps;
}

/// What a Transition program reads in its working folder.
void copy_beside(const Transition& step, const fs::path& folder) {
  const fs::path programs = step.program.parent_path();
  for (const std::string& file :
       {fmt::format("V{}-Energy+.idd", step.from_whole), fmt::format("V{}-Energy+.idd", step.to_whole),
        fmt::format("Report Variables {} to {}.csv", step.from_whole, step.to_whole)}) {
    std::error_code failed;
    fs::copy_file(programs / file, folder / file, fs::copy_options::skip_existing, failed);
  }
}

void run_step(const Transition& step, const fs::path& folder, const std::string& place) {
  copy_beside(step, folder);
  const EngineRun run = run_engine_program(step.program, {(folder / "in.idf").string()}, folder, 300);
  // The programs write in.idfnew, or in.idf itself with the old one in in.idfold.
  if (fs::is_regular_file(folder / "in.idfnew")) fs::rename(folder / "in.idfnew", folder / "in.idf");
  if (!run.done) {
    throw hal::InputError(place,
                          fmt::format("a model that {} refuses: it {}", step.program.filename().string(), run.words),
                          "a model of EnergyPlus " + step.from, "correct it as the program says");
  }
}

}  // namespace

fs::path transitions_folder(const std::string& option, const fs::path& engine) {
  const char* variable = std::getenv("AIRSIDE_TRANSITIONS");
  const std::string wanted = !option.empty() ? option : variable != nullptr ? variable : "";
  if (wanted.empty()) return programs_of(engine);
  const fs::path found = programs_of(wanted);
  if (found.empty()) {
    throw hal::InputError(option.empty() ? "AIRSIDE_TRANSITIONS" : "--transitions",
                          "\"" + wanted + "\", a folder without Transition programs",
                          fmt::format("an EnergyPlus install, or its folder {}", inside_an_install),
                          "correct the folder, or leave it out: the tables of this program are used then");
  }
  return found;
}

std::string transitioned_idf(const std::string& text, const std::string& place, const std::string& from,
                             const std::string& to, const fs::path& programs, Upgrade& done) {
  const std::vector<Transition> steps = chain(programs, from, to);
  const sim::RunFolder folder;
  std::ofstream(folder.path() / "in.idf", std::ios::binary) << text;
  for (const Transition& step : steps) run_step(step, folder.path(), place);
  done = {from, to, programs.string(), {}};
  return hal::read_text_file((folder.path() / "in.idf").string(), "an IDF that a Transition program has written");
}

}  // namespace airside::tools
