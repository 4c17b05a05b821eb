#include <fmt/format.h>

#include "hal/points/point_map.hpp"
#include "hal/points/point_row.hpp"

namespace airside::hal {

std::string default_point_map(int vavs, int fcus, int powers, const StandIns& stand_ins, bool boxes_modulate) {
  std::string csv =
      "# physical = raw * scale + offset; addr counts from 0; max_rate is per minute in the unit.\n"
      "# Empty: byte_order and word_order big, scale 1, offset 0, no limit of rate or age, no sentinel, "
      "read-only.\n"
      "# clock_s and clock_advance_s are a simulated AHU's clock: take the two rows out for a real one, and\n"
      "# map_fingerprint unless a register tells a constant, which then is its default.\n";
  csv += modbus_header() + "\n";
  int addr = 0;
  const auto places = [&](SignalKind kind, int count, int width, std::string_view row) {
    for (int place = 1; place <= count; ++place) {
      if (stand_ins.of({kind, place})) continue;
      csv += fmt::format("{},{},4,{},{}\n", point_name({kind, place}), text_of(kind).unit, addr, row);
      addr += width;
    }
  };
  const auto single = [&](std::string_view name, std::string_view unit, int width, std::string_view row) {
    csv += fmt::format("{},{},4,{},{}\n", name, unit, addr, row);
    addr += width;
  };
  // After addr:
  // type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,policy,fc_write,default,readback
  const std::string_view room = "int16,big,big,0.01,0,5,45,1.0,1200,0x8000,,,,";
  const std::string_view status = "uint16,big,big,1,0,0,1,,1200,0xFFFF,,,,";
  places(SignalKind::room_temp, vavs, 1, room);
  places(SignalKind::fcu_temp, fcus, 1, room);
  places(SignalKind::vav_on, vavs, 1, status);
  places(SignalKind::fcu_on, fcus, 1, status);
  places(SignalKind::power, powers, 2, "float32,big,big,1,0,0,500,,1200,,,,,");
  if (!stand_ins.of({SignalKind::mau_temp, 0}))
    single("mau_temp", "degc", 1, "int16,big,big,0.01,0,-20,60,5.0,1200,0x8000,,,,");
  if (!stand_ins.of({SignalKind::outdoor_temp, 0}))
    single("outdoor_temp", "degc", 1, "int16,big,big,0.01,0,-40,60,2.0,1200,0x8000,,,,");
  if (!stand_ins.of({SignalKind::rain, 0})) single("rain", "", 1, status);
  single("supply_temp", "degc", 1, "int16,big,big,0.01,0,-10,60,10.0,1200,0x8000,,,,");
  if (boxes_modulate) {
    const auto each = [&](std::string_view stem, std::string_view unit, std::string_view row) {
      for (int place = 1; place <= vavs; ++place) single(fmt::format("{}_{}", stem, place), unit, 1, row);
    };
    each("damper", "", "uint16,big,big,0.0001,0,0,1,,1200,0xFFFF,,,,");
    each("zone_setpoint", "degc", "int16,big,big,0.01,0,5,45,,1200,0x8000,,,,");
    each("zone_heating_setpoint", "degc", "int16,big,big,0.01,0,5,45,,1200,0x8000,,,,");
    single("occupied", "", 1, status);
    single("supply_flow", "m3/s", 2, "float32,big,big,1,0,0,1000,,1200,,,,,");
    single("ahu_on", "", 1, status);
  }
  single("clock_s", "s", 2, "int32,big,big,1,0,0,2147483647,,,,,,,");
  single("map_fingerprint", "", 2, "uint32,big,big,1,0,0,4294967295,,,,,,,");
  csv += "setpoint,degc,3,0,int16,big,big,0.01,0,8,32,,,0x8000,on-change,6,18,self\n";
  csv += "heartbeat,,3,1,uint16,big,big,1,0,0,65535,,,,refresh,6,,self\n";
  csv += "clock_advance_s,s,3,2,int32,big,big,1,0,0,2147483647,,,,refresh,16,,self\n";
  return csv;
}

}  // namespace airside::hal
