#pragma once
// A real airside-page on a folder of its own, and peers with plain sockets, each from an address of its choice.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "airside/controller/instances.hpp"
#include "hal/weights/signature.hpp"
#include "support/child.hpp"

namespace airside::page {

namespace fs = std::filesystem;
using closed_loop::Child;
using closed_loop::now_s;
using closed_loop::sleep_s;
using Bytes = std::vector<std::byte>;

/// One TCP connection to a port of this machine.
class Peer {
 public:
  explicit Peer(int port, const std::string& from = "127.0.0.1") : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in own{}, other{};
    own.sin_family = other.sin_family = AF_INET;
    ::inet_pton(AF_INET, from.c_str(), &own.sin_addr);
    ::inet_pton(AF_INET, "127.0.0.1", &other.sin_addr);
    other.sin_port = htons(static_cast<std::uint16_t>(port));
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&own), sizeof own), 0);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&other), sizeof other), 0) << from;
  }
  ~Peer() { ::close(socket_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  /// False: the other side has closed.
  bool send(std::string_view text) const {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  bool send(const Bytes& bytes) const {
    return send(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  void end() const { ::shutdown(socket_, SHUT_WR); }
  /// Everything until the other side closes, or until `wait_s` have passed.
  std::string receive(double wait_s = 20) {
    const double until = now_s() + wait_s;
    std::string text;
    char some[4096];
    while (now_s() < until) {
      pollfd ready{socket_, POLLIN, 0};
      if (::poll(&ready, 1, wait_s < 0.1 ? 0 : 50) <= 0) continue;
      const ssize_t got = ::recv(socket_, some, sizeof some, 0);
      if (got <= 0) {
        closed_ = true;
        break;
      }
      text.append(some, static_cast<std::size_t>(got));
    }
    return text;
  }
  /// Whether the other side has closed by now. What it said before is dropped.
  bool closed() {
    if (!closed_) receive(0.001);
    return closed_;
  }

 private:
  int socket_;
  bool closed_ = false;
};

/// Status of an answer, 0 where there is none.
inline int status_of(const std::string& answer) {
  return answer.starts_with("HTTP/1.1 ") ? std::stoi(answer.substr(9)) : 0;
}
inline std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

/// The longest blob for a room of this shape; all weights of the network zero.
template <Topology T = FiveZone>
Bytes plain_blob(BlobHeader header = {}) {
  auto payload = std::make_unique<typename WeightBlob<T>::Payload>();
  payload->head_states = static_cast<std::uint32_t>(RoomHead<T>::states);
  payload->residual.values.fill(1.0f);
  payload->residual.is_trained = 1;
  Bytes bytes(WeightBlob<T>::max_bytes);
  EXPECT_EQ(WeightBlob<T>::encode(header, *payload, bytes), bytes.size());
  return bytes;
}

class PageRig : public ::testing::Test {
 protected:
  PageRig() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::temp_directory_path() / (std::string("airside_page_") + test->name() + "_" + std::to_string(getpid()));
    fs::remove_all(folder);
    for (const char* part : {"state", "inbox", "keys"}) fs::create_directories(folder / part);
    write("state/status.json", R"({"site":"Room 301","state":"learn"})");
    write("keys/ann.pub", hal::public_key_text(ann.open));
  }
  ~PageRig() override {
    page.reset();
    std::error_code ignored;
    if (!HasFailure()) fs::remove_all(folder, ignored);
  }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
  }
  void write_site(const std::string& page_keys = "", const std::string& name = "Room 301") const {
    write("site.toml", "[site]\nname = \"" + name + "\"\ntopology = \"5vav-5fcu-2power\"\n[page]\n" + page_keys + "\n");
  }
  /// Starts it on any free port; false if it ended instead.
  bool start(const std::string& page_keys = "") {
    write_site(page_keys);
    fs::remove(folder / "ready");
    page = std::make_unique<Child>(
        std::vector<std::string>{std::string(AIRSIDE_BIN_DIR) + "/airside-page", "--site", folder / "site.toml",
                                 "--port", "0", "--ready", folder / "ready"},
        folder / "said.txt");
    const double until = now_s() + 20;
    while (now_s() < until && page->running()) {
      const std::string where = read("ready");
      if (where.ends_with('\n')) {
        port = std::stoi(where.substr(where.rfind(':') + 1));
        token = body_of(ask(get("/token")));
        if (!token.empty()) token.pop_back();
        return true;
      }
      sleep_s(0.005);
    }
    return false;
  }
  std::string read(const std::string& name) const {
    std::ifstream in(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// One exchange on a connection of its own.
  std::string ask(const std::string& request, const std::string& from = "127.0.0.1") const {
    Peer peer(port, from);
    peer.send(request);
    return peer.receive();
  }
  std::string host() const { return "127.0.0.1:" + std::to_string(port); }
  std::string get(const std::string& path) const { return "GET " + path + " HTTP/1.1\r\nHost: " + host() + "\r\n\r\n"; }
  /// Head of an upload that nothing is wrong with; `more` are further lines.
  std::string post_head(std::size_t bytes, const std::string& more = "") const {
    return "POST /weights HTTP/1.1\r\nHost: " + host() + "\r\nX-Airside-Token: " + token +
           "\r\nContent-Length: " + std::to_string(bytes) + "\r\n" + more + "\r\n";
  }
  std::string post(const Bytes& blob, const std::string& more = "") const {
    return post_head(blob.size(), more) + std::string(reinterpret_cast<const char*>(blob.data()), blob.size());
  }
  Bytes signed_blob(std::uint64_t counter = 10, Bytes blob = plain_blob()) const {
    hal::sign_blob(blob, ann, counter);
    return blob;
  }
  bool inbox_is_empty() const { return fs::is_empty(folder / "inbox"); }
  std::size_t descriptors() const {
    const auto each = fs::directory_iterator("/proc/" + std::to_string(page->pid()) + "/fd");
    return static_cast<std::size_t>(std::distance(fs::begin(each), fs::end(each)));
  }
  /// Memory that the process has for itself, kB.
  long memory_kb() const {
    std::ifstream in("/proc/" + std::to_string(page->pid()) + "/status");
    for (std::string word; in >> word;) {
      if (word != "RssAnon:") continue;
      long kb = 0;
      in >> kb;
      return kb;
    }
    return 0;
  }

  hal::SecretKey ann = hal::make_key("ann");
  fs::path folder;
  std::unique_ptr<Child> page;
  int port = 0;
  std::string token;
};

}  // namespace airside::page
