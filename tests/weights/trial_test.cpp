// Pushed weights: refused with the reason, or taken in one commit and kept on trial for a day; what acts wildly is
// taken back by itself. Every row of the loop is the daemon's own code.

#include "firmware/edge/weights_trial.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "power_loss/test_folder.hpp"
#include "safety/controller_rig.hpp"
#include "weights/blob_maker.hpp"

namespace airside::weights {
namespace {

using T = FiveZone;
using edge::TrialState;

class Trial : public ::testing::Test {
 protected:
  Trial() {
    std::filesystem::create_directories(folder.file("keys"));
    std::filesystem::create_directories(folder.file("inbox"));
    std::filesystem::create_directories(folder.file("state"));
    std::ofstream(folder.file("keys") / "ann.pub") << hal::public_key_text(key.open);
    open();
    rig.cycles(6);
  }
  void open() {
    trial = std::make_unique<edge::WeightsTrial<T>>(folder.file("keys").string(), folder.file("inbox").string(),
                                                    folder.file("state").string(), 5, hal::Sync::none, "Room 301");
    trial->open_inbox();
  }

  void push(const Bytes& bytes) {
    const auto path = folder.file("inbox") / "weights.blob";
    std::ofstream out(path, std::ios::binary);
    for (const std::byte b : bytes) out.put(static_cast<char>(b));
    out.close();
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
  }
  void wish(const std::string& name) { std::ofstream(folder.file("inbox") / name); }
  /// The rig's weights with every one scaled, so that they differ and stay sane.
  Bytes other(std::uint64_t counter, float factor = 0.9F) {
    return signed_by(blob_of<T>(*rig.controller,
                                [&](auto& p) {
                                  for (float& w : p.weights) w *= factor;
                                }),
                     key, counter);
  }
  /// One row as the daemon has it. Returns whether the learning state was exchanged.
  bool row() {
    rig.row();
    const bool exchanged = trial->row({rig.now.seconds - row_s}, *rig.controller, record);
    trial->committed();
    return exchanged;
  }
  void rows(int n) {
    for (int i = 0; i < n; ++i) row();
  }
  float first_weight() const { return rig.controller->learning().weights.values[0]; }

  hal::TestFolder folder{"trial"};
  hal::SecretKey key = hal::make_key("Ann");
  ControllerRig rig;
  edge::TrialRecord record;
  std::unique_ptr<edge::WeightsTrial<T>> trial;
};

TEST_F(Trial, Row49WithoutItSoundWeightsAreConfirmedAfterADay) {
  const float before = first_weight();
  push(other(1));
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::on_trial);
  EXPECT_NE(first_weight(), before);
  rows(rows_per_day - 1);
  EXPECT_EQ(record.state, TrialState::on_trial);
  rows(2);
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(rig.decision().mode, Mode::learn);
}

TEST_F(Trial, WithoutAPushNothingChanges) {
  ControllerRig undisturbed;
  undisturbed.cycles(6);
  for (int i = 0; i < 100; ++i) {
    row();
    undisturbed.row();
    ASSERT_EQ(rig.setpoint, undisturbed.setpoint) << i;
  }
  EXPECT_EQ(record.state, TrialState::none);
}

TEST_F(Trial, Row47AnOldAndARepeatedCounterAreRefused) {
  const Bytes first = other(5);
  push(first);
  ASSERT_TRUE(row());
  push(first);
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_counter);
  push(other(4));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_counter);
  push(other(6));
  EXPECT_TRUE(row());
  EXPECT_EQ(record.refusal, Fault::none);
}

TEST_F(Trial, Row47WithoutItEachKeyHasACounterOfItsOwn) {
  const hal::SecretKey bob = hal::make_key("Bob");
  std::ofstream(folder.file("keys") / "bob.pub") << hal::public_key_text(bob.open);
  open();
  push(other(1000));
  ASSERT_TRUE(row());
  push(signed_by(other(1), bob, 3));
  EXPECT_TRUE(row()) << "his third, though hers was the thousandth";
}

