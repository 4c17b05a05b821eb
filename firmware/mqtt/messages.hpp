#pragma once
// What is published: topics and payloads, made of a site file alone. The state is the daemon's snapshot as it is.

#include <string>
#include <vector>

#include "hal/site/site_file.hpp"

namespace airside::mqtt {

/// One retained message.
struct Message {
  std::string topic, payload;
};

/// `PREFIX/status`: status.json as the daemon wrote it.
std::string status_topic(const hal::MqttSection& mqtt);
/// `PREFIX/availability`: online while the daemon's status is fresh and the broker hears of it, else offline.
std::string availability_topic(const hal::MqttSection& mqtt);

/// Home Assistant's discovery: a document for each room temperature, the setpoint, mode, reason and alarm, and what the
/// objective is judged by: target, held value, forecast and confidence; with `band` the warmest zone and the most open
/// damper. Empty without a discovery prefix. `site.mqtt` must be there.
std::vector<Message> discovery(const hal::SiteFile& site);

/// Empty messages for the documents that this site has only with the other objective: a broker forgets a retained
/// message when an empty one follows. Empty without a discovery prefix.
std::vector<Message> outdated(const hal::SiteFile& site);

/// Empty messages for every topic that this site, or the same site with other counts of rooms or the other objective,
/// may have left.
std::vector<Message> withdrawal(const hal::SiteFile& site);

}  // namespace airside::mqtt
