// The inbox: whatever lies there, it is taken away row by row, nothing outside of the folder is touched, and a sound
// blob gets its turn.

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "fuzz/folder.hpp"
#include "fuzz/target.hpp"
#include "hal/weights/mailbox.hpp"

namespace airside::fuzz {
namespace {

constexpr std::array<const char*, 10> names = {"a.blob",    "weights.blob", "z.blob",     "rollback", "release",
                                               "hand-back", "refused",      ".part.blob", "x.blo",    ".blob"};

/// Puts one thing into the inbox: a file, an empty file, a folder, a folder with a file, a link, a pipe.
void put(const Folder& inbox, unsigned kind, const char* name, View content) {
  switch (kind % 6) {
    case 0: inbox.write(name, content); break;
    case 1: inbox.write(name, {}); break;
    case 2: ::mkdirat(inbox.fd(), name, 0750); break;
    case 3:
      if (::mkdirat(inbox.fd(), name, 0750) == 0) inbox.write((std::string(name) + "/x").c_str(), content);
      break;
    case 4: FUZZ_CLAIM(::symlinkat("/proc/version", inbox.fd(), name) == 0); break;
    default: FUZZ_CLAIM(::mkfifoat(inbox.fd(), name, 0640) == 0); break;
  }
}

bool collect(View input) {
  static const Folder inbox("fuzz_inbox");
  for (const auto& entry : std::filesystem::directory_iterator(inbox.path())) std::filesystem::remove_all(entry.path());
  Cursor in(input);
  std::array<bool, names.size()> there{};
  int things = 0;
  while (!in.rest().empty() && things < 12) {
    const unsigned kind = in.byte();
    const std::size_t which = in.byte() % names.size();
    const View content = in.take(in.byte());
    if (there[which]) continue;
    there[which] = true;
    put(inbox, kind, names[which], content);
    ++things;
  }
  hal::Mailbox mailbox(inbox.path());
  FUZZ_CLAIM(mailbox.is_open());
  std::array<std::byte, 64> blob{};
  bool any = false;
  for (int round = 0; round < 5; ++round) {
    const hal::Mail mail = mailbox.collect(blob);
    FUZZ_CLAIM(mail.blob_bytes <= blob.size());
    any = any || mail.has_blob || mail.release || mail.rollback || mail.hand_back;
    if (round > 0) FUZZ_CLAIM(!mail.release && !mail.rollback && !mail.hand_back);
    mailbox.finish(round % 2 == 0);
  }
  // A sound blob that comes now is found, read whole and gone after it was taken.
  const std::array<std::uint8_t, 3> sound = {1, 2, 3};
  ::unlinkat(inbox.fd(), "sound.blob", 0);
  inbox.write("sound.blob", sound);
  const hal::Mail mail = mailbox.collect(blob);
  FUZZ_CLAIM(mail.has_blob && mail.blob_bytes == sound.size() && blob[1] == std::byte{2});
  mailbox.finish(true);
  FUZZ_CLAIM(::faccessat(inbox.fd(), "sound.blob", F_OK, 0) != 0 && !mailbox.collect(blob).has_blob);
  return any;
}

std::vector<Bytes> seeds() {
  return {
      {0, 0, 4, 'b', 'l', 'o', 'b'},        {1, 3, 0, 1, 4, 0, 1, 5, 0}, {0, 1, 2, 1, 2, 2, 0, 0}, {4, 0, 0, 5, 1, 0},
      {0, 7, 1, 1, 0, 8, 1, 1, 0, 9, 1, 1}, {2, 6, 0, 0, 0, 1, 1}};
}

}  // namespace

const Target mailbox{"mailbox", 64, collect, nullptr, seeds, nullptr};

}  // namespace airside::fuzz
