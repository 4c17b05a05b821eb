#pragma once
// Keeps a broker informed of the newest status: what it missed while it was away is never made up for.

#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/mqtt/broker.hpp"
#include "firmware/mqtt/status_watch.hpp"

namespace airside::mqtt {

/// Memory: the discovery documents and two statuses, however long the broker is away.
class Publisher {
 public:
  /// `site` must outlive it and have [mqtt].
  explicit Publisher(const hal::SiteFile& site);

  /// Publishes until `stop` is set; then "offline", and the connection ends in order.
  void run(const volatile std::sig_atomic_t& stop);
  /// Connects once, sends `messages`, and ends in order. Returns what went wrong, "" where nothing did.
  std::string send_once(const std::vector<Message>& messages, const volatile std::sig_atomic_t& stop);

 private:
  void look_after_connection(double now_s);
  void publish_what_changed(double now_s);
  void say_once(const std::string& line);
  /// Turns until the broker has taken everything, or is gone, or 3 s are over.
  void finish();

  const hal::MqttSection& mqtt_;
  const std::vector<Message> outdated_, discovery_;
  StatusWatch watch_;
  Broker broker_;
  std::string said_;             ///< last line, which is not repeated
  std::uint64_t random_;         ///< spreads the attempts of boxes that lost the same broker
  std::uint64_t published_ = 0;  ///< version of the status that the broker has
  int published_online_ = -1;    ///< availability that the broker has; -1: none from this connection
  bool introduced_ = false;      ///< whether this connection has seen the discovery documents
  bool was_up_ = false;
  double up_since_s_ = 0, next_attempt_s_ = 0, delay_s_ = 0;
};

}  // namespace airside::mqtt
