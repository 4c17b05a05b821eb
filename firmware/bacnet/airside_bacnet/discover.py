"""Finding devices and objects, and reading points once: what a person needs who writes a point map."""

import csv
import re
import sys

from airside_bacnet.client import BacnetClient, Device, NotAnswered, Refused
from airside_bacnet.gateway import make_devices
from airside_bacnet.notify import say
from airside_bacnet.objects import NUMBERS, STATES, TYPES, ObjectName
from airside_bacnet.values import as_number, judge, no_reading

COLUMNS = ["name", "unit", "protocol", "object", "scale", "offset", "min", "max"]
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


async def object_row(client, device, kind, instance, taken):
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
    comment = re.sub(r"[\r\n]+", " ", f"# {name.short_text} {', '.join(map(str, facts))}")
    return comment, [point_name(str(said["object-name"]), taken), row[0], "bacnet", name.short_text, *row[1:]]


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
        found = sorted({(instance, str(address)): address for instance, address in found}.items())
        if not found:
            say("found no device; expected an answer to Who-Is; check address, prefix and port, name a device with "
                "--device ADDRESS where routers keep broadcasts back")
            return 1
        print("# Rows of a point map: rename what the controller shall use (room_temp_1, setpoint, ...), "
              "remove the rest.")
        out = csv.writer(sys.stdout, lineterminator="\n")
        out.writerow(COLUMNS)
        taken = {"heartbeat", "map_fingerprint"}
        instances = [instance for (instance, _), _ in found]
        for (instance, _), address in found:
            if instances.count(instance) > 1:
                print(f"# TWO DEVICES HAVE THE NUMBER {instance}: give one another before anything is commanded")
            await list_device(client, Device(instance, address=address), taken, out)
        out.writerow(["heartbeat", "", "bacnet", "gateway", "", "", 0, 65535])
        out.writerow(["map_fingerprint", "", "bacnet", "gateway", "", "", 0, 4294967295])
        return 0
    finally:
        client.close()


async def list_device(client, device, taken, out):
    identifier = f"device,{device.instance}"
    try:
        named = await property_or_none(client, device, identifier, "object-name")
        vendor = await property_or_none(client, device, identifier, "vendor-name")
        print(f"# device {device.instance} \"{named}\" at {device.address}" + (f", {vendor}" if vendor else ""))
        for kind, instance in await object_list(client, device):
            if str(kind) not in TYPES:
                continue
            comment, row = await object_row(client, device, str(kind), instance, taken)
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
