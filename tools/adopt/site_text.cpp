#include "tools/adopt/site_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/log/log_csv.hpp"
#include "hal/points/point_row.hpp"
#include "tools/adopt/advice.hpp"

namespace airside::tools {

namespace {

/// A basic string of TOML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (u < 0x20 || u == 0x7f) {
      out += fmt::format("\\u{:04X}", u);
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string list_of(const std::vector<std::string>& texts) {
  std::string out = "[";
  for (const std::string& text : texts) out += (out.size() == 1 ? "" : ", ") + quoted(text);
  return out + "]";
}

/// The loop's name as a site's: without what a page could take for markup, at most 64 bytes.
std::string site_name(const std::string& loop) {
  std::string name;
  for (const char c : loop) name += c == '<' || c == '>' || c == '&' || c == '"' || (c >= 0 && c < 0x20) ? ' ' : c;
  if (name.size() <= 64) return name;
  std::size_t end = 64;  // not within a letter of several bytes
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0) == 0x80) --end;
  return name.substr(0, end);
}

std::string clock(double hours) {
  const int minutes = static_cast<int>(std::lround(hours * 60));
  return fmt::format("\"{:02}:{:02}\"", minutes / 60, minutes % 60);
}

std::string names_table(const Adoption& a) {
  std::vector<std::string> zones, terminals, people;
  for (const LoopTerminal& t : a.loop.terminals) {
    zones.push_back(t.zone);
    terminals.push_back(t.damper ? t.name : "");
    if (t.people) people.push_back(t.zone);
  }
  std::string text = "\n[twin.names]             # by which the model offers what the points show\n";
  text += "supply_setpoint_schedule = " + quoted(a.setpoint.schedule) + "\n";
  text += "supply_air_node = " + quoted(a.loop.supply_outlet) + "\n";
  if (a.loop.outdoor_air_treated) text += "mau_outlet_node = " + quoted(a.loop.outdoor_stream_node) + "\n";
  text += "zones = " + list_of(zones) + "\n";
  text += "terminals = " + list_of(terminals) + "\n";
  if (!a.loop.fcu_zones.empty()) text += "fcu_zones = " + list_of(a.loop.fcu_zones) + "\n";
  if (!a.loop.fan.name.empty()) text += "supply_fan = " + quoted(a.loop.fan.name) + "\n";
  if (!a.choices.powers.empty()) text += "powers = " + list_of(a.choices.powers) + "\n";
  if (a.shows_people()) text += "occupancy = " + list_of(people) + "\n";
  return text;
}

/// What the model says of its ventilation, where that is not the default.
std::string outdoor_share_of(const Adoption& a) {
  if (a.choices.outdoor_share <= 0) return "";
  return fmt::format(
      "\n[controller.override]\nband_outdoor_share = {:.2f} # least outdoor air, share of the design flow\n",
      a.choices.outdoor_share);
}

std::string objective_of(const Adoption& a) {
  if (!a.serves_band()) {
    if (!a.choices.two_day_types) return "";
    return "\n[controller.override]\nhead_day_types = 2       # weekends have people at other hours than working "
           "days\n";
  }
  return std::string(
             "\n[controller]\nobjective = \"band\"       # least energy with every zone in its band; \"mean\" holds "
             "the "
             "mean room temperature\n") +
         outdoor_share_of(a);
}

std::string stand_ins(const Adoption& a) {
  std::string text =
      "\n[stand_in]               # what the controller takes for signals that this model does not show\n"
      "rain = 0\n"
      "vav_on = 1               # every box\n";
  if (!a.loop.outdoor_air_treated) text += "mau_temp = 20.0\n";
  return text;
}

/// After addr: type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,policy,fc_write,default,
/// readback.
class PointRows {
 public:
  void add(const std::string& name, const char* unit, int width, const std::string& row) {
    text_ += fmt::format("{},{},4,{},{}\n", name, unit, address_, row);
    address_ += width;
  }
  void add_each(const char* name, std::size_t count, const char* unit, int width, const std::string& row) {
    for (std::size_t n = 1; n <= count; ++n) add(fmt::format("{}_{}", name, n), unit, width, row);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  int address_ = 0;
};

}  // namespace

