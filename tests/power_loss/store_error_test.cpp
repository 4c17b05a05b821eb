// What a person reads of a storage fault: each has words and a remedy, and each errno is sorted to the right one.

#include "hal/storage/store_error.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <set>

namespace airside::hal {
namespace {

constexpr StoreFault all_faults[] = {StoreFault::none,         StoreFault::no_space,     StoreFault::read_only,
                                     StoreFault::io,           StoreFault::locked,       StoreFault::not_found,
                                     StoreFault::wrong_size,   StoreFault::other_layout, StoreFault::log_shorter,
                                     StoreFault::out_of_order, StoreFault::row_too_long, StoreFault::unread,
                                     StoreFault::removed,      StoreFault::wrong_kind};

TEST(StoreErrors, EachFaultHasAWordAndARemedy) {
  std::set<std::string> words;
  for (const StoreFault fault : all_faults) {
    words.insert(text_of(fault));
    const std::string said = describe({fault, 0, "sync row record"});
    EXPECT_EQ(said.find("sync row record: "), 0u);
    EXPECT_GT(said.size(), said.find("; ") + 10) << said;
  }
  EXPECT_EQ(words.size(), std::size(all_faults));
  EXPECT_STREQ(text_of(static_cast<StoreFault>(200)), "unknown");
  EXPECT_NE(describe({static_cast<StoreFault>(200), 0, "x"}).find("fault of the program"), std::string::npos);
}

TEST(StoreErrors, AnErrnoIsSaidInTheSystemsWordsAndSorted) {
  EXPECT_NE(describe(store_error(ENOSPC, "write")).find("No space left"), std::string::npos);
  const auto sorted = [](int number) { return store_error(number, "x").fault; };
  for (const int number : {ENOSPC, EDQUOT, EFBIG}) EXPECT_EQ(sorted(number), StoreFault::no_space);
  for (const int number : {EROFS, EACCES, EPERM}) EXPECT_EQ(sorted(number), StoreFault::read_only);
  for (const int number : {ENOENT, ENOTDIR}) EXPECT_EQ(sorted(number), StoreFault::not_found);
  EXPECT_EQ(sorted(EWOULDBLOCK), StoreFault::locked);
  for (const int number : {ELOOP, EISDIR, ENXIO}) EXPECT_EQ(sorted(number), StoreFault::wrong_kind);
  for (const int number : {EIO, EINVAL, EMFILE}) EXPECT_EQ(sorted(number), StoreFault::io);
}

}  // namespace
}  // namespace airside::hal
