#!/usr/bin/env python3
"""A real BACnet/IP device, an AHU controller, in front of a simulated room: device.py INSTANCE ADDRESS [MODBUS_PORT].
ADDRESS is as 192.0.2.10/24:47808, or 2001:5@192.0.2.10/24 for station 5 of network 2001 behind a router there.

Its objects show what `airside serve` has in its registers, its analog-output 1 is commandable with a priority array,
and what comes out of that array is written to the room. Without MODBUS_PORT its inputs hold constants. One line of JSON
on standard input, one answer on standard output: {"fault": [TYPE, INSTANCE, true]}, {"out_of_service": the same},
{"set": [TYPE, INSTANCE, VALUE]}, {"rename": [TYPE, INSTANCE, NAME]}, {"device_name": NAME},
{"priorities": [TYPE, INSTANCE]}, {"mute": true} (it answers nothing),
{"no_multiple": true} (ReadPropertyMultiple is rejected), {"most_at_once": 5} (longer answers are aborted)."""

import asyncio
import json
import struct
import sys

from bacpypes3.apdu import AbortPDU, AbortReason
from bacpypes3.app import Application
from bacpypes3.appservice import ApplicationServiceAccessPoint
from bacpypes3.comm import bind
from bacpypes3.errors import UnrecognizedService
from bacpypes3.ipv4.app import NormalApplication
from bacpypes3.ipv4.link import NormalLinkLayer
from bacpypes3.local.analog import AnalogInputObject, AnalogOutputObject, AnalogValueObject, AnalogValueObjectCmd
from bacpypes3.local.binary import BinaryInputObject
from bacpypes3.local.device import DeviceObject
from bacpypes3.netservice import NetworkServiceAccessPoint, NetworkServiceElement
from bacpypes3.pdu import IPv4Address, LocalBroadcast, LocalStation
from bacpypes3.vlan import Network, Node
from pymodbus.client import AsyncModbusTcpClient

RELINQUISH_DEFAULT = 24.0
# Registers of the default point map of 5vav-5fcu-2power: name, address, kind, object.
ROOM = ([(f"room_temp_{n}", n - 1, "int16", ("analog-input", n)) for n in range(1, 6)]
        + [(f"fcu_temp_{n}", 4 + n, "int16", ("analog-input", 10 + n)) for n in range(1, 6)]
        + [(f"vav_on_{n}", 9 + n, "state", ("binary-input", n)) for n in range(1, 6)]
        + [(f"fcu_on_{n}", 14 + n, "state", ("binary-input", 10 + n)) for n in range(1, 6)]
        + [(f"power_{n}", 18 + 2 * n, "float32", ("analog-input", 20 + n)) for n in range(1, 3)]
        + [("mau_temp", 24, "int16", ("analog-input", 31)), ("outdoor_temp", 25, "int16", ("analog-input", 32)),
           ("rain", 26, "state", ("binary-input", 21)), ("supply_temp", 27, "int16", ("analog-input", 33))])
UNIT = {"power": "kilowatts"}
USUAL = {"room_temp": 24.0, "fcu_temp": 24.0, "vav_on": 1, "fcu_on": 0, "power": 4.0, "mau_temp": 18.0,
         "outdoor_temp": 28.0, "rain": 0, "supply_temp": 20.0}


def stem(name):
    return name.rstrip("0123456789").rstrip("_")


class Controller(NormalApplication):
    muted = no_multiple = False
    most_at_once = 1000

    async def indication(self, apdu):
        if not self.muted:
            await super().indication(apdu)

    async def do_ReadPropertyMultipleRequest(self, apdu):
        if self.no_multiple:
            raise UnrecognizedService
        if len(apdu.listOfReadAccessSpecs) > self.most_at_once:
            # Not by an exception: bacpypes3 0.0.110 forgets to mark the abort as a server's, and its clients wait on.
            await self.response(AbortPDU(True, reason=AbortReason.segmentationNotSupported, context=apdu))
            return
        await super().do_ReadPropertyMultipleRequest(apdu)


def common(identifier, name):
    return {"objectIdentifier": identifier, "objectName": name, "statusFlags": [0, 0, 0, 0], "eventState": "normal",
            "outOfService": False}


def make_objects():
    objects = {}
    for name, _, kind, identifier in ROOM:
        usual = USUAL[stem(name)]
        if kind == "state":
            objects[identifier] = BinaryInputObject(**common(identifier, name), polarity="normal",
                                                    presentValue="active" if usual else "inactive")
        else:
            unit = UNIT.get(stem(name), "degreesCelsius")
            objects[identifier] = AnalogInputObject(**common(identifier, name), presentValue=float(usual), units=unit,
                                                    reliability="noFaultDetected")
    objects["analog-output", 1] = AnalogOutputObject(**common(("analog-output", 1), "supply air setpoint"),
                                                     units="degreesCelsius", presentValue=RELINQUISH_DEFAULT,
                                                     relinquishDefault=RELINQUISH_DEFAULT)
    objects["analog-output", 1].priorityArray[15] = type(objects["analog-output", 1].priorityArray[15])(null=())
    objects["analog-value", 1] = AnalogValueObjectCmd(**common(("analog-value", 1), "heartbeat"), units="noUnits",
                                                      presentValue=0.0, relinquishDefault=0.0)
    objects["analog-value", 2] = AnalogValueObject(**common(("analog-value", 2), "plain setpoint"),
                                                   units="degreesCelsius", presentValue=19.0)
    return objects


