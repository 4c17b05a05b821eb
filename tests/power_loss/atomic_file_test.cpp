#include "hal/storage/atomic_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>

#include "power_loss/write_recorder.hpp"
#include "support/test_folder.hpp"

namespace airside::hal {
namespace {

TEST(StorageFile, MovedToItselfStaysOpen) {
  const TestFolder folder("file_moved");
  auto opened = StorageFile::open_dir(folder.c_str());
  ASSERT_TRUE(opened);
  StorageFile& same = *opened;
  *opened = std::move(same);
  EXPECT_TRUE(opened->is_open());
}

TEST(StorageFile, AFolderIsAwayWhereItsPathNamesAnotherOneOrNone) {
  const TestFolder folder("file_away");
  const std::string path = folder.file("a/b").string();
  const auto put = [&] { std::filesystem::create_directories(path); };
  put();
  auto opened = StorageFile::open_dir(path.c_str());
  ASSERT_TRUE(opened);
  EXPECT_FALSE(opened->is_replaced_at(path.c_str()) || opened->is_unlinked());
  std::filesystem::rename(path, folder.file("c"));
  EXPECT_TRUE(opened->is_replaced_at(path.c_str()));
  EXPECT_FALSE(opened->is_unlinked()) << "it only has another name";
  put();
  EXPECT_TRUE(opened->is_replaced_at(path.c_str()));
  std::filesystem::remove_all(folder.file("a"));
  std::ofstream(folder.file("a")).put('x');
  EXPECT_FALSE(opened->is_replaced_at(path.c_str())) << "where nobody can look it may still be";
  std::filesystem::remove(folder.file("c"));
  EXPECT_TRUE(opened->is_unlinked());
  EXPECT_TRUE(opened->is_replaced_at(path.c_str()));
}

TEST(AtomicFile, CutAtEveryByteLeavesTheOldFile) {
  const TestFolder folder("atomic");
  const std::string path = folder.file("blob").string();
  const std::vector<std::byte> old_bytes(50, std::byte{1}), new_bytes(70, std::byte{2});
  ASSERT_TRUE(write_file_atomically(path, old_bytes).has_value());
  for (int fail_at = 0; fail_at < 2; ++fail_at) {
    WriteRecorder recorder;
    recorder.fail_at = fail_at;
    recorder.fail_errno = ENOSPC;
    const auto done = write_file_atomically(path, new_bytes);
    ASSERT_FALSE(done.has_value());
    EXPECT_EQ(done.error().fault, StoreFault::no_space);
    EXPECT_EQ(folder.image().size(), 1u) << "the staged file is gone";
    EXPECT_EQ(folder.image().at("blob"), old_bytes);
  }
  ASSERT_TRUE(write_file_atomically(path, new_bytes).has_value());
  EXPECT_EQ(folder.image().at("blob"), new_bytes);
  EXPECT_EQ(write_file_atomically(folder.file("no/blob").string(), new_bytes).error().fault, StoreFault::not_found);
}

/// The names under which a file may be staged: this process's, and one for all.
std::array<std::string, 2> staged_names() { return {"blob." + std::to_string(::getpid()) + ".new", "blob.new"}; }

TEST(AtomicFile, FollowsNoLinkAndWaitsForNoPipeUnderTheStagedName) {
  const TestFolder folder("atomic_link"), other("atomic_victim");
  const std::string path = folder.file("blob").string();
  const std::vector<std::byte> bytes(50, std::byte{1});
  std::ofstream(other.file("victim")) << "mine";
  const FolderImage before = other.image();
  for (const std::string& staged : staged_names()) {
    std::filesystem::create_symlink(other.file("victim"), folder.file(staged));
    ASSERT_TRUE(write_file_atomically(path, bytes)) << staged;
    EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(path))) << staged;
    EXPECT_EQ(other.image(), before) << staged;
    std::filesystem::remove(folder.file(staged));
    ASSERT_EQ(::mkfifo(folder.file(staged).c_str(), 0600), 0);
    const StorageFile reader(::open(folder.file(staged).c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));  // else it hangs
    EXPECT_TRUE(write_file_atomically(path, bytes)) << staged;
    EXPECT_TRUE(std::filesystem::is_regular_file(path)) << staged;
    std::filesystem::remove(path);
    std::filesystem::remove(folder.file(staged));
  }
}

TEST(AtomicFile, LeavesWhatAnotherProcessStages) {
  const TestFolder folder("atomic_two");
  const std::vector<std::byte> bytes(50, std::byte{1});
  for (const char* staged : {"blob.1.new", "blob.new"}) std::ofstream(folder.file(staged)) << "half";
  const FolderImage before = folder.image();
  ASSERT_TRUE(write_file_atomically(folder.file("blob").string(), bytes));
  FolderImage after = folder.image();
  EXPECT_EQ(after.at("blob"), bytes);
  after.erase("blob");
  EXPECT_EQ(after, before);
}

TEST(AtomicFile, SaysThatTheStagedNameIsTakenByWhatCannotBeRemoved) {
  const TestFolder folder("atomic_taken");
  const std::string path = folder.file("blob").string();
  std::ofstream(path) << "old";
  std::filesystem::create_directory(folder.file(staged_names()[0]));
  EXPECT_FALSE(write_file_atomically(path, std::vector<std::byte>(50, std::byte{1})));
  EXPECT_EQ(std::filesystem::file_size(path), 3u);
}

TEST(AtomicFile, SaysThatAFolderStandsInItsPlace) {
  const TestFolder folder("atomic_folder");
  std::filesystem::create_directories(folder.file("blob") / "full");
  EXPECT_FALSE(write_file_atomically(folder.file("blob").string(), std::vector<std::byte>(5, std::byte{1})));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.c_str()), {}), 1) << "the staged file is gone";
}

TEST(AtomicFile, NeedsNoFolderInItsNameAndNoSync) {
  const TestFolder folder("atomic_here");
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::current_path(folder.c_str());
  EXPECT_TRUE(write_file_atomically("a", std::vector<std::byte>(5, std::byte{1})));
  EXPECT_TRUE(write_file_atomically("b", std::vector<std::byte>(5, std::byte{1}), Sync::none));
  std::filesystem::current_path(here);
  EXPECT_EQ(folder.image().size(), 2u);
}

}  // namespace
}  // namespace airside::hal
