#include "firmware/mqtt/publisher.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>

namespace airside::mqtt {

namespace {

constexpr double first_delay_s = 1, longest_delay_s = 60;
constexpr double lasting_s = 60;  // a connection that lasted so long was a good one
constexpr int turn_ms = 250;

double clock_s() {
  std::timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

Publisher::Publisher(const hal::SiteFile& site)
    : mqtt_(*site.mqtt),
      outdated_(outdated(site)),
      discovery_(discovery(site)),
      watch_(site.state_dir + "/status.json"),
      broker_(mqtt_, site.path),
      random_(static_cast<std::uint64_t>(::getpid()) * 2862933555777941757U + 3037000493U) {}

void Publisher::say_once(const std::string& line) {
  if (line == said_) return;
  said_ = line;
  std::fprintf(stderr, "airside-mqtt: %s\n", line.c_str());
}

void Publisher::look_after_connection(double now_s) {
  const bool up = broker_.is_up();
  if (up && !was_up_) {
    up_since_s_ = now_s;
    introduced_ = false;
    published_ = 0;
    published_online_ = -1;
    say_once(fmt::format("connected to {} port {}; publishing below {}", mqtt_.host, mqtt_.port, mqtt_.topic_prefix));
  }
  if (was_up_ && !up && now_s - up_since_s_ > lasting_s) delay_s_ = 0;
  was_up_ = up;
  if (broker_.is_open()) return;
  if (next_attempt_s_ == 0) {  // lost just now, or never tried
    if (!broker_.complaint().empty()) say_once(broker_.complaint());
    random_ = random_ * 6364136223846793005U + 1442695040888963407U;
    const double spread = 0.75 + 0.5 * static_cast<double>(random_ >> 40) / static_cast<double>(1 << 24);
    next_attempt_s_ = now_s + delay_s_ * spread;
    delay_s_ = std::clamp(2 * delay_s_, first_delay_s, longest_delay_s);
  }
  if (now_s < next_attempt_s_) return;
  next_attempt_s_ = 0;
  broker_.connect(now_s);
}

void Publisher::publish_what_changed(double now_s) {
  // One round at a time: while it is under way, what comes replaces what has not been sent.
  if (!broker_.is_up() || broker_.outstanding() > 0) return;
  if (!introduced_) {
    for (const Message& message : outdated_) broker_.publish(message, now_s);
    for (const Message& message : discovery_) broker_.publish(message, now_s);
    introduced_ = true;
  }
  if (watch_.version() != published_) {
    broker_.publish({status_topic(mqtt_), watch_.text()}, now_s);
    published_ = watch_.version();
  }
  const int online = watch_.is_current(now_s) ? 1 : 0;
  if (online == published_online_) return;
  broker_.publish({availability_topic(mqtt_), online != 0 ? "online" : "offline"}, now_s);
  published_online_ = online;
  if (online == 0) {
    say_once(fmt::format("{}: {}; published as offline until airsided writes a new one", watch_.path(),
                         watch_.complaint().empty() ? "the daemon has stopped, or the status is older than 15 min"
                                                    : watch_.complaint()));
  } else {
    say_once("the status is fresh; published as online");
  }
}

void Publisher::run(const volatile std::sig_atomic_t& stop) {
  while (stop == 0) {
    watch_.poll(clock_s());
    look_after_connection(clock_s());
    publish_what_changed(clock_s());
    if (broker_.is_open()) {
      broker_.turn(turn_ms, clock_s());
    } else {
      ::poll(nullptr, 0, turn_ms);  // a signal ends it
    }
  }
  if (broker_.is_up()) broker_.publish({availability_topic(mqtt_), "offline"}, clock_s());
  finish();
  std::fprintf(stderr, "airside-mqtt: stopped\n");
}

void Publisher::finish() {
  const double until_s = clock_s() + 3;
  while (broker_.is_up() && broker_.outstanding() > 0 && clock_s() < until_s) broker_.turn(50, clock_s());
  if (broker_.is_up()) broker_.disconnect();
}

std::string Publisher::send_once(const std::vector<Message>& messages, const volatile std::sig_atomic_t& stop) {
  broker_.connect(clock_s());
  while (stop == 0 && broker_.is_open() && !broker_.is_up()) broker_.turn(50, clock_s());
  if (!broker_.is_up()) return broker_.complaint().empty() ? "stopped before the broker answered" : broker_.complaint();
  for (const Message& message : messages) broker_.publish(message, clock_s());
  while (stop == 0 && broker_.is_up() && broker_.outstanding() > 0) broker_.turn(50, clock_s());
  if (!broker_.is_up()) return broker_.complaint();
  if (broker_.outstanding() > 0) return "stopped before the broker had taken everything";
  broker_.disconnect();
  return "";
}

}  // namespace airside::mqtt
