#include "firmware/page/page_server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "hal/weights/signature.hpp"

namespace airside::page {
namespace {

constexpr std::uint64_t max_status_bytes = 65536, max_weights_bytes = 4u << 20;

std::int64_t after(double seconds) { return hal::monotonic_ns() + static_cast<std::int64_t>(seconds * 1e9); }

/// An address in text, and as the IPv6 address that stands for it.
std::string text_of(const sockaddr* address, std::array<std::uint8_t, 16>& bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  bytes = {};
  if (address->sa_family == AF_INET) {
    const auto* four = reinterpret_cast<const sockaddr_in*>(address);
    bytes[10] = bytes[11] = 0xFF;
    std::memcpy(bytes.data() + 12, &four->sin_addr, 4);
    ::inet_ntop(AF_INET, &four->sin_addr, text.data(), text.size());
  } else if (address->sa_family == AF_INET6) {
    const auto* six = reinterpret_cast<const sockaddr_in6*>(address);
    std::memcpy(bytes.data(), &six->sin6_addr, bytes.size());
    ::inet_ntop(AF_INET6, &six->sin6_addr, text.data(), text.size());
  }
  return text.data();
}

std::string local_address_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<std::uint8_t, 16> ignored{};
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  return text_of(reinterpret_cast<const sockaddr*>(&address), ignored);
}

/// The peer will send no more, and all that it sent has been read. libmicrohttpd would wait on.
bool has_hung_up(int socket) {
  char byte = 0;
  return ::recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

/// Markup cannot be in a JSON text whose angle brackets are escaped; outside of its strings there are none.
std::string without_markup(std::string_view json) {
  std::string safe;
  for (const char c : json) {
    switch (c) {
      case '<': safe += "\\u003c"; break;
      case '>': safe += "\\u003e"; break;
      case '&': safe += "\\u0026"; break;
      default: safe += c;
    }
  }
  return safe;
}

MHD_Response* response_of(const std::string& text) {
  // The library takes a void* that it does not write to when it copies.
  return MHD_create_response_from_buffer(text.size(), const_cast<char*>(text.data()), MHD_RESPMEM_MUST_COPY);
}

MHD_Response* json_of(int status, std::string_view reason) {
  return response_of(without_markup(fmt::format("{{\"status\":{},\"reason\":\"{}\"}}\n", status, reason)));
}

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
      deadlines_(deadlines) {
  for (Upload& upload : uploads_) upload.bytes.resize(door_.max_bytes());
  listen_on(site.page.listen, site.page.port);
  try {
    start(site.page);
  } catch (...) {
    ::close(listen_socket_);
    throw;
  }
}

PageServer::~PageServer() {
  if (daemon_ != nullptr) MHD_stop_daemon(daemon_);  // closes the listening socket too
}

void PageServer::listen_on(const std::string& address, int port) {
  sockaddr_in four{};
  sockaddr_in6 six{};
  four.sin_family = AF_INET;
  six.sin6_family = AF_INET6;
  four.sin_port = six.sin6_port = htons(static_cast<std::uint16_t>(port));
  const bool is_four = ::inet_pton(AF_INET, address.c_str(), &four.sin_addr) == 1;
  if (!is_four) ::inet_pton(AF_INET6, address.c_str(), &six.sin6_addr);
  auto* at = is_four ? reinterpret_cast<sockaddr*>(&four) : reinterpret_cast<sockaddr*>(&six);
  socklen_t size = is_four ? sizeof four : sizeof six;
  listen_socket_ = ::socket(is_four ? AF_INET : AF_INET6, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  ::setsockopt(listen_socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (listen_socket_ < 0 || ::bind(listen_socket_, at, size) != 0 || ::listen(listen_socket_, max_waiting) != 0) {
    const int error = errno;
    if (listen_socket_ >= 0) ::close(listen_socket_);
    throw hal::InputError(fmt::format("[page] listen {} port {}", address, port), std::strerror(error),
                          "an address of this machine and a free port", "correct them in the site file");
  }
  ::getsockname(listen_socket_, at, &size);
  port_ = ntohs(is_four ? four.sin_port : six.sin6_port);
}

void PageServer::start(const hal::PageSection& page) {
  std::string certificate, key;
  std::vector<MHD_OptionItem> tls;
  unsigned flags = MHD_USE_EPOLL | MHD_USE_ERROR_LOG;
  if (!page.tls_cert.empty()) {
    need_private(page.tls_key);
    certificate = hal::read_text_file(page.tls_cert, "a certificate in PEM");
    key = hal::read_text_file(page.tls_key, "its private key in PEM");
    flags |= MHD_USE_TLS;
    tls.push_back({MHD_OPTION_HTTPS_MEM_CERT, 0, certificate.data()});
    tls.push_back({MHD_OPTION_HTTPS_MEM_KEY, 0, key.data()});
    static char priorities[] = "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2";
    tls.push_back({MHD_OPTION_HTTPS_PRIORITIES, 0, priorities});
  }
  tls.push_back({MHD_OPTION_END, 0, nullptr});
  daemon_ = MHD_start_daemon(
      flags, 0, nullptr, nullptr, &PageServer::on_request, this, MHD_OPTION_EXTERNAL_LOGGER, &PageServer::on_message,
      this, MHD_OPTION_LISTEN_SOCKET, listen_socket_, MHD_OPTION_CONNECTION_LIMIT, max_sockets,
      MHD_OPTION_PER_IP_CONNECTION_LIMIT, max_sockets_a_peer, MHD_OPTION_CONNECTION_MEMORY_LIMIT, head_memory_bytes,
      MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_UNESCAPE_CALLBACK, &leave_escaped, nullptr,
      MHD_OPTION_NOTIFY_CONNECTION, &PageServer::notice_connection, this, MHD_OPTION_NOTIFY_COMPLETED,
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
    pollfd ready{info->epoll_fd, POLLIN, 0};
    const int ms = wait_ms();
    const timespec wait{ms / 1000, (ms % 1000) * 1'000'000L};
    ::ppoll(&ready, 1, &wait, &while_waiting);
    cut_overdue();
    // A socket that has become free is offered to the next who waits only by another round.
    for (int round = 0; round < 4; ++round) {
      freed_ = false;
      MHD_run(daemon_);
      if (!freed_) break;
    }
  }
}

int PageServer::wait_ms() const {
  // Deadlines are kept to a tenth of a second; an idle page wakes once a second.
  const bool busy = std::ranges::any_of(connections_, [](const Connection& c) { return c.socket >= 0; });
  MHD_UNSIGNED_LONG_LONG ms = busy ? 100 : 1000, wish = 0;
  if (MHD_get_timeout(daemon_, &wish) == MHD_YES) ms = std::min(ms, wish);
  return static_cast<int>(ms);
}

void PageServer::cut_overdue() {
  const std::int64_t now = hal::monotonic_ns();
  for (Connection& connection : connections_) {
    if (connection.socket < 0) continue;
    if (connection.asks && has_hung_up(connection.socket)) {
      connection.asks = false;
      connection.until_ns = std::min(connection.until_ns, after(0.2));  // what it said before may still be read
    }
    if (now < connection.until_ns) continue;
    // libmicrohttpd sees the end of the stream, and closes.
    ::shutdown(connection.socket, SHUT_RDWR);
    connection.until_ns = std::numeric_limits<std::int64_t>::max();
  }
}

void PageServer::notice_connection(void* self, MHD_Connection* c, void** place, MHD_ConnectionNotificationCode code) {
  auto& server = *static_cast<PageServer*>(self);
  if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
    if (*place != nullptr) server.release(*static_cast<Connection*>(*place));
    return;
  }
  const int socket = MHD_get_connection_info(c, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
  const auto free = std::ranges::find(server.connections_, -1, &Connection::socket);
  if (free == server.connections_.end()) {
    ::shutdown(socket, SHUT_RDWR);
    return;
  }
  free->socket = socket;
  free->asks = true;
  free->until_ns = after(server.deadlines_.head_s);
  free->peer_text = text_of(MHD_get_connection_info(c, MHD_CONNECTION_INFO_CLIENT_ADDRESS)->client_addr, free->peer);
  *place = &*free;
}

void PageServer::release(Connection& connection) {
  if (connection.upload != nullptr) connection.upload->used = false;
  connection.upload = nullptr;
  connection.socket = -1;
  freed_ = true;
}

/// One exchange a connection: what libmicrohttpd answers by itself (400, 431) ends it too.
void PageServer::notice_completed(void* self, MHD_Connection* c, void**, MHD_RequestTerminationCode) {
  auto& server = *static_cast<PageServer*>(self);
  const MHD_ConnectionInfo* info = MHD_get_connection_info(c, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
  if (info == nullptr || info->socket_context == nullptr) return;
  auto& connection = *static_cast<Connection*>(info->socket_context);
  if (connection.upload != nullptr) {
    const Upload& upload = *connection.upload;
    server.log_.refusal(fmt::format("upload from {} broke off after {} of {} bytes", connection.peer_text, upload.got,
                                    upload.expected));
    connection.upload->used = false;
    connection.upload = nullptr;
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
      log_.refusal(fmt::format("upload from {} refused: {} {}", connection.peer_text, verdict.status, verdict.reason));
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
    log_.refusal(fmt::format("upload from {} put off: {} {}", connection.peer_text, status, reason));
    Response* response = json_of(status, reason);
    MHD_add_response_header(response, "Retry-After", "15");
    return answer(c, connection, status, response);
  };
  const Refusal* refusal = refusal_of(connection.peer);
  if (refusal != nullptr && hal::monotonic_ns() < refusal->until_ns) {
    return wait(429, "the last blob from there was refused just now");
  }
  const bool another = std::ranges::any_of(connections_, [&](const Connection& other) {
    return other.socket >= 0 && other.upload != nullptr && other.peer == connection.peer;
  });
  const auto free = std::ranges::find(uploads_, false, &Upload::used);
  if (another || free == uploads_.end()) return wait(503, "another upload is under way");
  free->used = true;
  free->expected = bytes;
  free->got = 0;
  connection.upload = &*free;
  connection.until_ns = after(deadlines_.body_s);
  return MHD_YES;
}

MHD_Result PageServer::end_upload(MHD_Connection* c, Connection& connection) {
  Upload& upload = *connection.upload;
  connection.upload = nullptr;
  upload.used = false;
  if (upload.got != upload.expected) return MHD_NO;
  const UploadDoor::Answer said = door_.take(std::span(upload.bytes).first(upload.got));
  const std::string who = said.log.empty() ? "nobody's signature" : said.log;
  if (said.status == 202) {
    log_.say(fmt::format("upload from {} accepted: {} bytes, {}", connection.peer_text, upload.got, who));
  } else {
    log_.refusal(fmt::format("upload from {} refused: {} {} ({} bytes, {})", connection.peer_text, said.status,
                             said.text, upload.got, who));
  }
  if (said.status == 403 || said.status == 422) {
    Refusal* place = refusal_of(connection.peer);
    if (place == nullptr) place = &*std::ranges::min_element(refusals_, {}, &Refusal::until_ns);
    *place = {connection.peer, after(pause_after_refusal_s)};
  }
  return answer(c, connection, said.status, json_of(said.status, said.text));
}

PageServer::Refusal* PageServer::refusal_of(const Peer& peer) {
  const auto at = std::ranges::find_if(refusals_, [&](const Refusal& r) { return r.until_ns != 0 && r.peer == peer; });
  return at == refusals_.end() ? nullptr : &*at;
}

MHD_Result PageServer::refuse(MHD_Connection* c, Connection& connection, const Verdict& verdict) {
  Response* response = json_of(verdict.status, verdict.reason);
  if (*verdict.allow != '\0') MHD_add_response_header(response, "Allow", verdict.allow);
  return answer(c, connection, verdict.status, response);
}

MHD_Result PageServer::answer(MHD_Connection* c, Connection& connection, int status, Response* response) {
  if (response == nullptr) return MHD_NO;
  const char* type = MHD_get_response_header(response, "Content-Type");
  if (type == nullptr) MHD_add_response_header(response, "Content-Type", "application/json; charset=utf-8");
  static constexpr const char* always[][2] = {
      {"Connection", "close"},
      {"Cache-Control", "no-store"},
      {"X-Content-Type-Options", "nosniff"},
      {"Content-Security-Policy", "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; sandbox"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"X-Frame-Options", "DENY"},
      {"Referrer-Policy", "no-referrer"},
  };
  for (const auto& [name, value] : always) MHD_add_response_header(response, name, value);
  connection.asks = false;
  connection.until_ns = after(deadlines_.answer_s);
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
