"""The Modbus side: registers on the loopback, by pymodbus. What they hold is asked of the gateway at each request."""

from pymodbus.constants import ExcCodes
from pymodbus.pdu.device import ModbusDeviceIdentification
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from airside_bacnet.input_error import InputError

READS, WRITES = (3, 4), (16,)


class DeviceSilent(Exception):
    """The object's device does not answer: Modbus exception 11, a gateway's."""


class DeviceRefuses(Exception):
    """The device refused the value: Modbus exception 3."""


class ModbusSide:
    """`gateway` has `read(point)` and `write(point, registers)`, both async; two registers a point."""

    def __init__(self, site, points, gateway):
        self._points = {(p.function, p.address): p for p in points}
        self._gateway, self._site = gateway, site
        self._device = SimDevice(site.unit, [SimData(0, count=2 * len(points), values=0, datatype=DataType.REGISTERS)],
                                 identity=ModbusDeviceIdentification(info_name={"ProductName": "airside-bacnet"}),
                                 action=self._action)
        self._server = None

    async def start(self):
        self._server = ModbusTcpServer(self._device, address=(self._site.host, self._site.port))
        try:
            await self._server.serve_forever(background=True)
        except RuntimeError:
            raise InputError(f"{self._site.path}: modbus.port",
                             f"{self._site.port}, on which {self._site.host} cannot listen",
                             "a free port; below 1024 needs a privilege that the unit does not have",
                             "take another, such as port = 1502") from None

    def drop_connections(self):
        """A client that comes again reads everything before it writes, and takes no change for a person's."""
        for connection in list(self._server.active_connections.values()):
            connection.close()

    async def stop(self):
        if self._server:
            await self._server.shutdown()

    def _asked(self, function, address, count):
        """The points that these registers are, or None where one of them is none of this function."""
        function = 3 if function in WRITES else function
        if address % 2 or count % 2:
            return None
        points = [self._points.get((function, a)) for a in range(address, address + count, 2)]
        return None if None in points else points

    async def _action(self, function, start, address, count, registers, values):
        if function not in READS + WRITES:
            return ExcCodes.ILLEGAL_FUNCTION
        points = self._asked(function, address, count)
        if points is None:
            return ExcCodes.ILLEGAL_ADDRESS
        try:
            if values is not None:
                for i, point in enumerate(points):
                    await self._gateway.write(point, tuple(values[2 * i:2 * i + 2]))
                return None
            shown = await self._gateway.read_all(points)
        except DeviceSilent:
            return ExcCodes.GATEWAY_NO_RESPONSE
        except DeviceRefuses:
            return ExcCodes.ILLEGAL_VALUE
        for point, pair in zip(points, shown):
            registers[point.address - start:point.address - start + 2] = pair
        return None
