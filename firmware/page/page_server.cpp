#include "firmware/page/page_server.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "firmware/page/response.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "hal/weights/signature.hpp"

namespace airside::page {
namespace {

constexpr std::uint64_t max_status_bytes = 65536, max_weights_bytes = 4u << 20;

std::int64_t after(double seconds) { return hal::monotonic_ns() + static_cast<std::int64_t>(seconds * 1e9); }

MHD_Result add_header_line(void* lines, MHD_ValueKind, const char* name, std::size_t name_size, const char* value,
                           std::size_t value_size) {
  auto& list = *static_cast<std::vector<HeaderLine>*>(lines);
  list.push_back({{name, name_size}, value == nullptr ? std::string_view() : std::string_view(value, value_size)});
  return list.size() > max_header_lines ? MHD_NO : MHD_YES;
}

/// Paths are compared as they were sent; nothing is unescaped.
std::size_t leave_escaped(void*, MHD_Connection*, char* text) { return std::strlen(text); }

std::string new_token() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium finds no source of random numbers");
  std::array<std::uint8_t, 16> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  return hal::hex_of(bytes);
}

void need_private(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & 007) != 0) {
    throw hal::InputError(path, fmt::format("permissions {:o}", status.st_mode & 0777U),
                          "a key that only its owner and group may read", "chmod 640 it");
  }
}

}  // namespace

PageServer::PageServer(const hal::SiteFile& site, Deadlines deadlines)
    : state_dir_(site.state_dir),
      door_(site),
      rules_{.names = site.page.names,
             .token = new_token(),
             .max_upload_bytes = door_.max_bytes(),
             .tls = !site.page.tls_cert.empty()},
      table_(log_, deadlines, rules_.tls, door_.max_bytes()),
      listener_(site.page.listen, site.page.port) {
  start(site.page);
}

PageServer::~PageServer() {
  if (daemon_ != nullptr) MHD_stop_daemon(daemon_);
}

void PageServer::start(const hal::PageSection& page) {
  std::string certificate, key;
  std::vector<MHD_OptionItem> tls;
  unsigned flags = MHD_USE_EPOLL | MHD_USE_ERROR_LOG | MHD_USE_NO_LISTEN_SOCKET;
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
    std::array<pollfd, 2> ready{{{info->epoll_fd, POLLIN, 0}, {listener_.descriptor(), POLLIN, 0}}};
    const int ms = wait_ms();
    const timespec wait{ms / 1000, (ms % 1000) * 1'000'000L};
    ::ppoll(ready.data(), newcomer_ ? 1 : 2, &wait, &while_waiting);
    table_.cut_overdue(hal::monotonic_ns());
    take_newcomers();
    // What has been closed makes room for the next, whose request may be there already.
    for (int round = 0; round < 4; ++round) {
      freed_ = false;
      MHD_run(daemon_);
      if (!freed_) break;
      take_newcomers();
    }
  }
}

int PageServer::wait_ms() const {
  // Deadlines are kept to a tenth of a second; an idle page wakes once a second.
  MHD_UNSIGNED_LONG_LONG ms = newcomer_ ? 20 : table_.is_empty() ? 1000 : 100, wish = 0;
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
  if (connection.upload == nullptr) return MHD_NO;
  Upload& upload = *connection.upload;
  if (*body_bytes == 0) return server.end_upload(c, connection);
  if (*body_bytes > upload.expected - upload.got) return MHD_NO;
  std::memcpy(upload.bytes.data() + upload.got, body, *body_bytes);
  upload.got += *body_bytes;
  *body_bytes = 0;
  return MHD_YES;
}

MHD_Result PageServer::begin(MHD_Connection* c, Connection& connection, const char* url, const char* method) {
  std::vector<HeaderLine> headers;
  MHD_get_connection_values_n(c, MHD_HEADER_KIND, &add_header_line, &headers);
  const std::string local = local_address_of(connection.socket);
  const Verdict verdict =
      check_request({.method = method, .path = url, .headers = headers, .local_address = local}, rules_);
  if (verdict.status != 200) {
    if (std::strcmp(method, "POST") == 0) {
      log_.refusal(fmt::format("upload from {} refused: {} {}", connection.peer.text, verdict.status, verdict.reason));
    }
    return refuse(c, connection, verdict);
  }
  switch (verdict.route) {
    case Route::status: return send_status(c, connection);
    case Route::weights: return send_weights(c, connection);
    case Route::token: {
      Response* response = response_of(rules_.token + "\n");
      MHD_add_response_header(response, "Content-Type", "text/plain; charset=utf-8");
      return answer(c, connection, MHD_HTTP_OK, response);
    }
    case Route::upload: return begin_upload(c, connection, verdict.upload_bytes);
    case Route::none: break;
  }
  return MHD_NO;
}