TEST_F(Trial, KeysThatComeAndGoOverTheYearsDoNotUseUpTheCounters) {
  for (int year = 0; year < 40; ++year) {
    const hal::SecretKey next = hal::make_key("key of " + std::to_string(year));
    std::ofstream(folder.file("keys") / "next.pub") << hal::public_key_text(next.open);
    open();
    push(signed_by(other(1), next, 1));
    ASSERT_TRUE(row()) << year << ": " << text_of(record.refusal);
  }
}

struct Refused {
  const char* name;
  Fault fault;
  std::function<Bytes(const Controller<T>&, const hal::SecretKey&)> make;
};

const Refused refused[] = {
    {"Unsigned", Fault::blob_signature, [](const auto& c, const auto&) { return blob_of<T>(c); }},
    {"OfAStranger", Fault::blob_signature,
     [](const auto& c, const auto&) { return signed_by(blob_of<T>(c), hal::make_key("x"), 9); }},
    {"CutOff", Fault::blob_truncated,
     [](const auto& c, const auto& key) {
       Bytes b = signed_by(blob_of<T>(c), key, 9);
       b.resize(b.size() - 1);
       return b;
     }},
    {"OfAnotherSite", Fault::blob_scope,
     [](const auto& c, const auto& key) {
       BlobHeader header;
       std::string("Room 999").copy(header.site_scope.data(), 31);
       return signed_by(blob_of<T>(
                            c, [](auto&) {}, header),
                        key, 9);
     }},
    {"WithoutNumbers", Fault::blob_value,
     [](const auto& c, const auto& key) {
       return signed_by(blob_of<T>(c, [](auto& p) { p.weights[7] = std::nanf(""); }), key, 9);
     }},
    {"Huge", Fault::blob_value,
     [](const auto& c, const auto& key) {
       return signed_by(blob_of<T>(c, [](auto& p) { p.weights[7] = 1e6F; }), key, 9);
     }},
    {"WildOnCanaryStates", Fault::blob_value,
     [](const auto& c, const auto& key) {
       return signed_by(blob_of<T>(c,
                                   [](auto& p) {
                                     for (float& w : p.weights) w *= 6;
                                   }),
                        key, 9);
     }},
    {"HeadWithAWildDay", Fault::blob_value,
     [](const auto& c, const auto& key) {
       return signed_by(blob_of<T>(c, [](auto& p) { p.head_theta(RoomHead<T>::regressors + 5) = 50; }), key, 9);
     }},
    {"HeadBeyondAllNumbers", Fault::blob_value,
     [](const auto& c, const auto& key) {
       return signed_by(blob_of<T>(c, [](auto& p) { p.head_theta(4) = -1e300; }), key, 9);
     }},
    {"HeadThatKnowsNothing", Fault::blob_value,
     [](const auto& c, const auto& key) {
       return signed_by(blob_of<T>(c, [](auto& p) { p.head_covariance[0] = 1e300; }), key, 9);
     }},
    {"HeadThatHeatsByCooling", Fault::blob_value,
     [](const auto& c, const auto& key) {
       constexpr auto gain = static_cast<std::size_t>(HeadFeatures::setpoint_change);
       return signed_by(blob_of<T>(c,
                                   [](auto& p) {
                                     p.head_theta(HeadFeatures::setpoint_change) = -0.5;
                                     p.head_covariance[gain * RoomHead<T>::states + gain] = 1e-4;
                                   }),
                        key, 9);
     }},
};

TEST_F(Trial, Row49WhatIsNotSoundIsRefusedAndChangesNothing) {
  for (const Refused& r : refused) {
    const Bytes bytes = r.make(*rig.controller, key);
    push(bytes);
    // Between two decisions, so that learning moves nothing either.
    while (starts_cycle(rig.now)) row();
    const NetworkWeights<T, float> before = rig.controller->learning().weights;
    EXPECT_FALSE(row()) << r.name;
    EXPECT_TRUE(rig.same_weights(before)) << r.name;
    EXPECT_EQ(record.refusal, r.fault) << r.name << ": " << text_of(record.refusal);
    EXPECT_EQ(record.state, TrialState::none) << r.name;
    EXPECT_TRUE(std::filesystem::exists(folder.file("inbox") / "refused")) << r.name;
  }
}

