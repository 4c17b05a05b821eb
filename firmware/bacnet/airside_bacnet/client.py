"""The BACnet side: devices are found, objects read and commanded. Every exchange is over within `timeout_s`."""

import asyncio
import socket
from dataclasses import dataclass, field

from bacpypes3.apdu import AbortPDU, AbortReason, ErrorPDU, ErrorRejectAbortNack, RejectPDU
from bacpypes3.ipv4.app import NormalApplication
from bacpypes3.local.device import DeviceObject
from bacpypes3.pdu import Address, IPv4Address
from bacpypes3.primitivedata import Null, ObjectIdentifier

from airside_bacnet.input_error import InputError
from airside_bacnet.notify import say
from airside_bacnet.values import judge

MOST_OBJECTS = 20  # in one ReadPropertyMultiple, halved for devices whose answer does not hold so many
OTHERS_S = 0.3  # how long further answers to a Who-Is for one device may take
READ_PROPERTIES = ("status-flags", "reliability")
NO_ANSWER = {int(reason) for reason in (AbortReason.noResponse, AbortReason.serverTimeout, AbortReason.tsmTimeout,
                                        AbortReason.applicationExceededReplyTime)}


class NotAnswered(Exception):
    """Nothing came within the time; nobody knows whether a write was taken."""


class Refused(Exception):
    """The device understood and said no."""


@dataclass
class Device:
    instance: int
    fixed: Address | None = None
    address: Address | None = None
    objects: list = field(default_factory=list)
    at_once: int = MOST_OBJECTS  # 0: it lacks ReadPropertyMultiple
    answers: bool = False

    @property
    def name(self):
        return f"device {self.instance}" + (f" at {self.address}" if self.address else "")


def check_card(section, path):
    """A card that is not there, or a port that another program has, would be waited for without a word."""
    probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        probe.bind((section.address.partition("/")[0], section.port))
    except OSError as error:
        raise InputError(f"{path}: bacnet.address", f"{section.address}, UDP port {section.port} ({error.strerror})",
                         "an address of this machine whose BACnet port is free",
                         "see `ip -4 address` and `ss -lun`; another BACnet program here needs another port") from None
    finally:
        probe.close()


def _why(error):
    if isinstance(error, ErrorPDU):
        return str(error.errorCode)
    return str(error.apduAbortRejectReason)


