"""Command line of airside-bacnet."""

import argparse
import asyncio
import signal
import sys

from airside_bacnet import __version__
from airside_bacnet.input_error import InputError
from airside_bacnet.point_map import load_point_map, unwatched
from airside_bacnet.site_file import BacnetSection, is_card_address, is_device_address, read_site_file

ABOUT = """\
airside-bacnet shows BACnet devices to airsided as a Modbus device on this machine's loopback, and commands the setpoint
in the device's priority array. Stopped, and wherever airsided falls silent, it relinquishes what it commanded.

  airside-bacnet --discover --address 192.168.1.30/24 > points.csv    lists devices and objects as rows of a point map
  airside-bacnet --site site.toml --check     reads site file and point map; touches no network
  airside-bacnet --site site.toml --read      reads every point once and shows its value; writes nothing
  airside-bacnet --site site.toml             serves; docs/bacnet.md says how to commission

Exit codes: 0 done or stopped in order, 1 bad input, 2 bad command line, 3 a point could not be read (--read)."""


def parse_arguments(arguments):
    parser = argparse.ArgumentParser("airside-bacnet", description=ABOUT,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--site", metavar="FILE", help="site file with [modbus] and [bacnet]")
    parser.add_argument("--version", action="version", version=f"airside-bacnet {__version__}")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="say whether site file and point map are in order, and stop")
    what.add_argument("--read", action="store_true", help="read every point once, write nothing, and stop")
    what.add_argument("--discover", action="store_true", help="list devices and their objects, and stop")
    parser.add_argument("--address", metavar="IP/PREFIX", help="of --discover without --site: this machine's")
    parser.add_argument("--port", type=int, default=47808, help="of --discover without --site: UDP (default 47808)")
    parser.add_argument("--device", metavar="ADDRESS", action="append", default=[],
                        help="of --discover: ask this address, such as 192.168.1.50 or 2001:5, instead of everybody")
    parser.add_argument("--clock-speed", type=float, default=1.0, metavar="N",
                        help="let times run N times as fast, beside airsided --clock-speed; for measurements")
    chosen = parser.parse_args(arguments)
    if not chosen.site and not (chosen.discover and chosen.address):
        parser.error("--site FILE is needed, or --discover with --address IP/PREFIX")
    if not 1 <= chosen.clock_speed <= 10000:
        parser.error("--clock-speed: expected 1 to 10000")
    if not 1 <= chosen.port <= 65535:
        parser.error("--port: expected 1 to 65535")
    return chosen


def section_of(chosen):
    if chosen.site:
        return read_site_file(chosen.site).bacnet
    if not is_card_address(chosen.address):
        raise InputError("--address", f'"{chosen.address}"', "an IPv4 address of this machine with its prefix, 8 to 32",
                         "write it as in 192.168.1.30/24; `ip -4 address` shows it")
    return BacnetSection(chosen.address, chosen.port)


# The libraries are loaded where they are needed: --check and --help answer at once.


async def serve(site, point_map, shown, speed):
    from airside_bacnet.gateway import Gateway

    stop = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    return await Gateway(site, point_map, shown, speed).run(stop)


def run_discovery(chosen):
    from airside_bacnet.client import check_card
    from airside_bacnet.discover import discover

    section = section_of(chosen)
    for address in chosen.device:
        if not is_device_address(address):
            raise InputError("--device", f'"{address}"', "192.168.1.50, 192.168.1.50:47809, or 2001:5 behind a router",
                             "correct it")
    check_card(section, chosen.site or "--address")
    return asyncio.run(discover(section, chosen.device))


def run(chosen):
    if chosen.discover:
        return run_discovery(chosen)
    site = read_site_file(chosen.site)
    point_map, shown = load_point_map(site.points)
    if chosen.check:
        objects = [p for p in point_map.points if p.object]
        devices = sorted({p.object.device for p in objects})
        print(f"{site.path}: site and points are in order\n{len(objects)} objects of devices "
              f"{', '.join(map(str, devices))}; fingerprint {point_map.fingerprint:016x}; "
              f"Modbus on {site.host}:{site.port}")
        if warning := unwatched(point_map):
            print(f"airside-bacnet: {site.points}: warning: {warning}", file=sys.stderr)
        return 0
    from airside_bacnet.client import check_card
    from airside_bacnet.discover import read_points

    check_card(site.bacnet, site.path)
    if chosen.read:
        return asyncio.run(read_points(site, point_map))
    return 0 if asyncio.run(serve(site, point_map, shown, chosen.clock_speed)) else 1


def main(arguments=None):
    chosen = parse_arguments(arguments)
    try:
        return run(chosen)
    except InputError as error:
        print(f"airside-bacnet: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