TEST_F(Trial, Row49AHeadThatForetellsTheRoomsBadlyIsTakenBack) {
  const typename RoomHead<T>::State before = rig.controller->learning().head.theta();
  while (starts_cycle(rig.now)) rig.row();
  // Within what a room could do, and so sure of itself that it does not learn better.
  push(signed_by(blob_of<T>(*rig.controller,
                            [](auto& p) {
                              for (int i = RoomHead<T>::regressors; i < RoomHead<T>::states; ++i) p.head_theta(i) = 3;
                              for (double& c : p.head_covariance) c *= 1e-6;
                            }),
                 key, 1));
  ASSERT_TRUE(row()) << text_of(record.refusal) << ' ' << record.refusal_field.data();
  EXPECT_EQ(record.took_head, 1u);
  int rows_on_trial = 0;
  for (; record.state == TrialState::on_trial && rows_on_trial < rows_per_day; ++rows_on_trial) row();
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_LE(rows_on_trial, 12 * rows_per_cycle);
  const typename RoomHead<T>::State after = rig.controller->learning().head.theta();
  EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 0.5) << "the head from before the push";
}

TEST_F(Trial, Row49WithoutAYoungRoomItsOwnHeadStaysWhateverTheBlobHolds) {
  rig.controller->learning().head.set_updates(cycles_per_day);
  while (starts_cycle(rig.now)) rig.row();
  const typename RoomHead<T>::State before = rig.controller->learning().head.theta();
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.head_theta(RoomHead<T>::regressors + 5) = 50; }), key, 1));
  ASSERT_TRUE(row()) << text_of(record.refusal);
  EXPECT_EQ(rig.controller->learning().head.theta(), before);
  EXPECT_EQ(record.took_head, 0u);
}

TEST_F(Trial, Row47AnOldCounterIsToldBeforeWhatTheBlobHolds) {
  push(other(5));
  ASSERT_TRUE(row());
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.weights[7] = std::nanf(""); }), key, 5));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_counter);
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.weights[7] = std::nanf(""); }), key, 6));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_value);
}

TEST_F(Trial, Row46ABlobForAnotherTopologyIsRefusedByThatName) {
  auto small = std::make_unique<Controller<ThreeVav>>();
  push(signed_by(blob_of<ThreeVav>(*small), key, 9));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_topology);
}

