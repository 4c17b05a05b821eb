#include "firmware/page/data/checkout.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "firmware/page/data/state_folder.hpp"
#include "hal/points/point_type_names.hpp"
#include "hal/points/register_codec.hpp"
#include "hal/points/word_order.hpp"
#include "hal/storage/atomic_file.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

constexpr const char* readings_name = "points.json";  ///< of the daemon's folder
/// Of its inbox: readings, and a write.
constexpr std::array<const char*, 2> wish_names = {"read-points", "check-write"};
constexpr std::uint64_t max_readings_bytes = 262144;

/// What makes a number of the registers of a point: where it changes, a sign-off is of something else.
std::string row_text(const hal::Point& p) {
  return fmt::format("{} {} {} {}{} {} {} {} {}", p.fc, p.addr, hal::name_of(p.type), static_cast<int>(p.byte_order),
                     static_cast<int>(p.word_order), p.scale, p.offset, p.unit, p.object);
}

/// A limit or value without digits that nobody measured; null where it is none.
json thousandths(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::round(value * 1000) / 1000;
}

std::vector<std::uint16_t> words_of(const json& reading) {
  std::vector<std::uint16_t> words;
  const auto raw = reading.is_object() ? reading.find("raw") : reading.end();
  if (!reading.is_object() || raw == reading.end() || !raw->is_array() || raw->size() > 2) return words;
  for (const json& word : *raw) {
    if (!word.is_number_unsigned() || word.get<std::uint64_t>() > 0xFFFF) return {};
    words.push_back(word.get<std::uint16_t>());
  }
  return words;
}

/// The number in the registers, also where it is beyond the point's limits.
double scaled(hal::Point point, const std::vector<std::uint16_t>& words) {
  point.min = -std::numeric_limits<double>::infinity();
  point.max = std::numeric_limits<double>::infinity();
  if (words.empty()) return std::numeric_limits<double>::quiet_NaN();
  return hal::decode(point, words).value_or(std::numeric_limits<double>::quiet_NaN());
}

/// Of a point: read, not read yet, out of limits, ... A word for the page's texts.
std::string verdict_of(const hal::Point& point, const json& reading, const std::vector<std::uint16_t>& words) {
  if (!point.readable()) return "not readable";
  if (!reading.is_object()) return "not read";
  std::string fault = text_in(reading, "fault");
  if (words.size() < static_cast<std::size_t>(point.width())) {
    return number_of(reading, "exception") > 0 ? "refused" : "no reading";
  }
  if (fault != "none") return fault;
  return hal::fits_other_order_only(point, words) ? "word order" : "plausible";
}

/// What became of the last write that was asked for; null without one.
json write_of(const json& found) {
  const auto write = found.is_object() ? found.find("write") : found.end();
  if (!found.is_object() || write == found.end() || !write->is_object()) return nullptr;
  json out{{"time", text_in(*write, "time")}, {"fault", text_in(*write, "fault")}};
  for (const char* name : {"before", "sent", "taken", "restored"}) out[name] = thousandths(number_of(*write, name));
  return out;
}

std::string now_text() { return hal::civil_text({std::int64_t{std::time(nullptr)}}) + "Z"; }

std::vector<std::string> lines_of(std::string_view body) {
  std::vector<std::string> lines;
  while (lines.size() < 8) {
    const std::size_t end = body.find('\n');
    lines.emplace_back(body.substr(0, end));
    if (end == std::string_view::npos) break;
    body.remove_prefix(end + 1);
  }
  return lines;
}

/// A field of CSV, quoted.
std::string field(std::string text) {
  if (!text.empty() && std::string_view("=+-@\t\r").find(text.front()) != std::string_view::npos) text.insert(0, "'");
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}
std::string number_text(const json& value) { return value.is_number() ? fmt::format("{}", value.get<double>()) : ""; }

}  // namespace

