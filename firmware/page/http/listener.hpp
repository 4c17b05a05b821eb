#pragma once
// The page's listening socket, and the peers that come to it.

#include <optional>
#include <string>

#include "firmware/page/http/connection_table.hpp"
#include "hal/storage/storage_file.hpp"

struct sockaddr;

namespace airside::page {

/// A peer that was accepted and has no place yet.
struct Newcomer {
  hal::StorageFile socket;  ///< a descriptor that closes with its owner
  PeerAddress peer;
  std::int64_t since_ns = 0;
};

class Listener {
 public:
  static constexpr int max_waiting = 64;  ///< in the kernel, until somebody is accepted

  /// Binds and listens; port 0 takes any. Errors: InputError for an address or port that cannot be had.
  Listener(const std::string& address, int port);

  /// The next peer; nothing where none waits.
  std::optional<Newcomer> accept() const;
  int descriptor() const { return socket_.descriptor(); }
  int port() const { return port_; }

 private:
  hal::StorageFile socket_;
  int port_ = 0;
};

/// Numeric address of this machine that the peer of `socket` has reached.
std::string local_address_of(int socket);

}  // namespace airside::page
