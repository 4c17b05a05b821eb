"""What the gateway needs of a site file: [modbus] to serve on, [bacnet] to reach devices, by the rules of
hal/site/bacnet_section.cpp."""

import ipaddress
import os
import tomllib
from dataclasses import dataclass, field

from airside_bacnet.input_error import InputError

NUMBERS = {  # default, least, most
    "poll_s": (15.0, 1, 300),
    "stale_s": (60.0, 3, 1200),
    "timeout_s": (3.0, 0.2, 8),
    "heartbeat_timeout_s": (60.0, 15, 1200),
}
WHOLE = {"port": (47808, 1, 65535), "instance": (4190000, 0, 4194302), "priority": (10, 8, 16)}


@dataclass
class BacnetSection:
    address: str
    port: int = 47808
    instance: int = 4190000
    priority: int = 10
    poll_s: float = 15.0
    stale_s: float = 60.0
    timeout_s: float = 3.0
    heartbeat_timeout_s: float = 60.0
    devices: dict = field(default_factory=dict)  # instance -> address, of those that Who-Is does not find


@dataclass
class Site:
    path: str
    host: str
    port: int
    unit: int
    points: str
    bacnet: BacnetSection


def _is_ipv4(text):
    try:
        ipaddress.IPv4Address(text)
        return True
    except ValueError:
        return False


def _whole(text, most):
    return int(text) if text.isascii() and text.isdigit() and int(text) <= most else None


def is_card_address(text):
    address, slash, prefix = text.partition("/")
    return bool(slash) and _is_ipv4(address) and (_whole(prefix, 32) or 0) >= 8


def is_device_address(text):
    before, colon, after = text.partition(":")
    if not colon:
        return _is_ipv4(text)
    if "." in text:
        return _is_ipv4(before) and (_whole(after, 65535) or 0) > 0
    return (_whole(before, 65534) or 0) > 0 and _whole(after, 255) is not None


def _found(value):
    return f'"{value}"' if isinstance(value, str) else str(value)


def _number(table, place, key, default, least, most, whole):
    value = table.get(key, default)
    fits = isinstance(value, int) if whole else isinstance(value, (int, float))
    if not fits or isinstance(value, bool) or not least <= value <= most:
        raise InputError(f"{place}.{key}", _found(value),
                         f"a {'whole ' if whole else ''}number from {least} to {most}", "correct it")
    return value


def _devices(place, listed):
    if not isinstance(listed, list) or not all(isinstance(entry, str) for entry in listed):
        raise InputError(f"{place}.devices", _found(listed), "a list of texts", 'write it as ["1201@192.168.1.50"]')
    devices = {}
    for entry in listed:
        instance, at, address = entry.partition("@")
        number = _whole(instance, 4194302)
        if not at or number is None or not is_device_address(address):
            raise InputError(f"{place}.devices", f'"{entry[:60]}"',
                             'INSTANCE@ADDRESS, such as "1201@192.168.1.50", "1201@192.168.1.50:47809", or '
                             '"1305@2001:5" for station 5 of network 2001 behind a router',
                             "correct it, or take it out where the device answers Who-Is")
        if number in devices:
            raise InputError(f"{place}.devices", f"device {number} twice", "each device once", "remove one of the two")
        devices[number] = address
    return devices


def read_bacnet(table, path):
    place = f"{path}: bacnet"
    known = {"address", "devices", *NUMBERS, *WHOLE}
    for key in table:
        if key not in known:
            raise InputError(f"{place}.{key}", f"an unknown key `{key}`", f"one of {', '.join(sorted(known))}",
                             "correct or remove it")
    address = table.get("address")
    if not isinstance(address, str) or not is_card_address(address):
        raise InputError(f"{place}.address", "nothing" if address is None else _found(address),
                         "this machine's IPv4 address in the network of the devices, with the length of its prefix, "
                         "8 to 32",
                         'write it as in "192.168.1.30/24"; `ip -4 address` shows it')
    section = BacnetSection(address)
    for key, (default, least, most) in NUMBERS.items():
        setattr(section, key, float(_number(table, place, key, default, least, most, False)))
    for key, (default, least, most) in WHOLE.items():
        setattr(section, key, _number(table, place, key, default, least, most, True))
    if section.stale_s < 2 * section.poll_s:
        raise InputError(f"{place}.{'stale_s' if 'stale_s' in table else 'poll_s'}", f"{section.stale_s:g} s",
                         f"stale_s of at least two times poll_s; they are {section.stale_s:g} and {section.poll_s:g} s",
                         "read more often, or believe values for longer")
    section.devices = _devices(place, table.get("devices", []))
    return section


def _loopback(host):
    host = "127.0.0.1" if host == "localhost" else host
    return host if _is_ipv4(host) and ipaddress.IPv4Address(host).is_loopback else None


def read_site_file(path):
    try:
        with open(path, "rb") as file:
            tables = tomllib.load(file)
    except OSError as error:
        raise InputError(path, f"no readable file ({error.strerror})", "a site file in TOML",
                         "check the path") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(path, f"text that is not TOML ({error})", "lines such as key = value",
                         "correct the line; texts and times stand in double quotes") from None
    modbus, bacnet = tables.get("modbus"), tables.get("bacnet")
    if not isinstance(bacnet, dict):
        raise InputError(f"{path}: [bacnet]", "nothing", "a table that says how the devices are reached",
                         'add [bacnet] with address = "192.168.1.30/24", this machine\'s in their network')
    if not isinstance(modbus, dict):
        raise InputError(f"{path}: [modbus]", "nothing", "where airsided looks for the gateway",
                         'add [modbus] with host = "127.0.0.1" and points = "points.csv"')
    section = read_bacnet(bacnet, path)
    host = _loopback(str(modbus.get("host", "")))
    if modbus.get("transport", "tcp") != "tcp" or host is None:
        raise InputError(f"{path}: [modbus] host", _found(modbus.get("host", "nothing")),
                         '"127.0.0.1" by tcp: the rows of BACnet are served on this machine alone',
                         'set transport = "tcp" and host = "127.0.0.1"')
    deadline_s, heartbeat_s = modbus.get("deadline_s", 5.0), modbus.get("heartbeat_s", 20.0)
    if section.timeout_s >= deadline_s:
        raise InputError(f"{path}: [bacnet] timeout_s", f"{section.timeout_s:g} s",
                         f"less than deadline_s of [modbus], {deadline_s:g} s", "lower timeout_s or raise deadline_s")
    if section.heartbeat_timeout_s < 3 * heartbeat_s:
        raise InputError(f"{path}: [bacnet] heartbeat_timeout_s", f"{section.heartbeat_timeout_s:g} s",
                         f"at least three times heartbeat_s of [modbus], {heartbeat_s:g} s",
                         "raise heartbeat_timeout_s or lower heartbeat_s")
    points = os.path.join(os.path.dirname(path), str(modbus.get("points", "points.csv")))
    return Site(path, host, _number(modbus, f"{path}: modbus", "port", 502, 1, 65535, True),
                _number(modbus, f"{path}: modbus", "unit_id", 1, 0, 255, True), points, section)
