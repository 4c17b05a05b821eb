#include "hal/storage/store_error.hpp"

#include <cerrno>
#include <cstring>

namespace airside::hal {

const char* remedy_of(StoreFault fault) {
  switch (fault) {
    case StoreFault::no_space: return "free some space; control goes on and the next commit tries again";
    case StoreFault::read_only: return "make the folder writable for this user";
    case StoreFault::io: return "check the storage medium; control goes on and the next commit writes anew";
    case StoreFault::locked: return "stop the other process or give this one a folder of its own";
    case StoreFault::not_found: return "create the folder or correct its path in the site file";
    case StoreFault::other_layout: return "give this site a state folder of its own, or move the old files away";
    case StoreFault::log_shorter: return "the missing rows cannot be restored; the log goes on from here";
    case StoreFault::out_of_order:
      return "set the clock right, or move the log folder away; until the clock has passed that row nothing is logged";
    case StoreFault::unread: return "load it; it was out of reach at the start";
    case StoreFault::removed: return "stop airsided before its files are moved; the next row writes new ones";
    case StoreFault::wrong_kind: return "find out who put it there, and take it away";
    case StoreFault::none:
    case StoreFault::wrong_size:
    case StoreFault::row_too_long: break;
  }
  return "this is a fault of the program";
}

const char* text_of(StoreFault fault) {
  switch (fault) {
    case StoreFault::none: return "none";
    case StoreFault::no_space: return "disk full";
    case StoreFault::read_only: return "not writable";
    case StoreFault::io: return "storage failed";
    case StoreFault::locked: return "another process uses it";
    case StoreFault::not_found: return "folder not found";
    case StoreFault::wrong_size: return "wrong size";
    case StoreFault::other_layout: return "state of another topology, control cycle or build";
    case StoreFault::log_shorter: return "log shorter than committed";
    case StoreFault::out_of_order: return "log's last row is later than the clock";
    case StoreFault::row_too_long: return "row too long";
    case StoreFault::unread: return "older state not read yet";
    case StoreFault::removed: return "files removed while in use";
    case StoreFault::wrong_kind: return "not a regular file or folder";
  }
  return "unknown";
}

std::string describe(const StoreError& error) {
  std::string text = std::string(error.step) + ": " + text_of(error.fault);
  if (error.error_number != 0) text += std::string(" (") + std::strerror(error.error_number) + ")";
  return text + "; " + remedy_of(error.fault);
}

StoreError store_error(int error_number, const char* step) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG: return {StoreFault::no_space, error_number, step};
    case EROFS:
    case EACCES:
    case EPERM: return {StoreFault::read_only, error_number, step};
    case ENOENT:
    case ENOTDIR: return {StoreFault::not_found, error_number, step};
    case ELOOP:   // a link where none is followed
    case EISDIR:  // a folder
    case ENXIO:   // a socket or a device
      return {StoreFault::wrong_kind, error_number, step};
    case EWOULDBLOCK: return {StoreFault::locked, error_number, step};
    default: return {StoreFault::io, error_number, step};
  }
}

}  // namespace airside::hal
