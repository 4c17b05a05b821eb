#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "arrows/include_rules.hpp"

namespace airside::arrows {
namespace {

namespace fs = std::filesystem;

const fs::path source_dir = AIRSIDE_SOURCE_DIR;
const fs::path list_file = source_dir / "tests/arrows/arrows.txt";

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Files below `folder` whose name ends in one of `endings`.
std::vector<fs::path> files_of(const std::string& folder, const std::set<std::string>& endings) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(source_dir / folder)) {
    const std::string name = entry.path().filename().string();
    for (const std::string& ending : endings) {
      if (entry.is_regular_file() && name.ends_with(ending)) files.push_back(entry.path());
    }
  }
  return files;
}

std::vector<fs::path> sources() {
  std::vector<fs::path> files;
  for (const char* top : tops) {
    for (const fs::path& file : files_of(top, {".hpp", ".cpp", ".h", ".c", ".inc"})) files.push_back(file);
  }
  return files;
}

std::string wing_of_file(const fs::path& file) { return wing_of(fs::relative(file, source_dir).string()); }

Graph used_arrows() {
  Graph used;
  for (const fs::path& file : sources()) {
    const std::string wing = wing_of_file(file);
    used[wing].merge(wings_included(wing, text_of(file)));
  }
  return used;
}

std::string joined(const Breaches& breaches) {
  std::string text;
  for (const std::string& breach : breaches) text += breach + "\n";
  return text;
}

/// The comments at the head of the list.
std::string head_of(const std::string& text) {
  std::istringstream in(text);
  std::string head, line;
  while (std::getline(in, line) && (line.empty() || line[0] == '#')) head += line + "\n";
  return head;
}

Graph arrows() {
  Breaches breaches;
  return read_arrows(text_of(list_file), breaches);
}

// AIRSIDE_UPDATE_ARROWS=1 writes the tightest list for the sources as they are: look at its diff, then commit it.
TEST(Arrows, HaveNoCycleAndNoneToSpare) {
  Breaches breaches;
  const std::string tightest = head_of(text_of(list_file)) + arrows_text(used_arrows(), breaches);
  ASSERT_EQ(joined(breaches), "");
  if (std::getenv("AIRSIDE_UPDATE_ARROWS") != nullptr) std::ofstream(list_file) << tightest;
  const Graph listed = read_arrows(text_of(list_file), breaches);
  EXPECT_EQ(joined(breaches), "");
  const Graph used = used_arrows();
  for (const auto& [wing, others] : listed) {
    for (const std::string& other : others) {
      EXPECT_TRUE(used.contains(wing) && used.at(wing).contains(other)) << wing << " no longer includes " << other;
    }
  }
}

TEST(Arrows, EveryIncludeFollowsThem) {
  const Graph listed = arrows();
  for (const fs::path& file : sources()) {
    EXPECT_EQ(joined(include_breaches(listed, wing_of_file(file), file.string(), text_of(file))), "");
  }
  EXPECT_GT(files_of("lib", {".hpp"}).size(), 10u) << "the sources were not found";
}

TEST(Arrows, EveryBuildFileFollowsThem) {
  const Graph listed = arrows();
  for (const char* top : tops) {
    for (const fs::path& file : files_of(top, {"CMakeLists.txt", ".cmake"})) {
      EXPECT_EQ(joined(target_breaches(listed, top, file.string(), text_of(file))), "");
    }
  }
}

TEST(Arrows, NoBuildFileGivesUpNanChecks) {
  std::vector<fs::path> files{source_dir / "CMakeLists.txt", source_dir / "CMakePresets.json"};
  for (const char* folder : {"lib", "hal", "sim", "firmware", "tools", "toolchains"}) {
    for (const fs::path& file : files_of(folder, {"CMakeLists.txt", ".cmake", ".hpp", ".cpp"})) files.push_back(file);
  }
  for (const fs::path& file : files) EXPECT_EQ(joined(fast_math_breaches(file.string(), text_of(file))), "");
}

const Graph example = {{"lib/airside", {}},
                       {"hal/text", {"lib/airside"}},
                       {"hal/modbus", {"hal/text", "lib/airside"}},
                       {"sim", {"lib/airside"}},
                       {"firmware/edge", {"lib/airside", "hal/modbus"}},
                       {"tools/gap", {"hal/text", "sim"}},
                       {"tools/report", {"tools/gap"}}};

