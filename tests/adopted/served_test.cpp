// A building that the project did not write behind Modbus: the daemon controls it for a day as the simulation in one
// process does, to the bit.

#include <fmt/format.h>
#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>

#include "adopted/reference_models.hpp"
#include "hal/points/point_map.hpp"
#include "hal/points/register_codec.hpp"
#include "support/child.hpp"
#include "support/program.hpp"

namespace airside::closed_loop {
namespace {

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return "[" + text + "]";
}

constexpr int rooms = 3;  ///< of a shape that every build has

/// A folder with site, points and patch of some of the medium office's bottom floor.
class Office {
 public:
  Office() : options_(sim::medium_office()) {
    sim::OwnNames& names = *options_.own;
    names.zones.resize(rooms);
    names.terminals.resize(rooms);
    names.powers = {"Electricity:HVAC"};
    std::string points = hal::default_point_map(rooms, 0, 1);
    int addr = 200;
    const auto add = [&](const std::string& name, const char* unit, const char* scale, const char* max) {
      points += fmt::format("{},{},4,{},uint16,big,big,{},0,0,{},,,0xFFFF,,,,\n", name, unit, addr++, scale, max);
    };
    for (int i = 1; i <= rooms; ++i) add(fmt::format("damper_{}", i), "", "0.001", "1");
    for (int i = 1; i <= rooms; ++i) add(fmt::format("zone_setpoint_{}", i), "degc", "0.01", "60");
    add("occupied", "", "1", "1");
    add("ahu_on", "", "1", "1");
    add("supply_flow", "m3/s", "0.001", "60");
    write("points.csv", points);
    write("twin.patch.json", options_.patches.front().content.dump());
    write_site(502);
  }

  void write_site(int port) const {
    const sim::OwnNames& n = *options_.own;
    write("site.toml",
          fmt::format("[site]\nname = \"Office\"\ntopology = \"3vav-0fcu-1power\"\n"
                      "[target]\nroom_temp_degc = 24.0\n[setpoint]\nmin_degc = 12.0\nmax_degc = 20.0\n"
                      "[expert]\nwork_degc = 13.0\noff_degc = 18.0\n[controller.override]\nbatch = 16\n"
                      "recent_in_batch = 4\n[clock]\nsource = \"plant\"\n"
                      "[modbus]\ntransport = \"tcp\"\nhost = \"127.0.0.1\"\nport = {}\n"
                      "[weights]\nblob = \"w.blob\"\n"
                      "[twin]\nmodel = \"{}\"\npatches = [\"twin.patch.json\"]\nweather = \"{}\"\ncontrol = \"own\"\n"
                      "step_min = 6\n[twin.names]\nsupply_setpoint_schedule = \"{}\"\nsupply_air_node = \"{}\"\n"
                      "mau_outlet_node = \"{}\"\nzones = {}\nterminals = {}\nsupply_fan = \"{}\"\npowers = {}\n"
                      "occupancy = {}\n",
                      port, options_.model.string(), options_.weather.string(), n.supply_setpoint_schedule,
                      n.supply_air_node, n.mau_outlet_node, list_of(n.zones), list_of(n.terminals), n.supply_fan,
                      list_of(n.powers), list_of(n.occupancy)));
  }

  Outcome run(const std::string& program, const std::vector<std::string>& words) const {
    return run_program(program, words, folder_.path(), folder_.path(), 300);
  }
  fs::path file(const std::string& name) const { return folder_.path() / name; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(file(name)) << text; }

