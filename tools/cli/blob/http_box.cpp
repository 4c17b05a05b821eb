#include "tools/cli/blob/http_box.hpp"

#include <curl/curl.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>

#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"

namespace airside::tools {

namespace {

constexpr long connect_limit_s = 10, whole_limit_s = 60;

struct Body {
  std::vector<std::byte> bytes;
  std::size_t max_bytes = 0;
};

std::size_t receive(char* some, std::size_t size, std::size_t count, void* into) {
  auto& body = *static_cast<Body*>(into);
  const auto bytes = std::as_bytes(std::span(some, size * count));
  if (body.bytes.size() + bytes.size() > body.max_bytes) return 0;  // ends the exchange
  body.bytes.insert(body.bytes.end(), bytes.begin(), bytes.end());
  return bytes.size();
}

/// What the box says of a refusal, safe for a terminal.
std::string reason_of(std::span<const std::byte> body) {
  const auto* text = reinterpret_cast<const char*>(body.data());
  const auto answer = nlohmann::json::parse(text, text + body.size(), nullptr, false);
  std::string reason;
  if (answer.is_object() && answer.contains("reason") && answer["reason"].is_string()) reason = answer["reason"];
  for (char& c : reason) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return reason.substr(0, 200);
}

std::string remedy_for(long status) {
  switch (status) {
    case 401: return "give a file with a key by --access; airside-page --new-key on the box prints one";
    case 403: return "sign it with a key whose .pub lies in the box's keys folder, and which is not revoked";
    case 404: return "let airsided run for a day with weights; is this an airside-page at all?";
    case 409: return "wait until the daemon has taken the other blob (6 min), or sign this one later than that";
    case 413: return "give a weight blob for this room's topology";
    case 421: return "call the box by its address, or by a name in [page] names of its site file";
    case 422: return "`airside check` with the box's site file says whether a blob is for it";
    case 429:
    case 503: return "try again in a minute; `airside status` on the box says more";
    case 507: return "make room on the box's disk";
    default: return "give the address of an airside-page, such as http://127.0.0.1:8350";
  }
}

struct EndTransfer {
  void operator()(CURL* c) const { curl_easy_cleanup(c); }
};
struct FreeLines {
  void operator()(curl_slist* lines) const { curl_slist_free_all(lines); }
};

[[noreturn]] void complain(CURLcode code, const std::string& address, const char* detail, std::size_t max_bytes) {
  const std::string said = *detail != '\0' ? detail : curl_easy_strerror(code);
  switch (code) {
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
      throw hal::InputError(address, "a certificate that cannot be trusted (" + said + ")",
                            "one that this machine or --ca vouches for, with this host's name in it",
                            "give the box's own certificate by --ca FILE, after comparing it on the box");
    case CURLE_WRITE_ERROR:
      throw hal::InputError(address, "an answer that does not end", fmt::format("at most {} bytes", max_bytes),
                            "is this an airside-page?");
    default:
      throw hal::InputError(address, "no answer (" + said + ")", "an airside-page that listens there",
                            "start airside-page on the box; [page] of its site file says where it listens");
  }
}

}  // namespace

bool is_web_address(const std::string& target) {
  return target.starts_with("http://") || target.starts_with("https://");
}

HttpBox::HttpBox(std::string address, const BoxAccess& access) : address_(std::move(address)), ca_file_(access.ca) {
  while (address_.ends_with('/')) address_.pop_back();
  static const std::regex shape(R"(https?://([A-Za-z0-9.-]+|\[[0-9a-fA-F:.]+\])(:[0-9]{1,5})?)");
  if (!std::regex_match(address_, shape)) {
    throw hal::InputError("\"" + address_.substr(0, 100) + "\"", "no address of a box",
                          "http://HOST:PORT or https://HOST:PORT, and nothing behind",
                          "leave path and user out, such as https://192.168.1.30:8350");
  }
  if (!ca_file_.empty() && !std::filesystem::is_regular_file(ca_file_)) {
    throw hal::InputError("--ca " + ca_file_, "no such file", "certificates in PEM",
                          "copy the box's certificate ([page] tls_cert) here");
  }
  if (access.key_file.empty()) return;
  key_ = hal::read_text_file(access.key_file, "a key that airside-page --new-key printed");
  while (key_.ends_with('\n') || key_.ends_with('\r')) key_.pop_back();
  static const std::regex key_shape("[0-9a-f]{64}");
  if (!std::regex_match(key_, key_shape)) {
    throw hal::InputError("--access " + access.key_file, "no key of a box's page", "64 hex digits",
                          "make one on the box: airside-page --site /etc/airside/site.toml --new-key installer");
  }
}

HttpBox::Answer HttpBox::exchange(const std::string& path, std::size_t max_bytes,
                                  const std::span<const std::byte>* body, const std::string& token) const {
  static const CURLcode ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  const std::unique_ptr<CURL, EndTransfer> c(ready == CURLE_OK ? curl_easy_init() : nullptr);
  if (!c) throw std::runtime_error("libcurl cannot be initialised");
  Body received{{}, max_bytes};
  char detail[CURL_ERROR_SIZE] = "";
  const std::string url = address_ + path;
  curl_easy_setopt(c.get(), CURLOPT_URL, url.c_str());
  curl_easy_setopt(c.get(), CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(c.get(), CURLOPT_PROXY, "");
  curl_easy_setopt(c.get(), CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(c.get(), CURLOPT_CONNECTTIMEOUT, connect_limit_s);
  curl_easy_setopt(c.get(), CURLOPT_TIMEOUT, whole_limit_s);
  curl_easy_setopt(c.get(), CURLOPT_ERRORBUFFER, &detail[0]);
  curl_easy_setopt(c.get(), CURLOPT_WRITEFUNCTION, &receive);
  curl_easy_setopt(c.get(), CURLOPT_WRITEDATA, &received);
  if (!ca_file_.empty()) {
    curl_easy_setopt(c.get(), CURLOPT_CAINFO, ca_file_.c_str());
    curl_easy_setopt(c.get(), CURLOPT_CAPATH, nullptr);
  }
  std::vector<std::string> texts;
  if (!key_.empty()) texts.push_back("Authorization: Bearer " + key_);
  if (body != nullptr) {
    // The box refuses by the head alone before the body is sent.
    texts.insert(texts.end(),
                 {"X-Airside-Token: " + token, "Expect: 100-continue", "Content-Type: application/octet-stream"});
  }
  std::unique_ptr<curl_slist, FreeLines> lines;
  for (const std::string& line : texts) {
    curl_slist* all = curl_slist_append(lines.get(), line.c_str());
    if (all == nullptr) throw std::bad_alloc();
    if (!lines) lines.reset(all);  // further ones hang on the first
  }
  if (lines) curl_easy_setopt(c.get(), CURLOPT_HTTPHEADER, lines.get());
  if (body != nullptr) {
    curl_easy_setopt(c.get(), CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body->size()));
    curl_easy_setopt(c.get(), CURLOPT_POSTFIELDS, reinterpret_cast<const char*>(body->data()));
  }
  const CURLcode code = curl_easy_perform(c.get());
  if (code != CURLE_OK) complain(code, address_, &detail[0], max_bytes);
  Answer answer{0, std::move(received.bytes)};
  curl_easy_getinfo(c.get(), CURLINFO_RESPONSE_CODE, &answer.status);
  return answer;
}

void HttpBox::refuse(const std::string& path, const Answer& answer) const {
  const std::string reason = reason_of(answer.body);
  throw hal::InputError(address_ + path, fmt::format("{}{}{}", answer.status, reason.empty() ? "" : ": ", reason),
                        "a box that gives or takes weights", remedy_for(answer.status));
}

std::vector<std::byte> HttpBox::get(const std::string& path, std::size_t max_bytes) const {
  Answer answer = exchange(path, max_bytes, nullptr, "");
  if (answer.status != 200) refuse(path, answer);
  return std::move(answer.body);
}

std::string HttpBox::send_blob(std::span<const std::byte> blob) const {
  constexpr std::size_t longest_answer = 65536;
  const std::vector<std::byte> token_answer = get("/token", longest_answer);
  const std::string token(reinterpret_cast<const char*>(token_answer.data()), token_answer.size());
  static const std::regex shape("([0-9a-f]{32})\n?");
  std::smatch match;
  if (!std::regex_match(token, match, shape)) {
    throw hal::InputError(address_ + "/token", fmt::format("{} bytes that are no token", token_answer.size()),
                          "32 hex digits", "give the address of an airside-page");
  }
  const Answer answer = exchange("/weights", longest_answer, &blob, match[1]);
  if (answer.status != 202) refuse("/weights", answer);
  return reason_of(answer.body);
}

}  // namespace airside::tools
