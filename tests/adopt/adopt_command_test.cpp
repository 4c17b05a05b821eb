// The command as a person types it: what it refuses leaves nothing, and what is there already stays.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "adopt/foreign_models.hpp"
#include "adopt/template_model.hpp"
#include "support/complaint.hpp"
#include "support/program.hpp"
#include "tools/gap/map/mapped_model.hpp"

namespace airside::tools {
namespace {

class AdoptCommand : public testing::Test {
 protected:
  /// Runs `airside adopt m.idf -o site` with further words.
  Outcome adopt(const std::string& model, std::vector<std::string> more = {}) {
    std::ofstream(folder_.path() / "m.idf") << model;
    std::vector<std::string> words = {"adopt", "m.idf", "-o", "site"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program("airside", words, folder_.path(), scratch_.path(), 300);
  }

  /// Refused with this, and without a trace.
  void expect_refused(const Outcome& outcome, const hal::Complaint& want) {
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    for (const char* part : {want.place, want.found, want.expected, want.remedy})
      EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " in: " << outcome.err;
    EXPECT_EQ(names_in(folder_.path()), std::set<std::string>{"m.idf"});
  }

  TemporaryFolder folder_, scratch_;
};

std::string changed(const std::string& from, const std::string& to) { return hal::replaced(template_model, from, to); }

TEST_F(AdoptCommand, WritesASiteAndLeavesItToItsOwner) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  const Outcome first = adopt(template_model, {"--json"});
  ASSERT_EQ(first.code, 0) << first.err;
  const auto said = nlohmann::json::parse(first.out);
  EXPECT_EQ(said["air_loop"], "Anlage 1");
  EXPECT_EQ(said["site"], "site/site.toml");
  EXPECT_EQ(said["advice"]["verdict"], "schedule")
      << "the loop is weak, and the coldest air holds its rooms best: " << said["advice"];
  EXPECT_EQ(said["autumn"]["constants"].size(), 4U);
  const auto names = names_in(folder_.path() / "site");
  EXPECT_EQ(names, (std::set<std::string>{"site.toml", "points.csv", "model.epJSON", "twin.patch.json", "map.toml",
                                          "adopt.md", said["weather"].get<std::string>()}));
  const gap::Mapping map = gap::read_mapping((folder_.path() / "site" / "map.toml").string());
  EXPECT_TRUE(std::filesystem::exists(gap::prepare_mapped_model(map, scratch_.path() / "runs")))
      << "the engine shows what the first mapping names";
  std::ofstream(folder_.path() / "site" / "adopt.md") << "mine";
  const Outcome second = adopt(template_model);
  EXPECT_EQ(second.code, 1);
  EXPECT_NE(second.err.find("a folder that has files already"), std::string::npos) << second.err;
  EXPECT_EQ(text_of_file(folder_.path() / "site" / "adopt.md"), "mine");
  EXPECT_EQ(adopt(template_model, {"--force"}).code, 0);
  EXPECT_NE(text_of_file(folder_.path() / "site" / "adopt.md"), "mine");
}

TEST_F(AdoptCommand, AdviceIsPrintedAndRepeatedByACheckOfTheTwin) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  const Outcome adopted = adopt(template_model);
  ASSERT_EQ(adopted.code, 0) << adopted.err;
  const auto at = adopted.out.find("advice: ");
  ASSERT_NE(at, std::string::npos) << adopted.out;
  const std::string headline = adopted.out.substr(at + 8, adopted.out.find('\n', at) - at - 8);
  EXPECT_NE(adopted.err.find("18 runs of the engine"), std::string::npos) << adopted.err;
  const Outcome check = run_program("airside", {"check", "site/site.toml", "--twin"}, folder_.path(), scratch_.path());
  EXPECT_EQ(check.code, 0) << check.out << check.err;
  EXPECT_NE(check.out.find("adopt.md: " + headline), std::string::npos) << check.out;
}

TEST_F(AdoptCommand, RefusesMissingWeather) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  expect_refused(adopt(template_model, {"--weather", "none.epw"}),
                 {"none.epw", "no such weather file", "EPW file of a whole year", "leave --weather out"});
}

TEST_F(AdoptCommand, RefusesAMissingSchedule) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  expect_refused(adopt(changed("People,Leute Nord,Raum Nord,Bürozeit", "People,Leute Nord,Raum Nord,Nachts")),
                 {"People / Leute Nord", "the name \"Nachts\", which no object has", "name of an object", ""});
}

TEST_F(AdoptCommand, RefusesAnIdfThatIsCutShort) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  const std::string whole = template_model;
  expect_refused(adopt(whole.substr(0, whole.find("Raum Nord,,Outdoors"))), {"m.idf", "", "", ""});
}

TEST_F(AdoptCommand, RefusesAnObjectThatTheEngineDoesNotKnow) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  expect_refused(adopt(std::string(template_model) + "\nZon,Keller;\n"), {"m.idf", "", "", "correct"});
}

TEST_F(AdoptCommand, RefusesAModelThatTheEngineDoesNotRun) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  expect_refused(adopt(changed("Material,Brick,Rough,0.2,0.7", "Material,Brick,Rough,0.2,0.00001")), {"", "", "", ""});
}

TEST_F(AdoptCommand, RefusesAFileWhereTheFolderShouldBe) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  std::ofstream(folder_.path() / "site") << "a file";
  const Outcome outcome = adopt(template_model);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("site: found a file; expected a folder"), std::string::npos) << outcome.err;
}

TEST_F(AdoptCommand, SignalLeavesNothing) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  std::ofstream(folder_.path() / "m.idf") << template_model;
  // alarm() of run_program ends it in the middle of the engine's runs.
  (void)run_program("airside", {"adopt", "m.idf", "-o", "site"}, folder_.path(), scratch_.path(), 1);
  const auto names = names_in(folder_.path());
  EXPECT_TRUE(names == std::set<std::string>{"m.idf"} || names.contains("site/site.toml")) << names.size();
}

}  // namespace
}  // namespace airside::tools