TEST_F(Trial, Row49WeightsThatDoWorseThanTheScheduleAreTakenBack) {
  rig.now = {1'627'862'400 + 8 * 3600};
  rig.cycles(6);
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  const ControllerSettings& s = rig.controller->settings();
  int rows_on_trial = 0;
  while (record.state == TrialState::on_trial && rows_on_trial < 60) {
    // From the second cycle on: what the first row judges is still of the weights before.
    for (int k = 0; k < 40; ++k) rig.controller->cycle().shadow.cycle(s, s.target_degc + 1, 22, 20.5, 0.6);
    row();
    ++rows_on_trial;
  }
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_LE(rows_on_trial, 15) << "within a few cycles";
  EXPECT_TRUE(rig.same_weights(before)) << "those from before the push";
}

TEST_F(Trial, NewWeightsDoNotAnswerForWhatThoseBeforeThemDid) {
  rig.now = {1'627'862'400 + 8 * 3600};
  rig.cycles(6);
  const ControllerSettings& s = rig.controller->settings();
  auto& cycle = rig.controller->cycle();
  for (int k = 0; k < 40; ++k) cycle.shadow.cycle(s, s.target_degc + 1, 22, 20.5, 0.6);
  rig.cycles(1);
  ASSERT_EQ(rig.decision().reason, Reason::worse_than_schedule);
  cycle.ladder.hold(Reason::worse_for_long, rig.now, 86400);
  push(other(1));
  ASSERT_TRUE(row()) << "and the standing decision is still that of the weights before";
  rows(rows_per_day / 2);
  EXPECT_EQ(record.state, TrialState::on_trial);
  EXPECT_EQ(rig.decision().mode, Mode::learn) << "they act, else a trial shows nothing";
  rows(rows_per_day / 2 + 2);
  EXPECT_EQ(record.state, TrialState::confirmed);
}

TEST_F(Trial, WeightsThatForetellTheRoomsBadlyAreTakenBackThoughTheHeadControlsWell) {
  ASSERT_EQ(rig.controller->settings().head_weight, 1.0);
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  int rows_on_trial = 0;
  for (; record.state == TrialState::on_trial && rows_on_trial < rows_per_day; ++rows_on_trial) {
    rig.controller->cycle().network_expected_degc += 1.5;
    row();
  }
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_LE(rows_on_trial, 12 * rows_per_cycle);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(Trial, ADayOnTheScheduleConfirmsNothing) {
  push(other(1));
  ASSERT_TRUE(row());
  rig.controller->hold(Reason::crash_loop, rig.now, 2 * 86400);
  rows(rows_per_day + 10);
  EXPECT_EQ(record.state, TrialState::on_trial);
  EXPECT_EQ(record.tried_cycles, 0u);
  rows(rows_per_day + 50 * rows_per_cycle);
  EXPECT_EQ(record.state, TrialState::confirmed);
}

TEST_F(Trial, FirstWeightsAreOnTrialTooAndTheWayBackIsTheSchedule) {
  rig.controller->cycle().has_weights = 0;
  rig.cycles(2);
  ASSERT_EQ(rig.decision().reason, Reason::no_weights);
  push(other(1));
  ASSERT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::on_trial);
  rig.cycles(2);
  EXPECT_LT(rig.decision().mode, Mode::expert);
  wish("rollback");
  EXPECT_TRUE(row());
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights);
}

TEST_F(Trial, WeightsThatNobodyPushedAreNotTakenBack) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> standing = rig.controller->learning().weights;
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.state, TrialState::none);
  EXPECT_TRUE(rig.same_weights(standing));
  rig.cycles(2);
  EXPECT_LT(rig.decision().mode, Mode::expert);
}

TEST_F(Trial, AnotherPushDuringATrialKeepsTheWayBackThatWasProven) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  push(other(2, 0.8F));
  ASSERT_TRUE(row());
  wish("rollback");
  ASSERT_TRUE(row());
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(Trial, AfterAWayBackTheBarIsThatOfTheWeightsInUse) {
  rig.controller->cycle().network_error_k2 = 0.04;
  push(other(1));
  ASSERT_TRUE(row());
  rig.controller->cycle().network_error_k2 = 3.6;  // what bad weights leave
  wish("rollback");
  ASSERT_TRUE(row());
  EXPECT_EQ(rig.controller->cycle().network_error_k2, record.before_error_k2);
  EXPECT_LT(record.before_error_k2, 1.0);
}

TEST_F(Trial, TheScheduleIsAWayBackThatNeedsNoCopy) {
  rig.controller->cycle().has_weights = 0;
  push(other(1));
  ASSERT_TRUE(row());
  std::filesystem::remove(folder.file("state") / "previous");
  wish("rollback");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights);
}

TEST_F(Trial, Row48KeysAreReadAnewForEachBlob) {
  const hal::SecretKey bob = hal::make_key("Bob");
  push(signed_by(other(1), bob, 1));
  EXPECT_FALSE(row());
  EXPECT_STREQ(record.refusal_field.data(), "key_id");
  std::ofstream(folder.file("keys") / "bob.pub") << hal::public_key_text(bob.open);
  push(signed_by(other(1), bob, 1));
  EXPECT_TRUE(row()) << "without a restart";
  std::ofstream(folder.file("keys") / "revoked") << hal::hex_of(bob.open.id) << '\n';
  push(signed_by(other(1), bob, 2));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_signature);
  std::ofstream(folder.file("keys") / "spoilt.pub") << "no key";
  push(other(3));
  EXPECT_TRUE(row()) << "a spoilt file is left out";
}

