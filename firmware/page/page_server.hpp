#pragma once
// The HTTP side of airside-page: libmicrohttpd driven by one thread, with limits of its own on who may hold a socket
// for how long.

#include <microhttpd.h>
#include <sys/socket.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/page/audit_log.hpp"
#include "firmware/page/request_check.hpp"
#include "firmware/page/upload_door.hpp"
#include "hal/site/site_file.hpp"
#include "hal/storage/storage_file.hpp"

namespace airside::page {

/// How long a connection may stay in each of its parts, s in all: a byte now and then buys no more.
struct Deadlines {
  double head_s = 5;     ///< from the connection, TLS included, to the end of the header lines
  double body_s = 10;    ///< of an upload
  double answer_s = 10;  ///< until the peer has taken it
};

class PageServer {
 public:
  static constexpr unsigned max_sockets = 16, max_sockets_a_peer = 4;
  static constexpr int max_waiting = 64;                   ///< in the kernel, until a socket is free
  static constexpr std::size_t max_uploads = 4;            ///< at once, one a peer
  static constexpr std::size_t head_memory_bytes = 16384;  ///< a connection's, for header lines
  static constexpr double pause_after_refusal_s = 2;       ///< before the next upload of a peer whose blob was refused

  /// Binds and listens. Errors: InputError for an address or port that cannot be had, certificates that cannot be used.
  PageServer(const hal::SiteFile& site, Deadlines deadlines = {});
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// Serves until `stop`, a signal handler's variable, is not zero; the signal is let through only while it waits.
  void run(const volatile std::sig_atomic_t& stop, const sigset_t& while_waiting);

  int port() const { return port_; }

 private:
  using Peer = std::array<std::uint8_t, 16>;
  /// A body that is being received. The memory is kept.
  struct Upload {
    bool used = false;
    std::vector<std::byte> bytes;
    std::size_t expected = 0, got = 0;
  };
  /// A socket, from accept to close.
  struct Connection {
    int socket = -1;  ///< -1: free
    std::int64_t until_ns = 0;
    bool asks = false;  ///< its request is not whole yet
    Peer peer{};
    std::string peer_text;
    Upload* upload = nullptr;
  };
  struct Refusal {
    Peer peer{};
    std::int64_t until_ns = 0;
  };
  using Response = struct MHD_Response;

  void listen_on(const std::string& address, int port);
  void start(const hal::PageSection& page);

  // libmicrohttpd calls these; `self` is the server.
  static void notice_connection(void* self, MHD_Connection* c, void** place, MHD_ConnectionNotificationCode code);
  static void notice_completed(void* self, MHD_Connection* c, void** exchange, MHD_RequestTerminationCode code);
  static MHD_Result on_request(void* self, MHD_Connection* c, const char* url, const char* method, const char* version,
                               const char* body, std::size_t* body_bytes, void** exchange);
  static void on_message(void* self, const char* format, va_list arguments);

  MHD_Result begin(MHD_Connection* c, Connection& connection, const char* url, const char* method);
  MHD_Result begin_upload(MHD_Connection* c, Connection& connection, std::size_t bytes);
  MHD_Result end_upload(MHD_Connection* c, Connection& connection);
  MHD_Result answer(MHD_Connection* c, Connection& connection, int status, Response* response);
  MHD_Result refuse(MHD_Connection* c, Connection& connection, const Verdict& verdict);
  MHD_Result send_status(MHD_Connection* c, Connection& connection);
  MHD_Result send_weights(MHD_Connection* c, Connection& connection);

  hal::StorageFile open_in_state(const char* name, std::uint64_t max_bytes, std::uint64_t& bytes) const;
  void cut_overdue();
  int wait_ms() const;
  void release(Connection& connection);
  Refusal* refusal_of(const Peer& peer);

  std::string state_dir_;
  UploadDoor door_;
  RequestRules rules_;
  Deadlines deadlines_;
  AuditLog log_;
  int listen_socket_ = -1, port_ = 0;
  MHD_Daemon* daemon_ = nullptr;
  bool freed_ = false;  ///< a connection was closed in this round
  std::array<Connection, 2 * max_sockets> connections_;
  std::array<Upload, max_uploads> uploads_;
  std::array<Refusal, 2 * max_sockets> refusals_;
};

}  // namespace airside::page