MHD_Result PageServer::begin_upload(MHD_Connection* c, Connection& connection, std::size_t bytes) {
  const auto wait = [&](int status, const char* reason) {
    log_.refusal(fmt::format("upload from {} put off: {} {}", connection.peer.text, status, reason));
    Response* response = json_of(status, reason);
    MHD_add_response_header(response, "Retry-After", "15");
    return answer(c, connection, status, response);
  };
  const Refusal* refusal = refusal_of(connection.peer);
  if (refusal != nullptr && hal::monotonic_ns() < refusal->until_ns) {
    return wait(429, "the last blob from there was refused just now");
  }
  if (table_.begin_upload(connection, bytes, hal::monotonic_ns()) == nullptr) {
    return wait(503, "another upload is under way");
  }
  return MHD_YES;
}

MHD_Result PageServer::end_upload(MHD_Connection* c, Connection& connection) {
  const Upload& upload = *connection.upload;
  ConnectionTable::end_upload(connection);  // its bytes are kept until the next one begins
  if (upload.got != upload.expected) return MHD_NO;
  const UploadDoor::Answer said = door_.take(std::span(upload.bytes).first(upload.got));
  const std::string who = said.log.empty() ? "nobody's signature" : said.log;
  if (said.status == 202) {
    log_.say(fmt::format("upload from {} accepted: {} bytes, {}", connection.peer.text, upload.got, who));
  } else {
    log_.refusal(fmt::format("upload from {} refused: {} {} ({} bytes, {})", connection.peer.text, said.status,
                             said.text, upload.got, who));
  }
  if (said.status == 403 || said.status == 422) {
    Refusal* place = refusal_of(connection.peer);
    if (place == nullptr) place = &*std::ranges::min_element(refusals_, {}, &Refusal::until_ns);
    *place = {connection.peer, after(pause_after_refusal_s)};
  }
  return answer(c, connection, said.status, json_of(said.status, said.text));
}

PageServer::Refusal* PageServer::refusal_of(const PeerAddress& peer) {
  const auto at =
      std::ranges::find_if(refusals_, [&](const Refusal& r) { return r.until_ns != 0 && r.peer.is_same(peer); });
  return at == refusals_.end() ? nullptr : &*at;
}

MHD_Result PageServer::refuse(MHD_Connection* c, Connection& connection, const Verdict& verdict) {
  Response* response = json_of(verdict.status, verdict.reason);
  if (*verdict.allow != '\0') MHD_add_response_header(response, "Allow", verdict.allow);
  return answer(c, connection, verdict.status, response);
}

MHD_Result PageServer::answer(MHD_Connection* c, Connection& connection, int status, Response* response) {
  if (response == nullptr) return MHD_NO;
  add_common_lines(response);
  table_.begin_answer(connection, hal::monotonic_ns());
  const MHD_Result queued = MHD_queue_response(c, static_cast<unsigned>(status), response);
  MHD_destroy_response(response);
  return queued;
}

hal::StorageFile PageServer::open_in_state(const char* name, std::uint64_t max_bytes, std::uint64_t& bytes) const {
  const std::string path = state_dir_ + "/" + name;
  hal::StorageFile file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.descriptor(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  bytes = static_cast<std::uint64_t>(status.st_size);
  if (bytes > max_bytes) return {};
  return file;
}

MHD_Result PageServer::send_status(MHD_Connection* c, Connection& connection) {
  std::uint64_t size = 0;
  const hal::StorageFile file = open_in_state("status.json", max_status_bytes, size);
  std::string text(static_cast<std::size_t>(size), '\0');
  const auto got = file.is_open() ? file.read_at(std::as_writable_bytes(std::span(text)), 0, "read status")
                                  : hal::StoreResult<std::size_t>(std::size_t{0});
  if (!got || *got == 0 || *got != size) {
    return answer(c, connection, 503, json_of(503, "no status yet; is airsided running?"));
  }
  return answer(c, connection, MHD_HTTP_OK, response_of(without_markup(text)));
}

MHD_Result PageServer::send_weights(MHD_Connection* c, Connection& connection) {
  std::uint64_t size = 0;
  hal::StorageFile file = open_in_state("weights.blob", max_weights_bytes, size);
  if (!file.is_open() || size == 0) {
    return answer(c, connection, 404, json_of(404, "no weights yet; airsided gives them out once a day"));
  }
  Response* response = MHD_create_response_from_fd(static_cast<std::size_t>(size), ::dup(file.descriptor()));
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, "Content-Type", "application/octet-stream");
  MHD_add_response_header(response, "Content-Disposition", "attachment; filename=\"weights.blob\"");
  return answer(c, connection, MHD_HTTP_OK, response);
}

}  // namespace airside::page
