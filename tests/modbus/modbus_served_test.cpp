// Other people's programs at a real `airside serve`: a point map of every type in every byte and word order, read by
// mbpoll and pymodbus and compared with the same room in this process; a setpoint written by each is taken.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "hal/modbus/plant_clock.hpp"
#include "modbus/third_party.hpp"
#include "sim/simulated_plant.hpp"
#include "support/bench.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

namespace fs = std::filesystem;
using testing_peers::has_mbpoll;
using testing_peers::ProgramResult;
using testing_peers::python;
using testing_peers::run_program;

/// How a value lies in registers, as a person writes it into points.csv.
struct Form {
  const char *type, *byte_order, *word_order, *scale;
  bool is_wide() const { return std::string(type).find("16") == std::string::npos; }
};
constexpr Form forms[] = {
    {"int16", "big", "big", "0.01"},       {"int16", "little", "big", "0.01"},
    {"uint16", "big", "big", "0.01"},      {"uint16", "little", "big", "0.01"},
    {"int32", "big", "big", "0.0001"},     {"int32", "big", "little", "0.0001"},
    {"int32", "little", "big", "0.0001"},  {"int32", "little", "little", "0.0001"},
    {"uint32", "big", "big", "0.0001"},    {"uint32", "big", "little", "0.0001"},
    {"uint32", "little", "big", "0.0001"}, {"uint32", "little", "little", "0.0001"},
    {"float32", "big", "big", "1"},        {"float32", "big", "little", "1"},
    {"float32", "little", "big", "1"},     {"float32", "little", "little", "1"},
};

struct Served {
  std::string name;
  int table, addr;  ///< 3 holding, 4 input registers, as in points.csv
  Form form;
};

/// What a client finds in an answer of its own: physical values by name.
using Values = std::map<std::string, double>;

