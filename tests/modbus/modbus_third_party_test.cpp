// Programs that other people wrote read and write what the server serves: mbpoll (C, libmodbus) and pymodbus
// (Python, its own stack), over TCP and over a serial line.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "hal/points/register_codec.hpp"
#include "modbus/third_party.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;

struct Typed {
  const char* name;    ///< of the point, without its order
  const char* type;    ///< in points.csv
  const char* python;  ///< struct format of the raw value
  double scale, value;
};
constexpr std::array<Typed, 5> register_values = {{{"a", "int16", "h", 0.01, -25.25},
                                                   {"b", "uint16", "H", 1, 51966},
                                                   {"c", "int32", "i", 1, -19088744},
                                                   {"d", "uint32", "I", 1, 4023233417.0},
                                                   {"e", "float32", "f", 1, 25.375}}};

/// Every type in every byte and word order, twice: writable from address 100, read-only from 300; coil and discrete.
std::string all_types_csv() {
  std::string csv = csv_header();
  int addr = 0;
  for (const char* bytes : {"big", "little"}) {
    for (const char* words : {"big", "little"}) {
      for (const Typed& t : register_values) {
        const bool wide = std::string(t.type).find("16") == std::string::npos;
        const std::string limits = std::string(t.type) + "," + bytes + "," + words + "," + std::to_string(t.scale) +
                                   (t.scale < 1        ? ",0,-300,300,,,,"
                                    : t.type[0] == 'u' ? (wide ? ",0,0,4294967295,,,," : ",0,0,65535,,,,")
                                                       : ",0,-2147483648,2147483647,,,,");
        const std::string name = std::string(t.name) + "_" + bytes + "_" + words;
        csv += name + "_w,,3," + std::to_string(100 + addr) + "," + limits + "on-change,16,,self\n";
        csv += name + "_r,,4," + std::to_string(300 + addr) + "," + limits + ",,,\n";
        addr += wide ? 2 : 1;
      }
    }
  }
  return csv + "coil_1,,1,5,coil,,,,,,,,,,on-change,5,0,self\nwet,,2,9,discrete,,,,,,,,,,,,,\n";
}

struct Served {
  explicit Served(ServerSettings settings)
      : thread(PointMap::parse(all_types_csv(), "points.csv"), std::move(settings)) {
    ModbusServer& server = thread.server();
    for (const char* bytes : {"big", "little"}) {
      for (const char* words : {"big", "little"}) {
        for (const Typed& t : register_values) {
          server.set(std::string(t.name) + "_" + bytes + "_" + words + "_r", t.value);
          server.set(std::string(t.name) + "_" + bytes + "_" + words + "_w", 0);
        }
      }
    }
    server.set("wet", 1);
    thread.start();
  }
  ModbusServer& server() { return thread.server(); }
  ServerThread thread;
};

/// What mbpoll prints after `[addr]:`.
std::string mbpoll_value(const std::string& output, int addr) {
  const std::string key = "[" + std::to_string(addr) + "]:";
  const std::size_t at = output.find(key);
  if (at == std::string::npos) return "no line " + key + " in: " + output;
  const std::size_t from = output.find_first_not_of(" \t", at + key.size());
  return output.substr(from, output.find_first_of(" \n", from) - from);
}

/// mbpoll knows big bytes only, in both word orders.
void check_with_mbpoll(ModbusServer& server, ServerThread& thread, const std::string& where) {
  for (const char* words : {"big", "little"}) {
    const std::string order = words[0] == 'b' ? " -B" : "";
    const auto addr_of = [&](const char* name, const char* suffix) {
      return server.map().at(std::string(name) + "_big_" + words + suffix).addr;
    };
    const auto read = [&](const char* table, const char* name, const char* format) {
      const int addr = addr_of(name, "_r");
      return mbpoll_value(run_program("mbpoll -0 -1 -q -t " + std::string(table) + format + order + " -r " +
                                      std::to_string(addr) + where)
                              .output,
                          addr);
    };
    EXPECT_EQ(read("3", "a", "").substr(0, 5), "63011") << "-25.25 at 0.01";
    EXPECT_EQ(read("3", "b", "").substr(0, 5), "51966");
    EXPECT_EQ(read("3", "c", ":int"), "-19088744");
    EXPECT_EQ(read("3", "d", ":int"), "-271733879") << "4023233417: mbpoll shows 32 bits with a sign";
    EXPECT_EQ(read("3", "e", ":float"), "25.375");

    const auto write = [&](const char* name, const char* format, const std::string& value) {
      return run_program("mbpoll -0 -1 -q -t 4" + std::string(format) + order + " -r " +
                         std::to_string(addr_of(name, "_w")) + where + " -- " + value);
    };
    EXPECT_EQ(write("a", "", "64302").status, 0) << "-12.34 at 0.01: mbpoll writes 16 bits without a sign";
    EXPECT_EQ(write("b", "", "4711").status, 0);
    EXPECT_EQ(write("c", ":int", "-123456").status, 0);
    EXPECT_EQ(write("d", ":int", "-294967296").status, 0) << "4000000000";
    EXPECT_EQ(write("e", ":float", "21.5").status, 0);
  }
  EXPECT_EQ(run_program("mbpoll -0 -1 -q -t 0 -r 5" + where + " 1").status, 0);
  EXPECT_EQ(mbpoll_value(run_program("mbpoll -0 -1 -q -t 0 -r 5" + where).output, 5), "1");
  EXPECT_EQ(mbpoll_value(run_program("mbpoll -0 -1 -q -t 1 -r 9" + where).output, 9), "1");
  const ProgramResult unmapped = run_program("mbpoll -0 -1 -q -t 4 -r 5000" + where);
  EXPECT_NE(unmapped.output.find("Illegal data address"), std::string::npos) << unmapped.output;
  const ProgramResult refused = run_program("mbpoll -0 -1 -q -t 4:int -r " +
                                            std::to_string(server.map().at("c_big_big_w").addr + 1) + where + " 7");
  EXPECT_NE(refused.output.find("Illegal data"), std::string::npos) << "a torn write: " << refused.output;
  thread.stop();
  for (const char* words : {"big", "little"}) {
    EXPECT_NEAR(server.get(std::string("a_big_") + words + "_w"), -12.34, 1e-9);
    EXPECT_EQ(server.get(std::string("b_big_") + words + "_w"), 4711);
    EXPECT_EQ(server.get(std::string("c_big_") + words + "_w"), -123456);
    EXPECT_EQ(server.get(std::string("d_big_") + words + "_w"), 4000000000.0);
    EXPECT_EQ(server.get(std::string("e_big_") + words + "_w"), 21.5);
  }
}

