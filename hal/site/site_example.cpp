#include <array>
#include <string_view>

#include "hal/site/site_file.hpp"
#include "hal/site/site_keys.hpp"

namespace airside::hal {

namespace {

constexpr const char* after_topology = R"(
[target]
room_temp_degc = 25.25   # at which the rooms are held, degC
hold = "mean"            # what of them: mean; weighted: mean by weights = [...], one a VAV box; middle: of warmest and coldest
work_start = "07:00"     # local time; standard time unless daylight_saving is set
work_end = "19:00"
weekday_only = false     # true: Saturday and Sunday are days off, with a daily profile of their own

[setpoint]               # supply-air temperature setpoint
min_degc = 20.0          # the controller chooses from min to max
max_degc = 26.0
step_k = 0.1
max_change_k = 4.5       # largest change from one control cycle to the next
round_k = 0.01           # resolution of what is written
outside = "step"         # a setpoint found outside min and max: "step" max_change_k a cycle towards them, or "jump" inside

[expert]                 # the schedule that the room had before, and falls back to
work_degc = 20.5         # in working hours
off_degc = 25.0          # outside

[controller]
preset = "product"       # product; paper: the printed method, but it acts before it learns, and mode arbiter and safety limits stay; paper-repaired: that without its offsets
objective = "mean"       # mean: hold the room temperature; band: boxes modulate, least energy with zones in their band
cycle_min = 18           # control cycle: 6, 12, 18 or 24 min; weights are of one length; band has 18 alone
seed = 1                 # of the random generator

[controller.override]    # a controller setting that has no key above, by name, such as
# move_penalty = 0.1

[modbus]                 # leave this table out for a room that is only simulated
transport = "tcp"        # tcp or rtu
host = "127.0.0.1"       # tcp
port = 502
device = "/dev/ttyUSB0"  # rtu
baud = 19200
parity = "E"             # N, E or O
unit_id = 1
deadline_s = 5.0         # one exchange is over after so long
heartbeat_s = 20.0       # between two beats; the AHU should take over after three that are missing
points = "points.csv"    # the point map

[clock]
source = "system"        # system, or plant: the time that a simulated plant tells
daylight_saving = "none" # none, eu or us: the schedule follows people's clocks; rows and logs never shift
utc_offset_h = 0.0       # of standard time, hours east; "eu" needs it

[state]
dir = "state"            # what survives a power cut

[log]
dir = "log"              # one CSV file a day
max_files = 40           # the oldest is removed
max_file_mb = 8.0

[history]
log = ""                 # CSV log of days under the schedule, remembered at the first start: by weights, or by band

[weights]
blob = ""                # weight blob to start with
keys = "keys"            # folder of public keys (*.pub) whose pushed weights are taken

[inbox]
dir = "inbox"            # where `airside push`, a copied file or a stick's content arrive

[page]                   # airside-page, a program of its own: the page for people at the AHU, status and weights over HTTP
listen = "127.0.0.1"     # the address of a network card opens it to that network; then TLS is needed
port = 8350
names = []               # host names that people may call it by, such as ["ahu-3.example.org"]
tls_cert = ""            # PEM files
tls_key = ""
dir = "page"             # its own folder: passwords (airside-page --set-password), alarms that somebody has seen

[ahu]                    # when its fan runs: at other times supply air cannot follow its setpoint, which is no alarm
fan_start = "00:00"      # local time; a point ahu_on (1 runs, 0 rests) in the point map goes before
fan_end = "24:00"
weekday_only = false     # true: it rests on Saturday and Sunday

# Signals for which the site has no sensor: take their rows out of the point map and give their stand-ins here.
# Room temperatures and the setpoint need theirs. `airside check` says what each missing signal costs.
# [stand_in]
# rain = 0
# mau_temp = 18.0        # degC
# outdoor_temp = 28.0    # degC
# power_1 = 4.0          # kW, one meter; power = 4.0 for all that have no row
# vav_on = 1             # all boxes: on
# fcu_on = 0
# fcu_temp = 25.0        # degC

# A model of the building, for training before anything is installed:
# [twin]
# model = "twin.epJSON"  # or "rc"
# patches = ["room301.json"]
# weather = "site.epw"

# An AHU that speaks BACnet, shown on this machine by airside-bacnet; [modbus] then has host = "127.0.0.1", port = 1502:
# [bacnet]
# address = "192.168.1.30/24"  # of this machine, in the network of the devices
# priority = 10          # at which the setpoint is commanded, 8 to 16

# What the box is doing, for an MQTT broker and Home Assistant: a program of its own, airside-mqtt, only publishes.
# [mqtt]
# host = "192.168.1.10"  # the broker
# port = 1883            # 8883 where tls_ca is given
# tls_ca = ""            # PEM file of the authority that signed the broker's certificate: TLS
# username = ""
# password_file = ""     # its first line is the password; mode 640 or less
# topic_prefix = ""      # "": airside/ and the site's name
# client_id = ""         # "": airside- and the site's name
# discovery_prefix = "homeassistant"  # "": no discovery
)";

/// Boxes that modulate hold their zones themselves: supply air may be as cold as they were sized for.
constexpr std::array<std::array<std::string_view, 2>, 5> of_band{{
    {"min_degc = 20.0 ", "min_degc = 12.0 "},
    {"max_degc = 26.0\n", "max_degc = 18.0\n"},
    {"work_degc = 20.5 ", "work_degc = 14.0 "},
    {"off_degc = 25.0 ", "off_degc = 14.0 "},
    {"objective = \"mean\" ", "objective = \"band\" "},
}};

}  // namespace

std::string example_site_text(const std::string& topology, Objective objective) {
  std::string rest = after_topology;
  if (objective == Objective::band) {
    for (const auto& [usual, own] : of_band) rest.replace(rest.find(usual), usual.size(), own);
  }
  return "# Site file of one room with its air handling unit. Paths are relative to this file.\n"
         "# `airside check site.toml` says whether it is right.\n"
         "\n"
         "[site]\n"
         "name = \"Room 301\"\n"
         "topology = \"" +
         topology +
         "\"  # how many VAV boxes, fan coil units, power meters\n"
         "scope = \"Room 301\"              # weight blobs for this scope are taken\n" +
         rest;
}

std::string sections_of_site_key(std::string_view key) {
  const std::string text = example_site_text("1vav-0fcu-0power");
  std::string section, all;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    if (line.starts_with("# ")) line.remove_prefix(2);  // keys that a site may leave out
    if (line.starts_with('[')) section = line.substr(0, line.find(']') + 1);
    const bool same = line.starts_with(key) && line.substr(key.size()).starts_with(" = ");
    if (same && !all.ends_with(section)) all += (all.empty() ? "" : " or ") + section;
  }
  return all;
}

}  // namespace airside::hal
