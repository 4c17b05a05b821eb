#include "tools/tags/brick.hpp"

#include <fmt/format.h>

#include <array>
#include <set>
#include <string_view>

#include "hal/site/mqtt_section.hpp"
#include "tools/tags/site_points.hpp"

namespace airside::tools {

namespace {

constexpr const char* turtle_prefixes = R"(# Written by `airside tags`.
@prefix brick: <https://brickschema.org/schema/Brick#> .
@prefix rec: <https://w3id.org/rec#> .
@prefix ref: <https://brickschema.org/schema/Brick/ref#> .
@prefix qudt: <http://qudt.org/schema/qudt/> .
@prefix unit: <http://qudt.org/vocab/unit/> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix skos: <http://www.w3.org/2004/02/skos/core#> .
@prefix bacnet: <http://data.ashrae.org/bacnet/2020#> .
@prefix airside: <urn:airside:vocabulary#> .
@prefix : <urn:airside:site:{}#> .

)";

/// Brick knows no reference to a register.
constexpr const char* modbus_vocabulary = R"(airside:ModbusReference a owl:Class ;
    rdfs:subClassOf ref:ExternalReference ;
    rdfs:label "Modbus reference"@en ;
    skos:definition "A register or bit of a Modbus device; physical = raw * scale + offset, address from 0."@en .

)";

/// In the order of Owner. Locations in the words of Brick 1.3, and in those of RealEstateCore, which 1.4 prefers.
constexpr std::array<const char*, 7> owner_classes = {
    "brick:AHU", "brick:Supply_Fan",      "brick:MAU", "brick:VAV", "brick:HVAC_Zone , rec:HVACZone",
    "brick:FCU", "brick:Electrical_Meter"};

std::string turtle_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    switch (c) {
      case '"': out += "\\\""; break;
      case '\\': out += "\\\\"; break;
      case '\n': out += "\\n"; break;
      case '\r': out += "\\r"; break;
      default:
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
          out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
        } else {
          out += c;
        }
    }
  }
  return out + '"';
}

const char* type_text(hal::PointType type) {
  constexpr std::array<const char*, 7> names = {"coil", "discrete", "int16", "uint16", "int32", "uint32", "float32"};
  return names[static_cast<std::size_t>(type)];
}

const char* order_text(hal::Endian order) { return order == hal::Endian::big ? "big" : "little"; }

/// A double of Turtle with all its digits, which only its exponent tells from a decimal.
std::string double_text(double value) {
  std::string text = fmt::format("{}", value);
  return text.find('e') == std::string::npos ? text + "e0" : text;
}

std::string register_of(const hal::Point& row) {
  std::string out = fmt::format(
      " ,\n        [ a airside:ModbusReference ; airside:functionCode {} ; airside:address {} ; airside:type \"{}\" ; "
      "airside:byteOrder \"{}\" ;\n          airside:wordOrder \"{}\" ; airside:scale {} ; airside:offset {}",
      row.fc, row.addr, type_text(row.type), order_text(row.byte_order), order_text(row.word_order),
      double_text(row.scale), double_text(row.offset));
  if (row.writable()) out += fmt::format(" ; airside:writeFunctionCode {}", row.fc_write);
  return out + " ]";
}

/// A device by its own node, so that points of one device share it.
std::string device_id(const BacnetObject& at) { return fmt::format("bacnet_device_{}", at.device); }

/// Scale and offset stand there only where the object's value is in another unit than the point's.
std::string object_reference(const BacnetObject& at, const hal::Point& row) {
  std::string out = fmt::format(
      " ,\n        [ a ref:BACnetReference ; bacnet:object-identifier \"{0},{1}\" ; bacnet:object-type \"{0}\" ;\n"
      "          bacnet:objectOf :{2} ; ref:bacnet-read-property \"{3}\" ; ref:BACnetURI \"bacnet://{4}/{0},{1}/{3}\"",
      at.type, at.instance, device_id(at), at.property, at.device);
  if (row.scale != 1 || row.offset != 0)
    out += fmt::format(" ;\n          airside:scale {} ; airside:offset {}", double_text(row.scale),
                       double_text(row.offset));
  return out + " ]";
}

