// The inbox: whatever lies there is read once, taken away, and never followed out of the folder.

#include "hal/weights/mailbox.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "airside/controller/blob.hpp"
#include "support/test_folder.hpp"

namespace airside::weights {
namespace {

namespace fs = std::filesystem;

class Inbox : public ::testing::Test {
 protected:
  void put(const std::string& name, const std::string& text = "") { std::ofstream(folder.file(name)) << text; }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder.c_str()), fs::directory_iterator{}));
  }

  hal::TestFolder folder{"inbox"};
  hal::Mailbox box{std::string(folder.c_str())};
  std::array<std::byte, 1000> blob{};
};

TEST_F(Inbox, IsEmptyWhereNothingLies) {
  const hal::Mail mail = box.collect(blob);
  EXPECT_FALSE(mail.hand_back || mail.release || mail.rollback || mail.has_blob);
}

TEST_F(Inbox, GivesEachWishOnce) {
  put("hand-back");
  put("release");
  put("rollback");
  const hal::Mail mail = box.collect(blob);
  EXPECT_TRUE(mail.hand_back != mail.release && mail.rollback);
  EXPECT_EQ(files(), 3u) << "a crash before the commit must not lose them";
  const hal::Mail again = box.collect(blob);
  EXPECT_FALSE(again.hand_back || again.release || again.rollback) << "told once";
  put("release");
  EXPECT_TRUE(box.collect(blob).release) << "said again while the first one still waits";
  box.finish(true);
  EXPECT_EQ(files(), 1u) << "the release";
  EXPECT_FALSE(box.collect(blob).release);
}

TEST_F(Inbox, KeepsAReleaseForStartsThatKnowNothingUntilItIsHandedBack) {
  const auto later = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  put("release");
  EXPECT_TRUE(box.collect(blob).release);
  box.finish(true);
  for (int start = 0; start < 2; ++start) {
    hal::Mailbox next{std::string(folder.c_str())};
    EXPECT_TRUE(next.release_waits()) << "before anything is written";
    EXPECT_TRUE(next.collect(blob).release);
    next.finish(true);
  }
  later();
  put("hand-back");
  hal::Mailbox both{std::string(folder.c_str())};
  const hal::Mail mail = both.collect(blob);
  EXPECT_TRUE(mail.hand_back && !mail.release) << "the later one, also where one start is told both";
  EXPECT_TRUE(box.collect(blob).hand_back);
  EXPECT_FALSE(box.collect(blob).hand_back) << "told once, though no commit has ended it yet";
  box.finish(true);
  EXPECT_EQ(files(), 0u);
}

TEST_F(Inbox, AReleaseAfterAHandBackThatWasNotEndedYetStays) {
  const auto later = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  put("hand-back");
  EXPECT_TRUE(box.collect(blob).hand_back);
  later();
  put("release");
  EXPECT_TRUE(box.collect(blob).release);
  box.finish(true);
  EXPECT_EQ(files(), 1u);
  EXPECT_TRUE(fs::exists(folder.file("release")));
}

TEST_F(Inbox, AHandBackStaysWhereItsReleaseCannotBeTaken) {
  put("release");
  EXPECT_TRUE(box.collect(blob).release);
  box.finish(true);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  put("hand-back");
  EXPECT_TRUE(box.collect(blob).hand_back);
  fs::remove(folder.file("release"));
  put("release");  // said again meanwhile, which this look does not know
  box.finish(true);
  EXPECT_TRUE(box.collect(blob).release);
}

/// While it lives nothing in the folder can be looked at, as on a medium that fails.
class Blind {
 public:
  explicit Blind(const fs::path& folder) : folder_(folder), is_root_(::geteuid() == 0) {
    fs::permissions(folder_, fs::perms::none);
    if (is_root_ && ::seteuid(65534) != 0) throw std::runtime_error("seteuid");
  }
  ~Blind() {
    if (is_root_) (void)!::seteuid(0);
    fs::permissions(folder_, fs::perms::owner_all);
  }
  Blind(const Blind&) = delete;
  Blind& operator=(const Blind&) = delete;

 private:
  fs::path folder_;
  bool is_root_;
};

TEST_F(Inbox, WhatCannotBeLookedAtIsNotTakenForGone) {
  put("release");
  EXPECT_TRUE(box.collect(blob).release);
  EXPECT_TRUE(box.finish(true));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  put("hand-back");
  EXPECT_TRUE(box.collect(blob).hand_back);
  {
    const Blind blind(folder.c_str());
    EXPECT_FALSE(box.finish(true)) << "alone in the inbox the release would be told again by the next start";
    const hal::Mail mail = box.collect(blob);
    EXPECT_FALSE(mail.hand_back || mail.release || mail.has_blob || box.release_waits());
  }
  EXPECT_EQ(files(), 2u);
  const hal::Mail mail = box.collect(blob);
  EXPECT_FALSE(mail.hand_back || mail.release) << "both were told before";
  EXPECT_TRUE(box.finish(true));
  EXPECT_EQ(files(), 0u);
}