std::string adopted_site_text(const Adoption& a) {
  const SiteChoices& c = a.choices;
  std::string text = fmt::format(
      "# Site file of the air loop {} of {}, written by `airside adopt`.\n"
      "# adopt.md says what was found, chosen and could not be found.\n"
      "# Its advice: {}.\n",
      site_name(a.loop.name), a.model_name, advice_on(a).headline);
  text += fmt::format("\n[site]\nname = {}\ntopology = \"{}\"\n", quoted(site_name(a.loop.name)), a.topology());
  text += fmt::format(
      "\n[target]\nroom_temp_degc = {:.2f}   # mean of the rooms in working hours, under the model's own "
      "control\nwork_start = {}\nwork_end = {}\nweekday_only = {}\n",
      c.target_degc, clock(c.work.from_h), clock(c.work.to_h), c.work.weekday_only);
  text += fmt::format(
      "\n[ahu]                    # when its fan ran; the point ahu_on goes before\nfan_start = {}\n"
      "fan_end = {}\nweekday_only = {}\n",
      clock(c.fan.from_h), clock(c.fan.to_h), c.fan.weekday_only);
  text += fmt::format(
      "\n[setpoint]\nmin_degc = {:.1f}\nmax_degc = {:.1f}\nstep_k = {:.1f}\nmax_change_k = {:.1f}\n"
      "round_k = 0.01\n",
      c.min_degc, c.max_degc, c.step_k, std::min(4.5, c.max_degc - c.min_degc));
  text += fmt::format(
      "\n[expert]                 # the model's own setpoint in summer\nwork_degc = {:.1f}\noff_degc = "
      "{:.1f}\n",
      c.work_degc, c.off_degc);
  text += objective_of(a) + stand_ins(a);
  text +=
      "\n[modbus]                 # as `airside serve --site` gives it\ntransport = \"tcp\"\nhost = \"127.0.0.1\"\n"
      "port = 1502\nunit_id = 1\npoints = \"points.csv\"\n"
      "\n[clock]\nsource = \"plant\"         # \"system\" beside a real AHU\n"
      "\n[state]\ndir = \"state\"\n\n[log]\ndir = \"log\"\n\n[weights]\n";
  text += a.serves_band() ? "blob = \"\"                # the objective \"band\" learns on the box\n"
                          : "blob = \"site.blob\"       # airside pretrain --site site.toml -o site.blob\n";
  text +=
      "keys = \"keys\"\n"
      "\n[inbox]\ndir = \"inbox\"\n";
  text += fmt::format(
      "\n[twin]\nmodel = \"model.epJSON\"\npatches = [\"twin.patch.json\"]\nweather = {}\n"
      "control = \"own\"          # the model's own thermostats and terminals run\nstep_min = 6\n",
      quoted(a.weather_name));
  return text + names_table(a);
}

std::string adopted_map_text(const Adoption& a) {
  std::string text = fmt::format(
      "# First mapping of a log to the air loop {} of {}, written by `airside adopt`:\n"
      "#   airside gap --map map.toml --measured log.csv --reference ref.csv -o gap-report\n"
      "# The columns are those of the controller's own log. For another log name its columns, units and steps, and\n"
      "# remove what it has not.\n",
      site_name(a.loop.name), a.model_name);
  text += fmt::format("\n[model]\nfile = \"model.epJSON\"\npatches = [\"twin.patch.json\"]\nair_loops = {}\n",
                      list_of({a.loop.name}));
  text += fmt::format("\n[weather]\nfile = {}\n\n[log]\ntime = \"time\"\nstep_min = 6\n", quoted(a.weather_name));
  const auto channel = [&text](const std::string& column, const char* kind, const std::string& rest) {
    text += fmt::format("\n[[channel]]\ncolumn = \"{}\"\nkind = \"{}\"\n{}", column, kind, rest);
  };
  const auto add = [&](SignalKind kind, std::size_t n, const char* word, const std::string& rest) {
    channel(hal::column_of({kind, static_cast<int>(n)}), word, rest);
  };
  const auto& terminals = a.loop.terminals;
  const auto zone_of = [](const std::string& zone) { return "zone = " + quoted(zone) + "\n"; };
  for (std::size_t n = 0; n < terminals.size(); ++n)
    add(SignalKind::room_temp, n + 1, "room_temperature", zone_of(terminals[n].zone));
  for (std::size_t n = 0; n < a.loop.fcu_zones.size(); ++n) {
    const std::string& zone = a.loop.fcu_zones[n];
    if (std::ranges::none_of(terminals, [&zone](const LoopTerminal& t) { return t.zone == zone; }))
      add(SignalKind::fcu_temp, n + 1, "room_temperature", zone_of(zone));
  }
  channel("supply_temp_degc", "supply_temperature", "key = " + quoted(a.loop.supply_outlet) + "\n");
  if (a.loop.outdoor_air_treated)
    add(SignalKind::mau_temp, 0, "preheated_temperature", "key = " + quoted(a.loop.outdoor_stream_node) + "\n");
  add(SignalKind::outdoor_temp, 0, "outdoor_temperature", "");
  for (std::size_t n = 0; n < a.choices.powers.size(); ++n)
    add(SignalKind::power, n + 1, "power", "meter = " + quoted(a.choices.powers[n]) + "\n");
  for (std::size_t n = 0; n < terminals.size(); ++n) {
    if (terminals[n].damper)
      channel(hal::column_of(hal::SideColumn{hal::SideSignal::damper, static_cast<int>(n) + 1}), "damper",
              zone_of(terminals[n].zone) + "key = " + quoted(terminals[n].name) + "\n");
  }
  text += fmt::format("\n[[command]]\ncolumn = \"setpoint_degc\"\nkind = \"supply_setpoint\"\nschedule = {}\n",
                      quoted(a.setpoint.schedule));
  return text;
}