TEST(Arrows, RefuseWhatPointsBackwards) {
  const auto refused = [](const char* wing, const char* name) {
    const std::string text = "#pragma once\n  # include \"" + std::string(name) + "\"\n";
    return include_breaches(example, wing, "x.hpp", text) ==
           Breaches{"x.hpp:2: " + std::string(wing) + " includes " + name};
  };
  EXPECT_TRUE(refused("lib/airside", "hal/text/number_text.hpp"));
  EXPECT_TRUE(refused("hal/modbus", "sim/rc/rc_plant.hpp"));
  EXPECT_TRUE(refused("hal/text", "hal/modbus/link.hpp")) << "wings of one top folder";
  EXPECT_TRUE(refused("tools/gap", "tools/report/report.hpp"));
  EXPECT_TRUE(refused("tools/report", "sim/plant_model.hpp")) << "what tools/gap may include is not handed on";
  EXPECT_TRUE(refused("lib/airside", "airside/network/adam.hpp")) << "a folder below is another wing";
  EXPECT_TRUE(refused("tools/gap", "tests/golden/golden.hpp"));
  EXPECT_EQ(include_breaches(example, "hal/text", "x.hpp", "#include \"../sim/weather.hpp\"\n").size(), 1u);
  EXPECT_EQ(include_breaches(example, "hal/new", "x.hpp", "").size(), 1u) << "a wing that is not listed";
  EXPECT_EQ(target_breaches(example, "hal", "x", "target_link_libraries(airside_hal PUBLIC airside_sim)").size(), 1u);
  EXPECT_EQ(fast_math_breaches("x", "add_compile_options(-O2 -ffast-math)").size(), 1u);
}

TEST(Arrows, RefuseAListWithACycle) {
  Breaches breaches;
  read_arrows("hal/log: hal/text\nhal/text: hal/log\n", breaches);
  EXPECT_EQ(joined(breaches), "arrows.txt:1: hal/log may include only wings listed before it, not hal/text\n");
  breaches.clear();
  read_arrows("hal/text:\nhal/log: hal/text\nhal/text:\n", breaches);
  EXPECT_EQ(joined(breaches), "arrows.txt:3: hal/text is listed twice\n");
  breaches.clear();
  EXPECT_EQ(arrows_text({{"hal/log", {"hal/text"}}, {"hal/text", {"hal/log"}}, {"lib/airside", {}}}, breaches),
            "lib/airside:\n");
  EXPECT_EQ(breaches.size(), 2u);
  breaches.clear();
  arrows_text({{"lib/airside", {"hal/text"}}, {"hal/text", {}}}, breaches);
  EXPECT_EQ(breaches.size(), 1u) << "lib below hal, although that is no cycle";
}

TEST(Arrows, RefuseHeadersThatAllocateOrDoIo) {
  for (const char* name : {"iostream", "fstream", "thread", "mutex", "vector", "string", "map", "memory", "functional",
                           "chrono", "filesystem", "cstdio", "random", "fmt/core.h", "Eigen/Sparse", "unistd.h"}) {
    const std::string text = std::string("#include <") + name + ">\n";
    EXPECT_EQ(include_breaches(example, "lib/airside", "x.hpp", text).size(), 1u) << name;
    EXPECT_EQ(include_breaches(example, "hal/text", "x.hpp", text).size(), 0u) << name;
  }
}

TEST(Arrows, AcceptWhatPointsForwards) {
  EXPECT_EQ(joined(include_breaches(example, "lib/airside", "x.hpp",
                                    "#include <Eigen/Core>\n#include \"airside/reading.hpp\"\n")),
            "");
  EXPECT_EQ(joined(include_breaches(example, "tools/gap", "x.cpp",
                                    "#include \"sim/plant_model.hpp\"\n#include <vector>\n#include \"near.hpp\"\n")),
            "");
  EXPECT_EQ(joined(target_breaches(example, "tools", "x", "target_link_libraries(airside_tools PUBLIC airside_sim)")),
            "");
  Breaches breaches;
  EXPECT_EQ(read_arrows("# head\nlib/airside:\nhal/text: lib/airside\n", breaches),
            (Graph{{"lib/airside", {}}, {"hal/text", {"lib/airside"}}}));
  EXPECT_EQ(joined(breaches), "");
}

}  // namespace
}  // namespace airside::arrows
