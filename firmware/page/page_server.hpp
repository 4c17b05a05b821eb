#pragma once
// The HTTP side of airside-page: libmicrohttpd driven by one thread, with limits of its own on who may hold a socket
// for how long.

#include <microhttpd.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "firmware/page/answers.hpp"
#include "firmware/page/http/audit_log.hpp"
#include "firmware/page/http/connection_table.hpp"
#include "firmware/page/http/listener.hpp"
#include "firmware/page/http/request_check.hpp"
#include "firmware/page/inbox/upload_door.hpp"
#include "firmware/page/sign_in.hpp"
#include "hal/site/site_file.hpp"

namespace airside::page {

class PageServer {
 public:
  static constexpr std::size_t head_memory_bytes = 16384;  ///< a connection's, for header lines
  static constexpr double pause_after_refusal_s = 2;       ///< before the next upload of a peer whose blob was refused

  /// Binds and listens. Errors: InputError for an address or port that cannot be had, certificates that cannot be used.
  PageServer(const hal::SiteFile& site, Deadlines deadlines = {});
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// Serves until `stop`, a signal handler's variable, is not zero; the signal is let through only while it waits.
  void run(const volatile std::sig_atomic_t& stop, const sigset_t& while_waiting);

  int port() const { return listener_.port(); }

 private:
  struct Refusal {
    PeerAddress peer{};
    std::int64_t until_ns = 0;
  };
  using Response = struct MHD_Response;

  void start(const hal::PageSection& page);

  // libmicrohttpd calls these; `self` is the server.
  static void notice_connection(void* self, MHD_Connection* c, void** place, MHD_ConnectionNotificationCode code);
  static void notice_completed(void* self, MHD_Connection* c, void** exchange, MHD_RequestTerminationCode code);
  static MHD_Result on_request(void* self, MHD_Connection* c, const char* url, const char* method, const char* version,
                               const char* body, std::size_t* body_bytes, void** exchange);
  static void on_message(void* self, const char* format, va_list arguments);

  MHD_Result begin(MHD_Connection* c, Connection& connection, const char* url, const char* method);
  MHD_Result begin_body(MHD_Connection* c, Connection& connection, std::size_t bytes);
  MHD_Result end_body(MHD_Connection* c, Connection& connection);
  MHD_Result end_upload(MHD_Connection* c, Connection& connection, std::span<const std::byte> blob);
  MHD_Result do_order(MHD_Connection* c, Connection& connection, std::string_view body);
  MHD_Result begin_login(MHD_Connection* c, Connection& connection, std::span<std::byte> body);
  MHD_Result end_login(MHD_Connection* c, Connection& connection);
  MHD_Result send_asset(MHD_Connection* c, Connection& connection, const StaticFile& file);
  MHD_Result send_text(MHD_Connection* c, Connection& connection, const std::string& text, const char* type);
  MHD_Result put_off(MHD_Connection* c, Connection& connection, int status, const Refused& why, int after_s);
  MHD_Result answer(MHD_Connection* c, Connection& connection, int status, Response* response);
  MHD_Result refuse(MHD_Connection* c, Connection& connection, const Verdict& verdict);

  /// On the monotonic clock, ns.
  static std::int64_t after(double seconds);
  int wait_ms() const;
  /// A verification that has come to its end lets its connection go on.
  void resume_login();
  /// Accepts whoever gets a place; the first who must wait for one is kept.
  void take_newcomers();
  void add(const Newcomer& newcomer);
  Refusal* refusal_of(const PeerAddress& peer);

  std::string inbox_dir_;
  UploadDoor door_;
  RequestRules rules_;
  AuditLog log_;
  Answers answers_;
  ConnectionTable table_;
  Listener listener_;
  SignIn sign_in_;
  MHD_Connection* login_ = nullptr;  ///< whose password is being verified
  std::optional<SignIn::Outcome> login_outcome_;
  bool reads_log_ = true;                ///< there is more of it to read
  std::optional<Newcomer> newcomer_;     ///< who waits for a place
  const PeerAddress* adding_ = nullptr;  ///< while libmicrohttpd takes a socket over
  MHD_Daemon* daemon_ = nullptr;
  bool freed_ = false;  ///< a connection was closed in this round
  std::array<Refusal, 2 * ConnectionTable::max_sockets> refusals_;
};

}  // namespace airside::page