TEST_F(Trial, AKeyThatLiesAsideForAWhileKeepsItsCounterWhereThereIsRoom) {
  push(other(5));
  ASSERT_TRUE(row());
  std::filesystem::rename(folder.file("keys") / "ann.pub", folder.file("ann.pub"));
  const hal::SecretKey bob = hal::make_key("Bob");
  std::ofstream(folder.file("keys") / "bob.pub") << hal::public_key_text(bob.open);
  push(signed_by(other(1), bob, 1));
  ASSERT_TRUE(row());
  std::filesystem::rename(folder.file("ann.pub"), folder.file("keys") / "ann.pub");
  push(other(5));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_counter);
}

TEST_F(Trial, WhereTheWayBackCannotBeWrittenThePushWaitsInTheInbox) {
  std::filesystem::create_directories(folder.file("state") / "previous.new");
  push(other(1));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::state_invalid);
  EXPECT_TRUE(std::filesystem::exists(folder.file("inbox") / "weights.blob"));
  EXPECT_EQ(record.state, TrialState::none);
  std::filesystem::remove(folder.file("state") / "previous.new");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.refusal, Fault::none);
  EXPECT_TRUE(std::filesystem::is_empty(folder.file("inbox")));
}

TEST_F(Trial, ABlobThatMayNotBeReadIsRefusedWithThatReason) {
  std::filesystem::create_symlink("/proc/version", folder.file("inbox") / "a.blob");
  EXPECT_FALSE(row());
  EXPECT_NE(std::string(record.refusal_field.data()).find("may read"), std::string::npos);
}

TEST_F(Trial, AnOperatorMayTakeThemBackAndARestartInBetweenChangesNothing) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  open();  // the daemon was restarted: the way back lies on the disk
  rows(10);
  wish("rollback");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_TRUE(rig.same_weights(before));
}

/// What a medium that fails is to an inbox: a name that opens to nothing, though it is no link.
void put_unreadable(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.string().copy(address.sun_path, sizeof address.sun_path - 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << path;
  ::close(fd);
}

TEST_F(Trial, ABlobThatCannotBeReadIsTriedByThreeRowsMore) {
  const auto path = folder.file("inbox") / "a.blob";
  put_unreadable(path);
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < hal::Mailbox::patience; ++i) {
    EXPECT_FALSE(row());
    EXPECT_TRUE(std::filesystem::exists(path)) << i;
  }
  EXPECT_FALSE(row());
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_TRUE(std::filesystem::exists(folder.file("inbox") / "refused"));
  EXPECT_NE(said.find("pushed weights wait: a.blob"), std::string::npos) << said;
  EXPECT_NE(said.find("pushed weights refused: a.blob"), std::string::npos) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 2) << "once each: " << said;
  put_unreadable(path);
  EXPECT_FALSE(row());
  EXPECT_TRUE(std::filesystem::exists(path)) << "the next one has a patience of its own";
  std::filesystem::remove(path);
  push(other(1));
  EXPECT_TRUE(row()) << "and what can be read then is taken";
}

TEST_F(Trial, ABlobThatCannotBeReadAndWasTakenBackDoesNotWait) {
  put_unreadable(folder.file("inbox") / "a.blob");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_taken_back);
  EXPECT_FALSE(std::filesystem::exists(folder.file("inbox") / "a.blob"));
}

TEST_F(Trial, AWayBackThatCannotBeReadOnceIsReadByTheNextRow) {
  const auto previous = folder.file("state") / "previous", away = folder.file("state") / "away";
  for (const bool comes_back : {true, false}) {
    while (starts_cycle(rig.now)) row();
    const NetworkWeights<T, float> before = rig.controller->learning().weights;
    push(other(comes_back ? 1 : 2));
    ASSERT_TRUE(row());
    std::filesystem::rename(previous, away);
    std::filesystem::create_directory(previous);  // which cannot be read
    wish("rollback");
    EXPECT_TRUE(row());
    EXPECT_EQ(record.state, TrialState::on_trial);
    EXPECT_EQ(rig.controller->cycle().has_weights, 0) << "meanwhile nobody asks those that go";
    if (comes_back) {
      std::filesystem::remove(previous);
      std::filesystem::rename(away, previous);
      wish("rollback");  // asked again in the row that succeeds
      EXPECT_TRUE(row());
    }
    if (!comes_back) rows(3);
    EXPECT_EQ(record.state, TrialState::rolled_back);
    EXPECT_EQ(record.tries_back, 0u);
    EXPECT_EQ(rig.controller->cycle().has_weights, comes_back ? 1 : 0);
    EXPECT_EQ(rig.same_weights(before), comes_back);
  }
}

