#pragma once
// A box's airside-page as a client sees it: what it gives out, and what it takes.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tools/cli/command.hpp"

namespace airside::tools {

/// Whether a target is a web address rather than a file's path.
bool is_web_address(const std::string& target);

/// One box by `http://HOST[:PORT]` or `https://HOST[:PORT]`. No proxy is asked and no redirect followed: a box is near.
class HttpBox {
 public:
  /// `access.ca`: PEM certificates to trust beside none else, such as a box's own; "" trusts this machine's.
  /// Errors: hal::InputError for another address, or a file that is not there.
  HttpBox(std::string address, const BoxAccess& access);

  /// Body of GET `path`. Errors: hal::InputError with the address, what came back and what to do; also for more than
  /// `max_bytes`.
  std::vector<std::byte> get(const std::string& path, std::size_t max_bytes) const;
  /// Sends a signed blob and returns what the box says. Refused before the body goes out where that can be known.
  /// Errors: as get().
  std::string send_blob(std::span<const std::byte> blob) const;

 private:
  struct Answer {
    long status = 0;
    std::vector<std::byte> body;
  };
  Answer exchange(const std::string& path, std::size_t max_bytes, const std::span<const std::byte>* body,
                  const std::string& token) const;
  [[noreturn]] void refuse(const std::string& path, const Answer& answer) const;

  std::string address_, ca_file_, key_;
};

}  // namespace airside::tools
