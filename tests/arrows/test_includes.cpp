#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "arrows/include_rules.hpp"

namespace airside::arrows {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Files below `folder` whose name ends in one of `endings`.
std::vector<fs::path> files_of(const std::string& folder, const std::set<std::string>& endings) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(AIRSIDE_SOURCE_DIR) / folder)) {
    const std::string name = entry.path().filename().string();
    for (const std::string& ending : endings) {
      if (entry.is_regular_file() && name.ends_with(ending)) files.push_back(entry.path());
    }
  }
  return files;
}

std::string joined(const Breaches& breaches) {
  std::string text;
  for (const std::string& breach : breaches) text += breach + "\n";
  return text;
}

TEST(Arrows, EveryIncludeFollowsThem) {
  for (const auto& [folder, allowed] : may_include) {
    for (const fs::path& file : files_of(folder, {".hpp", ".cpp", ".h", ".c", ".inc"})) {
      EXPECT_EQ(joined(include_breaches(folder, file.string(), text_of(file))), "");
    }
  }
  EXPECT_GT(files_of("lib", {".hpp"}).size(), 10u) << "the sources were not found";
}

TEST(Arrows, EveryBuildFileFollowsThem) {
  for (const auto& [folder, allowed] : may_include) {
    for (const fs::path& file : files_of(folder, {"CMakeLists.txt", ".cmake"})) {
      EXPECT_EQ(joined(target_breaches(folder, file.string(), text_of(file))), "");
    }
  }
}

TEST(Arrows, NoBuildFileGivesUpNanChecks) {
  std::vector<fs::path> files{fs::path(AIRSIDE_SOURCE_DIR) / "CMakeLists.txt",
                              fs::path(AIRSIDE_SOURCE_DIR) / "CMakePresets.json"};
  for (const char* folder : {"lib", "hal", "sim", "firmware", "tools", "toolchains"}) {
    for (const fs::path& file : files_of(folder, {"CMakeLists.txt", ".cmake", ".hpp", ".cpp"})) files.push_back(file);
  }
  for (const fs::path& file : files) EXPECT_EQ(joined(fast_math_breaches(file.string(), text_of(file))), "");
}

TEST(Arrows, RefuseWhatPointsBackwards) {
  EXPECT_EQ(include_breaches("lib", "x.hpp", "#include \"hal/clock.hpp\"\n").size(), 1u);
  EXPECT_EQ(include_breaches("hal", "x.hpp", "#pragma once\n  # include \"sim/rc/rc_plant.hpp\"\n").front(),
            "x.hpp:2: hal includes sim/rc/rc_plant.hpp");
  EXPECT_EQ(include_breaches("sim", "x.hpp", "#include \"tools/report.hpp\"\n").size(), 1u);
  EXPECT_EQ(include_breaches("firmware", "x.hpp", "#include \"sim/weather/weather.hpp\"\n").size(), 1u);
  EXPECT_EQ(include_breaches("tools", "x.hpp", "#include \"tests/golden.hpp\"\n").size(), 1u);
  EXPECT_EQ(include_breaches("hal", "x.hpp", "#include \"../sim/weather.hpp\"\n").size(), 1u);
  EXPECT_EQ(target_breaches("hal", "x", "target_link_libraries(airside_hal PUBLIC airside_sim)").size(), 1u);
  EXPECT_EQ(fast_math_breaches("x", "add_compile_options(-O2 -ffast-math)").size(), 1u);
}

TEST(Arrows, RefuseHeadersThatAllocateOrDoIo) {
  for (const char* name : {"iostream", "fstream", "thread", "mutex", "vector", "string", "map", "memory", "functional",
                           "chrono", "filesystem", "cstdio", "random", "fmt/core.h", "Eigen/Sparse", "unistd.h"}) {
    const std::string text = std::string("#include <") + name + ">\n";
    EXPECT_EQ(include_breaches("lib", "x.hpp", text).size(), 1u) << name;
    EXPECT_EQ(include_breaches("hal", "x.hpp", text).size(), 0u) << name;
  }
}

TEST(Arrows, AcceptWhatPointsForwards) {
  EXPECT_EQ(joined(include_breaches("lib", "x.hpp", "#include <Eigen/Core>\n#include \"airside/reading.hpp\"\n")), "");
  EXPECT_EQ(joined(include_breaches("tools", "x.cpp", "#include \"sim/weather/weather.hpp\"\n#include <vector>\n")),
            "");
  EXPECT_EQ(joined(target_breaches("sim", "x", "target_link_libraries(airside_sim PUBLIC airside_hal)")), "");
}

}  // namespace
}  // namespace airside::arrows
