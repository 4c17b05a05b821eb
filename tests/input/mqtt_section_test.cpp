#include "hal/site/mqtt_section.hpp"

#include <cctype>

#include "hal/site/site_file.hpp"
#include "support/complaint.hpp"

namespace airside::hal {
namespace {

SiteFile site_with(const std::string& mqtt, const std::string& name = "AHU 3") {
  return parse_site_text("[site]\nname = \"" + name + "\"\ntopology = \"3vav-0fcu-1power\"\n[mqtt]\n" + mqtt,
                         "room/site.toml", {.topologies = {"3vav-0fcu-1power"}, .settings = {}});
}

void refuse(const std::string& mqtt, const Complaint& want) {
  expect_complaint(want, [&] { (void)site_with(mqtt); });
}

TEST(MqttSection, NothingIsPublishedWithoutTheTable) {
  const SiteFile site = parse_site_text("[site]\nname = \"a\"\ntopology = \"3vav-0fcu-1power\"\n", "site.toml",
                                        {.topologies = {"3vav-0fcu-1power"}, .settings = {}});
  EXPECT_FALSE(site.mqtt.has_value());
  EXPECT_FALSE(parse_site_text(example_site_text("3vav-0fcu-1power"), "site.toml",
                               {.topologies = {"3vav-0fcu-1power"}, .settings = {}})
                   .mqtt.has_value());
}

TEST(MqttSection, ABrokerIsEnough) {
  const MqttSection mqtt = *site_with("host = \"broker.example.org\"\n").mqtt;
  EXPECT_EQ(mqtt.host, "broker.example.org");
  EXPECT_EQ(mqtt.port, 1883);
  EXPECT_EQ(mqtt.topic_prefix, "airside/ahu_3");
  EXPECT_EQ(mqtt.client_id, "airside-ahu_3");
  EXPECT_EQ(mqtt.discovery_prefix, "homeassistant");
  EXPECT_EQ(mqtt.username + mqtt.password_file + mqtt.tls_ca, "");
}

TEST(MqttSection, PathsAreThoseOfTheSiteFileAndTlsHasAPortOfItsOwn) {
  const MqttSection mqtt =
      *site_with("host = \"b\"\ntls_ca = \"ca.pem\"\nusername = \"u\"\npassword_file = \"/etc/airside/pw\"\n").mqtt;
  EXPECT_EQ(mqtt.tls_ca, "room/ca.pem");
  EXPECT_EQ(mqtt.password_file, "/etc/airside/pw");
  EXPECT_EQ(mqtt.port, 8883);
}

TEST(MqttSection, TheExampleWithItsCommentsRemovedIsAccepted) {
  std::string text = example_site_text("3vav-0fcu-1power");
  std::size_t at = text.find("# [mqtt]\n");
  ASSERT_NE(at, std::string::npos);
  for (; at != std::string::npos; at = text.find("\n# ", at))
    text.erase(text.compare(at, 2, "# ") == 0 ? at : at + 1, 2);
  const SiteFile site = parse_site_text(text, "site.toml", {.topologies = {"3vav-0fcu-1power"}, .settings = {}});
  ASSERT_TRUE(site.mqtt.has_value());
  EXPECT_EQ(site.mqtt->host, "192.168.1.10");
  EXPECT_EQ(site.mqtt->topic_prefix, "airside/room_301");
}

TEST(MqttSection, NamesAreKeptApart) {
  EXPECT_EQ(topic_name("Room 301"), "room_301");
  EXPECT_EQ(topic_name("airside/Room--301."), "airside_room_301");
  EXPECT_NE(topic_name("房間"), topic_name("走廊"));
  EXPECT_NE(topic_name("Room (1)"), topic_name("Room 1"));
  for (const char c : topic_name("房間 3 é")) EXPECT_TRUE(c == '_' || std::isdigit(c) || std::islower(c)) << c;
  EXPECT_FALSE(topic_name("").empty());
}

TEST(MqttSection, WhatIsWrongIsNamed) {
  refuse("", {"room/site.toml:4:1: mqtt.host", "nothing", "text", "192.168.1.10"});
  refuse("host = \"mqtt://broker\"\n", {"site.toml:5:1: mqtt.host", "mqtt://broker", "host name", "leave scheme"});
  refuse("host = \"\"\n", {"mqtt.host", "", "", ""});
  refuse("host = \"b\"\nport = 0\n", {"site.toml:6:1: mqtt.port", "0", "1 to 65535", "1883"});
  refuse("host = \"b\"\nport = \"1883\"\n", {"mqtt.port", "\"1883\"", "whole number", ""});
  refuse("host = \"b\"\npassword_file = \"pw\"\n",
         {"mqtt.username", "nothing beside", "whose password", "add username"});
  for (const char* topic : {"a/#", "a/+/b", "/a", "a/", "a//b", "$SYS/a"}) {
    refuse(std::string("host = \"b\"\ntopic_prefix = \"") + topic + "\"\n",
           {"site.toml:6:1: mqtt.topic_prefix", topic, "without + and #", "correct it"});
    refuse(std::string("host = \"b\"\ndiscovery_prefix = \"") + topic + "\"\n",
           {"mqtt.discovery_prefix", topic, "without + and #", "correct it"});
  }
  refuse("host = \"b\"\ntopic_prefix = \"" + std::string(129, 'a') + "\"\n",
         {"mqtt.topic_prefix", "129 bytes", "at most 128", "correct it"});
  refuse("host = \"b\"\nclient_id = \"a b\"\n", {"mqtt.client_id", "a b", "letters", "no other client"});
  refuse("host = \"b\"\npasword_file = \"pw\"\n",
         {"site.toml:6:1: mqtt.pasword_file", "pasword_file", "", "did you mean `password_file`?"});
  refuse("host = \"b\"\npassword = \"secret\"\n", {"mqtt.password", "password", "password_file", ""});
}

TEST(MqttSection, APasswordInPlainTextIsWarnedOf) {
  const std::string login = "username = \"u\"\npassword_file = \"pw\"\n";
  EXPECT_NE(warning_of(*site_with("host = \"10.0.0.2\"\n" + login).mqtt).find("10.0.0.2 can read the password"),
            std::string::npos);
  EXPECT_EQ(warning_of(*site_with("host = \"10.0.0.2\"\n").mqtt), "");
  EXPECT_EQ(warning_of(*site_with("host = \"10.0.0.2\"\ntls_ca = \"ca.pem\"\n" + login).mqtt), "");
  EXPECT_EQ(warning_of(*site_with("host = \"127.0.0.1\"\n" + login).mqtt), "");
}

}  // namespace
}  // namespace airside::hal