class ServedRoom {
 public:
  explicit ServedRoom(const Form& setpoint) {
    std::string pattern = (fs::temp_directory_path() / "airside_served_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no folder " + pattern);
    folder_ = pattern;
    std::string csv = testing_peers::csv_header();
    int addr = 10, form = 0;
    const auto add = [&](const std::string& name, const std::string& unit, const Form& f, int table, int at,
                         const std::string& more) {
      csv += fmt::format("{},{},{},{},{},{},{},{},0,{}\n", name, unit, table, at, f.type, f.byte_order, f.word_order,
                         f.scale, more);
      points_.push_back({name, table, at, f});
    };
    const tools::Site shape = tools::built_in_site();
    for (int i = 0; i < shape.counts.signals(); ++i, ++form) {
      const Form& f = forms[form % std::ssize(forms)];
      const SignalId id = shape.counts.signal(i);
      add(point_name(id), text_of(id.kind).unit, f, 4, addr, "0,300,,,,,,,");
      addr += f.is_wide() ? 2 : 1;
    }
    add("supply_temp", "degc", forms[11], 4, addr, "0,100,,,,,,,");
    add("setpoint", "degc", setpoint, 3, 20, fmt::format("8,32,,,,on-change,{},18,self", setpoint.is_wide() ? 16 : 6));
    add("heartbeat", "", {"uint16", "big", "big", "1"}, 3, 30, "0,65535,,,,refresh,6,,self");
    add("clock_advance_s", "s", {"int32", "little", "big", "1"}, 3, 31, "0,2147483647,,,,refresh,16,,self");
    add("clock_s", "s", {"int32", "big", "little", "1"}, 4, 200, "0,2147483647,,,,,,,");
    write("points.csv", csv);
    write("site.toml",
          "[site]\nname = \"Served\"\ntopology = \"5vav-5fcu-2power\"\n[modbus]\ntransport = \"tcp\"\nhost = "
          "\"127.0.0.1\"\nport = 502\nunit_id = 9\npoints = \"points.csv\"\n");
    site_ = tools::load_site((folder_ / "site.toml").string());
    const tools::PlantChoice choice = closed_loop::rc_room("402");
    model_ = tools::make_plant(choice, site_, 1);
    const fs::path ready = folder_ / "ready";
    server_ = std::make_unique<closed_loop::Child>(
        std::vector<std::string>{std::string(AIRSIDE_BIN_DIR) + "/airside", "serve", "--site", folder_ / "site.toml",
                                 "--plant", "rc", "--room", choice.room, "--start", choice.start, "--seed",
                                 std::to_string(choice.seed), "--days", "1", "--port", "0", "--ready", ready},
        folder_ / "says");
    for (int i = 0; i < 400 && port_.empty(); ++i) {
      closed_loop::sleep_s(0.05);
      std::string where;
      std::getline(std::ifstream(ready), where);
      if (const auto colon = where.find(':'); colon != std::string::npos) port_ = where.substr(colon + 1);
    }
    if (port_.empty()) throw std::runtime_error("airside serve does not begin: " + server_->said());
  }
  ~ServedRoom() {
    server_.reset();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

  const std::vector<Served>& points() const { return points_; }
  const std::string& port() const { return port_; }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  /// What the same room in this process shows.
  Values expected() const {
    Values all;
    for (int i = 0; i < site_.counts.signals(); ++i) {
      const SignalId id = site_.counts.signal(i);
      all[point_name(id)] = sim::sensor_value(model_->sensors(), id);
    }
    all["supply_temp"] = model_->sensors().supply_temp_degc;
    all["setpoint"] = model_->sensors().setpoint_degc;
    all["clock_s"] = seconds();
    return all;
  }
  double seconds() const { return static_cast<double>(model_->time().seconds - clock_epoch.seconds); }
  void live(double setpoint_degc, std::int64_t s) {
    model_->set_setpoint(setpoint_degc);
    model_->advance_to({model_->time().seconds + s});
  }

 private:
  fs::path folder_;
  std::vector<Served> points_;
  tools::Site site_;
  std::unique_ptr<sim::PlantModel> model_;
  std::unique_ptr<closed_loop::Child> server_;
  std::string port_;
};

/// Each value to half a step of its form, or float's own.
void expect_equal(const Values& got, const Values& expected, const std::vector<Served>& points, std::size_t least) {
  std::size_t compared = 0;
  for (const Served& p : points) {
    if (!expected.contains(p.name) || !got.contains(p.name)) continue;
    const double truth = expected.at(p.name), scale = std::stod(p.form.scale);
    const double step = std::string(p.form.type) == "float32" ? 1e-6 * std::max(1.0, std::abs(truth)) : 0.5 * scale;
    EXPECT_NEAR(got.at(p.name), truth, step + 1e-9)
        << p.name << " " << p.form.type << " " << p.form.byte_order << " " << p.form.word_order;
    ++compared;
  }
  EXPECT_GE(compared, least);
}

// ------------------------------------------------------------------ pymodbus: Python's own struct packs and unpacks

/// Runs `lines` of Python, in which read(name) and write(name, value) go by the point's form.
std::string run_python(const ServedRoom& room, const std::string& lines) {
  std::string script =
      "import struct, sys\n"
      "from pymodbus.client import ModbusTcpClient\n"
      "client = ModbusTcpClient('127.0.0.1', port=" +
      room.port() +
      ")\n"
      "assert client.connect(), 'cannot connect'\n"
      "code = {'int16': 'h', 'uint16': 'H', 'int32': 'i', 'uint32': 'I', 'float32': 'f'}\n"
      "points = {}\n"
      "def swap(words, byte_order, word_order):\n"
      "    if word_order == 'little': words = words[::-1]\n"
      "    if byte_order == 'little': words = [(w & 255) << 8 | w >> 8 for w in words]\n"
      "    return words\n"
      "def read(name):\n"
      "    table, addr, kind, byte_order, word_order, scale = points[name]\n"
      "    ask = client.read_holding_registers if table == 3 else client.read_input_registers\n"
      "    got = ask(addr, count=struct.calcsize('>' + code[kind]) // 2, device_id=9)\n"
      "    assert not got.isError(), (name, got)\n"
      "    words = swap(got.registers, byte_order, word_order)\n"
      "    return struct.unpack('>' + code[kind], struct.pack('>%dH' % len(words), *words))[0] * scale\n"
      "def write(name, value):\n"
      "    table, addr, kind, byte_order, word_order, scale = points[name]\n"
      "    raw = struct.pack('>' + code[kind], value / scale if kind == 'float32' else round(value / scale))\n"
      "    words = swap(list(struct.unpack('>%dH' % (len(raw) // 2), raw)), byte_order, word_order)\n"
      "    if len(words) == 1: put = client.write_register(addr, words[0], device_id=9)\n"
      "    else: put = client.write_registers(addr, words, device_id=9)\n"
      "    assert not put.isError(), (name, put)\n";
  for (const Served& p : room.points()) {
    script += fmt::format("points['{}'] = ({}, {}, '{}', '{}', '{}', {})\n", p.name, p.table, p.addr, p.form.type,
                          p.form.byte_order, p.form.word_order, p.form.scale);
  }
  const ProgramResult result =
      run_program("'" + python() + "' '" + room.write("client.py", script + lines).string() + "'");
  EXPECT_EQ(result.status, 0) << result.output;
  return result.output;
}

Values read_with_pymodbus(const ServedRoom& room) {
  std::istringstream lines(run_python(room, "for name in points: print(name, repr(read(name)))\n"));
  Values got;
  std::string name;
  for (double value = 0; lines >> name >> value;) got[name] = value;
  return got;
}

void advance(const ServedRoom& room, double to_s) {
  (void)run_python(room, fmt::format("write('clock_advance_s', {:.0f})\n", to_s));
}

// ------------------------------------------------------------------ mbpoll: C and libmodbus; big bytes, both word
// orders

/// The words on mbpoll's command line for a point; empty for bytes that it cannot swap.
std::string mbpoll_words(const ServedRoom& room, const Served& p) {
  if (std::string(p.form.byte_order) != "big") return "";
  const std::string type = p.form.type;
  const std::string format = type == "float32" ? ":float" : p.form.is_wide() ? ":int" : "";
  return fmt::format("mbpoll -0 -1 -q -a 9 -t {}{}{} -r {} -p {} 127.0.0.1", p.table == 3 ? 4 : 3, format,
                     std::string(p.form.word_order) == "big" && p.form.is_wide() ? " -B" : "", p.addr, room.port());
}

Values read_with_mbpoll(const ServedRoom& room) {
  Values got;
  for (const Served& p : room.points()) {
    const std::string words = mbpoll_words(room, p);
    if (words.empty()) continue;
    const std::string said = run_program(words).output, key = fmt::format("[{}]:", p.addr);
    const std::size_t at = said.find(key);
    if (at == std::string::npos) {
      ADD_FAILURE() << p.name << ": " << said;
      continue;
    }
    got[p.name] = std::strtod(said.c_str() + at + key.size(), nullptr) * std::stod(p.form.scale);
  }
  return got;
}

// ------------------------------------------------------------------ claims

/// The first 16 signals have all 16 forms, mbpoll has eight of them.
TEST(ServedPlant, IsReadByPymodbusInEveryTypeAndOrder) {
  NEEDS_PYMODBUS();
  ServedRoom room(forms[0]);
  expect_equal(read_with_pymodbus(room), room.expected(), room.points(), 28);
  advance(room, room.seconds() + 6 * 3600);
  room.live(room.expected().at("setpoint"), 6 * 3600);
  expect_equal(read_with_pymodbus(room), room.expected(), room.points(), 28);
}

TEST(ServedPlant, IsReadByMbpollInEveryTypeAndWordOrder) {
  NEEDS_MBPOLL();
  ServedRoom room(forms[13]);
  expect_equal(read_with_mbpoll(room), room.expected(), room.points(), 15);
}

class ServedSetpoint : public ::testing::TestWithParam<int> {
 protected:
  /// After an hour under it, register, room and supply air are those of the room in this process.
  static void expect_taken(ServedRoom& room, double setpoint_degc) {
    const Values before = room.expected();
    advance(room, room.seconds() + 3600);
    room.live(setpoint_degc, 3600);
    const Values after = room.expected();
    EXPECT_NEAR(after.at("setpoint"), setpoint_degc, 1e-5);
    EXPECT_GT(std::abs(after.at("supply_temp") - before.at("supply_temp")), 1.0) << "the AHU follows";
    expect_equal(read_with_pymodbus(room), after, room.points(), 28);
  }
};

TEST_P(ServedSetpoint, WrittenByPymodbusIsTaken) {
  NEEDS_PYMODBUS();
  ServedRoom room(forms[GetParam()]);
  (void)run_python(room, "write('setpoint', 21.75)\n");
  expect_taken(room, 21.75);
}

class ServedSetpointOfBigBytes : public ServedSetpoint {};

TEST_P(ServedSetpointOfBigBytes, WrittenByMbpollIsTaken) {
  NEEDS_MBPOLL();
  NEEDS_PYMODBUS();
  const Form& form = forms[GetParam()];
  ServedRoom room(form);
  const auto point = std::ranges::find(room.points(), "setpoint", &Served::name);
  const double raw = 22.25 / std::stod(form.scale);
  const std::string value = std::string(form.type) == "float32" ? "22.25" : fmt::format("{:.0f}", raw);
  const ProgramResult put = run_program(mbpoll_words(room, *point) + " -- " + value);
  EXPECT_EQ(put.status, 0) << put.output;
  EXPECT_NEAR(read_with_mbpoll(room).at("setpoint"), 22.25, 1e-5);
  expect_taken(room, 22.25);
}

std::string name_of(const ::testing::TestParamInfo<int>& one) {
  const Form& f = forms[one.param];
  return std::string(f.type) + "_" + f.byte_order + "_" + f.word_order;
}
INSTANTIATE_TEST_SUITE_P(InEveryForm, ServedSetpoint, ::testing::Range(0, static_cast<int>(std::size(forms))), name_of);
INSTANTIATE_TEST_SUITE_P(InEveryForm, ServedSetpointOfBigBytes, ::testing::Values(0, 2, 4, 5, 8, 9, 12, 13), name_of);

}  // namespace
}  // namespace airside::hal
