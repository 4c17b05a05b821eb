// A model whose names are not the project's runs by the names that its site file gives, and to the bit as it would by
// the project's own.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "sim/energyplus/install.hpp"
#include "sim/json/json_file.hpp"
#include "support/program.hpp"

namespace airside::sim {
namespace {

using nlohmann::json;

/// What somebody else would call things; # is 1 to 5.
const std::map<std::string, std::string>& other_names() {
  static const std::map<std::string, std::string> names = [] {
    const std::pair<const char*, const char*> each[] = {{"Interior #", "Interior Büro #"},
                                                        {"Perimeter #", "Perimeter Süd #"},
                                                        {"VAV # On", "Box # frei"},
                                                        {"VAV # Damper", "Box # Klappe"},
                                                        {"FCU # On", "Gerät # ein"},
                                                        {"Interior # Occupancy", "Leute innen #"},
                                                        {"Perimeter # Occupancy", "Leute außen #"}};
    std::map<std::string, std::string> all = {{"Supply Air Setpoint", "Zuluft Sollwert"},
                                              {"AHU Supply Fan Outlet", "Zuluft"},
                                              {"AHU Outside Air Inlet", "Außenluft"}};
    for (int n = 1; n <= 5; ++n) {
      for (const auto& [from, to] : each) {
        std::string a = from, b = to;
        a.replace(a.find('#'), 1, std::to_string(n));
        b.replace(b.find('#'), 1, std::to_string(n));
        all[a] = b;
      }
    }
    return all;
  }();
  return names;
}

std::string other(const std::string& name) {
  const auto found = other_names().find(name);
  return found == other_names().end() ? name : found->second;
}

/// The same model, with the other names wherever the project's stand.
json renamed(const json& node) {
  if (node.is_string()) return other(node.get<std::string>());
  json out = node;
  if (node.is_array()) {
    for (json& entry : out) entry = renamed(entry);
  } else if (node.is_object()) {
    out = json::object();
    for (const auto& [key, value] : node.items()) out[other(key)] = renamed(value);
  }
  return out;
}

constexpr const char* given_names = R"([twin.names]
interior_zones = ["Interior Büro 1", "Interior Büro 2", "Interior Büro 3", "Interior Büro 4", "Interior Büro 5"]
perimeter_zones = ["Perimeter Süd 1", "Perimeter Süd 2", "Perimeter Süd 3", "Perimeter Süd 4", "Perimeter Süd 5"]
supply_setpoint_schedule = "Zuluft Sollwert"
vav_on_schedule = "Box # frei"
vav_damper_schedule = "Box # Klappe"
fcu_on_schedule = "Gerät # ein"
interior_occupancy_schedule = "Leute innen #"
perimeter_occupancy_schedule = "Leute außen #"
supply_air_node = "Zuluft"
mau_outlet_node = "Außenluft"
)";

class GivenNames : public testing::Test {
 protected:
  void SetUp() override {
    if (!have_energyplus())
      GTEST_SKIP() << "\n*** EnergyPlus is not installed: run tools/setup. This test checked nothing. ***";
    const fs::path models = fs::path(AIRSIDE_SOURCE_DIR) / "sim" / "models";
    model_ = read_json(models / "twin.epJSON");
  }
  void write(const std::string& name, const json& model, const std::string& names) const {
    std::ofstream(folder_.path() / (name + ".epJSON")) << model.dump();
    std::ofstream(folder_.path() / (name + ".toml"))
        << fmt::format("[site]\nname = \"Haus\"\ntopology = \"5vav-5fcu-2power\"\n[twin]\nmodel = \"{}.epJSON\"\n",
                       name)
        << names;
  }
  Outcome simulate(const std::string& name) const {
    return run_program("airside",
                       {"simulate", "--site", name + ".toml", "--twin", "--plant", "energyplus", "--method", "expert",
                        "--expert-days", "0", "--days", "1", "--log", name + ".csv"},
                       folder_.path(), scratch_.path(), 200);
  }
  json model_;
  TemporaryFolder folder_, scratch_;
};

TEST_F(GivenNames, OfTheSiteFileReplaceTheProjectsOwn) {
  write("ours", model_, "");
  write("theirs", renamed(model_), given_names);
  const Outcome ours = simulate("ours"), theirs = simulate("theirs");
  ASSERT_EQ(ours.code, 0) << ours.err;
  ASSERT_EQ(theirs.code, 0) << theirs.err;
  const std::string log = text_of_file(folder_.path() / "theirs.csv");
  EXPECT_GT(log.size(), 20'000U);
  EXPECT_EQ(log, text_of_file(folder_.path() / "ours.csv"));
}

TEST_F(GivenNames, OneRunStartsTheEngineOnce) {
  write("ours", model_, "");
  const fs::path worker = folder_.path() / "worker", starts = folder_.path() / "starts";
  std::ofstream(worker) << fmt::format("#!/bin/sh\necho start >> {}\nexec {}/airside-energyplus \"$@\"\n",
                                       starts.string(), AIRSIDE_BIN_DIR);
  fs::permissions(worker, fs::perms::owner_all);
  setenv("AIRSIDE_ENERGYPLUS_WORKER", worker.c_str(), 1);
  const Outcome outcome = simulate("ours");
  unsetenv("AIRSIDE_ENERGYPLUS_WORKER");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("on EnergyPlus 25.2, twin"), std::string::npos) << outcome.out;
  EXPECT_EQ(text_of_file(starts), "start\n") << "the plant's description is that of the run";
}

TEST_F(GivenNames, AreNeededByAModelWhoseNamesAreNotTheProjects) {
  write("theirs", renamed(model_), "");
  const Outcome refused = simulate("theirs");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("Interior 1"), std::string::npos) << refused.err;
  EXPECT_FALSE(fs::exists(folder_.path() / "theirs.csv"));
}

}  // namespace
}  // namespace airside::sim