TEST(ThirdParty, MbpollReadsAndWritesOverTcp) {
  NEEDS_MBPOLL();
  Served served({TcpListen{}, 1});
  check_with_mbpoll(served.server(), served.thread, " -p " + std::to_string(served.server().port()) + " 127.0.0.1");
}

TEST(ThirdParty, MbpollReadsAndWritesOverASerialLine) {
  NEEDS_MBPOLL();
  Served served({PtyListen{}, 7});
  check_with_mbpoll(served.server(), served.thread, " -m rtu -a 7 -b 19200 -P none " + served.server().device());
}

/// Reads and writes every point with pymodbus, whose packing is Python's own struct module.
std::string pymodbus_script(const PointMap& map, const std::string& client, int unit) {
  std::string script =
      "import struct, sys\n"
      "from pymodbus.client import ModbusTcpClient, ModbusSerialClient\n"
      "client = " +
      client +
      "\n"
      "assert client.connect(), 'cannot connect'\n"
      "def pack(fmt, value, byte_order, word_order):\n"
      "    raw = struct.pack('>' + fmt, value)\n"
      "    words = [raw[i:i+2] for i in range(0, len(raw), 2)]\n"
      "    if word_order == 'little': words.reverse()\n"
      "    if byte_order == 'little': words = [w[::-1] for w in words]\n"
      "    return [int.from_bytes(w, 'big') for w in words]\n"
      "def check(ok, what):\n"
      "    if not ok: print('WRONG', what); sys.exit(1)\n"
      "count = 0\n";
  const std::string device = ", device_id=" + std::to_string(unit);
  for (const char* bytes : {"big", "little"}) {
    for (const char* words : {"big", "little"}) {
      for (const Typed& t : register_values) {
        const std::string name = std::string(t.name) + "_" + bytes + "_" + words;
        const Point& reader = map.at(name + "_r");
        const Point& writer = map.at(name + "_w");
        const double raw = t.value / t.scale;
        const std::string number =
            t.python[0] == 'f' ? std::to_string(raw) : std::to_string(static_cast<std::int64_t>(std::llround(raw)));
        script += "words = pack('" + std::string(t.python) + "', " + number + ", '" + bytes + "', '" + words + "')\n";
        script +=
            "got = client.read_input_registers(" + std::to_string(reader.addr) + ", count=len(words)" + device + ")\n";
        script += "check(not got.isError() and got.registers == words, ('" + name + "', got, words))\n";
        script += "put = client.write_registers(" + std::to_string(writer.addr) + ", words" + device + ")\n";
        script += "back = client.read_holding_registers(" + std::to_string(writer.addr) + ", count=len(words)" +
                  device + ")\n";
        script += "check(not put.isError() and back.registers == words, ('" + name + " written', put, back))\n";
        script += "count += 1\n";
      }
    }
  }
  return script + "check(not client.write_coil(5, True" + device +
         ").isError(), 'coil')\n"
         "check(client.read_coils(5, count=1" +
         device +
         ").bits[0], 'coil back')\n"
         "check(not client.write_coils(5, [False]" +
         device +
         ").isError(), 'coils')\n"
         "check(not client.read_coils(5, count=1" +
         device +
         ").bits[0], 'coils back')\n"
         "check(client.read_discrete_inputs(9, count=1" +
         device +
         ").bits[0], 'discrete')\n"
         "one = client.write_register(" +
         std::to_string(map.at("b_big_big_w").addr) + ", 99" + device +
         ")\n"
         "check(not one.isError(), 'single register')\n"
         "gap = client.read_holding_registers(5000, count=1" +
         device +
         ")\n"
         "check(gap.isError() and gap.exception_code == 2, ('unmapped', gap))\n"
         "deny = client.write_register(300, 1" +
         device +
         ")\n"
         "check(deny.isError() and deny.exception_code == 2, ('read-only', deny))\n"
         "print('checked', count)\n";
}

