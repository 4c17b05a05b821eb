"""Between the two sides: what was read and when, what may be commanded, and when it is given back."""

import asyncio
import math
import time

from bacpypes3.pdu import Address

from airside_bacnet.client import BacnetClient, Device, NotAnswered, Refused
from airside_bacnet.command_slot import CommandSlot
from airside_bacnet.modbus_server import DeviceRefuses, DeviceSilent, ModbusSide
from airside_bacnet.notify import say, tell_service_manager
from airside_bacnet.point_map import float_registers, registers_float
from airside_bacnet.values import no_reading

NO_VALUE = float_registers(math.nan)
WATCH_S = 1.0
NAMESAKE_S = 1.0  # a device answers Who-Is within a fraction of it
LAST_S = 20.0  # that a stop waits for a device to acknowledge; with one more try below TimeoutStopSec of the unit


def make_devices(points, fixed):
    devices = {}
    for point in points:
        if point.object is None:
            continue
        instance = point.object.device
        if instance not in devices:
            devices[instance] = Device(instance, Address(fixed[instance]) if instance in fixed else None)
        devices[instance].objects.append(point.object)
    return devices


class Gateway:
    """`speed`: its clock runs N times as fast, beside `airsided --clock-speed`; for measurements."""

    def __init__(self, site, point_map, shown_fingerprint, speed=1.0):
        self.site, self.map, self.speed = site, point_map, speed
        self.section = site.bacnet
        self.shown_fingerprint = shown_fingerprint
        self.devices = make_devices(point_map.points, self.section.devices)
        self.readings = {}  # ObjectName -> (Reading, now)
        self.said_silent = set()  # instances of devices that do not answer
        self.slots = {}
        self.beat = math.nan
        self.beat_at = None
        self.client = None
        self.modbus = ModbusSide(site, point_map.points, self)
        # After a write its effect is read where the map says, not what was there at the last poll.
        self.read_through = {p.name for p in point_map.points if p.written} | {
            p.readback for p in point_map.points if p.written}

    def now(self):
        return time.monotonic() * self.speed

    async def sleep(self, seconds):
        await asyncio.sleep(seconds / self.speed)

    async def run(self, stop):
        """Until `stop`, an asyncio.Event, is set; then what was commanded is given back. Whether all of it was."""
        self.client = BacnetClient(self.section)
        for point in self.map.points:
            if point.written and point.object is not None:
                device = self.devices[point.object.device]
                self.slots[point.name] = CommandSlot(self.client, device, point.object, self.section.priority)
        tasks = []
        try:
            await self.hand_back_all()
            await self.poll_all()
            await self.look_for_namesake()
            await self.modbus.start()
            say(f"serves {len(self.map.points)} points of {len(self.devices)} devices on "
                f"{self.site.host}:{self.site.port} unit {self.site.unit}, "
                f"commands at priority {self.section.priority}")
            tell_service_manager("READY=1")
            tasks = [asyncio.create_task(self.keep_polling()), asyncio.create_task(self.keep_watch())]
            stopped = asyncio.create_task(stop.wait())
            done, _ = await asyncio.wait([*tasks, stopped], return_when=asyncio.FIRST_COMPLETED)
            stopped.cancel()
            for task in done - {stopped}:
                task.result()  # a loop that ended has an error to tell
        finally:
            tell_service_manager("STOPPING=1")
            await self.modbus.stop()
            for task in tasks:
                task.cancel()
            given_back = await self.hand_back_at_last()
            self.client.close()
        return given_back

    async def look_for_namesake(self):
        """Says where another device has the gateway's own number: to everybody else the two are one."""
        number, own = self.section.instance, self.section.address.split("/")[0]
        places = [str(where) for _, where in await self.client.who_is(number, number, wait_s=NAMESAKE_S)]
        others = sorted(where for where in places if where.split(":")[0] != own)
        if others:
            say(f"the gateway's own device number {number} is also that of {' and '.join(others)}; "
                "set instance of [bacnet] to one that no device has")

    # ---- reading

    async def keep_polling(self):
        while True:
            began = self.now()
            await self.poll_all()
            tell_service_manager("WATCHDOG=1")
            await self.sleep(max(0.0, self.section.poll_s - (self.now() - began)))

    async def poll_all(self):
        await asyncio.gather(*(self.poll(device) for device in self.devices.values()))

    async def poll(self, device):
        """Reads all objects of a device; one that is silent is looked for, since its address may have changed."""
        try:
            if not device.answers and not await self.client.find(device):
                raise NotAnswered("not found by Who-Is")
            read = await self.client.read(device, device.objects)
        except NotAnswered as error:
            if device.answers or device.instance not in self.said_silent:
                say(f"{device.name}: {error}")
            self.said_silent.add(device.instance)
            device.answers = False
            return
        was_lost = device.instance in self.said_silent
        self.said_silent.discard(device.instance)
        device.answers = True
        for name, reading in read.items():
            self.take(name, reading)
        if was_lost:
            say(f"{device.name} answers")
            if any(slot.device is device for slot in self.slots.values()):
                # It may have restarted, and its setpoint with it: no person's doing.
                self.modbus.drop_connections()

    def take(self, name, reading):
        before = self.readings.get(name)
        why_before = before[0].why if before else ""
        if reading.why != why_before:
            say(f"{name.short_text}: {reading.why or 'is read again'}")
        self.readings[name] = (reading, self.now())

    def fresh(self, name):
        reading, at = self.readings.get(name, (no_reading("not read yet"), -math.inf))
        return reading if self.now() - at <= self.section.stale_s else no_reading("not read for too long")

    async def read_all(self, points):
        return [await self.read(point) for point in points]

    async def read(self, point):
        """Two registers. Raises DeviceSilent where the setpoint cannot be known."""
        if point.name == "map_fingerprint":
            return self.shown_fingerprint >> 16, self.shown_fingerprint & 0xFFFF
        if point.object is None:
            return float_registers(self.beat)
        if point.name not in self.read_through:
            reading = self.fresh(point.object)
            return float_registers(reading.value) if reading.is_good else NO_VALUE
        slot = self.slots.get(point.name)
        if slot is not None and not slot.emptied_once:
            raise DeviceSilent
        device = self.devices[point.object.device]
        try:
            async with asyncio.timeout(self.section.timeout_s):
                if device.address is None:
                    raise NotAnswered("not found")
                reading = (await self.client.read(device, [point.object]))[point.object]
        except (NotAnswered, TimeoutError):
            raise DeviceSilent from None
        self.take(point.object, reading)
        if not reading.is_good:
            if point.written:
                raise DeviceSilent  # a setpoint that its device does not vouch for is none to start from
            return NO_VALUE
        return float_registers(reading.value)

    # ---- commanding

    async def write(self, point, registers):
        value = registers_float(registers)
        if not math.isfinite(value):
            raise DeviceRefuses
        slot = self.slots.get(point.name)
        try:
            if slot is not None:
                async with asyncio.timeout(self.section.timeout_s):
                    await slot.write(value, self.now())
        except (NotAnswered, TimeoutError):
            say(f"{slot.name.short_text}: no answer to a command of {value:g}")
            raise DeviceSilent from None
        except Refused as refused:
            say(f"{slot.name.short_text}: {slot.device.name} refuses {value:g} ({refused})")
            raise DeviceRefuses from None
        if point.name == "heartbeat":
            if value != self.beat:
                self.beat_at = self.now()
            self.beat = value

    async def keep_watch(self):
        """The setpoint is given back when the controller has been silent; and as long as that has not succeeded."""
        while True:
            await self.sleep(WATCH_S)
            silent = [slot for slot in self.slots.values() if self.is_silent(slot)]
            if silent:
                say(f"the heartbeat has stood still for {self.section.heartbeat_timeout_s:g} s")
                self.modbus.drop_connections()
            for slot in silent:
                slot.written_at = None  # said once; tried until the device acknowledges it
            for slot in self.slots.values():
                if slot.may_hold and slot.written_at is None:
                    await slot.hand_back()

    def is_silent(self, slot):
        if slot.written_at is None:
            return False
        last = max(slot.written_at, self.beat_at or -math.inf)
        return self.now() - last > self.section.heartbeat_timeout_s

    async def hand_back_at_last(self):
        """Nobody tries again after this program; so a device that is away for a moment is waited for."""
        until = self.now() + LAST_S
        await self.hand_back_all()
        while (left := [s for s in self.slots.values() if s.may_hold and s.emptied_once]) and self.now() < until:
            await self.sleep(WATCH_S)
            await asyncio.gather(*(slot.hand_back() for slot in left))
        for slot in left:
            say(f"{slot.name.short_text}: priority {self.section.priority} of {slot.device.name} is left as it was "
                "commanded; write Null to it there, or start this program once more")
        return not left

    async def hand_back_all(self):
        await asyncio.gather(*(slot.hand_back() for slot in self.slots.values()))
