// Files that are no model of the engine's version. None of these needs the engine: they are refused before it runs.

#include <gtest/gtest.h>

#include <fstream>

#include "adopt/small_model.hpp"
#include "support/complaint.hpp"
#include "support/program.hpp"
#include "tools/adopt/model/foreign_file.hpp"

namespace airside::tools {
namespace {

/// An install that is asked for its version alone.
const sim::EnergyPlusInstall nowhere{"/nowhere", "/nowhere/libenergyplusapi.so", "/nowhere/schema"};

struct FileCase {
  const char* name;
  const char* file;
  std::string text;
  hal::Complaint want;
};

void PrintTo(const FileCase& c, std::ostream* out) { *out << c.name; }

std::string model_text(const char* patch) { return small_model_with(patch).dump(); }

std::vector<FileCase> files() {
  return {
      {"Empty", "m.idf", "", {"m.idf", "an empty file", "EnergyPlus model", "copy is whole"}},
      {"OnlyBlanks", "m.epJSON", " \n\t\n", {"m.epJSON", "an empty file", "EnergyPlus model", "copy is whole"}},
      {"NoJson", "m.epJSON", "{\"Zone\": {\n", {"m.epJSON:2", "not JSON", "JSON object", "ends early"}},
      {"IdfNamedEpjson", "m.epJSON", "Version,25.2;\n", {"m.epJSON:1", "not JSON", "", ""}},
      {"JsonNamedIdf", "m.idf", "[1]", {"m.idf", "array", "object types", ""}},
      {"Prose", "m.idf", "Dear all\n", {"m.idf", "neither JSON nor an IDF", ".epJSON", "right file"}},
      {"Picture", "m.idf", "\x89PNG\r\n\x1a\n", {"m.idf", "neither JSON nor an IDF", ".epJSON", "right file"}},
      {"IdfOfAVersionTooOld",
       "m.idf",
       "! by hand\n  Version, 8.8 ;\nZone,A;\n",
       {"m.idf: Version", "EnergyPlus 8.8", "EnergyPlus 8.9 to 25.2", "--transitions"}},
      {"IdfOfANewVersion",
       "m.idf",
       "VERSION,26.1;",
       {"m.idf: Version", "EnergyPlus 26.1, newer than the engine", "8.9 to 25.2", "save it for 25.2"}},
      {"IdfThatNoTableUpgrades",
       "m.idf",
       "Version,9.1;\nTable:OneIndependentVariable,T;\n",
       {"m.idf:2: Table:OneIndependentVariable / T", "9.1 that 9.2 changed", "", "--transitions"}},
      {"IdfWithoutVersion", "m.idf", "Zone,A;\n", {"m.idf: Version", "no version", "25.2", "add the object Version"}},
      {"IdfWithVersionInAComment",
       "m.idf",
       "! Version,25.2;\nZone,A;\n",
       {"m.idf: Version", "no version", "25.2", "add"}},
      {"EpjsonOfAVersionTooOld",
       "m.epJSON",
       model_text(R"({"Version": {"Version": {"version_identifier": "8.8"}}})"),
       {"m.epJSON: Version", "EnergyPlus 8.8", "8.9 to 25.2", "give the IDF"}},
      {"EpjsonOfANewVersion",
       "m.epJSON",
       model_text(R"({"Version": {"Version": {"version_identifier": "26.1"}}})"),
       {"m.epJSON: Version", "newer than the engine", "25.2", "save it for 25.2"}},
      {"EpjsonWithoutVersion",
       "m.epJSON",
       model_text(R"({"Version": null})"),
       {"m.epJSON: Version", "no version", "25.2", "add the object Version"}},
      {"TemplatesInEpjson",
       "m.epJSON",
       model_text(R"({"HVACTemplate:System:VAV": {"AHU": {}}})"),
       {"m.epJSON: HVACTemplate", "template objects", "equipment", "give the IDF"}},
      {"ScheduleFileNowhere",
       "m.epJSON",
       model_text(R"({"Schedule:File": {"People": {"file_name": "people.csv"}}})"),
       {"Schedule:File / People / file_name", "\"people.csv\"", "beside the model", "copy it there"}},
      {"KeyTwice", "m.epJSON", R"({"Zone": {}, "Zone": {}})", {"m.epJSON: Zone", "twice", "once", "remove"}},
  };
}

class BrokenFile : public testing::TestWithParam<FileCase> {};

TEST_P(BrokenFile, IsRefusedBeforeTheEngineRuns) {
  const FileCase& c = GetParam();
  const TemporaryFolder folder;
  std::ofstream(folder.path() / c.file) << c.text;
  hal::expect_complaint(c.want, [&] { (void)read_foreign_model(folder.path() / c.file, nowhere); });
}

std::string file_case_name(const testing::TestParamInfo<FileCase>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(File, BrokenFile, testing::ValuesIn(files()), file_case_name);

TEST(BrokenFiles, MissingModelAndFolderInsteadAreRefused) {
  const TemporaryFolder folder;
  hal::expect_complaint({"none.idf", "no file that can be read", "EnergyPlus model", ""},
                        [&] { (void)read_foreign_model(folder.path() / "none.idf", nowhere); });
  hal::expect_complaint({folder.path().c_str(), "", "EnergyPlus model", ""},
                        [&] { (void)read_foreign_model(folder.path(), nowhere); });
}

TEST(BrokenFiles, FileBesideTheModelIsNamedByItsWholePath) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "people.csv") << "1\n";
  std::ofstream(folder.path() / "m.epJSON") << model_text(R"({"Schedule:File": {"P": {"file_name": "people.csv"}}})");
  const auto model = read_foreign_model(folder.path() / "m.epJSON", nowhere);
  EXPECT_EQ(model.content["Schedule:File"]["P"]["file_name"], (folder.path() / "people.csv").string());
}

}  // namespace
}  // namespace airside::tools
