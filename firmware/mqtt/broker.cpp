#include "firmware/mqtt/broker.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/time.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <string_view>

#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"

namespace airside::mqtt {

namespace {

constexpr int keepalive_s = 30, answer_s = 15, connect_s = 10;

/// First line of the password file.
/// Errors: hal::InputError.
std::string password_in(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & 07) != 0) {
    throw hal::InputError(path, fmt::format("permissions {:o}", status.st_mode & 0777U),
                          "a password that only its owner and group may read", "chmod 640 the file");
  }
  std::string text = hal::read_text_file(path, "the broker's password in one line");
  text.resize(std::min(text.find_first_of("\r\n"), text.size()));
  if (text.empty() || text.size() > 1024) {
    throw hal::InputError(path, fmt::format("a first line of {} bytes", text.size()), "a password of 1 to 1024 bytes",
                          "write it into the first line");
  }
  return text;
}

/// Ends a connect() that nobody answers: the library's own blocks for minutes.
class Alarm {
 public:
  Alarm() { set({{1, 0}, {connect_s, 0}}); }
  ~Alarm() { set({}); }
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

 private:
  static void set(const itimerval& when) { ::setitimer(ITIMER_REAL, &when, nullptr); }
};

}  // namespace

Broker::Broker(const hal::MqttSection& mqtt, const std::string& site_path) : mqtt_(mqtt), site_path_(site_path) {
  mosquitto_lib_init();
}

Broker::~Broker() {
  client_.reset();
  mosquitto_lib_cleanup();
}

std::string Broker::place() const {
  const bool six = mqtt_.host.find(':') != std::string::npos;
  return fmt::format("{}: [mqtt]: broker {}{}{} port {}", site_path_, six ? "[" : "", mqtt_.host, six ? "]" : "",
                     mqtt_.port);
}

void Broker::fail(const std::string& found, const std::string& expected, const std::string& remedy) {
  complaint_ = hal::InputError(place(), found, expected, remedy).what();
  client_.reset();
  is_up_ = false;
  outstanding_ = 0;
}

void Broker::fail_with(int code, int system_error) {
  const bool tls = !mqtt_.tls_ca.empty();
  if (refused_ == 4 || refused_ == 5) {
    return fail(refused_ == 4 ? "\"bad user name or password\"" : "\"not authorised\"",
                mqtt_.username.empty() ? "a broker that takes clients without a name"
                                       : fmt::format("a broker that knows \"{}\" by this password", mqtt_.username),
                mqtt_.username.empty() ? "add username and password_file"
                                       : "correct username or password_file, or the broker's own list");
  }
  if (refused_ != 0) {
    return fail(fmt::format("\"{}\"", mosquitto_connack_string(refused_)), "a broker of MQTT 3.1.1 that takes us",
                "look into the broker's log; is client_id its own?");
  }
  if (code == MOSQ_ERR_TLS || code == MOSQ_ERR_TLS_HANDSHAKE) {
    return fail("no TLS" + (library_said_.empty() ? "" : " (" + library_said_ + ")"),
                "a certificate for this very host name, signed by tls_ca = " + mqtt_.tls_ca,
                "give the authority's PEM file, and the name that the certificate has");
  }
  if (code == MOSQ_ERR_EAI || code == MOSQ_ERR_LOOKUP) {
    return fail("no address of that name", "a name that this machine can resolve", "correct host, or give an address");
  }
  if (code == MOSQ_ERR_ERRNO) {
    const char* why = system_error == EINTR ? "no answer" : std::strerror(system_error);
    return fail(why, "an MQTT broker that listens there", "see that it runs; correct host and port");
  }
  if (is_up_) {
    return fail("a connection that was lost", "one that lasts",
                "see that the broker runs, and that no other client has the client_id " + mqtt_.client_id);
  }
  fail("a connection that ended before an answer",
       fmt::format("an MQTT broker {} TLS that listens there", tls ? "with" : "without"),
       tls ? "correct host and port, or take tls_ca out" : "correct host and port, or give tls_ca");
}