TEST_F(Inbox, IsToldAnewToAnotherState) {
  put("release");
  EXPECT_TRUE(box.collect(blob).release);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  put("hand-back");
  put("a.blob", "abc");
  for (int state = 0; state < 2; ++state) {
    const hal::Mail mail = box.collect(blob);
    EXPECT_TRUE(mail.hand_back && !mail.release && mail.has_blob) << state;
    if (state == 0) box.tell_anew();
  }
  EXPECT_TRUE(box.finish(true));
  EXPECT_EQ(files(), 0u);
}

TEST_F(Inbox, TellsThatAReleaseWaitsUntilItWasCollected) {
  EXPECT_FALSE(box.release_waits());
  put("release");
  EXPECT_TRUE(box.release_waits());
  EXPECT_TRUE(box.release_waits()) << "to look takes nothing away";
  EXPECT_TRUE(box.collect(blob).release);
  EXPECT_FALSE(box.release_waits());
  box.finish(true);
  EXPECT_FALSE(box.release_waits());
}

TEST_F(Inbox, TellsTheLaterOneOfAReleaseAndAHandBack) {
  const auto later = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  put("hand-back");
  later();
  put("release");
  hal::Mail mail = box.collect(blob);
  EXPECT_TRUE(mail.release && !mail.hand_back);
  box.finish(true);
  EXPECT_EQ(files(), 1u) << "the release";
  put("release");
  later();
  put("hand-back");
  mail = box.collect(blob);
  EXPECT_TRUE(mail.hand_back && !mail.release);
  box.finish(true);
}

TEST_F(Inbox, TellsWhetherABlobIsOlderThanTheRollbackBesideIt) {
  put("a.blob", "abc");
  put("rollback");
  EXPECT_TRUE(box.collect(blob).blob_is_older);
  box.finish(true);
  put("rollback");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  put("a.blob", "abc");
  EXPECT_FALSE(box.collect(blob).blob_is_older);
}

TEST_F(Inbox, ABlobMayBeReplacedByANewerOneOfItsKeyAlone) {
  BlobHeader mine;
  mine.key_id[0] = 1;
  mine.security_counter = 5;
  const std::string path = folder.file("weights.blob").string();
  const auto lay = [&](const BlobHeader& header, std::size_t bytes = sizeof(BlobHeader)) {
    put("weights.blob", std::string(reinterpret_cast<const char*>(&header), bytes));
  };
  EXPECT_FALSE(hal::Mailbox::waits(path, mine)) << "nothing is there";
  lay(mine, 100);
  EXPECT_FALSE(hal::Mailbox::waits(path, mine)) << "no whole header";
  BlobHeader other = mine;
  other.magic[0] = 'x';
  lay(other);
  EXPECT_FALSE(hal::Mailbox::waits(path, mine)) << "no blob";
  lay(mine);
  EXPECT_TRUE(hal::Mailbox::waits(path, mine)) << "as old";
  other = mine;
  other.security_counter = 4;
  lay(other);
  EXPECT_FALSE(hal::Mailbox::waits(path, mine));
  other.key_id[0] = 2;
  lay(other);
  EXPECT_TRUE(hal::Mailbox::waits(path, mine)) << "somebody else's";
  fs::remove(path);
  fs::create_directory(path);
  EXPECT_FALSE(hal::Mailbox::waits(path, mine)) << "nothing that could be read";
}

TEST_F(Inbox, ReadsABlobOnceHoweverOftenItIsLookedInto) {
  put("a.blob", "abc");
  EXPECT_TRUE(box.collect(blob).has_blob);
  EXPECT_FALSE(box.collect(blob).has_blob) << "the first one waits to be done with";
  box.finish(true);
  EXPECT_EQ(files(), 0u);
}

TEST_F(Inbox, KeepsABlobUntilItIsDoneWith) {
  put("room301.blob", "abc");
  hal::Mail mail = box.collect(blob);
  EXPECT_TRUE(mail.has_blob);
  EXPECT_EQ(mail.blob_bytes, 3u);
  EXPECT_EQ(blob[1], std::byte{'b'});
  EXPECT_EQ(files(), 1u) << "a crash now must not lose it";
  box.finish(true);
  EXPECT_EQ(files(), 0u);
}

