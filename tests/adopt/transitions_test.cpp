// EnergyPlus's own Transition programs, as far as this machine goes: programs of the same names that change the version
// alone. No real one can be had from a package registry.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "support/complaint.hpp"
#include "support/program.hpp"
#include "tools/adopt/model/foreign_file.hpp"
#include "tools/adopt/model/transitions.hpp"

namespace airside::tools {
namespace {

namespace fs = std::filesystem;

class Transitions : public testing::Test {
 protected:
  void SetUp() override { unsetenv("AIRSIDE_TRANSITIONS"); }

  /// A program that writes in.idfnew with the version, where its IDDs and list of variables lie beside it.
  void add(const std::string& from, const std::string& to, const std::string& script = {}) {
    const fs::path folder = install_.path() / "PreProcess" / "IDFVersionUpdater";
    fs::create_directories(folder);
    std::ofstream(folder / ("V" + from + "-Energy+.idd")) << "idd";
    std::ofstream(folder / ("V" + to + "-Energy+.idd")) << "idd";
    std::ofstream(folder / ("Report Variables " + from + " to " + to + ".csv")) << "csv";
    const fs::path program = folder / ("Transition-V" + from + "-to-V" + to);
    const std::string needs = "test -s 'V" + from + "-Energy+.idd' && test -s 'V" + to + "-Energy+.idd' || exit 3\n";
    std::ofstream(program) << "#!/bin/sh\n"
                           << (script.empty() ? needs + "{ cat \"$1\"; echo '! by " + to + "'; } > \"${1}new\"\n"
                                              : script);
    fs::permissions(program, fs::perms::owner_all);
  }

  std::string upgraded(const std::string& from, const std::string& to) {
    return transitioned_idf("Version,old;\n", "m.idf", from, to, transitions_folder(install_.path(), "/nowhere"),
                            done_);
  }

  TemporaryFolder install_;
  Upgrade done_;
};

TEST_F(Transitions, RunOneAfterTheOther) {
  add("8-0-0", "8-1-0");
  add("8-1-0", "9-6-0");
  add("9-6-0", "25-2-0");
  EXPECT_EQ(upgraded("8.1", "25.2"), "Version,old;\n! by 9-6-0\n! by 25-2-0\n");
  EXPECT_EQ(done_.from, "8.1");
  EXPECT_EQ(done_.to, "25.2");
  EXPECT_EQ(done_.programs, (install_.path() / "PreProcess" / "IDFVersionUpdater").string());
}

TEST_F(Transitions, OnesThatReplaceTheFileAreTakenToo) {
  add("9-6-0", "22-1-0", "mv \"$1\" \"${1}old\" && echo 'Version,22.1;' > \"$1\"\n");
  EXPECT_EQ(upgraded("9.6", "22.1"), "Version,22.1;\n");
}

TEST_F(Transitions, ChainThatEndsEarlyIsRefused) {
  add("8-0-0", "8-1-0");
  hal::expect_complaint(
      {install_.path().c_str(), "leads on from version 8.1", "from 8.0 to 25.2", "EnergyPlus 25.2 install"},
      [&] { (void)upgraded("8.0", "25.2"); });
}

TEST_F(Transitions, ProgramThatFailsIsRefused) {
  add("9-6-0", "22-1-0", "echo no; exit 2\n");
  hal::expect_complaint({"m.idf", "Transition-V9-6-0-to-V22-1-0 refuses", "EnergyPlus 9.6", "correct it"},
                        [&] { (void)upgraded("9.6", "22.1"); });
}

TEST_F(Transitions, OnesThatLeaveTheVersionAreRefused) {
  add("8-1-0", "25-2-0", "true\n");
  const fs::path model = install_.path() / "m.idf";
  std::ofstream(model) << "Version,8.1;\nZone,Z;\n";
  const sim::EnergyPlusInstall nowhere_at_all{"/nowhere", "/nowhere/libenergyplusapi.so", "/nowhere/schema"};
  hal::expect_complaint({"IDFVersionUpdater", "ended with a model of \"8.1\"", "EnergyPlus 25.2", "leave it out"},
                        [&] { (void)read_foreign_model(model, nowhere_at_all, install_.path()); });
}

TEST_F(Transitions, FolderIsAnOptionAVariableOrBesideTheEngine) {
  EXPECT_EQ(transitions_folder("", install_.path()), "");
  add("9-6-0", "22-1-0");
  const fs::path programs = install_.path() / "PreProcess" / "IDFVersionUpdater";
  EXPECT_EQ(transitions_folder("", install_.path()), programs);
  EXPECT_EQ(transitions_folder(programs, "/nowhere"), programs);
  EXPECT_EQ(transitions_folder("", "/nowhere"), "");
  setenv("AIRSIDE_TRANSITIONS", install_.path().c_str(), 1);
  EXPECT_EQ(transitions_folder("", "/nowhere"), programs);
  hal::expect_complaint({"--transitions", "\"/tmp/none\"", "PreProcess/IDFVersionUpdater", "leave it out"},
                        [] { (void)transitions_folder("/tmp/none", "/nowhere"); });
  setenv("AIRSIDE_TRANSITIONS", "/tmp/none", 1);
  hal::expect_complaint({"AIRSIDE_TRANSITIONS", "\"/tmp/none\"", "", ""},
                        [] { (void)transitions_folder("", "/nowhere"); });
  unsetenv("AIRSIDE_TRANSITIONS");
}

}  // namespace
}  // namespace airside::tools