TEST_F(Trial, ConfirmedWeightsStayWhileTheWayBackCannotBeRead) {
  push(other(1));
  ASSERT_TRUE(row());
  record.state = TrialState::confirmed;
  std::filesystem::remove(folder.file("state") / "previous");
  std::filesystem::create_directory(folder.file("state") / "previous");
  wish("rollback");
  EXPECT_TRUE(row());
  EXPECT_EQ(rig.controller->cycle().has_weights, 1);
  rows(3);
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(record.refusal, Fault::no_way_back);
  EXPECT_EQ(rig.controller->cycle().has_weights, 1);
}

TEST_F(Trial, ADamagedCopyIsNoWayBackAndHarmsNothing) {
  push(other(1));
  ASSERT_TRUE(row());
  std::fstream copy(folder.file("state") / "previous", std::ios::in | std::ios::out | std::ios::binary);
  copy.seekp(5000);
  copy.put('x');
  copy.put('y');
  copy.close();
  while (starts_cycle(rig.now)) row();
  const NetworkWeights<T, float> standing = rig.controller->learning().weights;
  record.state = TrialState::confirmed;
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_TRUE(rig.same_weights(standing));
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(record.refusal, Fault::no_way_back) << "for the status";
  record.state = TrialState::on_trial;
  wish("rollback");
  EXPECT_TRUE(row()) << "what is on trial goes";
  EXPECT_EQ(record.state, TrialState::rolled_back);
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights) << "the schedule";
}

TEST_F(Trial, APushThatIsTakenBackBeforeItWasTriedLeavesTheWeightsAlone) {
  push(other(1));
  ASSERT_TRUE(row());
  record.state = TrialState::confirmed;
  while (starts_cycle(rig.now)) row();
  const NetworkWeights<T, float> standing = rig.controller->learning().weights;
  push(other(2, 0.8F));
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(record.refusal, Fault::blob_taken_back);
  EXPECT_TRUE(rig.same_weights(standing));
  wish("rollback");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // files' times have the grain of the kernel's clock
  push(other(2, 0.8F));
  EXPECT_TRUE(row()) << "first back, then on with the new ones";
  EXPECT_EQ(record.state, TrialState::on_trial);
}

TEST_F(Trial, AWayBackIsOneTooWhereTheBlobInUseStillLiesInTheInbox) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  rig.row();
  ASSERT_TRUE(trial->row({rig.now.seconds - row_s}, *rig.controller, record));
  open();  // the daemon ended between the commit and the taking away
  wish("rollback");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(Trial, MemoriesKeepTheirMeaningUnderAnotherScaler) {
  const Scaler<T> old = rig.controller->learning().scaler;
  push(signed_by(blob_of<T>(*rig.controller,
                            [](auto& p) {
                              p.scaler.mean(0) += 1;
                              p.scaler.scale(0) *= 2;
                              for (int i = 0; i < Layout<T>::rooms; ++i) {
                                p.scaler.mean(i) = p.scaler.mean(0);
                                p.scaler.scale(i) = p.scaler.scale(0);
                              }
                              for (float& w : p.weights) w *= 0.5F;
                            }),
                 key, 1));
  while (starts_cycle(rig.now)) rig.row();
  const auto newest = rig.controller->replay().newest(0);
  ASSERT_TRUE(row()) << text_of(record.refusal);
  const Scaler<T>& now = rig.controller->learning().scaler;
  const auto& after = rig.controller->replay().newest(0);
  EXPECT_NE(after[0], newest[0]);
  EXPECT_NEAR(static_cast<double>(after[0]) * now.scale(0) + now.mean(0),
              static_cast<double>(newest[0]) * old.scale(0) + old.mean(0), 1e-4);
}

