// Counters of pushed weights that lie apart from the state: an old blob stays old when the state is lost.

#include "hal/weights/counter_ledger.hpp"

#include "weights/trial_rig.hpp"

namespace airside::weights {
namespace {

namespace fs = std::filesystem;

class Counters : public Trial {
 protected:
  Counters() {
    push(other(5));
    EXPECT_TRUE(row());
  }
  /// A new process on a box whose row record is gone.
  void lose_state() {
    record = {};
    open(false);
  }
  Fault refusal_of(const Bytes& blob) {
    push(blob);
    const bool taken = row();
    EXPECT_EQ(taken, record.refusal == Fault::none);
    return record.refusal;
  }
  void list_counter(const std::string& line) const { std::ofstream(folder.file("keys") / "counters") << line << '\n'; }
  const fs::path in_state = folder.file("state") / "push_counters", in_log = folder.file("log") / "push_counters";
};

TEST_F(Counters, OutliveTheState) {
  lose_state();
  EXPECT_EQ(refusal_of(other(5)), Fault::blob_counter);
  EXPECT_EQ(refusal_of(other(4)), Fault::blob_counter);
  EXPECT_EQ(refusal_of(other(6)), Fault::none);
}

TEST_F(Counters, OfOneFolderDo) {
  for (const fs::path& gone : {in_state, in_log}) {
    fs::remove(gone);
    lose_state();
    EXPECT_EQ(refusal_of(other(5)), Fault::blob_counter) << gone;
    trial->committed();
    EXPECT_TRUE(fs::exists(gone)) << "written again beside the next commit";
  }
}

TEST_F(Counters, OfTwoFoldersTheLargerRules) {
  for (const fs::path& old : {in_state, in_log}) {
    const fs::path kept = folder.file("kept");
    fs::copy_file(old, kept, fs::copy_options::overwrite_existing);
    const std::uint64_t newer = old == in_state ? 6 : 7;
    ASSERT_EQ(refusal_of(other(newer)), Fault::none);
    fs::copy_file(kept, old, fs::copy_options::overwrite_existing);
    lose_state();
    EXPECT_EQ(refusal_of(other(newer)), Fault::blob_counter) << old;
  }
}

TEST_F(Counters, ThatAreDamagedAreNotBelieved) {
  for (const fs::path& path : {in_state, in_log}) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(24);
    file.put(1);
  }
  lose_state();
  EXPECT_TRUE(trial->has_counters()) << "but they say that the box is not new";
  EXPECT_EQ(refusal_of(other(6)), Fault::counter_unknown);
}

TEST_F(Counters, ThatAreUnknownRefuseUntilAPersonListsThem) {
  fs::remove(in_state);
  fs::remove(in_log);
  lose_state();
  EXPECT_EQ(refusal_of(other(6)), Fault::counter_unknown);
  EXPECT_STREQ(record.refusal_field.data(), "security_counter");
  EXPECT_TRUE(fs::exists(folder.file("inbox") / "refused"));
  lose_state();
  EXPECT_EQ(refusal_of(other(6)), Fault::counter_unknown) << "a restart makes them no better known";
  list_counter(hal::hex_of(key.open.id) + " 8  # the last of spring");
  EXPECT_EQ(refusal_of(other(8)), Fault::blob_counter);
  EXPECT_EQ(refusal_of(other(9)), Fault::none);
  fs::remove(folder.file("keys") / "counters");
  lose_state();
  EXPECT_EQ(refusal_of(other(9)), Fault::blob_counter);
  EXPECT_EQ(refusal_of(other(10)), Fault::none) << "this key is known by now";
  const hal::SecretKey bob = hal::make_key("Bob");
  std::ofstream(folder.file("keys") / "bob.pub") << hal::public_key_text(bob.open);
  EXPECT_EQ(refusal_of(signed_by(other(1), bob, 99)), Fault::counter_unknown) << "of him nothing is known";
}

TEST_F(Counters, AListThatIsNoneIsLeftOut) {
  fs::remove(in_state);
  fs::remove(in_log);
  for (const char* line : {"", " x", " -1", " 1 2", " 99999999999999999999"}) {
    list_counter(hal::hex_of(key.open.id) + line);
    lose_state();
    EXPECT_EQ(refusal_of(other(6)), Fault::counter_unknown) << line;
    EXPECT_THROW((void)hal::KeyRing::load(folder.file("keys").string()), hal::InputError) << line;
  }
}

TEST_F(Counters, AListThatCannotBeReadIsLeftOut) {
  fs::remove(in_state);
  fs::remove(in_log);
  fs::create_symlink("counters", folder.file("keys") / "counters");  // leads to itself
  lose_state();
  EXPECT_EQ(refusal_of(other(6)), Fault::counter_unknown);
}

TEST_F(Counters, OfANewBoxAreKnown) {
  fs::remove(in_state);
  fs::remove(in_log);
  record = {};
  open(true);
  EXPECT_FALSE(trial->has_counters());
  EXPECT_EQ(refusal_of(other(1)), Fault::none);
}

TEST_F(Counters, AreAheadOfAnExchangeWhoseCommitWasCutOff) {
  const edge::TrialRecord before = record;
  const Bytes cut_off = other(6), same_counter = other(6, 0.8F);
  push(cut_off);
  rig.row();
  ASSERT_TRUE(trial->row({rig.now.seconds - row_s}, *rig.controller, record));
  record = before;  // what the medium holds: the commit never came
  open(true);
  EXPECT_EQ(refusal_of(same_counter), Fault::blob_counter) << "not the one that was being taken";
  EXPECT_EQ(refusal_of(cut_off), Fault::none) << "it still lies in the inbox";
  lose_state();
  EXPECT_EQ(refusal_of(cut_off), Fault::blob_counter) << "its commit has come";
}

TEST_F(Counters, ThatCannotBeWrittenLetNothingIn) {
  for (const char* name : {"state", "log"}) {
    fs::remove_all(folder.file(name));
    std::ofstream(folder.file(name)).put('x');
  }
  EXPECT_EQ(refusal_of(other(6)), Fault::state_invalid);
  for (const char* name : {"state", "log"}) fs::remove(folder.file(name));
  EXPECT_TRUE(row()) << "it waits in the inbox";
  EXPECT_EQ(record.refusal, Fault::none);
}

TEST_F(Counters, AreNotReadThroughALink) {
  fs::rename(in_state, folder.file("elsewhere"));
  fs::create_symlink(folder.file("elsewhere"), in_state);
  fs::remove(in_log);
  lose_state();
  EXPECT_EQ(refusal_of(other(6)), Fault::counter_unknown);
  EXPECT_FALSE(fs::is_symlink(in_state)) << "a file of its own by now";
}

TEST_F(Trial, SaysOnceThatTheInboxIsNoFolderAndGoesOnWhenItIsOne) {
  std::filesystem::remove_all(folder.file("inbox"));
  std::ofstream(folder.file("inbox")) << "a file";
  testing::internal::CaptureStderr();
  rows(2);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("nothing is taken from there"), std::string::npos) << said;
  EXPECT_EQ(said.find("nothing is taken from there"), said.rfind("nothing is taken from there")) << said;
  std::filesystem::remove(folder.file("inbox"));
  std::filesystem::create_directory(folder.file("inbox"));
  rows(2);
  push(other(1));
  rows(1);
  EXPECT_EQ(record.state, TrialState::on_trial);
}

TEST_F(Trial, WithoutAnInboxTakesNothingAndSaysNothing) {
  edge::WeightsTrial<T> none(folder.file("keys").string(), "", folder.file("state").string(), 5, hal::Sync::none, "");
  testing::internal::CaptureStderr();
  none.open_inbox();
  EXPECT_FALSE(none.row(rig.now, *rig.controller, record));
  EXPECT_EQ(testing::internal::GetCapturedStderr().find("inbox"), std::string::npos);
}

}  // namespace
}  // namespace airside::weights
