// Which folder of golden vectors AIRSIDE_GOLDEN means.

#include <unistd.h>

#include "golden_files.hpp"

namespace airside::golden {
namespace {

namespace fs = std::filesystem;

class GoldenFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::path(testing::TempDir()) / "airside_golden_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    desk_ = fs::canonical(pattern);
    fs::copy(own_, desk_ / "others");
  }
  void TearDown() override { fs::remove_all(desk_); }

  static std::string complaint(const std::string& given, const std::vector<fs::path>& bases) {
    try {
      return "none: " + golden_folder(given, bases);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

  const fs::path own_ = fs::path(AIRSIDE_SOURCE_DIR) / "tests/golden/data";
  fs::path desk_;
};

TEST_F(GoldenFolder, IsTheProjectsOwnWhereNoneIsGiven) { EXPECT_EQ(golden_folder("", {desk_}), own_.string()); }

TEST_F(GoldenFolder, IsTakenFromTheFirstBaseThatHasIt) {
  EXPECT_EQ(golden_folder("others", {"/nonexistent", desk_, own_}), (desk_ / "others").string());
  EXPECT_EQ(golden_folder((desk_ / "others").string(), {"/nonexistent"}), (desk_ / "others").string());
  EXPECT_EQ(golden_folder("tests/golden/data", {desk_, AIRSIDE_SOURCE_DIR}), own_.string());
}

TEST_F(GoldenFolder, IsMeantFromWhereThePersonStood) {
  const auto value_of = [](const char* name) {
    const char* const value = std::getenv(name);
    return std::string(value != nullptr ? value : "");
  };
  const std::string given = value_of("AIRSIDE_GOLDEN"), stood = value_of("PWD");
  setenv("AIRSIDE_GOLDEN", "others", 1);
  setenv("PWD", desk_.c_str(), 1);
  EXPECT_EQ(folder(), (desk_ / "others").string());
  setenv("PWD", stood.c_str(), 1);
  setenv("AIRSIDE_GOLDEN", given.c_str(), 1);
}

TEST_F(GoldenFolder, IsRefusedWhereItIsNoneOrNotWhole) {
  const std::string absent = complaint("other", {desk_, "/nonexistent"});
  EXPECT_NE(absent.find("\"other\", which is no folder"), std::string::npos) << absent;
  EXPECT_NE(absent.find((desk_ / "other").string() + ", /nonexistent/other"), std::string::npos) << absent;
  fs::remove(desk_ / "others/traj_b1000.json");
  const std::string torn = complaint("others", {desk_});
  EXPECT_NE(torn.find("without traj_b1000.json"), std::string::npos) << torn;
  std::ofstream(desk_ / "file") << "{}";
  const std::string file = complaint("file", {desk_});
  EXPECT_NE(file.find("which is no folder"), std::string::npos) << file;
}

}  // namespace
}  // namespace airside::golden
