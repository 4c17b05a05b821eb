// Who may do what: passwords and keys in their file, sessions, and how often a password may be tried.

#include <sys/stat.h>

#include <thread>

#include "firmware/page/auth/access_file.hpp"
#include "firmware/page/auth/lockout.hpp"
#include "firmware/page/auth/password_check.hpp"
#include "firmware/page/auth/sessions.hpp"
#include "hal/text/input_error.hpp"
#include "page_http/page_rig.hpp"

namespace airside::page {
namespace {

std::int64_t ns(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

TEST(PageLockout, LetsAFewTriesThroughAndThenWaitsLongerEachTime) {
  Lockout lockout;
  const Lockout::Prefix here{1}, there{2};
  double now_s = 1000;
  for (int i = 0; i < Lockout::free_failures; ++i) {
    EXPECT_EQ(lockout.wait_s(here, ns(now_s)), 0) << i;
    lockout.failed(here, Role::operator_, ns(now_s));
    now_s += 10;
  }
  EXPECT_NEAR(lockout.wait_s(here, ns(now_s)), Lockout::first_wait_s - 10, 1e-6);
  EXPECT_EQ(lockout.wait_s(there, ns(now_s)), 0) << "others are not kept waiting";
  double last_s = Lockout::first_wait_s;
  for (int i = 0; i < 12; ++i) {
    now_s += Lockout::longest_wait_s;
    EXPECT_EQ(lockout.wait_s(here, ns(now_s)), 0);
    lockout.failed(here, Role::operator_, ns(now_s));
    const double wait_s = lockout.wait_s(here, ns(now_s));
    EXPECT_GE(wait_s, last_s);
    EXPECT_LE(wait_s, Lockout::longest_wait_s);
    last_s = wait_s;
  }
  EXPECT_EQ(last_s, Lockout::longest_wait_s);
  lockout.succeeded(here, Role::operator_);
  EXPECT_EQ(lockout.wait_s(here, ns(now_s)), 0);
}

TEST(PageLockout, ForgetsNoFailuresAtOnePasswordWhenAnotherWasRight) {
  Lockout lockout;
  const Lockout::Prefix here{1};
  for (int i = 0; i < Lockout::free_failures - 1; ++i) lockout.failed(here, Role::installer, ns(1000));
  lockout.succeeded(here, Role::viewer);
  EXPECT_EQ(lockout.wait_s(here, ns(1001)), 0);
  lockout.failed(here, Role::installer, ns(1001));
  EXPECT_NEAR(lockout.wait_s(here, ns(1001)), Lockout::first_wait_s, 1e-6);
  lockout.succeeded(here, Role::installer);
  lockout.failed(here, Role::installer, ns(2000));
  EXPECT_EQ(lockout.wait_s(here, ns(2000)), 0) << "begun anew by the right one";
}

TEST(PageLockout, HoldsFailuresOfManyPlacesToARate) {
  Lockout lockout;
  int tried = 0;
  for (int second = 0; second < 600; ++second) {
    for (std::uint8_t place = 0; place < 200; ++place) {
      const Lockout::Prefix from{place, static_cast<std::uint8_t>(second % 250), 7};
      if (lockout.wait_s(from, ns(second)) > 0) continue;
      lockout.failed(from, Role::operator_, ns(second));
      ++tried;
    }
  }
  EXPECT_LE(tried, Lockout::failures_a_minute * 11);
  EXPECT_GE(tried, Lockout::failures_a_minute * 9);
  EXPECT_EQ(lockout.wait_s({9, 9, 9}, ns(700)), 0) << "and afterwards everybody may try again";
}

TEST(PageSessions, EndWhenIdleAndAfterALongDay) {
  Sessions sessions;
  const std::string idle = sessions.begin(Role::operator_, ns(0)).cookie;
  ASSERT_EQ(idle.size(), 64u);
  ASSERT_NE(sessions.find(idle, ns(Sessions::idle_s - 1)), nullptr);
  EXPECT_EQ(sessions.find(idle, ns(2 * Sessions::idle_s)), nullptr);
  EXPECT_EQ(sessions.find(idle, ns(1)), nullptr) << "what has ended stays so";
  const std::string busy = sessions.begin(Role::viewer, ns(0)).cookie;
  double now_s = 0;
  while (sessions.find(busy, ns(now_s)) != nullptr) now_s += 600;
  EXPECT_NEAR(now_s, Sessions::longest_s, 601);
}

TEST(PageSessions, AreToldApartByTheWholeCookie) {
  Sessions sessions;
  const Session one = sessions.begin(Role::operator_, ns(0)), two = sessions.begin(Role::installer, ns(0));
  EXPECT_NE(one.cookie, two.cookie);
  EXPECT_NE(one.token, two.token);
  ASSERT_NE(sessions.find(two.cookie, ns(1)), nullptr);
  EXPECT_EQ(sessions.find(two.cookie, ns(1))->role, Role::installer);
  for (const std::string& wrong : {std::string(), one.cookie.substr(1), one.cookie + "0", std::string(64, '0')}) {
    EXPECT_EQ(sessions.find(wrong, ns(1)), nullptr) << wrong;
  }
  sessions.end(one.cookie);
  EXPECT_EQ(sessions.find(one.cookie, ns(1)), nullptr);
  EXPECT_NE(sessions.find(two.cookie, ns(1)), nullptr);
  for (std::size_t i = 0; i < Sessions::max_sessions; ++i) {
    sessions.begin(Role::installer, ns(10 + static_cast<double>(i)));
  }
  EXPECT_EQ(sessions.find(two.cookie, ns(30)), nullptr) << "the one that was idle longest made room";
}

TEST(PageSessions, OfALowerRoleMakeRoomFirst) {
  Sessions sessions;
  const std::string installer = sessions.begin(Role::installer, ns(0)).cookie;
  const std::string worker = sessions.begin(Role::operator_, ns(1)).cookie;
  const std::string first = sessions.begin(Role::viewer, ns(2)).cookie;
  for (int i = 0; i < 2 * static_cast<int>(Sessions::max_sessions); ++i) sessions.begin(Role::viewer, ns(10 + i));
  EXPECT_EQ(sessions.find(first, ns(60)), nullptr) << "of the viewers the one that was idle longest";
  EXPECT_NE(sessions.find(installer, ns(60)), nullptr) << "a crowd of viewers signs no installer out";
  EXPECT_NE(sessions.find(worker, ns(60)), nullptr);
  for (int i = 0; i < static_cast<int>(Sessions::max_sessions); ++i) sessions.begin(Role::operator_, ns(70 + i));
  EXPECT_NE(sessions.find(installer, ns(90)), nullptr);
  EXPECT_EQ(sessions.find(worker, ns(90)), nullptr) << "an operator gives way to operators";
}

class PageAccess : public PageRig {
 protected:
  PageAccess() { fs::create_directory(dir); }
  std::string complaint() const {
    try {
      (void)read_access(dir);
    } catch (const hal::InputError& error) {
      return error.what();
    }
    return "";
  }
  void write_lines(const std::string& lines) const {
    write("page/access", std::string(Access::first_line) + "\n" + lines);
    ::chmod((folder / "page/access").c_str(), 0600);
  }
  std::string dir = folder / "page";
};

TEST_F(PageAccess, KeepsHashesInAFileOfItsOwnerAlone) {
  Access access;
  EXPECT_TRUE(access.of_anybody().install) << "no password: as a page without this file";
  EXPECT_FALSE(access.of_anybody().operate);
  access.password[static_cast<std::size_t>(Role::operator_)] = hash_of_password("seven quiet dampers");
  const std::string key(64, 'a');
  access.keys.push_back({Role::viewer, digest_of_key(key), "building system"});
  write_access(dir, access);
  struct stat status {};
  ASSERT_EQ(::stat((dir + "/access").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  const std::string text = read("page/access");
  EXPECT_EQ(text.find("seven quiet dampers"), std::string::npos);
  EXPECT_EQ(text.find(key), std::string::npos);
  EXPECT_NE(text.find("password operator $argon2id$v=19$m=19456,t=2,p=1$"), std::string::npos) << text;
  const Access again = read_access(dir);
  EXPECT_EQ(again.text(), access.text());
  ASSERT_NE(again.find_key(key), nullptr);
  EXPECT_EQ(again.find_key(key)->name, "building system");
  EXPECT_EQ(again.find_key(std::string(64, 'b')), nullptr);
  EXPECT_EQ(again.find_key(""), nullptr);
  EXPECT_TRUE(again.of_anybody().see);
  EXPECT_FALSE(again.of_anybody().install) << "with a password weights are the installer's";
}

TEST_F(PageAccess, RefusesWhateverItDidNotWrite) {
  const std::string hash = hash_of_password("seven quiet dampers");
  write_lines("password operator " + hash + "\n");
  EXPECT_EQ(complaint(), "");
  for (const std::string& lines :
       {"password operator " + hash, "password boss " + hash + "\n", std::string("password operator plain\n"),
        "password operator " + hash + "\npassword operator " + hash + "\n", std::string("key viewer abc name\n"),
        std::string("\n"), std::string("hello\n")}) {
    write_lines(lines);
    EXPECT_NE(complaint(), "") << lines;
    EXPECT_NE(complaint().find("page/access"), std::string::npos);
  }
  write_lines("password operator " + hash + "\n");
  ::chmod((folder / "page/access").c_str(), 0640);
  EXPECT_NE(complaint().find("permissions 640"), std::string::npos) << complaint();
  AccessWatch watch(dir);
  EXPECT_FALSE(watch.of_anybody().see) << "a file that cannot be trusted lets nobody in";
  ::chmod((folder / "page/access").c_str(), 0600);
  EXPECT_TRUE(watch.refresh());
  EXPECT_TRUE(watch.of_anybody().see);
  EXPECT_FALSE(watch.refresh()) << "nothing has changed";
}

TEST_F(PageAccess, VerifiesOnePasswordAtATimeBesideTheServer) {
  PasswordCheck check;
  const std::string hash = hash_of_password("seven quiet dampers");
  const auto outcome = [&check] {
    const double until = now_s() + 30;
    std::optional<PasswordResult> result;
    while (!result && now_s() < until) {
      sleep_s(0.002);
      result = check.result();
    }
    return result;
  };
  ASSERT_TRUE(check.begin(hash, "seven quiet dampers"));
  EXPECT_FALSE(check.begin(hash, "another one at the same time"));
  EXPECT_EQ(outcome(), PasswordResult::right);
  ASSERT_TRUE(check.begin(hash, "seven quiet damperS"));
  EXPECT_EQ(outcome(), PasswordResult::wrong);
  ASSERT_TRUE(check.begin("", ""));
  EXPECT_EQ(outcome(), PasswordResult::wrong) << "a role without a password lets nobody in";
  for (const std::string& damaged : {hash + "A", hash.substr(0, hash.size() - 1), std::string("$argon2id$"),
                                     "$argon2i" + hash.substr(9), hash.substr(0, 20) + "x" + hash.substr(21)}) {
    ASSERT_TRUE(check.begin(damaged, "seven quiet dampers"));
    EXPECT_EQ(outcome(), PasswordResult::wrong) << damaged;
  }
}

TEST_F(PageAccess, ServesOthersWhileAPasswordIsTriedAndTurnsAFloodOfThemAway) {
  Access access;
  access.password[static_cast<std::size_t>(Role::operator_)] = hash_of_password("seven quiet dampers");
  write_access(dir, access);
  ASSERT_TRUE(start()) << read("said.txt");
  const std::string body = "operator\nnot the password";
  const std::string login = "POST /login HTTP/1.1\r\nHost: " + host() + "\r\nX-Airside-Token: " + token +
                            "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
  std::vector<std::unique_ptr<Peer>> peers;
  for (int i = 0; i < 8; ++i) {
    peers.push_back(std::make_unique<Peer>(port, "127.0." + std::to_string(i + 1) + ".9"));
    peers.back()->send(login);
  }
  const double began = now_s();
  EXPECT_EQ(status_of(ask(get("/status.json"), "127.0.99.1")), 200);
  EXPECT_LT(now_s() - began, 2.0);
  int tried = 0, put_off = 0;
  for (auto& peer : peers) {
    const int status = status_of(peer->receive());
    tried += status == 403;
    put_off += status == 503;
  }
  EXPECT_GE(tried, 1);
  EXPECT_EQ(tried + put_off, 8);
  EXPECT_GE(put_off, 1) << "the others come back later; nothing queues up";
  EXPECT_EQ(status_of(ask(post(signed_blob()))), 401) << "weights are the installer's now";
  EXPECT_TRUE(inbox_is_empty());
}

}  // namespace
}  // namespace airside::page
