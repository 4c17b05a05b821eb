// Signing in where something happens meanwhile: another password is set, memory is short, the power fails.

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>

#include <atomic>

#include "firmware/page/auth/access_file.hpp"
#include "firmware/page/auth/password_check.hpp"
#include "firmware/page/sign_in.hpp"
#include "page_http/page_rig.hpp"
#include "support/sanitized.hpp"

static std::atomic<int> forced_folders{0};

/// In the place of the C library's: counts folders.
extern "C" int fsync(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) == 0 && S_ISDIR(status.st_mode)) ++forced_folders;
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

namespace airside::page {
namespace {

constexpr std::int64_t now_ns = 1'000'000'000'000;

class PageSignIn : public PageRig {
 protected:
  PageSignIn() {
    fs::create_directory(dir);
    set("seven quiet dampers");
  }
  void set(const std::string& password) const {
    Access access;
    access.password[static_cast<std::size_t>(Role::operator_)] = hash_of_password(password);
    write_access(dir, access);
  }
  static SignIn::Outcome outcome_of(SignIn& sign_in) {
    std::optional<SignIn::Outcome> outcome;
    for (const double until = now_s() + 30; !outcome && now_s() < until; sleep_s(0.002)) {
      outcome = sign_in.finish(now_ns);
    }
    EXPECT_TRUE(outcome.has_value());
    return outcome.value_or(SignIn::Outcome{});
  }
  static SignIn::Start try_with(SignIn& sign_in, const std::string& password) {
    return sign_in.begin("operator\n" + password, {.bytes = {1}, .text = "127.0.0.1"}, now_ns);
  }
  /// Leaves this process memory for little beside what it has, until it is destroyed.
  class Shortage {
   public:
    Shortage() {
      ::getrlimit(RLIMIT_AS, &before_);
      std::ifstream in("/proc/self/statm");
      rlim_t pages = 0;
      in >> pages;
      rlimit now = before_;
      now.rlim_cur = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + (4u << 20);
      ::setrlimit(RLIMIT_AS, &now);
    }
    ~Shortage() { ::setrlimit(RLIMIT_AS, &before_); }
    Shortage(const Shortage&) = delete;
    Shortage& operator=(const Shortage&) = delete;

   private:
    rlimit before_{};
  };

  std::string dir = folder / "page";
  AuditLog log;
};

TEST_F(PageSignIn, AnOldPasswordOpensNothingWhereAnotherWasSetMeanwhile) {
  SignIn sign_in(dir, "airside-1", false, log);
  ASSERT_EQ(try_with(sign_in, "seven quiet dampers").status, 200);
  set("nine cold coils here");
  sign_in.refresh();  // as another request does: everybody is signed out
  const SignIn::Outcome late = outcome_of(sign_in);
  EXPECT_EQ(late.session, nullptr);
  ASSERT_TRUE(late.put_off.has_value());
  EXPECT_STREQ(late.put_off->code, "passwords_changed");
  ASSERT_EQ(try_with(sign_in, "seven quiet dampers").status, 200);
  set("four loud fans there");  // and nobody has asked anything since
  EXPECT_EQ(outcome_of(sign_in).session, nullptr);
  ASSERT_EQ(try_with(sign_in, "four loud fans there").status, 200);
  EXPECT_NE(outcome_of(sign_in).session, nullptr);
}

TEST_F(PageSignIn, AShortageOfMemoryIsNoWrongPasswordAndEndsNothing) {
  if (sanitized) GTEST_SKIP() << "a sanitizer reserves more than any limit";
  SignIn sign_in(dir, "airside-1", false, log);
  for (int i = 0; i < 2 * Lockout::free_failures; ++i) {
    const Shortage shortage;
    ASSERT_EQ(try_with(sign_in, "seven quiet dampers").status, 200) << "nobody waits";
    const SignIn::Outcome outcome = outcome_of(sign_in);
    ASSERT_TRUE(outcome.put_off.has_value());
    EXPECT_STREQ(outcome.put_off->code, "sign_in_no_memory");
  }
  {
    PasswordCheck check;
    const Shortage shortage;
    ASSERT_TRUE(check.begin("", "a role without a password"));
    std::optional<PasswordResult> result;
    for (const double until = now_s() + 30; !result && now_s() < until; sleep_s(0.002)) result = check.result();
    EXPECT_EQ(result, PasswordResult::no_memory);
  }
  ASSERT_EQ(try_with(sign_in, "seven quiet dampers").status, 200);
  EXPECT_NE(outcome_of(sign_in).session, nullptr);
}

TEST_F(PageSignIn, ANewPasswordIsForcedToTheDiskWithItsName) {
  const int before = forced_folders;
  set("nine cold coils here");
  EXPECT_GT(forced_folders, before) << "else a power cut brings the old one back";
}

}  // namespace
}  // namespace airside::page