void check_with_pymodbus(Served& served, const std::string& client, int unit) {
  const std::filesystem::path script =
      std::filesystem::temp_directory_path() / ("airside_pymodbus_" + std::to_string(getpid()) + ".py");
  std::ofstream(script) << pymodbus_script(served.server().map(), client, unit);
  const ProgramResult result = run_program("'" + python() + "' '" + script.string() + "'");
  std::filesystem::remove(script);
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("checked 20"), std::string::npos) << result.output;
  served.thread.stop();
  for (const char* bytes : {"big", "little"}) {
    for (const char* words : {"big", "little"}) {
      for (const Typed& t : register_values) {
        const std::string name = std::string(t.name) + "_" + bytes + "_" + words + "_w";
        EXPECT_EQ(served.server().get(name), name == "b_big_big_w" ? 99 : t.value) << name;
      }
    }
  }
}

TEST(ThirdParty, PymodbusReadsAndWritesEveryTypeAndOrderOverTcp) {
  NEEDS_PYMODBUS();
  Served served({TcpListen{}, 1});
  check_with_pymodbus(served, "ModbusTcpClient('127.0.0.1', port=" + std::to_string(served.server().port()) + ")", 1);
}

TEST(ThirdParty, PymodbusReadsAndWritesEveryTypeAndOrderOverASerialLine) {
  NEEDS_PYMODBUS();
  if (run_program("'" + python() + "' -c 'import serial'").status != 0) {
    GTEST_SKIP() << "NOT TESTED: pymodbus needs pyserial for a serial line; mbpoll covers it";
  }
  Served served({PtyListen{}, 3});
  check_with_pymodbus(served, "ModbusSerialClient('" + served.server().device() + "', baudrate=19200)", 3);
}

/// A pymodbus server is a peer whose every line somebody else wrote; the guarded client must get along with it.
TEST(ThirdParty, GuardedClientReadsAndWritesAPymodbusServer) {
  NEEDS_PYMODBUS();
  const std::filesystem::path script =
      std::filesystem::temp_directory_path() / ("airside_pyserver_" + std::to_string(getpid()) + ".py");
  std::ofstream(script)
      << "import asyncio, sys\n"
         "from pymodbus.server import StartAsyncTcpServer\n"
         "from pymodbus.datastore import ModbusSequentialDataBlock as B, ModbusServerContext as S\n"
         "from pymodbus.datastore import ModbusDeviceContext as D\n"
         "d = D(hr=B(1, [i * 3 for i in range(200)]), ir=B(1, list(range(200))), co=B(1, [0, 1] * 50))\n"
         "asyncio.run(asyncio.wait_for(StartAsyncTcpServer(S(d), address=('127.0.0.1', "
         "int(sys.argv[1]))), 20))\n";
  int port = 0;
  {
    port = HostilePeer([](HostilePeer&, int) {}).port();
  }
  const std::string pid =
      run_program("'" + python() + "' '" + script.string() + "' " + std::to_string(port) + " >/dev/null 2>&1 & echo $!")
          .output;
  ModbusLink link(tcp_settings(port, 2.0));
  std::array<std::uint16_t, 125> registers{};
  bool up = false;
  for (int i = 0; i < 100 && !up; ++i) {
    up = link.read(3, 0, registers).has_value();
    if (!up) usleep(100'000);
  }
  EXPECT_TRUE(up) << "pymodbus never came up";
  for (std::size_t i = 0; i < registers.size(); ++i) EXPECT_EQ(registers[i], 3 * i);
  EXPECT_TRUE(link.read(4, 10, {registers.data(), 5}));
  EXPECT_EQ(registers[4], 14);
  EXPECT_TRUE(link.read(1, 0, {registers.data(), 20}));
  EXPECT_EQ(registers[19], 1);
  const std::array<std::uint16_t, 2> values = {0xCAFE, 0xBABE};
  EXPECT_TRUE(link.write(16, 7, values));
  EXPECT_TRUE(link.write(6, 9, {values.data(), 1}));
  const std::array<std::uint16_t, 1> on = {1};
  EXPECT_TRUE(link.write(5, 2, on));
  EXPECT_TRUE(link.read(3, 7, {registers.data(), 3}));
  EXPECT_EQ(registers[0], 0xCAFE);
  EXPECT_EQ(registers[1], 0xBABE);
  EXPECT_EQ(registers[2], 0xCAFE);
  EXPECT_EQ(link.read(3, 9999, {registers.data(), 1}).error().exception, 2);
  EXPECT_EQ(link.generation(), 1U);
  run_program("kill " + pid);
  std::filesystem::remove(script);
}

}  // namespace
}  // namespace airside::hal
