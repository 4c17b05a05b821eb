#include "tools/tags/haystack.hpp"

#include <array>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "hal/site/mqtt_section.hpp"
#include "tools/tags/site_points.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

/// In the order of Owner.
constexpr std::array<const char*, 7> owner_markers = {"equip ahu hvac",  "equip discharge fan motor", "equip mau hvac",
                                                      "equip vav hvac",  "space hvac zone",           "equip fcu hvac",
                                                      "equip elec meter"};

/// Codes of object types in bacnetCur, as connectors of Haystack servers read them; others have none.
/// Source: BacnetAddr of Haxall's ph.protocols, 2026.
constexpr std::array<std::pair<std::string_view, const char*>, 12> object_codes = {{{"analog-input", "AI"},
                                                                                    {"analog-output", "AO"},
                                                                                    {"analog-value", "AV"},
                                                                                    {"binary-input", "BI"},
                                                                                    {"binary-output", "BO"},
                                                                                    {"binary-value", "BV"},
                                                                                    {"multi-state-input", "MSI"},
                                                                                    {"multi-state-output", "MSO"},
                                                                                    {"multi-state-value", "MSV"},
                                                                                    {"accumulator", "ACC"},
                                                                                    {"positive-integer-value", "PIV"},
                                                                                    {"large-analog-value", "LAV"}}};

/// bacnetCur is the present value of an object; airsideBacnetObject has every object whole.
void add_object(json& row, const BacnetObject& at, const hal::Point& point) {
  row["airsideBacnetObject"] = point.object;
  row["bacnetDeviceInstance"] = std::stoi(std::string(at.device));
  for (const auto& [type, code] : object_codes) {
    if (type == at.type && at.property == "present-value") row["bacnetCur"] = code + std::string(at.instance);
  }
  row["bacnetScale"] = point.scale;
  row["bacnetOffset"] = point.offset;
}

void mark(json& row, const std::string& markers) {
  std::istringstream words(markers);
  for (std::string word; words >> word;) row[word] = {{"_kind", "marker"}};
}

class Grid {
 public:
  explicit Grid(const Site& site) : site_(site), prefix_("airside." + hal::topic_name(site.file.name)) {}

  json made() {
    const std::vector<SitePoint> points = site_points(site_);
    json site{{"id", ref("site")}, {"dis", site_.file.name}};
    mark(site, "site");
    rows_.push_back(std::move(site));
    for (const Owner owner : {Owner::ahu, Owner::fan, Owner::mau, Owner::vav, Owner::zone, Owner::fcu, Owner::meter}) {
      const int many = owners(site_, points, owner);
      for (int i = 1; i <= many; ++i) add_owner(owner, owner >= Owner::vav ? i : 0, points);
    }
    for (const SitePoint& p : points) add_point(p);
    std::set<std::string> names;
    for (const json& row : rows_) {
      for (const auto& [name, value] : row.items()) names.insert(name);
    }
    json columns = json::array();
    for (const std::string& name : names) columns.push_back({{"name", name}});
    return {{"_kind", "grid"}, {"meta", {{"ver", "3.0"}}}, {"cols", std::move(columns)}, {"rows", std::move(rows_)}};
  }

 private:
  json ref(const std::string& id) const { return {{"_kind", "ref"}, {"val", prefix_ + '.' + id}}; }
  json named(const std::string& id, const std::string& label) const {
    return {{"id", ref(id)}, {"dis", site_.file.name + ' ' + label}, {"siteRef", ref("site")}};
  }

  void add_owner(Owner owner, int place, const std::vector<SitePoint>& points) {
    json row = named(owner_id(owner, place), owner_label(owner, place));
    mark(row, owner_markers[static_cast<std::size_t>(owner)]);
    if (owner == Owner::fan) row["equipRef"] = ref(owner_id(Owner::ahu, 0));
    if (owner == Owner::ahu && owners(site_, points, Owner::mau) > 0) row["airRef"] = ref(owner_id(Owner::mau, 0));
    if (owner == Owner::vav) {
      row["airRef"] = ref(owner_id(Owner::ahu, 0));
      row["spaceRef"] = ref(owner_id(Owner::zone, place));
    }
    rows_.push_back(std::move(row));
  }

  void add_point(const SitePoint& p) {
    json row = named(p.row->name, p.label);
    mark(row, std::string("point cur ") + p.kind->markers);
    row["kind"] = p.kind->is_status ? "Bool" : "Number";
    if (*p.kind->haystack_unit != '\0') row["unit"] = p.kind->haystack_unit;
    const Owner owner = p.kind->owner;
    // A zone is a space, not equipment: its points are those of the box that serves it.
    row["equipRef"] = ref(owner == Owner::zone ? owner_id(Owner::vav, p.place) : owner_id(owner, p.place));
    if (owner == Owner::zone) row["spaceRef"] = ref(owner_id(owner, p.place));
    if (p.row->writable()) mark(row, "writable");
    row["airsidePoint"] = p.row->name;
    if (!p.column.empty()) row["airsideLogColumn"] = p.column;
    if (const auto at = bacnet_object(*p.row)) {
      add_object(row, *at, *p.row);
    } else if (site_.file.modbus && p.row->protocol == hal::Protocol::modbus) {
      row["modbusFunctionCode"] = p.row->fc;
      row["modbusAddress"] = p.row->addr;
      row["modbusScale"] = p.row->scale;
      row["modbusOffset"] = p.row->offset;
    }
    rows_.push_back(std::move(row));
  }

  const Site& site_;
  const std::string prefix_;
  json rows_ = json::array();
};

}  // namespace

json haystack_grid(const Site& site) { return Grid(site).made(); }

}  // namespace airside::tools