 private:
  sim::EnergyPlusOptions options_;
  TemporaryFolder folder_;
};

/// The lines of a file; a log folder's files one after the other, with one header.
std::vector<std::string> lines_of(const fs::path& place) {
  std::vector<fs::path> files;
  if (fs::is_directory(place)) {
    for (const auto& entry : fs::directory_iterator(place)) {
      if (entry.path().extension() == ".csv") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
  } else {
    files = {place};
  }
  std::vector<std::string> lines;
  for (const fs::path& file : files) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    if (lines.empty()) lines.push_back(line);
    while (std::getline(in, line)) lines.push_back(line);
  }
  return lines;
}

/// `airside serve` on the site's own twin, from its start to its end.
std::unique_ptr<Child> serve(const Office& office) {
  const fs::path ready = office.file("ready");
  fs::remove(ready);
  auto server = std::make_unique<Child>(
      std::vector<std::string>{std::string(AIRSIDE_BIN_DIR) + "/airside", "serve", "--site", office.file("site.toml"),
                               "--twin", "--start", "2021-07-06", "--days", "1", "--port", "0", "--ready", ready},
      office.file("server.txt"));
  const double deadline_s = now_s() + 200;
  while (!fs::exists(ready) && server->running() && now_s() < deadline_s) sleep_s(0.05);
  EXPECT_TRUE(fs::exists(ready)) << server->said();
  return server;
}

int port_of(const Office& office) {
  const std::string where = text_of_file(office.file("ready"));
  return where.empty() ? 0 : std::stoi(where.substr(where.rfind(':') + 1));
}

TEST(AdoptedSite, IsControlledByTheDaemonOverTcpAsInOneProcess) {
  AIRSIDE_NEEDS_REFERENCES();
  const Office office;
  const Outcome checked = office.run("airside", {"check", "site.toml"});
  EXPECT_EQ(checked.code, 1) << checked.out;  // no weights yet, nothing else
  EXPECT_NE(checked.out.find("its own controls; setpoint, nodes and 3 zones are there"), std::string::npos)
      << checked.out << checked.err;
  const Outcome trained = office.run("airside", {"pretrain", "--site", "site.toml", "--start", "2021-07-05", "--days",
                                                 "2", "--updates", "1", "-o", "w.blob"});
  ASSERT_EQ(trained.code, 0) << trained.err;
  const auto server = serve(office);
  office.write_site(port_of(office));
  Child daemon({std::string(AIRSIDE_BIN_DIR) + "/airsided", "--site", office.file("site.toml"), "--backoff", "0.05",
                "--until", "2021-07-07T00:00:00", "--no-sync", "--crash-limit", "0"},
               office.file("daemon.txt"));
  const Outcome simulated =
      office.run("airside", {"simulate", "--site", "site.toml", "--twin", "--start", "2021-07-06", "--expert-days", "0",
                             "--days", "1", "--weights", "w.blob", "--log", "simulated.csv"});
  ASSERT_EQ(simulated.code, 0) << simulated.err;
  ASSERT_EQ(daemon.wait(300), 0) << daemon.said();
  const std::vector<std::string> expected = lines_of(office.file("simulated.csv")), log = lines_of(office.file("log"));
  ASSERT_EQ(expected.size(), 241U);
  ASSERT_EQ(log.size(), expected.size());
  for (std::size_t i = 0; i < log.size(); ++i) ASSERT_EQ(log[i], expected[i]) << "line " << i + 1;
}

TEST(AdoptedSite, ServesTheSignalsBesideTheNetworksInputs) {
  AIRSIDE_NEEDS_REFERENCES();
  const Office office;
  const auto server = serve(office);
  const hal::PointMap map = hal::PointMap::load(office.file("points.csv"));
  const std::unique_ptr<modbus_t, void (*)(modbus_t*)> bus(modbus_new_tcp("127.0.0.1", port_of(office)), modbus_free);
  ASSERT_EQ(modbus_connect(bus.get()), 0);
  const auto read = [&](const std::string& name) {
    const hal::Point& p = map.at(name);
    std::array<std::uint16_t, 2> words{};
    const int got = p.fc == 4 ? modbus_read_input_registers(bus.get(), p.addr, p.width(), words.data())
                              : modbus_read_registers(bus.get(), p.addr, p.width(), words.data());
    EXPECT_EQ(got, p.width()) << name;
    return hal::decode(p, std::span(words).first(static_cast<std::size_t>(p.width()))).value_or(-1000);
  };
  EXPECT_EQ(read("occupied"), 0);
  EXPECT_NEAR(read("zone_setpoint_1"), 26.7, 0.01);
  // 11 o'clock, in the middle of the day's work.
  const hal::Point& clock = map.at("clock_advance_s");
  const auto seconds = static_cast<std::uint32_t>(read("clock_s")) + 11 * 3600;
  const std::array<std::uint16_t, 2> words{static_cast<std::uint16_t>(seconds >> 16U),
                                           static_cast<std::uint16_t>(seconds & 0xFFFFU)};
  ASSERT_EQ(modbus_write_registers(bus.get(), clock.addr, 2, words.data()), 2);
  EXPECT_EQ(read("occupied"), 1);
  EXPECT_EQ(read("ahu_on"), 1);
  EXPECT_NEAR(read("zone_setpoint_3"), 24, 0.01);
  EXPECT_GT(read("supply_flow"), 0.5);
  for (int i = 1; i <= rooms; ++i) EXPECT_GT(read(fmt::format("damper_{}", i)), 0.2);
  EXPECT_GT(read("power_1"), 0.5);
  modbus_close(bus.get());
}

}  // namespace
}  // namespace airside::closed_loop
