// Blob files and their refusals: each says where, what was found, what was expected and what to do.

#include "hal/weights/blob_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "hal/text/input_error.hpp"
#include "support/test_folder.hpp"

namespace airside::weights {
namespace {

class BlobFile : public ::testing::Test {
 protected:
  std::string file_of(std::size_t bytes) {
    std::ofstream(folder.file("a.blob"), std::ios::binary) << std::string(bytes, 'x');
    return folder.file("a.blob").string();
  }
  template <class Act>
  static std::string complaint(const Act& act) {
    try {
      act();
    } catch (const hal::InputError& e) {
      return e.what();
    }
    return "";
  }
  static void expect_complaint(const std::string& path, const std::string& words) {
    const std::string said = complaint([&] { hal::read_blob_file(path); });
    EXPECT_NE(said.find(path), std::string::npos) << said;
    EXPECT_NE(said.find(words), std::string::npos) << said;
  }

  hal::TestFolder folder{"blob_file"};
};

TEST_F(BlobFile, IsReadAsItWasWritten) {
  const std::vector<std::byte> blob(1000, std::byte{7});
  const std::string path = folder.file("b.blob").string();
  hal::write_blob_file(path, blob);
  EXPECT_EQ(hal::read_blob_file(path), blob);
}

TEST_F(BlobFile, IsRefusedWhereItIsMissingTooSmallTooLargeOrEndsEarly) {
  expect_complaint(folder.file("none").string(), "No such file");
  expect_complaint(file_of(191), "191 bytes");
  expect_complaint(file_of((4u << 20) + 1), "4194305 bytes");
  // A file of the kernel's that says 4096 bytes and gives a few, as a file does that is cut while it is read.
  expect_complaint("/sys/devices/system/cpu/online", "ends early");
}

TEST_F(BlobFile, SaysWhyItCannotBeOpened) {
  const std::string path = file_of(4096);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit none = before;
  none.rlim_cur = 0;  // not even its owner can open a file now
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const std::string said = complaint([&] { hal::read_blob_file(path); });
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_NE(said.find("Too many open files"), std::string::npos) << said;
  EXPECT_NE(said.find("may read"), std::string::npos) << said;
}

TEST_F(BlobFile, CannotBeWrittenIntoAFolderThatIsNone) {
  const std::vector<std::byte> blob(10);
  const std::string path = folder.file("none/a.blob").string();
  EXPECT_NE(complaint([&] { hal::write_blob_file(path, blob); }).find(path), std::string::npos);
}

TEST_F(BlobFile, CannotBeWrittenUnderANameThatIsTooLong) {
  const std::vector<std::byte> blob(10);
  const std::string path = folder.file(std::string(255, 'a')).string();  // and the copy beside it has more
  EXPECT_NE(complaint([&] { hal::write_blob_file(path, blob); }).find(path), std::string::npos);
}

TEST_F(BlobFile, WithoutAFolderInItsNameLandsInThisOne) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.c_str());
  hal::write_blob_file("b.blob", std::vector<std::byte>(1000));
  std::filesystem::current_path(before);
  EXPECT_TRUE(std::filesystem::exists(folder.file("b.blob")));
}

TEST_F(BlobFile, TakesThePlaceOfAFileAndOfNothingElse) {
  const std::vector<std::byte> blob(1000, std::byte{7});
  const std::string path = folder.file("old.blob").string(), notes = folder.file("site.toml").string();
  std::ofstream(path) << "AIRSIDEB of before";
  hal::write_blob_file(path, blob);
  EXPECT_EQ(hal::read_blob_file(path), blob);
  std::ofstream(notes) << "[site]\nname = \"a\"\n";
  EXPECT_NE(complaint([&] { hal::write_blob_file(notes, blob); }).find("another kind of file"), std::string::npos);
  const std::string pipe = folder.file("pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& other : {pipe, std::string(folder.c_str())}) {
    const std::string said = complaint([&] { hal::write_blob_file(other, blob); });
    EXPECT_NE(said.find(other), std::string::npos) << said;
    EXPECT_NE(said.find("a pipe or a device"), std::string::npos) << said;
  }
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(BlobRefusals, EachFaultHasWordsOfItsOwn) {
  std::set<std::string> found;
  int faults = 0;
  for (const Fault fault :
       {Fault::blob_truncated, Fault::blob_magic, Fault::blob_version, Fault::blob_architecture, Fault::blob_digest,
        Fault::blob_topology, Fault::blob_units, Fault::blob_scope, Fault::blob_value, Fault::blob_size,
        Fault::blob_signature, Fault::blob_cycle, Fault::blob_counter, Fault::blob_taken_back, Fault::state_invalid}) {
    ++faults;
    try {
      hal::throw_blob_error({fault, "the_field"}, "a.blob");
      FAIL();
    } catch (const hal::InputError& e) {
      EXPECT_EQ(e.place(), "a.blob: the_field");
      EXPECT_FALSE(e.expected().empty() || e.remedy().empty());
      found.insert(e.found());
    }
  }
  EXPECT_EQ(found.size(), static_cast<std::size_t>(faults));
}

TEST(BoxKernels, AreChosenByWordOrByTheMachine) {
  const auto with = [](const char* word) {
    ::setenv("AIRSIDE_KERNELS", word, 1);
    return hal::box_kernels();
  };
  ::unsetenv("AIRSIDE_KERNELS");
  const auto own = hal::box_kernels();
  EXPECT_EQ(with("").kind, own.kind);
  EXPECT_EQ(with("strict").kind, KernelKind::strict);
  (void)with("avx2");
  (void)with("avx512");
  EXPECT_THROW(with("fast"), hal::InputError);
  ::unsetenv("AIRSIDE_KERNELS");
}

}  // namespace
}  // namespace airside::weights
