#include "firmware/page/inbox/wishes.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <span>

#include "hal/storage/atomic_file.hpp"
#include "hal/weights/mailbox.hpp"

namespace airside::page {
namespace {

WishAnswer drop(const std::string& inbox_dir, const char* name, const std::string& text, const char* sentence) {
  // The folder is shared with other users: a link at its path is not followed.
  const auto inbox = hal::StorageFile::open_existing_dir(inbox_dir.c_str(), hal::FolderLink::refused);
  const hal::StoreResult<void> written = inbox
                                             ? hal::write_file_atomically(*inbox, name, std::as_bytes(std::span(text)))
                                             : hal::StoreResult<void>(tl::make_unexpected(inbox.error()));
  if (written) return {202, sentence};
  const bool full = written.error().fault == hal::StoreFault::no_space;
  return {full ? 507 : 503, fmt::format("the inbox cannot be written: {}", hal::text_of(written.error().fault))};
}

}  // namespace

WishAnswer ask_release(const std::string& inbox_dir, std::string_view body) {
  const auto hours = hal::Mailbox::hours_of(body);
  if (!hours) return {400, "hours that are no whole number from 1 to 168; leave the body empty for no end"};
  return drop(inbox_dir, hal::Mailbox::release_name, std::string(body),
              "nothing more is written, from now on; the heartbeat ends too, and the status says so within 6 min");
}

WishAnswer ask_hand_back(const std::string& inbox_dir) {
  return drop(inbox_dir, hal::Mailbox::hand_back_name, "",
              "the daemon takes over within 6 min, and sets the next setpoint with its next decision");
}

WishAnswer ask_rollback(const std::string& inbox_dir) {
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

WishAnswer ask_readings(const std::string& inbox_dir) {
  return drop(inbox_dir, "read-points", "", "the daemon reads every point with its next heartbeat or row");
}

WishAnswer ask_write_check(const std::string& inbox_dir) {
  return drop(inbox_dir, "check-write", "",
              "the daemon moves the setpoint by half a kelvin and back with its next heartbeat or row");
}

}  // namespace airside::page