class HearingApplication(NormalApplication):
    """Keeps every I-Am: bacpypes3 keeps one a number, and two devices of one number would be taken for one."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.heard = {}  # instance -> {text of address: address}

    async def do_IAmRequest(self, apdu):
        if apdu.iAmDeviceIdentifier is not None:
            self.heard.setdefault(apdu.iAmDeviceIdentifier[1], {})[str(apdu.pduSource)] = apdu.pduSource
        await super().do_IAmRequest(apdu)


class BacnetClient:
    def __init__(self, section, name="airside-bacnet"):
        self.timeout_s = section.timeout_s
        device = DeviceObject(objectIdentifier=("device", section.instance), objectName=f"{name}-{section.instance}",
                              vendorIdentifier=999, apduTimeout=int(500 * section.timeout_s), numberOfApduRetries=1)
        self.app = HearingApplication(device, IPv4Address(section.address, section.port))

    def close(self):
        self.app.close()

    @staticmethod
    def address(text):
        return Address(text)

    async def _exchange(self, request):
        """Raises NotAnswered or Refused. bacpypes3 raises what a device refuses as a BaseException."""
        try:
            return await asyncio.wait_for(request, self.timeout_s)
        except TimeoutError:
            raise NotAnswered("no answer") from None
        except ErrorRejectAbortNack as error:
            if isinstance(error, AbortPDU) and int(error.apduAbortRejectReason) in NO_ANSWER:
                raise NotAnswered("no answer") from None
            raise Refused(_why(error)) from error
        except (OSError, RuntimeError) as error:  # no route, or no broadcast on this card
            raise NotAnswered(str(error)) from None
        except Exception as error:  # whatever bacpypes3 makes of an answer that is not as the standard has it
            raise Refused(f"an answer that cannot be read ({type(error).__name__}: {error})") from error

    async def who_is(self, low=None, high=None, address=None, wait_s=None):
        """[(instance, address)] of those who answered; an instance twice where two devices have it."""
        self.app.heard.clear()
        try:
            found = await asyncio.wait_for(self.app.who_is(low, high, address, timeout=wait_s or self.timeout_s),
                                           2 * (wait_s or self.timeout_s))
        except (TimeoutError, OSError, RuntimeError):
            return []
        if found:
            await asyncio.sleep(OTHERS_S)  # a question for one ends with the first answer
        answered = {i_am.iAmDeviceIdentifier[1] for i_am in found or []}
        return [(instance, where) for instance, places in sorted(self.app.heard.items()) if instance in answered
                for where in places.values()]

    async def find(self, device):
        """Sets the device's address, a fixed one or that of its I-Am. Whether it is known.
        Raises NotAnswered where two devices have its number."""
        if device.fixed is not None:
            device.address = device.fixed
            return True
        places = [where for _, where in await self.who_is(device.instance, device.instance)]
        if len(places) > 1:
            device.address = None
            where = " and ".join(sorted(map(str, places)))
            raise NotAnswered(f"answers from {where}: two devices with one number; give one another, or "
                              "name the right one in devices of [bacnet]")
        device.address = places[0] if places else device.address
        return device.address is not None

    async def read_property(self, address, identifier, prop, index=None):
        return await self._exchange(self.app.read_property(address, ObjectIdentifier(identifier), prop, index))

    async def read(self, device, names):
        """{ObjectName: Reading} of objects of one device. Raises NotAnswered where it does not answer."""
        found = {}
        at = 0
        while at < len(names):
            some = names[at:at + max(1, device.at_once)]
            if device.at_once == 0:
                found[some[0]] = judge(await self._one_by_one(device.address, some[0]))
            else:
                try:
                    found.update(await self._multiple(device.address, some))
                except Refused as refused:
                    await self._take_smaller(device, some, refused, found)
                    if some[0] not in found:
                        continue
            at += len(some)
        return found

    async def _take_smaller(self, device, some, refused, found):
        """A refusal of many may be of one among them, of the length of the answer, or of the service."""
        if isinstance(refused.__cause__, RejectPDU):
            device.at_once = 0
            say(f"{device.name} has no ReadPropertyMultiple; its objects are read one by one")
        elif isinstance(refused.__cause__, AbortPDU) and device.at_once > 1:
            device.at_once = max(1, min(device.at_once, len(some)) // 2)
            say(f"{device.name} aborts a longer answer ({refused}); {device.at_once} objects are read at once")
        else:
            for name in some:
                found[name] = judge(await self._one_by_one(device.address, name))

    async def _multiple(self, address, names):
        parameters = []
        for name in names:
            parameters += [ObjectIdentifier(name.identifier), [name.prop, *READ_PROPERTIES]]
        answer = await self._exchange(self.app.read_property_multiple(address, parameters))
        properties = {name: {} for name in names}
        by_identifier = {}
        for name in names:
            by_identifier.setdefault(tuple(ObjectIdentifier(name.identifier)), []).append(name)
        for identifier, prop, _, value in answer or []:
            for name in by_identifier.get(tuple(identifier), []):
                key = "value" if str(prop) == name.prop else str(prop)
                # A property that is not there comes as an ErrorType.
                error = getattr(value, "errorCode", None)
                properties[name][key] = str(error) if error is not None else value
        return {name: judge(properties[name]) for name in names}

    async def _one_by_one(self, address, name):
        properties = {}
        for key, prop in (("value", name.prop), *((p, p) for p in READ_PROPERTIES)):
            try:
                properties[key] = await self.read_property(address, name.identifier, prop)
            except Refused as refused:
                properties[key] = str(refused)
                if key == "value":
                    break
        return properties

    async def is_commandable(self, device, name, priority):
        """Whether the object has a priority array. Raises NotAnswered; Refused for any other refusal."""
        try:
            await self.read_property(device.address, name.identifier, "priority-array", priority)
        except Refused as refused:
            if str(refused) in ("unknown-property", "property-is-not-an-array"):
                return False
            raise
        return True

    async def command(self, device, name, value, priority):
        """Writes present-value at `priority`. Raises NotAnswered or Refused."""
        whole = int(round(value)) if name.is_whole else value
        await self._exchange(self.app.write_property(device.address, ObjectIdentifier(name.identifier), "present-value",
                                                     whole, priority=priority))

    async def relinquish(self, device, name, priority):
        await self._exchange(self.app.write_property(device.address, ObjectIdentifier(name.identifier), "present-value",
                                                     Null(()), priority=priority))