TEST_F(Inbox, KeepsTheLastRefusedBlobAsideAndNoMore) {
  for (const char* text : {"one", "two"}) {
    put("weights.blob", text);
    box.collect(blob);
    box.finish(false);
    EXPECT_FALSE(box.collect(blob).has_blob) << "a refused blob does not come again";
  }
  EXPECT_EQ(files(), 1u);
  std::string left;
  std::ifstream(folder.file("refused")) >> left;
  EXPECT_EQ(left, "two");
}

TEST_F(Inbox, LeavesABlobThatCameInPlaceOfTheOneThatWasReadForTheNextRow) {
  for (const bool accepted : {true, false}) {
    put("weights.blob", "one");
    EXPECT_EQ(box.collect(blob).blob_bytes, 3u);
    put("pushed", "second");
    fs::rename(folder.file("pushed"), folder.file("weights.blob"));
    box.finish(accepted);
    EXPECT_EQ(files(), 1u) << "neither taken away nor put aside";
    EXPECT_EQ(box.collect(blob).blob_bytes, 6u);
    box.finish(true);
    EXPECT_EQ(files(), 0u);
  }
}

TEST_F(Inbox, LeavesABlobThatWasWrittenToSinceItWasRead) {
  put("weights.blob", "one");
  EXPECT_TRUE(box.collect(blob).has_blob);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  put("weights.blob", "second");
  box.finish(true);
  EXPECT_EQ(box.collect(blob).blob_bytes, 6u);
}

TEST_F(Inbox, LeavesWhatCameInPlaceOfABlobThatCouldNotBeRead) {
  fs::create_symlink("/proc/version", folder.file("a.blob"));
  EXPECT_NE(box.collect(blob).unread, nullptr);
  put("pushed", "abc");
  fs::rename(folder.file("pushed"), folder.file("a.blob"));
  box.finish(false);
  EXPECT_EQ(box.collect(blob).blob_bytes, 3u);
  fs::remove(folder.file("a.blob"));
  box.finish(false);
  EXPECT_EQ(files(), 0u) << "nothing lies there to be put aside";
}

TEST_F(Inbox, FollowsNoLinkAndWaitsForNoPipe) {
  put("../airside_secret", "secret");
  fs::create_symlink(folder.file("../airside_secret"), folder.file("a.blob"));
  hal::Mail mail = box.collect(blob);
  EXPECT_TRUE(mail.has_blob);
  EXPECT_EQ(mail.blob_bytes, 0u);
  box.finish(true);
  ASSERT_EQ(::mkfifo((folder.file("b.blob")).c_str(), 0600), 0);
  mail = box.collect(blob);
  EXPECT_TRUE(mail.has_blob);
  EXPECT_EQ(mail.blob_bytes, 0u);
  box.finish(true);
  fs::create_directory(folder.file("c.blob"));
  EXPECT_EQ(box.collect(blob).blob_bytes, 0u);
  fs::remove(folder.file("../airside_secret"));
}

TEST_F(Inbox, ReadsNothingOfAFileThatIsTooLong) {
  put("weights.blob", std::string(1001, 'x'));
  const hal::Mail mail = box.collect(blob);
  EXPECT_TRUE(mail.has_blob);
  EXPECT_EQ(mail.blob_bytes, 0u);
}

TEST_F(Inbox, FindsABlobAmongThousandsOfOtherFiles) {
  for (int i = 0; i < 3000; ++i) put("note" + std::to_string(i));
  put("z.blob", "abc");
  EXPECT_EQ(box.collect(blob).blob_bytes, 3u);
}

TEST_F(Inbox, LeavesABlobThatIsStillOnItsWayAndTakesOneThatWillNeverBeWhole) {
  BlobHeader header;
  header.payload_bytes = 100;
  const auto part = [&](const std::string& name, std::size_t bytes) {
    std::string text(reinterpret_cast<const char*>(&header), sizeof header);
    text.resize(bytes, 'x');
    put(name, text);
  };
  const std::size_t whole = sizeof header + 100 + blob_signature_bytes;
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{5}, sizeof header - 1, sizeof header, whole - 1}) {
    part("a.blob", bytes);
    EXPECT_FALSE(box.collect(blob).has_blob) << bytes << " bytes, just written";
    put("b.blob", "abc");
    EXPECT_EQ(box.collect(blob).blob_bytes, 3u) << "and does not stand before others";
    box.finish(true);
    EXPECT_TRUE(fs::exists(folder.file("a.blob")));
    for (const auto age : {std::chrono::seconds(hal::Mailbox::arriving_s + 1), std::chrono::seconds(-3600)}) {
      fs::last_write_time(folder.file("a.blob"), fs::file_time_type::clock::now() - age);
      const hal::Mail mail = box.collect(blob);
      EXPECT_TRUE(mail.has_blob) << bytes << ", " << age.count() << " s old";
      EXPECT_EQ(mail.blob_bytes, bytes);
      box.finish(false);
      part("a.blob", bytes);
    }
  }
  part("a.blob", whole);
  EXPECT_EQ(box.collect(blob).blob_bytes, whole);
}

