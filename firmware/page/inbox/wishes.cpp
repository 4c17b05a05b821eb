#include "firmware/page/inbox/wishes.hpp"

#include <filesystem>
#include <span>

#include "hal/storage/atomic_file.hpp"
#include "hal/weights/mailbox.hpp"

namespace airside::page {
namespace {

Said drop(const std::string& inbox_dir, const char* name, const std::string& text, const char* sentence) {
  // The folder is shared with other users: a link at its path is not followed.
  const auto inbox = hal::StorageFile::open_existing_dir(inbox_dir.c_str(), hal::FolderLink::refused);
  const hal::StoreResult<void> written = inbox
                                             ? hal::write_file_atomically(*inbox, name, std::as_bytes(std::span(text)))
                                             : hal::StoreResult<void>(tl::make_unexpected(inbox.error()));
  if (written) return {202, sentence};
  return inbox_refusal(written.error().fault);
}

}  // namespace

Said inbox_refusal(hal::StoreFault fault) {
  const bool full = fault == hal::StoreFault::no_space;
  Said said = full ? refusal(507, refusals::inbox_full) : refusal(503, refusals::inbox_unwritable);
  said.found = hal::text_of(fault);
  said.text += ": " + said.found;
  return said;
}

Said ask_release(const std::string& inbox_dir, std::string_view body) {
  const auto hours = hal::Mailbox::hours_of(body);
  if (!hours) return refusal(400, refusals::hours_wrong);
  return drop(inbox_dir, hal::Mailbox::release_name, std::string(body),
              "nothing more is written, from now on; the heartbeat ends too, and the status says so within 6 min");
}

Said ask_hand_back(const std::string& inbox_dir) {
  return drop(inbox_dir, hal::Mailbox::hand_back_name, "",
              "the daemon takes over within 6 min, and sets the next setpoint with its next decision");
}

Said ask_rollback(const std::string& inbox_dir) {
  return drop(inbox_dir, hal::Mailbox::rollback_name, "",
              "the daemon rolls back to the weights before the last push within 6 min");
}

std::string waiting_wish(const std::string& inbox_dir) {
  for (const char* wish : {hal::Mailbox::hand_back_name, hal::Mailbox::release_name}) {
    std::error_code unread;
    if (std::filesystem::is_regular_file(std::filesystem::path(inbox_dir) / wish, unread)) return wish;
  }
  return {};
}

Said ask_readings(const std::string& inbox_dir) {
  return drop(inbox_dir, "read-points", "", "the daemon reads every point with its next heartbeat or row");
}

Said ask_write_check(const std::string& inbox_dir) {
  return drop(inbox_dir, "check-write", "",
              "the daemon moves the setpoint by half a kelvin and back with its next heartbeat or row");
}

}  // namespace airside::page
