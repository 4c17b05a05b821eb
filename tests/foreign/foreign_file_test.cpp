// What somebody else has put where a file of the box belongs is never followed, waited for or written to.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "hal/storage/atomic_file.hpp"
#include "hal/storage/start_ledger.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/weights/mailbox.hpp"
#include "support/test_folder.hpp"

namespace airside::hal {
namespace {

namespace fs = std::filesystem;

class ForeignFile : public ::testing::Test {
 protected:
  ForeignFile() { std::ofstream(other.file("victim")) << "mine"; }
  /// Each kind of thing under its own name.
  void put_all() const {
    fs::create_symlink(other.file("victim"), folder.file("link"));
    fs::create_symlink(other.file("none"), folder.file("dangling"));
    ASSERT_EQ(::mkfifo(folder.file("pipe").c_str(), 0600), 0);
    fs::create_directory(folder.file("folder"));
  }
  TestFolder folder{"foreign"}, other{"foreign_victim"};
};

TEST_F(ForeignFile, IsOpenedNeitherForWritingNorForReading) {
  put_all();
  const auto dir = StorageFile::open_dir(folder.c_str());
  ASSERT_TRUE(dir);
  const FolderImage before = other.image();
  for (const char* name : {"link", "dangling", "pipe", "folder"}) {
    for (const bool create : {true, false}) {
      const auto file = StorageFile::open(dir->descriptor(), name, create, "open");
      ASSERT_FALSE(file) << name;
      EXPECT_EQ(file.error().fault, StoreFault::wrong_kind) << name;
    }
    const auto read = StorageFile::open_to_read(dir->descriptor(), name, "open");  // a pipe would wait for a writer
    ASSERT_FALSE(read) << name;
    EXPECT_EQ(read.error().fault, StoreFault::wrong_kind) << name;
  }
  EXPECT_EQ(other.image(), before) << "not even made by way of a dangling link";
}

TEST_F(ForeignFile, ALinkToAFolderIsFollowedWhereItsMakerIsTrustedAndTheCallerAllowsIt) {
  const fs::path link = folder.file("data");
  fs::create_directory_symlink(other.c_str(), link);
  EXPECT_TRUE(StorageFile::open_dir(link.c_str())) << "an administrator's, or our own";
  EXPECT_TRUE(StorageFile::open_existing_dir((link.string() + "/").c_str()));
  for (const std::string& path : {link.string(), link.string() + "/", link.string() + "//"}) {
    for (const auto& refused : {StorageFile::open_dir(path.c_str(), FolderLink::refused),
                                StorageFile::open_existing_dir(path.c_str(), FolderLink::refused)}) {
      ASSERT_FALSE(refused) << path;
      EXPECT_EQ(refused.error().fault, StoreFault::wrong_kind) << path;
    }
  }
  if (::geteuid() != 0) GTEST_SKIP() << "only root can make another user's link";
  ASSERT_EQ(::lchown(link.c_str(), 12345, 12345), 0);
  const auto foreign = StorageFile::open_dir(link.c_str());
  ASSERT_FALSE(foreign) << "another user's";
  EXPECT_EQ(foreign.error().fault, StoreFault::wrong_kind);
  // The same link is followed by a process of the user who made it.
  for (const fs::path path : {folder.c_str(), other.c_str()}) fs::permissions(path, fs::perms(0755));
  ASSERT_EQ(::seteuid(12345), 0);
  const bool own = StorageFile::open_existing_dir(link.c_str()).has_value();
  ASSERT_EQ(::seteuid(0), 0);
  EXPECT_TRUE(own);
}

TEST_F(ForeignFile, AFolderThatIsNoneOrIsNotThereIsSaidToBe) {
  std::ofstream(folder.file("file")) << "x";
  EXPECT_EQ(StorageFile::open_existing_dir(folder.file("file").c_str()).error().fault, StoreFault::not_found);
  EXPECT_EQ(StorageFile::open_existing_dir(folder.file("none").c_str()).error().fault, StoreFault::not_found);
  EXPECT_FALSE(StorageFile::open_existing_dir(std::string(5000, 'a').c_str()));
  fs::create_symlink("self", folder.file("self"));
  EXPECT_EQ(StorageFile::open_existing_dir(folder.file("self").c_str()).error().fault, StoreFault::wrong_kind);
  EXPECT_EQ(StorageFile::open_existing_dir((folder.file("self") / "below").c_str()).error().fault,
            StoreFault::wrong_kind);
  EXPECT_TRUE(StorageFile::open_existing_dir("//"));
}

TEST_F(ForeignFile, AnOpenFolderIsWrittenToWhateverItsPathLeadsToByNow) {
  const fs::path path = folder.file("inbox"), moved = folder.file("moved");
  fs::create_directory(path);
  const auto dir = StorageFile::open_existing_dir(path.c_str(), FolderLink::refused);
  ASSERT_TRUE(dir);
  fs::rename(path, moved);
  fs::create_directory_symlink(other.c_str(), path);
  const FolderImage before = other.image();
  ASSERT_TRUE(write_file_atomically(*dir, "blob", std::vector<std::byte>(5, std::byte{1})));
  EXPECT_EQ(fs::file_size(moved / "blob"), 5u);
  EXPECT_EQ(other.image(), before);
}

TEST_F(ForeignFile, ALinkInPlaceOfTheInboxIsNotFollowed) {
  const fs::path link = folder.file("inbox");
  std::ofstream(other.file("weights.blob")) << "abc";
  std::ofstream(other.file("release")).close();
  fs::create_directory_symlink(other.c_str(), link);
  std::array<std::byte, 100> blob{};
  for (const std::string& path : {link.string(), link.string() + "/"}) {
    Mailbox led(path);
    EXPECT_FALSE(led.is_open()) << path;
    EXPECT_EQ(led.fault(), StoreFault::wrong_kind) << path;
    EXPECT_FALSE(led.collect(blob).has_blob) << path;
    EXPECT_FALSE(led.release_waits()) << path;
  }
  fs::remove(link);
  const Mailbox own(link);
  EXPECT_TRUE(own.is_open()) << "made where there is none";
  EXPECT_EQ(own.fault(), StoreFault::none);
}

TEST_F(ForeignFile, InPlaceOfTheStartsIsReported) {
  StartLedger ledger(folder.c_str(), Sync::none);
  EXPECT_EQ(ledger.record(600), 1);
  EXPECT_TRUE(ledger.is_kept());
  ledger.keep();  // nothing is left to do
  EXPECT_TRUE(ledger.is_kept());
  fs::remove(folder.file("starts"));
  fs::create_symlink(other.file("victim"), folder.file("starts"));
  const FolderImage before = other.image();
  EXPECT_EQ(ledger.record(600), 1);
  EXPECT_FALSE(ledger.is_kept());
  EXPECT_EQ(other.image(), before);
}

}  // namespace
}  // namespace airside::hal