TEST_F(Inbox, SaysWhyNothingOfABlobCouldBeRead) {
  put("a.blob", "abc");
  EXPECT_EQ(box.collect(blob).unread, nullptr);
  box.finish(true);
  put("a.blob", std::string(1001, 'x'));
  EXPECT_NE(std::string(box.collect(blob).unread).find("longer"), std::string::npos);
  box.finish(true);
  fs::create_symlink("/proc/version", folder.file("a.blob"));
  EXPECT_NE(std::string(box.collect(blob).unread).find("may read"), std::string::npos);
}

/// An inbox that was moved away under the daemon, and what stands in its place.
class ReplacedInbox : public Inbox {
 protected:
  ~ReplacedInbox() override { fs::remove_all(away); }
  void move_away() const { fs::rename(folder.c_str(), away); }
  void replace() const {
    move_away();
    fs::create_directory(folder.c_str());
  }

  const std::string away = std::string(folder.c_str()) + ".old";
};

TEST_F(ReplacedInbox, ItsWishesAreSeenBetweenRowsAndInThem) {
  replace();
  EXPECT_FALSE(box.release_waits());
  put("release");
  EXPECT_TRUE(box.release_waits());
  EXPECT_TRUE(box.collect(blob).release);
  EXPECT_FALSE(box.release_waits());
}

TEST_F(ReplacedInbox, AWishWaitsThereThoughOneWasToldFromTheOldOne) {
  put("release");
  put("a.blob", "old");
  EXPECT_TRUE(box.collect(blob).release);
  replace();
  put("release");
  put("b.blob", "later");
  EXPECT_TRUE(box.release_waits());
  const hal::Mail mail = box.collect(blob);
  EXPECT_TRUE(mail.release);
  EXPECT_EQ(mail.blob_bytes, 5u) << "the old one's blob, that was not finished, stands before none";
  box.finish(true);
  EXPECT_EQ(files(), 1u) << "the release";
  EXPECT_TRUE(fs::exists(away + "/release") && fs::exists(away + "/a.blob"));
}

TEST_F(ReplacedInbox, WhatWasToldBeforeIsFinishedWhereItLies) {
  put("rollback");
  put("a.blob", "abc");
  EXPECT_TRUE(box.collect(blob).has_blob);
  replace();
  put("rollback");
  put("a.blob", "abc");
  box.finish(true);
  EXPECT_EQ(files(), 2u) << "nobody has told these";
  EXPECT_TRUE(fs::is_empty(away));
}

TEST_F(ReplacedInbox, IsMadeAnewWhereNothingStands) {
  move_away();
  EXPECT_FALSE(box.release_waits());
  EXPECT_FALSE(fs::exists(folder.c_str())) << "a look makes nothing";
  EXPECT_FALSE(box.collect(blob).release);
  EXPECT_TRUE(box.is_open());
  put("release");
  EXPECT_TRUE(box.collect(blob).release);
}

TEST_F(ReplacedInbox, IsEmptyWhileNoFolderCanBeHadThere) {
  move_away();
  std::ofstream(folder.c_str()).put('x');
  EXPECT_FALSE(box.collect(blob).release);
  EXPECT_FALSE(box.is_open());
  fs::remove(folder.c_str());
  fs::rename(away, folder.c_str());
  put("release");
  EXPECT_TRUE(box.release_waits()) << "though the next row has yet to open it";
  EXPECT_TRUE(box.collect(blob).release);
}

TEST_F(Inbox, ThatStaysIsNotTakenForAnother) {
  put("release");
  put("a.blob", "abc");
  EXPECT_TRUE(box.collect(blob).release);
  fs::permissions(folder.c_str(), fs::perms::group_write, fs::perm_options::add);
  put("note");
  const hal::Mail mail = box.collect(blob);
  EXPECT_FALSE(mail.release || mail.has_blob || box.release_waits()) << "told once";
  box.finish(true);
  EXPECT_EQ(files(), 2u) << "the release and the note";
}

TEST(InboxWithoutAFolder, StaysEmpty) {
  std::array<std::byte, 10> blob{};
  hal::Mailbox none(""), impossible("/proc/no/such/folder");
  EXPECT_FALSE(none.collect(blob).has_blob);
  EXPECT_FALSE(impossible.collect(blob).has_blob);
  EXPECT_FALSE(impossible.release_waits());
  impossible.finish(true);
}

}  // namespace
}  // namespace airside::weights
