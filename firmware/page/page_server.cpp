#include "firmware/page/page_server.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"

namespace airside::page {
namespace {

/// Paths are compared as they were sent; nothing is unescaped.
std::size_t leave_escaped(void*, MHD_Connection*, char* text) { return std::strlen(text); }

void need_private(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & 007) != 0) {
    throw hal::InputError(path, fmt::format("permissions {:o}", status.st_mode & 0777U),
                          "a key that only its owner and group may read", "chmod 640 it");
  }
}

}  // namespace

PageServer::PageServer(const hal::SiteFile& site, Deadlines deadlines)
    : inbox_dir_(site.inbox_dir),
      door_(site),
      rules_{.names = site.page.names,
             .token = random_hex(16),
             .max_upload_bytes = door_.max_bytes(),
             .tls = !site.page.tls_cert.empty()},
      answers_(site),
      table_(log_, deadlines, rules_.tls, std::max(door_.max_bytes(), max_order_bytes)),
      listener_(site.page.listen, site.page.port),
      // By port: browsers send cookies to every port of a host.
      sign_in_(site.page.dir, (rules_.tls ? "__Host-airside-" : "airside-") + std::to_string(listener_.port()),
               rules_.tls, log_) {
  start(site.page);
}

std::int64_t PageServer::after(double seconds) {
  return hal::monotonic_ns() + static_cast<std::int64_t>(seconds * 1e9);
}

PageServer::~PageServer() {
  if (login_ != nullptr) MHD_resume_connection(login_);
  if (daemon_ != nullptr) MHD_stop_daemon(daemon_);
}

void PageServer::start(const hal::PageSection& page) {
  std::string certificate, key;
  std::vector<MHD_OptionItem> tls;
  unsigned flags = MHD_USE_EPOLL | MHD_USE_ERROR_LOG | MHD_USE_NO_LISTEN_SOCKET | MHD_ALLOW_SUSPEND_RESUME;
  if (!page.tls_cert.empty()) {
    need_private(page.tls_key);
    certificate = hal::read_text_file(page.tls_cert, "a certificate in PEM");
    key = hal::read_text_file(page.tls_key, "its private key in PEM");
    flags |= MHD_USE_TLS;
    tls.push_back({MHD_OPTION_HTTPS_MEM_CERT, 0, certificate.data()});
    tls.push_back({MHD_OPTION_HTTPS_MEM_KEY, 0, key.data()});
    // Authenticated encryption with forward secrecy alone: no CBC suites, no static RSA.
    static char priorities[] =
        "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2:-CIPHER-ALL:+AES-256-GCM:+AES-128-GCM:+CHACHA20-POLY1305:-RSA";
    tls.push_back({MHD_OPTION_HTTPS_PRIORITIES, 0, priorities});
  }
  tls.push_back({MHD_OPTION_END, 0, nullptr});
  daemon_ = MHD_start_daemon(flags, 0, nullptr, nullptr, &PageServer::on_request, this, MHD_OPTION_EXTERNAL_LOGGER,
                             &PageServer::on_message, this, MHD_OPTION_CONNECTION_LIMIT,
                             static_cast<unsigned>(2 * ConnectionTable::max_sockets),
                             MHD_OPTION_CONNECTION_MEMORY_LIMIT, head_memory_bytes, MHD_OPTION_STRICT_FOR_CLIENT, 1,
                             MHD_OPTION_UNESCAPE_CALLBACK, &leave_escaped, nullptr, MHD_OPTION_NOTIFY_CONNECTION,
                             &PageServer::notice_connection, this, MHD_OPTION_NOTIFY_COMPLETED,
                             &PageServer::notice_completed, this, MHD_OPTION_ARRAY, tls.data(), MHD_OPTION_END);
  if (daemon_ == nullptr) {
    throw hal::InputError(page.tls_cert.empty() ? "[page]" : page.tls_cert, "what no server can be started with",
                          "a PEM certificate and the key that belongs to it", "the line above says more");
  }
}

void PageServer::on_message(void* self, const char* format, va_list arguments) {
  std::array<char, 256> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  static_cast<PageServer*>(self)->log_.refusal(text.data());
}

void PageServer::run(const volatile std::sig_atomic_t& stop, const sigset_t& while_waiting) {
  const MHD_DaemonInfo* info = MHD_get_daemon_info(daemon_, MHD_DAEMON_INFO_EPOLL_FD);
  while (stop == 0) {
    // While a newcomer waits for a place, those behind it stay in the kernel.
    std::array<pollfd, 3> ready{
        {{info->epoll_fd, POLLIN, 0}, {sign_in_.descriptor(), POLLIN, 0}, {listener_.descriptor(), POLLIN, 0}}};
    const int ms = wait_ms();
    const timespec wait{ms / 1000, (ms % 1000) * 1'000'000L};
    ::ppoll(ready.data(), newcomer_ ? 2 : 3, &wait, &while_waiting);
    table_.cut_overdue(hal::monotonic_ns());
    resume_login();
    take_newcomers();
    // What has been closed makes room for the next, whose request may be there already.
    for (int round = 0; round < 4; ++round) {
      freed_ = false;
      MHD_run(daemon_);
      if (!freed_) break;
      take_newcomers();
    }
    reads_log_ = answers_.tick(hal::monotonic_ns());
  }
}

