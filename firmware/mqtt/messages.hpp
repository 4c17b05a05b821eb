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

/// Home Assistant's discovery: a document for each room temperature, the setpoint, what it is to reach, mode, reason
/// and alarm. Empty without a discovery prefix. `site.mqtt` must be there.
std::vector<Message> discovery(const hal::SiteFile& site);

/// Empty messages for every topic that this site, or the same site with other counts of rooms, may have left: a broker
/// forgets a retained message when an empty one follows.
std::vector<Message> withdrawal(const hal::SiteFile& site);

}  // namespace airside::mqtt