std::string devices_turtle(const std::vector<SitePoint>& points) {
  std::set<std::string_view> devices;
  std::string out;
  for (const SitePoint& p : points) {
    const auto at = bacnet_object(*p.row);
    if (!at || !devices.insert(at->device).second) continue;
    out += fmt::format(
        ":{} a bacnet:BACnetDevice ;\n    rdfs:label \"BACnet device {}\" ;\n    bacnet:device-instance {} .\n\n",
        device_id(*at), at->device, at->device);
  }
  return out;
}

/// What belongs to what, and feeds what.
std::string owner_relations(Owner owner, int place, const Site& site, const std::vector<SitePoint>& points) {
  std::string out;
  const auto add = [&out](const char* predicate, Owner other, int number) {
    out += fmt::format(" ;\n    {} :{}", predicate, owner_id(other, number));
  };
  if (owner != Owner::zone) out += " ;\n    brick:hasLocation :building";
  if (owner == Owner::ahu) {
    for (int i = 1; i <= site.counts.vavs; ++i) add("brick:feeds", Owner::vav, i);
    if (owners(site, points, Owner::fan) > 0) add("brick:hasPart", Owner::fan, 0);
  }
  if (owner == Owner::vav) add("brick:feeds", Owner::zone, place);
  if (owner == Owner::mau) add("brick:feeds", Owner::ahu, 0);
  if (owner == Owner::zone) out += fmt::format(" ;\n    brick:hasPart :room_{}", place);
  return out;
}

std::string owner_turtle(Owner owner, int place, const Site& site, const std::vector<SitePoint>& points) {
  return fmt::format(":{} a {} ;\n    rdfs:label {}{} .\n\n", owner_id(owner, place),
                     owner_classes[static_cast<std::size_t>(owner)], turtle_text(owner_label(owner, place)),
                     owner_relations(owner, place, site, points));
}

std::string point_turtle(const SitePoint& p, const Site& site) {
  std::string out = fmt::format(":{} a brick:{} ;\n    rdfs:label {} ;\n    brick:isPointOf :{}", p.row->name,
                                p.kind->brick_class, turtle_text(p.label), owner_id(p.kind->owner, p.place));
  if (*p.kind->qudt_unit != '\0') out += fmt::format(" ;\n    brick:hasUnit unit:{}", p.kind->qudt_unit);
  std::string references;
  if (!p.column.empty()) {
    references += fmt::format(" ,\n        [ a ref:TimeseriesReference ; ref:hasTimeseriesId {} ; ref:storedAt {} ]",
                              turtle_text(p.column), turtle_text(log_folder(site)));
  }
  if (const auto at = bacnet_object(*p.row)) {
    references += object_reference(*at, *p.row);
  } else if (site.file.modbus && p.row->protocol == hal::Protocol::modbus) {
    references += register_of(*p.row);
  }
  if (!references.empty()) out += " ;\n    ref:hasExternalReference" + references.substr(2);
  return out + " .\n\n";
}

}  // namespace

std::string brick_model(const Site& site) {
  const std::vector<SitePoint> points = site_points(site);
  std::string out = fmt::format(fmt::runtime(turtle_prefixes), hal::topic_name(site.file.name));
  if (site.file.modbus && !site.file.bacnet) out += modbus_vocabulary;
  std::set<std::string_view> units;
  for (const SitePoint& p : points) units.insert(p.kind->qudt_unit);
  units.erase("");
  for (const std::string_view unit : units) out += fmt::format("unit:{} a qudt:Unit .\n", unit);
  if (!units.empty()) out += '\n';
  out += fmt::format(":building a brick:Building , rec:Building ;\n    rdfs:label {}", turtle_text(site.file.name));
  for (int i = 1; i <= site.counts.vavs; ++i) out += fmt::format(" ;\n    brick:hasPart :{}", owner_id(Owner::zone, i));
  out += " .\n\n";
  for (const Owner owner : {Owner::mau, Owner::ahu, Owner::fan, Owner::vav, Owner::zone, Owner::fcu, Owner::meter}) {
    const int many = owners(site, points, owner);
    const bool numbered = owner >= Owner::vav;
    for (int i = 1; i <= many; ++i) out += owner_turtle(owner, numbered ? i : 0, site, points);
  }
  for (int i = 1; i <= site.counts.vavs; ++i) {
    out += fmt::format(":room_{} a brick:Room , rec:Room ;\n    rdfs:label \"room {}\" .\n\n", i, i);
  }
  out += devices_turtle(points);
  for (const SitePoint& p : points) out += point_turtle(p, site);
  out.pop_back();
  return out;
}

}  // namespace airside::tools