std::string adopted_points_text(const Adoption& a) {
  const std::string status = "uint16,big,big,1,0,0,1,,1200,0xFFFF,,,,";
  const std::string temperature = "int16,big,big,0.01,0,-20,60,5.0,1200,0x8000,,,,";
  const std::size_t boxes = a.loop.terminals.size();
  PointRows rows;
  rows.add_each("room_temp", boxes, "degc", 1, "int16,big,big,0.01,0,0,50,1.0,1200,0x8000,,,,");
  rows.add_each("fcu_temp", a.loop.fcu_zones.size(), "degc", 1, "int16,big,big,0.01,0,0,50,1.0,1200,0x8000,,,,");
  rows.add_each("fcu_on", a.loop.fcu_zones.size(), "", 1, status);
  for (std::size_t n = 0; n < a.choices.powers.size(); ++n) {
    const double most = std::max(100.0, std::ceil(a.most_kw[n] * 4 / 100) * 100);
    rows.add(fmt::format("power_{}", n + 1), "kw", 2, fmt::format("float32,big,big,1,0,0,{:.0f},,1200,,,,,", most));
  }
  if (a.loop.outdoor_air_treated) rows.add("mau_temp", "degc", 1, temperature);
  rows.add("outdoor_temp", "degc", 1, "int16,big,big,0.01,0,-50,60,2.0,1200,0x8000,,,,");
  rows.add("supply_temp", "degc", 1, "int16,big,big,0.01,0,-20,80,20.0,1200,0x8000,,,,");
  for (std::size_t n = 0; n < boxes; ++n) {
    if (a.loop.terminals[n].damper)
      rows.add(fmt::format("damper_{}", n + 1), "", 1, "uint16,big,big,0.0001,0,0,1,,1200,0xFFFF,,,,");
  }
  for (std::size_t n = 0; n < boxes; ++n) {
    if (a.loop.terminals[n].thermostat)
      rows.add(fmt::format("zone_setpoint_{}", n + 1), "degc", 1, "int16,big,big,0.01,0,0,60,,1200,0x8000,,,,");
  }
  for (std::size_t n = 0; n < boxes; ++n) {
    if (a.loop.terminals[n].thermostat)
      rows.add(fmt::format("zone_heating_setpoint_{}", n + 1), "degc", 1,
               "int16,big,big,0.01,0,-60,60,,1200,0x8000,,,,");
  }
  if (a.shows_people()) rows.add("occupied", "", 1, status);
  rows.add("supply_flow", "m3/s", 2, "float32,big,big,1,0,0,1000,,1200,,,,,");
  if (!a.loop.fan.name.empty()) rows.add("ahu_on", "", 1, status);
  rows.add("clock_s", "s", 2, "int32,big,big,1,0,0,2147483647,,,,,,,");
  rows.add("map_fingerprint", "", 2, "uint32,big,big,1,0,0,4294967295,,,,,,,");
  std::string text =
      "# Points of an adopted model as `airside serve` gives them; for a real AHU replace addresses and types.\n";
  text += hal::modbus_header() + "\n";
  text += rows.text();
  text += fmt::format("setpoint,degc,3,0,int16,big,big,0.01,0,{:.0f},{:.0f},,,0x8000,on-change,6,{:.1f},self\n",
                      std::floor(std::min(8.0, a.choices.min_degc)), std::ceil(std::max(32.0, a.choices.max_degc)),
                      a.choices.work_degc);
  text += "heartbeat,,3,1,uint16,big,big,1,0,0,65535,,,,refresh,6,,self\n";
  text += "clock_advance_s,s,3,2,int32,big,big,1,0,0,2147483647,,,,refresh,16,,self\n";
  return text;
}

}  // namespace airside::tools