Checkout::Checkout(const hal::SiteFile& site)
    : state_dir_(site.state_dir), inbox_dir_(site.inbox_dir), dir_(site.page.dir) {
  if (!site.modbus) {
    trouble_ = "the site has no bus";
    return;
  }
  try {
    map_ = hal::PointMap::load(site.modbus->points);
  } catch (const hal::InputError& unread) {
    trouble_ = unread.what();
  }
  load();
}

void Checkout::load() {
  std::uint64_t size = 0;
  const hal::StorageFile file = open_in(dir_, file_name, max_bytes, size);
  if (!file.is_open()) return;
  const json all = json_in(file, size);
  if (!all.is_object()) {
    trouble_ = fmt::format("{}/{} is damaged; every point is to be signed off again", dir_, file_name);
    return;
  }
  for (const auto& [name, s] : all.items()) {
    signed_[name] = {text_in(s, "by"),  text_in(s, "role"),  text_in(s, "at"), text_in(s, "read_at"),
                     text_in(s, "raw"), text_in(s, "value"), text_in(s, "row")};
  }
}

bool Checkout::save(const SignOffs& all) {
  json out = json::object();
  for (const auto& [name, s] : all) {
    out[name] = {{"by", s.by},   {"role", s.role},   {"at", s.at},  {"read_at", s.read_at},
                 {"raw", s.raw}, {"value", s.value}, {"row", s.row}};
  }
  const std::string text = dumped(out);
  const auto folder = hal::StorageFile::open_existing_dir(dir_.c_str());
  kept_ = text.size() <= max_bytes && folder &&
          hal::write_file_atomically(*folder, file_name, std::as_bytes(std::span(text)), hal::Sync::full).has_value();
  return kept_;
}

/// points.json of the daemon; null without one.
json Checkout::latest() const {
  std::uint64_t size = 0;
  const hal::StorageFile file = open_in(state_dir_, readings_name, max_readings_bytes, size);
  if (!file.is_open()) return nullptr;
  json found = json_in(file, size);
  if (!found.is_object() || !found.contains("points") || !found["points"].is_array()) return nullptr;
  struct stat status {};
  const double age_s = ::fstat(file.descriptor(), &status) == 0
                           ? std::difftime(std::time(nullptr), status.st_mtim.tv_sec)
                           : std::numeric_limits<double>::quiet_NaN();
  found["age_s"] = thousandths(age_s);
  return found;
}

json Checkout::fact(const hal::Point& point, const json& reading) const {
  const std::vector<std::uint16_t> words = words_of(reading);
  json out{{"name", point.name},
           {"unit", point.unit},
           {"fc", point.fc},
           {"addr", point.addr},
           {"type", hal::name_of(point.type)},
           {"min", thousandths(point.min)},
           {"max", thousandths(point.max)},
           {"writable", point.writable()},
           {"raw", words},
           {"value", thousandths(scaled(point, words))},
           {"verdict", verdict_of(point, reading, words)},
           {"signed", nullptr}};
  if (!point.object.empty()) out["object"] = point.object;
  if (const auto at = signed_.find(point.name); at != signed_.end()) {
    const SignOff& s = at->second;
    out["signed"] = {{"by", s.by},
                     {"role", s.role},
                     {"at", s.at},
                     {"read_at", s.read_at},
                     {"raw", s.raw},
                     {"value", s.value},
                     {"valid", s.row == row_text(point)}};
  }
  return out;
}

