#pragma once
// One connection to an MQTT broker: made, lost, and made anew from nothing, so that no message of an old one is left in
// it.

#include <mosquitto.h>
#include <memory>
#include <string>

#include "firmware/mqtt/messages.hpp"
#include "hal/site/mqtt_section.hpp"

namespace airside::mqtt {

/// libmosquitto, driven by its owner's thread. All messages are retained, at least once (QoS 1).
class Broker {
 public:
  /// `mqtt` and `site_path`, for complaints, must outlive it. Last will: "offline" on the availability topic.
  Broker(const hal::MqttSection& mqtt, const std::string& site_path);
  ~Broker();
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;

  /// Begins a connection; reads password and certificates anew. Blocks for 10 s at most, or until a signal comes.
  /// Errors: none here; complaint() says what went wrong.
  void connect(double now_s);
  /// Sends and receives for at most `wait_ms`. A broker that does not answer within 15 s is left.
  void turn(int wait_ms, double now_s);
  /// Ends a connection in order, so that the broker keeps the last will to itself.
  void disconnect();

  /// Whether there is a connection that the broker has taken.
  bool is_up() const { return is_up_; }
  /// Whether one is there or being made.
  bool is_open() const { return client_ != nullptr; }
  /// Messages that the broker has not taken yet.
  int outstanding() const { return outstanding_; }
  void publish(const Message& message, double now_s);
  /// Why there is no connection, in the form of every complaint about input; "" where there is one.
  const std::string& complaint() const { return complaint_; }

 private:
  struct Free {
    void operator()(mosquitto* client) const { mosquitto_destroy(client); }
  };
  std::string place() const;
  void fail(const std::string& found, const std::string& expected, const std::string& remedy);
  /// `code` of libmosquitto, at the beginning of a connection or during it.
  void fail_with(int code, int system_error);
  void prepare();
  static void on_connect(mosquitto*, void* self, int code);
  static void on_publish(mosquitto*, void* self, int message);
  static void on_log(mosquitto*, void* self, int level, const char* text);

  const hal::MqttSection& mqtt_;
  const std::string& site_path_;
  std::unique_ptr<mosquitto, Free> client_;
  std::string complaint_, library_said_;
  int refused_ = 0;  ///< code of the broker's refusal
  int outstanding_ = 0;
  int awaited_ = 0;        ///< of them at the last turn
  double deadline_s_ = 0;  ///< for the next answer that is due
  bool is_up_ = false;
};

}  // namespace airside::mqtt