TEST_F(Trial, Row49WeightsThatForetellNothingAreTakenBackAtOnce) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  auto& learning = rig.controller->learning();
  learning.weights.values.fill(std::nanf(""));
  learning.head.theta().setConstant(std::nan(""));
  rig.controller->prepare();
  for (int i = 0; i < rows_per_cycle && record.state == TrialState::on_trial; ++i) row();
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(Trial, Row49WeightsUnderWhichTheGainTurnsRoundAreTakenBackAtOnce) {
  const auto turn_round = [this] {
    RoomHead<T>& head = rig.controller->learning().head;
    constexpr int gain = HeadFeatures::setpoint_change;
    head.theta()(gain) = -3;
    head.covariance().row(gain).setZero();
    head.covariance().col(gain).setZero();
    head.covariance()(gain, gain) = 1e-6;
  };
  push(other(1));
  ASSERT_TRUE(row());
  turn_round();
  for (int i = 0; i < 2 * rows_per_cycle && record.state == TrialState::on_trial; ++i) row();
  EXPECT_EQ(record.state, TrialState::rolled_back);
  // One that had turned round before is not held against weights that come.
  record = {};
  turn_round();
  rig.cycles(2);
  ASSERT_EQ(rig.decision().reason, Reason::gain_reversed);
  rig.controller->learning().head.set_updates(cycles_per_day);
  push(other(2));
  ASSERT_TRUE(row()) << record.refusal_field.data();
  turn_round();
  rows(3 * rows_per_cycle);
  ASSERT_EQ(rig.decision().reason, Reason::gain_reversed);
  EXPECT_EQ(record.state, TrialState::on_trial);
}

TEST_F(Trial, Row49WeightsThatForetellThePastWildlyAreRefused) {
  push(signed_by(blob_of<T>(*rig.controller,
                            [](auto& p) {
                              for (int i = 0; i < Layout<T>::rooms; ++i) p.scaler.mean(i) += 9;
                            }),
                 key, 1));
  EXPECT_FALSE(row());
  EXPECT_STREQ(record.refusal_field.data(), "forecasts of what this room did");
}

TEST_F(Trial, NoWorseThanThoseBeforeIsGoodEnough) {
  rig.controller->cycle().network_error_k2 = 9;
  push(other(1));
  ASSERT_TRUE(row());
  for (int i = 0; i < 15 * rows_per_cycle; ++i) {
    rig.controller->cycle().network_expected_degc += 0.6;  // three times a cycle
    row();
  }
  EXPECT_GT(record.error_sum_k2 / record.tried_cycles, 1.0);
  EXPECT_EQ(record.state, TrialState::on_trial);
}

TEST_F(Trial, AScheduleThatHasTakenOverSpeaksAgainstTheWeights) {
  push(other(1));
  ASSERT_TRUE(row());
  rig.controller->hold(Reason::worse_for_long, rig.now, 86400);
  rows(5 * rows_per_cycle);
  EXPECT_EQ(record.state, TrialState::rolled_back);
}

TEST_F(Trial, AHeadIsOnTrialOnlyWhereItCameAndForetold) {
  push(other(1));
  ASSERT_TRUE(row());
  for (int i = 0; i < 6 * rows_per_cycle; ++i) {
    rig.controller->cycle().head_expected_degc = std::nan("");
    row();
  }
  EXPECT_EQ(record.took_head, 1u);
  EXPECT_GT(record.tried_cycles, 3u);
  EXPECT_EQ(record.head_error_sum_k2, 0.0) << "no forecast is no error";
  wish("rollback");
  ASSERT_TRUE(row());
  rig.controller->learning().head.set_updates(cycles_per_day);
  push(other(2));
  ASSERT_TRUE(row());
  for (int i = 0; i < 15 * rows_per_cycle; ++i) {
    rig.controller->cycle().head_expected_degc += 1.5;
    row();
  }
  EXPECT_EQ(record.took_head, 0u);
  EXPECT_EQ(record.state, TrialState::on_trial) << "that was the room's own";
}

TEST_F(Trial, AskedTwiceItGoesBackOnce) {
  push(other(1));
  ASSERT_TRUE(row());
  wish("rollback");
  EXPECT_TRUE(row());
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
}