json Checkout::points() const {
  const json found = latest();
  std::map<std::string, const json*> by_name;
  if (found.is_object()) {
    for (const json& reading : found["points"]) by_name[text_in(reading, "name")] = &reading;
  }
  json list = json::array();
  std::size_t total = 0, done = 0;
  if (map_) {
    for (const hal::Point& point : map_->points()) {
      const auto at = by_name.find(point.name);
      list.push_back(fact(point, at == by_name.end() ? json() : *at->second));
      ++total;
      const json& s = list.back()["signed"];
      if (s.is_object() && s["valid"].get<bool>()) ++done;
    }
  }
  const auto waits = [this](const char* name) {
    struct stat status {};
    return ::lstat((inbox_dir_ + "/" + name).c_str(), &status) == 0;
  };
  return {{"time", found.is_object() ? text_in(found, "time") : ""},
          {"age_s", found.is_object() ? found["age_s"] : json()},
          {"waiting", std::ranges::any_of(wish_names, waits)},
          {"write", write_of(found)},
          {"trouble", trouble_},
          {"kept", kept_},
          {"total", total},
          {"signed", done},
          {"points", std::move(list)}};
}

std::string Checkout::csv() const {
  const json all = points();
  std::string out =
      "point,unit,function,address,type,min,max,writable,read_at,raw,value,verdict,signed_by,role,signed_at_utc,"
      "signed_read_at,signed_raw,signed_value,sign_off_valid\n";
  for (const json& p : all["points"]) {
    std::string raw;
    for (const json& word : p["raw"]) raw += (raw.empty() ? "" : " ") + std::to_string(word.get<unsigned>());
    out += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}", field(p["name"]), field(p["unit"]), p["fc"].get<int>(),
                       p["addr"].get<int>(), field(p["type"]), number_text(p["min"]), number_text(p["max"]),
                       p["writable"].get<bool>() ? 1 : 0, field(raw.empty() ? "" : text_in(all, "time")), field(raw),
                       number_text(p["value"]), field(p["verdict"]));
    const json& s = p["signed"];
    for (const char* name : {"by", "role", "at", "read_at", "raw", "value"}) out += "," + field(text_in(s, name));
    out += s.is_object() ? (s["valid"].get<bool>() ? ",1\n" : ",0\n") : ",\n";
  }
  return out;
}

Said Checkout::sign(std::string_view body, const std::string& role) {
  const std::vector<std::string> lines = lines_of(body);
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  if (lines.size() != 3) return refusal(400, refusals::sign_off_form);
  const std::string& person = lines[1];
  if (person.empty() || person.find_first_not_of(' ') == std::string::npos || person.size() > max_name_bytes ||
      std::ranges::any_of(person, is_control)) {
    static_assert(max_name_bytes == 80, "name_form says so");
    return refusal(400, refusals::name_form);
  }
  const hal::Point* point = map_ ? map_->find(lines[0]) : nullptr;
  if (point == nullptr) return refusal(404, refusals::point_unknown);
  const json all = points();
  const json& list = all["points"];
  const auto at = std::ranges::find_if(list, [&](const json& p) { return p["name"] == lines[0]; });
  const std::string verdict = text_in(*at, "verdict");
  if (text_in(all, "time") != lines[2]) return refusal(409, refusals::reading_old);
  if (verdict != "plausible" && verdict != "not readable") {
    Said said = refusal(409, refusals::reading_poor);
    said.text += ": " + verdict + "; correct map or device, and read again";
    said.found = verdict;
    return said;
  }
  std::string raw;
  for (const json& word : (*at)["raw"]) raw += (raw.empty() ? "" : " ") + std::to_string(word.get<unsigned>());
  SignOffs next = signed_;
  next[point->name] = {person, role, now_text(), lines[2], raw, number_text((*at)["value"]), row_text(*point)};
  if (!save(next)) return refusal(503, refusals::sign_off_not_kept);
  signed_ = std::move(next);
  return {200, "signed off"};
}

Said Checkout::withdraw(std::string_view body) {
  SignOffs next = signed_;
  const auto at = next.find(body);
  if (at == next.end()) return refusal(404, refusals::not_signed);
  next.erase(at);
  if (!save(next)) return refusal(503, refusals::sign_off_stays);
  signed_ = std::move(next);
  return {200, "withdrawn"};
}

}  // namespace airside::page
