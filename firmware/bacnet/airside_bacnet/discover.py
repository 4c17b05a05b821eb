"""Finding devices and objects, and reading points once: what a person needs who writes a point map."""

import csv
import re
import sys

from airside_bacnet.client import BacnetClient, Device, NotAnswered, Refused
from airside_bacnet.gateway import make_devices
from airside_bacnet.notify import say
from airside_bacnet.objects import NUMBERS, STATES, TYPES, ObjectName
from airside_bacnet.point_map import UNWATCHED
from airside_bacnet.usual_limits import STALE_S, USUAL, is_heartbeat, kind_of_temperature
from airside_bacnet.values import as_number, judge, no_reading

COLUMNS = ["name", "unit", "protocol", "object", "scale", "offset", "min", "max", "max_rate", "stale_s"]
GATEWAY_HEARTBEAT = "heartbeat,,bacnet,gateway,,,0,65535,,"
# BACnet unit -> unit of the map, scale, offset, min, max as physical values.
UNITS = {
    "degrees-celsius": ("degc", "", "", -40, 60),
    "degrees-fahrenheit": ("degc", 0.5555555556, -17.77777778, -40, 60),
    "kilowatts": ("kw", "", "", 0, 500),
    "watts": ("kw", 0.001, "", 0, 500),
    "percent": ("", 0.01, "", 0, 1),
    "cubic-meters-per-second": ("m3/s", "", "", 0, 1000),
    "liters-per-second": ("m3/s", 0.001, "", 0, 1000),
    "cubic-meters-per-hour": ("m3/s", 0.0002777777778, "", 0, 1000),
    "cubic-feet-per-minute": ("m3/s", 0.000471947443, "", 0, 1000),
}
WAIT_S = 5.0
DEFAULT_PORT = 47808


def point_name(text, taken):
    """Of the letters that a map's names have, unique."""
    stem = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_") or "point"
    stem = (stem if stem[0].isalpha() else f"p_{stem}")[:44]
    name, number = stem, 2
    while name in taken:
        name, number = f"{stem}_{number}", number + 1
    taken.add(name)
    return name


async def object_list(client, device):
    identifier = f"device,{device.instance}"
    try:
        return [tuple(i) for i in await client.read_property(device.address, identifier, "object-list")]
    except Refused:  # longer than its answers may be
        count = int(await client.read_property(device.address, identifier, "object-list", 0))
        return [tuple(await client.read_property(device.address, identifier, "object-list", i))
                for i in range(1, count + 1)]


async def property_or_none(client, device, identifier, prop, index=None):
    try:
        return await client.read_property(device.address, identifier, prop, index)
    except Refused:
        return None


def one_line(text):
    """A name with a line end in it would otherwise add a row of its own to the map."""
    return re.sub(r"[\r\n\v\f\x85\u2028\u2029]+", " ", text)


async def object_row(client, device, kind, instance, listing):
    """(comment, row) of one object."""
    name = ObjectName(device.instance, kind, instance)
    said = {prop: await property_or_none(client, device, name.identifier, prop)
            for prop in ("object-name", "description", "units", "present-value", "status-flags", "reliability")}
    reading = judge({"value": said["present-value"], **{p: said[p] for p in ("status-flags", "reliability")}})
    commandable = kind in (*NUMBERS, *STATES) and await property_or_none(
        client, device, name.identifier, "priority-array", 16) is not None
    unit = str(said["units"]) if said["units"] is not None else ""
    facts = [f'"{said["object-name"]}"', f"{reading.value:g}" if reading.is_good else reading.why]
    facts += [fact for fact in (unit, said["description"], "commandable" if commandable else "") if fact]
    states = kind.startswith("binary")
    if states:
        row = ["", "", "", 0, 1]
    elif kind.startswith("multi-state"):
        count = await property_or_none(client, device, name.identifier, "number-of-states")
        row = ["", "", "", 1, as_number(count) or 2]
    else:
        row = list(UNITS.get(unit, (unit if unit not in ("no-units", "") else "", "", "", -1000000, 1000000)))
    texts = [str(said[prop] or "") for prop in ("object-name", "description")]
    ours, usual = "", ("", STALE_S)
    if commandable and is_heartbeat(*texts):
        ours, usual = listing.take_heartbeat(name), USUAL["heartbeat"][2:]
        row = ["", "", "", *(USUAL["heartbeat"][:2] if kind in NUMBERS else row[3:])]
    elif row[0] == "degc":
        known = kind_of_temperature(*texts, commandable)
        if known:
            row[3:], usual = USUAL[known][:2], USUAL[known][2:]
        else:
            facts.append("wide limits: neither name nor description shows what it is")
    comment = one_line(f"# {name.short_text} {', '.join(map(str, facts))}")
    return comment, [ours or point_name(texts[0], listing.names), row[0], "bacnet", name.short_text, *row[1:], *usual]