void Broker::prepare() {
  client_.reset(mosquitto_new(mqtt_.client_id.c_str(), true, this));
  if (!client_) throw std::bad_alloc();
  mosquitto_connect_callback_set(client_.get(), on_connect);
  mosquitto_publish_callback_set(client_.get(), on_publish);
  mosquitto_log_callback_set(client_.get(), on_log);
  if (!mqtt_.username.empty()) {
    const std::string password = mqtt_.password_file.empty() ? "" : password_in(mqtt_.password_file);
    mosquitto_username_pw_set(client_.get(), mqtt_.username.c_str(),
                              mqtt_.password_file.empty() ? nullptr : password.c_str());
  }
  const std::string will = availability_topic(mqtt_), offline = "offline";
  mosquitto_will_set(client_.get(), will.c_str(), static_cast<int>(offline.size()), offline.data(), 1, true);
  if (mqtt_.tls_ca.empty()) return;
  if (hal::read_text_file(mqtt_.tls_ca, "certificates in PEM").find("-----BEGIN") == std::string::npos) {
    throw hal::InputError(mqtt_.tls_ca, "no certificate", "certificates in PEM",
                          "give the file of the authority that signed the broker's certificate");
  }
  mosquitto_tls_set(client_.get(), mqtt_.tls_ca.c_str(), nullptr, nullptr, nullptr, nullptr);
}

void Broker::connect(double now_s) {
  refused_ = outstanding_ = 0;
  is_up_ = false;
  library_said_.clear();
  try {
    prepare();
  } catch (const hal::InputError& e) {
    complaint_ = e.what();
    client_.reset();
    return;
  }
  deadline_s_ = now_s + connect_s + answer_s;
  const Alarm alarm;
  const int code = mosquitto_connect(client_.get(), mqtt_.host.c_str(), mqtt_.port, keepalive_s);
  const int system_error = errno;
  if (code != MOSQ_ERR_SUCCESS) fail_with(code, system_error);
}

void Broker::turn(int wait_ms, double now_s) {
  const int code = mosquitto_loop(client_.get(), wait_ms, 1);
  const int system_error = errno;
  if (code != MOSQ_ERR_SUCCESS || refused_ != 0) return fail_with(code, system_error);
  const bool waits = !is_up_ || outstanding_ > 0;
  if (!waits || outstanding_ < awaited_) deadline_s_ = now_s + answer_s;
  awaited_ = outstanding_;
  if (waits && now_s > deadline_s_) {
    fail("no answer", "an MQTT broker that answers within 15 s", "see that it runs, and is not overloaded");
  }
}

void Broker::disconnect() {
  if (client_) mosquitto_disconnect(client_.get());
  client_.reset();
  is_up_ = false;
}

void Broker::publish(const Message& message, double now_s) {
  if (outstanding_ == 0) deadline_s_ = now_s + answer_s;
  const int code = mosquitto_publish(client_.get(), nullptr, message.topic.c_str(),
                                     static_cast<int>(message.payload.size()), message.payload.data(), 1, true);
  if (code == MOSQ_ERR_SUCCESS) ++outstanding_;  // another code: the next turn finds the connection lost
}

void Broker::on_connect(mosquitto*, void* self, int code) {
  auto& broker = *static_cast<Broker*>(self);
  broker.refused_ = code;
  broker.is_up_ = code == 0;
  if (code == 0) broker.complaint_.clear();
}

void Broker::on_publish(mosquitto*, void* self, int) { --static_cast<Broker*>(self)->outstanding_; }

void Broker::on_log(mosquitto*, void* self, int level, const char* text) {
  if ((level & (MOSQ_LOG_ERR | MOSQ_LOG_WARNING)) == 0) return;
  // "OpenSSL Error[0]: error:0A000086:SSL routines::certificate verify failed": people want its end.
  const std::string_view line(text);
  const std::size_t end = line.rfind(':');
  static_cast<Broker*>(self)->library_said_ = line.substr(end == line.npos || end + 1 >= line.size() ? 0 : end + 1);
}

}  // namespace airside::mqtt
