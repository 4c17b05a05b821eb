#pragma once
// Who may hold a socket or an upload of airside-page, for how long, and who loses it when somebody else needs it:
// the whole policy against peers that are slow on purpose, without a socket call.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/page/http/audit_log.hpp"
#include "firmware/page/http/request_check.hpp"

namespace airside::page {

/// How long a connection may stay in each of its parts, s in all: a byte now and then buys no more.
struct Deadlines {
  double head_s = 5;     ///< from the connection, TLS included, to the end of the header lines
  double body_s = 10;    ///< of an upload
  double answer_s = 10;  ///< until the peer has taken it
};

/// A peer's address as an IPv6 address, that of IPv4 as the one that stands for it.
struct PeerAddress {
  std::array<std::uint8_t, 16> bytes{};
  std::string text = {};

  bool is_same(const PeerAddress& other) const { return bytes == other.bytes; }
  /// Within one /24 of IPv4 or one /64 of IPv6: what one sender can have at no cost.
  bool shares_prefix(const PeerAddress& other) const;
  /// The address with what is behind its prefix as zeros.
  std::array<std::uint8_t, 16> prefix() const;
};

/// A body that is being received. The memory is kept.
struct Upload {
  bool used = false;
  std::vector<std::byte> bytes;
  std::size_t expected = 0, got = 0;
};

/// A socket, from accept to close.
struct Connection {
  int socket = -1;            ///< -1: free
  std::int64_t since_ns = 0;  ///< when its part began: head, body or answer
  std::int64_t until_ns = 0;  ///< when that must have ended
  bool asks = false;          ///< its request is not whole yet
  bool dropped = false;       ///< shut down; libmicrohttpd has not closed it yet
  PeerAddress peer{};
  Upload* upload = nullptr;
  Route route = Route::none;  ///< of what changes something, once its head was judged
  std::string who{};          ///< who asks for it, for the audit log
  bool waits = false;         ///< for a password to be verified
};

/// Connections and uploads, with budgets for one address, one prefix, and in all. Where a budget is used up, the
/// slowest within it makes room; who is not slow is never cut for another.
class ConnectionTable {
 public:
  static constexpr std::size_t max_sockets = 16, max_sockets_a_prefix = 12, max_sockets_an_address = 4;
  static constexpr std::size_t max_uploads = 6, max_uploads_a_prefix = 4;  ///< at once, one an address
  /// A part that lasts longer is slow: it goes when another needs its place. A handshake costs both sides computation.
  static constexpr double slow_head_s = 0.25, slow_head_tls_s = 0.75, slow_answer_s = 2, slow_body_s = 0.5;

  enum class Admission : std::uint8_t {
    take,    ///< there is a place
    wait,    ///< ask again soon: nobody within the budget is slow yet
    refuse,  ///< the address has its share
  };

  ConnectionTable(AuditLog& log, Deadlines deadlines, bool tls, std::size_t upload_bytes);

  /// Whether a new peer gets a place; a slow one may be dropped for it.
  Admission admit(const PeerAddress& peer, std::int64_t now_ns);
  /// The connection that was just taken; nullptr where no place is left.
  Connection* begin(int socket, const PeerAddress& peer, std::int64_t now_ns);
  /// A place for `bytes` of body; nullptr while others use them all. A slow upload may be dropped for it.
  Upload* begin_upload(Connection& connection, std::size_t bytes, std::int64_t now_ns);
  void begin_answer(Connection& connection, std::int64_t now_ns) const;
  /// The upload's place is free again.
  static void end_upload(Connection& connection);
  /// The socket is closed.
  static void end(Connection& connection);
  /// Cuts whoever is beyond a deadline, and notices who has hung up.
  void cut_overdue(std::int64_t now_ns);
  bool is_empty() const;

 private:
  /// Drops the slowest of those that `within` is true of. False: none of them is slow.
  template <class Within>
  bool drop_slowest(std::int64_t now_ns, const Within& within);
  bool is_slow(const Connection& c, std::int64_t now_ns) const;
  template <class Within>
  std::size_t count(const Within& within) const;
  static void drop(Connection& connection);

  AuditLog& log_;
  Deadlines deadlines_;
  double slow_head_s_;
  std::array<Connection, 2 * max_sockets> connections_;  // those that are dropped keep theirs until they are closed
  std::array<Upload, max_uploads> uploads_;
};

}  // namespace airside::page
