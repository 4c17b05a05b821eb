#include "firmware/page/http/connection_table.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <limits>

namespace airside::page {
namespace {

std::int64_t ns_of(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

/// The peer will send no more, and all that it sent has been read. libmicrohttpd would wait on.
bool has_hung_up(int socket) {
  char byte = 0;
  return ::recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

bool is_free(const Connection& c) { return c.socket < 0; }
bool holds_place(const Connection& c) { return c.socket >= 0 && !c.dropped; }

}  // namespace

std::array<std::uint8_t, 16> PeerAddress::prefix() const {
  constexpr std::array<std::uint8_t, 12> four{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};
  const std::ptrdiff_t size = std::equal(four.begin(), four.end(), bytes.begin()) ? 15 : 8;
  std::array<std::uint8_t, 16> prefix{};
  std::copy(bytes.begin(), bytes.begin() + size, prefix.begin());
  return prefix;
}

bool PeerAddress::shares_prefix(const PeerAddress& other) const { return prefix() == other.prefix(); }

ConnectionTable::ConnectionTable(AuditLog& log, Deadlines deadlines, bool tls, std::size_t upload_bytes)
    : log_(log), deadlines_(deadlines), slow_head_s_(tls ? slow_head_tls_s : slow_head_s) {
  for (Upload& upload : uploads_) upload.bytes.resize(upload_bytes);
}

template <class Within>
std::size_t ConnectionTable::count(const Within& within) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(connections_, [&within](const Connection& c) { return holds_place(c) && within(c); }));
}

bool ConnectionTable::is_slow(const Connection& c, std::int64_t now_ns) const {
  const std::int64_t lasts_ns = now_ns - c.since_ns;
  if (!c.asks) return lasts_ns >= ns_of(slow_answer_s);
  if (c.upload == nullptr) return lasts_ns >= ns_of(slow_head_s_);
  // Behind the pace at which its body comes to an end in time.
  const double due = static_cast<double>(c.upload->expected) * static_cast<double>(lasts_ns) * 1e-9;
  return lasts_ns >= ns_of(slow_body_s) && static_cast<double>(c.upload->got) * deadlines_.body_s < due;
}

/// Those that still ask go before those that are answered; then who has the most sockets, then the oldest.
template <class Within>
bool ConnectionTable::drop_slowest(std::int64_t now_ns, const Within& within) {
  Connection* slowest = nullptr;
  std::size_t most = 0;
  for (Connection& c : connections_) {
    if (!holds_place(c) || !within(c) || !is_slow(c, now_ns)) continue;
    const std::size_t held = count([&c](const Connection& other) { return other.peer.is_same(c.peer); });
    const bool slower = slowest == nullptr || c.asks > slowest->asks ||
                        (c.asks == slowest->asks && (held > most || (held == most && c.since_ns < slowest->since_ns)));
    if (!slower) continue;
    slowest = &c;
    most = held;
  }
  if (slowest == nullptr) return false;
  log_.refusal("connection from " + slowest->peer.text + " dropped: it is slow, and another one needs its place");
  drop(*slowest);
  end_upload(*slowest);
  return true;
}

ConnectionTable::Admission ConnectionTable::admit(const PeerAddress& peer, std::int64_t now_ns) {
  const auto same = [&peer](const Connection& c) { return c.peer.is_same(peer); };
  const auto near = [&peer](const Connection& c) { return c.peer.shares_prefix(peer); };
  const auto any = [](const Connection&) { return true; };
  if (count(same) >= max_sockets_an_address) return Admission::refuse;
  if (std::ranges::none_of(connections_, is_free)) return Admission::wait;
  if (count(near) >= max_sockets_a_prefix) return drop_slowest(now_ns, near) ? Admission::take : Admission::wait;
  if (count(any) >= max_sockets) return drop_slowest(now_ns, any) ? Admission::take : Admission::wait;
  return Admission::take;
}

Connection* ConnectionTable::begin(int socket, const PeerAddress& peer, std::int64_t now_ns) {
  const auto free = std::ranges::find_if(connections_, is_free);
  if (free == connections_.end()) return nullptr;
  *free = {.socket = socket,
           .since_ns = now_ns,
           .until_ns = now_ns + ns_of(deadlines_.head_s),
           .asks = true,
           .peer = peer,
           .upload = nullptr,
           .route = Route::none,
           .who = {},
           .waits = false};
  return &*free;
}

Upload* ConnectionTable::begin_upload(Connection& connection, std::size_t bytes, std::int64_t now_ns) {
  const auto uploads = [](const Connection& c) { return c.upload != nullptr; };
  const auto near = [&](const Connection& c) { return uploads(c) && c.peer.shares_prefix(connection.peer); };
  if (count([&](const Connection& c) { return uploads(c) && c.peer.is_same(connection.peer); }) > 0) return nullptr;
  if (count(near) >= max_uploads_a_prefix && !drop_slowest(now_ns, near)) return nullptr;
  if (std::ranges::find(uploads_, false, &Upload::used) == uploads_.end()) drop_slowest(now_ns, uploads);
  const auto free = std::ranges::find(uploads_, false, &Upload::used);
  if (free == uploads_.end()) return nullptr;
  free->used = true;
  free->expected = bytes;
  free->got = 0;
  connection.upload = &*free;
  connection.since_ns = now_ns;
  connection.until_ns = now_ns + ns_of(deadlines_.body_s);
  return connection.upload;
}

void ConnectionTable::begin_answer(Connection& connection, std::int64_t now_ns) const {
  connection.asks = false;
  connection.since_ns = now_ns;
  connection.until_ns = now_ns + ns_of(deadlines_.answer_s);
}

void ConnectionTable::end_upload(Connection& connection) {
  if (connection.upload != nullptr) connection.upload->used = false;
  connection.upload = nullptr;
}

void ConnectionTable::end(Connection& connection) {
  end_upload(connection);
  connection.socket = -1;
}

void ConnectionTable::drop(Connection& connection) {
  // libmicrohttpd sees the end of the stream, and closes.
  ::shutdown(connection.socket, SHUT_RDWR);
  connection.until_ns = std::numeric_limits<std::int64_t>::max();
  connection.dropped = true;
}

void ConnectionTable::cut_overdue(std::int64_t now_ns) {
  for (Connection& c : connections_) {
    if (!holds_place(c)) continue;
    if (c.asks && has_hung_up(c.socket)) {
      c.asks = false;
      c.until_ns = std::min(c.until_ns, now_ns + ns_of(0.2));  // what it said before may still be read
    }
    if (now_ns >= c.until_ns) drop(c);
  }
}

bool ConnectionTable::is_empty() const { return std::ranges::all_of(connections_, is_free); }

}  // namespace airside::page
