// Pushed weights that are refused, with the reason: keys and counters, what a blob holds, what cannot be read.

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <thread>

#include "support/default_cycle.hpp"
#include "weights/trial_rig.hpp"

namespace airside::weights {
namespace {

using Refusal = Trial;

TEST_F(Refusal, Row47AnOldAndARepeatedCounterAreRefused) {
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

TEST_F(Refusal, Row47WithoutItEachKeyHasACounterOfItsOwn) {
  const hal::SecretKey bob = hal::make_key("Bob");
  std::ofstream(folder.file("keys") / "bob.pub") << hal::public_key_text(bob.open);
  open();
  push(other(1000));
  ASSERT_TRUE(row());
  push(signed_by(other(1), bob, 3));
  EXPECT_TRUE(row()) << "his third, though hers was the thousandth";
}

TEST_F(Refusal, KeysThatComeAndGoOverTheYearsDoNotUseUpTheCounters) {
  for (int year = 0; year < 40; ++year) {
    const hal::SecretKey next = hal::make_key("key of " + std::to_string(year));
    std::ofstream(folder.file("keys") / "next.pub") << hal::public_key_text(next.open);
    open();
    push(signed_by(other(1), next, 1));
    ASSERT_TRUE(row()) << year << ": " << text_of(record.refusal);
  }
}

TEST_F(Refusal, AKeyThatLiesAsideForAWhileKeepsItsCounterWhereThereIsRoom) {
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

TEST_F(Refusal, ACounterIsGivenUpOnlyWhereItsKeyIsGone) {
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

TEST_F(Refusal, Row47AnOldCounterIsToldBeforeWhatTheBlobHolds) {
  push(other(5));
  ASSERT_TRUE(row());
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.weights[7] = std::nanf(""); }), key, 5));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_counter);
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.weights[7] = std::nanf(""); }), key, 6));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_value);
}

TEST_F(Refusal, Row48KeysAreReadAnewForEachBlob) {
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
    {"OfAnotherCycle", Fault::blob_cycle,
     [](const auto& c, const auto& key) {
       return signed_by(blob_of<T>(c, [](auto& p) { p.cycle = cycle_of_minutes(12); }), key, 9);
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

TEST_F(Refusal, Row49WhatIsNotSoundIsRefusedAndChangesNothing) {
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

TEST_F(Refusal, Row46ABlobForAnotherTopologyIsRefusedByThatName) {
  auto small = std::make_unique<Controller<ThreeVav>>();
  push(signed_by(blob_of<ThreeVav>(*small), key, 9));
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_topology);
}

TEST_F(Refusal, Row49WeightsThatForetellThePastWildlyAreRefused) {
  push(signed_by(blob_of<T>(*rig.controller,
                            [](auto& p) {
                              for (int i = 0; i < Layout<T>::rooms; ++i) p.scaler.mean(i) += 9;
                            }),
                 key, 1));
  EXPECT_FALSE(row());
  EXPECT_STREQ(record.refusal_field.data(), "forecasts of what this room did");
}

TEST_F(Refusal, ABlobThatMayNotBeReadIsRefusedWithThatReason) {
  std::filesystem::create_symlink("/proc/version", folder.file("inbox") / "a.blob");
  EXPECT_FALSE(row());
  EXPECT_NE(std::string(record.refusal_field.data()).find("may read"), std::string::npos);
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

TEST_F(Refusal, ABlobThatCannotBeReadIsTriedByThreeRowsMore) {
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
  for (int i = 1; i < hal::Mailbox::patience; ++i) EXPECT_FALSE(row());
  std::filesystem::remove(path);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // files' times have the grain of the kernel's clock
  put_unreadable(path);
  EXPECT_FALSE(row());
  EXPECT_TRUE(std::filesystem::exists(path)) << "and so has one that replaces another";
  std::filesystem::remove(path);
  push(other(1));
  EXPECT_TRUE(row()) << "and what can be read then is taken";
}

TEST_F(Refusal, ABlobThatCannotBeReadAndWasTakenBackDoesNotWait) {
  put_unreadable(folder.file("inbox") / "a.blob");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_taken_back);
  EXPECT_FALSE(std::filesystem::exists(folder.file("inbox") / "a.blob"));
}

TEST_F(Refusal, WhatCannotBeReadAndWasTakenBackIsTheLatter) {
  std::filesystem::create_symlink("/proc/version", folder.file("inbox") / "a.blob");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::blob_taken_back);
}

TEST_F(Refusal, NamesThatAreNoPlainTextDoNotReachTheLog) {
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

}  // namespace
}  // namespace airside::weights