class Listing:
    """What is known of the rows that are written."""

    def __init__(self):
        self.names, self.heartbeats = {"heartbeat", "map_fingerprint"}, []

    def take_heartbeat(self, name):
        """The first commandable one has the name; a second is for a person to choose."""
        self.heartbeats.append(name.short_text)
        return "heartbeat" if len(self.heartbeats) == 1 else ""

    def write_own_rows(self, out):
        if self.heartbeats:
            print(f"# {self.heartbeats[0]} is taken for the heartbeat that the AHU watches. Only where its program does "
                  f"not:\n# {GATEWAY_HEARTBEAT}")
        else:
            print(f"# No commandable heartbeat was found: {UNWATCHED}.\n{GATEWAY_HEARTBEAT}")
            say(f"found no commandable heartbeat; {UNWATCHED}")
        if len(self.heartbeats) > 1:
            said = (f"found {len(self.heartbeats)} objects that may be the heartbeat, {', '.join(self.heartbeats)}; "
                    "expected that of the AHU whose setpoint is commanded; give the name heartbeat to that one alone")
            print(f"# {said}")
            say(said)
        out.writerow(["map_fingerprint", "", "bacnet", "gateway", "", "", 0, 4294967295, "", ""])


def is_own(section, instance, address):
    """bacpypes3 itself answers what is sent to its own port on any 127.x, and no packet leaves it."""
    host, _, port = str(address).partition(":")
    return (instance == section.instance and int(port or DEFAULT_PORT) == section.port and
            (host == section.address.partition("/")[0] or host.startswith("127.")))


async def discover(section, addresses):
    client = BacnetClient(section)
    try:
        found = []
        for address in addresses:
            found += await client.who_is(address=client.address(address), wait_s=section.timeout_s)
        if not addresses:
            found = await client.who_is(wait_s=WAIT_S)
            for instance, address in section.devices.items():
                found += [(instance, client.address(address))] if instance not in dict(found) else []
        for instance, address in [entry for entry in found if is_own(section, *entry)]:
            found.remove((instance, address))
            say(f"found this program itself at {address}; expected a device; on 127.x another program is reached at "
                "another UDP port alone: give --port, or port in [bacnet]")
        found = sorted({(instance, str(address)): address for instance, address in found}.items())
        if not found:
            say("found no device; expected an answer to Who-Is; check address, prefix and port, name a device with "
                "--device ADDRESS where routers keep broadcasts back")
            return 1
        print("# Rows of a point map: rename what the controller shall use (room_temp_1, setpoint, ...), "
              "remove the rest.")
        print("# Limits are those of the kind that an object's name shows: " +
              ", ".join(f"{name} {usual[0]} to {usual[1]}" for name, usual in USUAL.items()) + ".")
        out = csv.writer(sys.stdout, lineterminator="\n")
        out.writerow(COLUMNS)
        listing = Listing()
        instances = [instance for (instance, _), _ in found]
        for (instance, _), address in found:
            if instances.count(instance) > 1:
                print(f"# TWO DEVICES HAVE THE NUMBER {instance}: give one another before anything is commanded")
            await list_device(client, Device(instance, address=address), listing, out)
        listing.write_own_rows(out)
        return 0
    finally:
        client.close()


async def list_device(client, device, listing, out):
    identifier = f"device,{device.instance}"
    try:
        named = await property_or_none(client, device, identifier, "object-name")
        vendor = await property_or_none(client, device, identifier, "vendor-name")
        print(one_line(f"# device {device.instance} \"{named}\" at {device.address}" + (f", {vendor}" if vendor else "")))
        for kind, instance in await object_list(client, device):
            if str(kind) not in TYPES:
                continue
            comment, row = await object_row(client, device, str(kind), instance, listing)
            print(comment)
            out.writerow(row)
            sys.stdout.flush()
    except NotAnswered:
        print(f"# device {device.instance} stopped answering")
        say(f"{device.name} stopped answering")


async def read_points(site, point_map):
    """A table of every point; 3 where one could not be read."""
    client = BacnetClient(site.bacnet)
    wrong = 0
    try:
        readings = {}
        devices = make_devices(point_map.points, site.bacnet.devices)
        for device in devices.values():
            try:
                if await client.find(device):
                    readings.update(await client.read(device, device.objects))
            except NotAnswered as error:
                say(f"{device.name}: {error}")
        for point in point_map.points:
            if point.object is None:
                continue
            reading = readings.get(point.object, no_reading("device not found, or silent"))
            wrong += not reading.is_good
            commanded = point.written and reading.is_good
            held = await priorities(client, devices[point.object.device], point) if commanded else ""
            print(f"{point.name:24} {point.object.short_text:32} "
                  f"{f'{reading.value:g}' if reading.is_good else 'NOT READ: ' + reading.why}{held}")
    finally:
        client.close()
    print(f"{wrong} points could not be read" if wrong else
          "all points were read, as the devices have them, before scale and offset; `airside probe` shows them as "
          "airsided sees them")
    return 3 if wrong else 0


async def priorities(client, device, point):
    """Who commands the object."""
    array = await property_or_none(client, device, point.object.identifier, "priority-array")
    if array is None:
        return "  NOT COMMANDABLE: no priority array"
    taken = [f"{i}: {getattr(slot, slot._choice)}" for i, slot in enumerate(array, 1) if slot._choice != "null"]
    return f"  commanded at {', '.join(taken)}" if taken else "  commandable; nobody commands it"