TEST_F(Trial, AWayBackThatHoldsNoNumbersIsTheSchedule) {
  while (starts_cycle(rig.now)) rig.row();
  rig.controller->learning().weights.values[5] = std::nanf("");
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.weights[5] = 0; }), key, 1));
  ASSERT_TRUE(row()) << text_of(record.refusal) << ' ' << record.refusal_field.data();
  wish("rollback");
  EXPECT_TRUE(row());
  rig.cycles(1);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights);
}

TEST_F(Trial, MailOfRowsWithoutACommitIsFinishedByTheNextOne) {
  wish("rollback");
  push(other(1));
  for (int i = 0; i < 2; ++i) {
    rig.row();
    (void)trial->row({rig.now.seconds - row_s}, *rig.controller, record);
  }
  EXPECT_TRUE(std::filesystem::exists(folder.file("inbox") / "rollback"));
  trial->committed();
  EXPECT_FALSE(std::filesystem::exists(folder.file("inbox") / "rollback"));
}

TEST_F(Trial, NamesThatAreNoPlainTextDoNotReachTheLog) {
  ::testing::internal::CaptureStderr();
  for (const char* name : {"a\nb.blob", "c\x7f.blob"}) {
    const auto path = folder.file("inbox") / name;
    std::ofstream(path).put('x');
    std::filesystem::last_write_time(path, std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
    EXPECT_FALSE(row());
  }
  std::filesystem::create_symlink("/proc/version", folder.file("inbox") / "\xc3\xa4.blob");
  EXPECT_FALSE(row());
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("a blob"), std::string::npos) << said;
  EXPECT_EQ(said.find("\nb"), std::string::npos) << said;
  EXPECT_EQ(said.find('\x7f'), std::string::npos) << said;
  EXPECT_EQ(said.find('\xc3'), std::string::npos) << said;
}

TEST_F(Trial, WhatCannotBeReadAndWasTakenBackIsTheLatter) {
  std::filesystem::create_symlink("/proc/version", folder.file("inbox") / "a.blob");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_taken_back);
}

TEST_F(Trial, ACounterIsGivenUpOnlyWhereItsKeyIsGone) {
  std::vector<hal::SecretKey> sixteen;
  for (int i = 0; i < 16; ++i) sixteen.push_back(hal::make_key("key " + std::to_string(i)));
  std::filesystem::remove(folder.file("keys") / "ann.pub");
  const auto lay = [&](int i) {
    std::ofstream(folder.file("keys") / (std::to_string(i) + ".pub"))
        << hal::public_key_text(sixteen[static_cast<std::size_t>(i)].open);
  };
  for (int i = 0; i < 16; ++i) {
    lay(i);
    record.counter[static_cast<std::size_t>(i)] = {.key = sixteen[static_cast<std::size_t>(i)].open.id, .highest = 7};
  }
  std::filesystem::remove(folder.file("keys") / "9.pub");
  const hal::SecretKey next = hal::make_key("next");
  std::ofstream(folder.file("keys") / "next.pub") << hal::public_key_text(next.open);
  push(signed_by(other(1), next, 1));
  EXPECT_TRUE(row()) << text_of(record.refusal);
  EXPECT_EQ(record.counter[9].key, next.open.id);
  EXPECT_EQ(record.counter[8].highest, 7u);
}

TEST(TrialStates, HaveWords) {
  EXPECT_STREQ(edge::text_of(TrialState::none), "none");
  EXPECT_STREQ(edge::text_of(TrialState::confirmed), "confirmed");
  EXPECT_STREQ(edge::text_of(TrialState::rolled_back), "rolled back");
  EXPECT_STREQ(edge::text_of(static_cast<TrialState>(9)), "unknown");
}

TEST_F(Trial, WishesReachTheLadder) {
  wish("release");
  row();
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::released_by_hand);
  wish("hand-back");
  row();
  rig.cycles(2);
  EXPECT_EQ(rig.decision().mode, Mode::learn);
}

}  // namespace
}  // namespace airside::weights