int PageServer::wait_ms() const {
  // Deadlines are kept to a tenth of a second; an idle page wakes once a second.
  MHD_UNSIGNED_LONG_LONG ms = newcomer_ ? 20 : table_.is_empty() ? 1000 : 100, wish = 0;
  if (reads_log_) ms = 0;  // a little each time, between requests
  if (MHD_get_timeout(daemon_, &wish) == MHD_YES) ms = std::min(ms, wish);
  return static_cast<int>(ms);
}

void PageServer::take_newcomers() {
  constexpr double longest_wait_s = 0.5;  // a crowd of one prefix must not keep the others out
  // No more than fit at once: those that were taken shall be heard before the next are weighed against them.
  for (std::size_t taken = 0; taken < ConnectionTable::max_sockets;) {
    if (!newcomer_) newcomer_ = listener_.accept();
    if (!newcomer_) return;
    const std::int64_t now_ns = hal::monotonic_ns();
    ConnectionTable::Admission admission = table_.admit(newcomer_->peer, now_ns);
    if (admission == ConnectionTable::Admission::wait) {
      if (static_cast<double>(now_ns - newcomer_->since_ns) * 1e-9 < longest_wait_s) return;
      admission = ConnectionTable::Admission::refuse;
    }
    if (admission == ConnectionTable::Admission::take) {
      add(*newcomer_);
      ++taken;
    }
    newcomer_.reset();
  }
}

void PageServer::add(const Newcomer& newcomer) {
  adding_ = &newcomer.peer;
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  const int socket = ::fcntl(newcomer.socket.descriptor(), F_DUPFD_CLOEXEC, 0);  // the library closes its own
  if (socket >= 0 && ::getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0) {
    MHD_add_connection(daemon_, socket, reinterpret_cast<sockaddr*>(&address), size);
  } else if (socket >= 0) {
    ::close(socket);  // gone already
  }
  adding_ = nullptr;
}

void PageServer::notice_connection(void* self, MHD_Connection* c, void** place, MHD_ConnectionNotificationCode code) {
  auto& server = *static_cast<PageServer*>(self);
  if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
    if (*place != nullptr) ConnectionTable::end(*static_cast<Connection*>(*place));
    server.freed_ = true;
    return;
  }
  const int socket = MHD_get_connection_info(c, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
  Connection* connection =
      server.adding_ == nullptr ? nullptr : server.table_.begin(socket, *server.adding_, hal::monotonic_ns());
  if (connection == nullptr) ::shutdown(socket, SHUT_RDWR);
  *place = connection;
}

/// One exchange a connection: what libmicrohttpd answers by itself (400, 431) ends it too.
void PageServer::notice_completed(void* self, MHD_Connection* c, void**, MHD_RequestTerminationCode) {
  auto& server = *static_cast<PageServer*>(self);
  const MHD_ConnectionInfo* info = MHD_get_connection_info(c, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
  if (info == nullptr || info->socket_context == nullptr) return;
  auto& connection = *static_cast<Connection*>(info->socket_context);
  if (server.login_ == c) server.login_ = nullptr;
  if (connection.upload != nullptr) {
    const Upload& upload = *connection.upload;
    server.log_.refusal(fmt::format("upload from {} broke off after {} of {} bytes", connection.peer.text, upload.got,
                                    upload.expected));
    ConnectionTable::end_upload(connection);
  }
  connection.until_ns = std::min(connection.until_ns, after(1));
}

MHD_Result PageServer::on_request(void* self, MHD_Connection* c, const char* url, const char* method, const char*,
                                  const char* body, std::size_t* body_bytes, void** exchange) {
  auto& server = *static_cast<PageServer*>(self);
  const MHD_ConnectionInfo* info = MHD_get_connection_info(c, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
  if (info == nullptr || info->socket_context == nullptr) return MHD_NO;
  auto& connection = *static_cast<Connection*>(info->socket_context);
  if (*exchange == nullptr) {
    *exchange = &connection;
    return server.begin(c, connection, url, method);
  }
  if (connection.waits) return server.end_login(c, connection);
  if (*body_bytes == 0) return server.end_body(c, connection);
  if (connection.upload == nullptr) return MHD_NO;
  Upload& upload = *connection.upload;
  if (*body_bytes > upload.expected - upload.got) return MHD_NO;
  std::memcpy(upload.bytes.data() + upload.got, body, *body_bytes);
  upload.got += *body_bytes;
  *body_bytes = 0;
  return MHD_YES;
}

}  // namespace airside::page