class Bridge:
    """Copies registers of the served room to the objects, and the setpoint the other way."""

    def __init__(self, objects, port):
        self.objects, self.client = objects, AsyncModbusTcpClient("127.0.0.1", port=port, timeout=2)

    async def run(self):
        await self.client.connect()
        beat = 0
        while True:
            registers = (await self.client.read_input_registers(0, count=28, device_id=1)).registers
            for name, address, kind, identifier in ROOM:
                if kind == "float32":
                    value = struct.unpack(">f", struct.pack(">HH", *registers[address:address + 2]))[0]
                elif kind == "int16":
                    value = struct.unpack(">h", struct.pack(">H", registers[address]))[0] / 100
                else:
                    value = "active" if registers[address] == 1 else "inactive"
                self.objects[identifier].presentValue = value
            beat = (beat + 1) % 65536
            setpoint = self.objects["analog-output", 1].presentValue
            await self.client.write_registers(0, [round(100 * setpoint) & 0xFFFF], device_id=1)
            await self.client.write_register(1, beat, device_id=1)
            await asyncio.sleep(0.05)


def identifier_of(words):
    return words[0], int(words[1])


def obey(app, objects, order):
    if "fault" in order:  # bacpypes3 makes the fault flag of the reliability
        kind, instance, wrong = order["fault"]
        objects[kind, instance].reliability = "openLoop" if wrong else "noFaultDetected"
    if "out_of_service" in order:
        kind, instance, wrong = order["out_of_service"]
        objects[kind, instance].outOfService = wrong
    if "set" in order:
        kind, instance, value = order["set"]
        objects[kind, instance].presentValue = value
    if "rename" in order:
        kind, instance, name = order["rename"]
        app.delete_object(objects[kind, instance])
        objects[kind, instance].objectName = name
        app.add_object(objects[kind, instance])
    if "device_name" in order:
        app.device_object.objectName = order["device_name"]
    if "mute" in order:
        app.muted = order["mute"]
    if "no_multiple" in order:
        app.no_multiple = order["no_multiple"]
    if "most_at_once" in order:
        app.most_at_once = order["most_at_once"]
    if "priorities" in order:
        one = objects[identifier_of(order["priorities"])]
        return {"present_value": float(one.presentValue),
                "slots": {str(i): float(getattr(slot, slot._choice)) for i, slot in enumerate(one.priorityArray, 1)
                          if slot._choice != "null"}}
    return {}


class RoutedController(Application):
    """The same behind a BACnet/IP router: station `address` of a network of its own, as an MS/TP device is."""

    muted = False

    def __init__(self, device, router_address, network, station):
        super().__init__()
        lan = Network(name="lan", broadcast_address=LocalBroadcast())
        self.asap = ApplicationServiceAccessPoint(device, self.device_info_cache)
        self.nsap, self.nse = NetworkServiceAccessPoint(), NetworkServiceElement()
        bind(self.nse, self.nsap)
        bind(self, self.asap, self.nsap)
        address = LocalStation(station)
        self.nsap.bind(Node(address, lan), address=address)
        self.add_object(device)
        router, router_element = NetworkServiceAccessPoint(), NetworkServiceElement()
        bind(router_element, router)
        outer, inner = IPv4Address(router_address), LocalStation(1)
        router.bind(NormalLinkLayer(outer), 100, outer)
        router.bind(Node(inner, lan), network, inner)
        self.router = router, router_element


async def main(instance, address, port):
    objects = make_objects()
    device = DeviceObject(objectIdentifier=("device", instance), objectName=f"AHU-{instance}", vendorIdentifier=999)
    if "@" in address:
        place, _, router_address = address.partition("@")
        network, _, station = place.partition(":")
        app = RoutedController(device, router_address, int(network), int(station))
    else:
        app = Controller(device, IPv4Address(address))
    for one in objects.values():
        app.add_object(one)
    bridge = asyncio.create_task(Bridge(objects, port).run()) if port else None
    reader = asyncio.StreamReader()
    await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    print(json.dumps({"ready": True}), flush=True)
    while line := await reader.readline():
        if bridge and bridge.done():
            bridge.result()
        print(json.dumps(obey(app, objects, json.loads(line))), flush=True)


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1]), sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 0))
