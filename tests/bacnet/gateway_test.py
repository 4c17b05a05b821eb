"""The gateway beside a real BACnet device over UDP; a plain Modbus client in the place of airsided."""

import math
import signal
import struct
import time

from desk import DEFAULT_DEGC, DEVICE, HEADER, OWN_ROWS, SETPOINT_ROW, BacnetTest, Refused, full_map, until
from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ConnectionException

FEW = (HEADER + f"room_temp_1,degc,bacnet,{DEVICE}:analog-input:1,5,45\n" + SETPOINT_ROW + OWN_ROWS
       + f"vav_on_1,,bacnet,{DEVICE}:binary-input:1,0,1\n" + f"absent,,bacnet,{DEVICE}:analog-input:999,0,1\n")
ROOM, SETPOINT, HEARTBEAT, FINGERPRINT, VAV, ABSENT = range(0, 12, 2)
NO_ANSWER, ILLEGAL_VALUE, ILLEGAL_ADDRESS, ILLEGAL_FUNCTION = 11, 3, 2, 1


class GatewayCase(BacnetTest):
    points = FEW
    speed = 20
    orders = {}  # to the device, before the gateway starts

    def setUp(self):
        super().setUp()
        self.start_device()
        if self.orders:
            self.device.do(**self.orders)
        self.gateway = self.start_gateway()
        self.modbus = ModbusTcpClient("127.0.0.1", port=self.modbus_port, timeout=5)
        self.addCleanup(self.modbus.close)

    def read(self, read, address):
        for _ in range(10):  # the gateway ends the connection where a device returns; the client comes again
            try:
                return read(address, count=2, device_id=1)
            except (ConnectionException, ConnectionError):
                time.sleep(0.1)
                self.modbus.connect()
        return read(address, count=2, device_id=1)

    def input(self, address):
        """NaN for no value."""
        registers = self.read(self.modbus.read_input_registers, address).registers
        return struct.unpack(">f", struct.pack(">HH", *registers))[0]

    def holding(self, address):
        """The value, or the exception's number."""
        answer = self.read(self.modbus.read_holding_registers, address)
        if answer.isError():
            return ("exception", answer.exception_code)
        return struct.unpack(">f", struct.pack(">HH", *answer.registers))[0]

    def write(self, address, value):
        """0, or the exception's number."""
        answer = self.modbus.write_registers(address, list(struct.unpack(">HH", struct.pack(">f", value))), device_id=1)
        return answer.exception_code if answer.isError() else 0


class GatewayTest(GatewayCase):
    def test_reads_numbers_and_states_and_shows_what_is_absent_as_no_value(self):
        self.assertEqual(self.input(ROOM), 24.0)
        self.assertEqual(self.input(VAV), 1.0)
        self.assertTrue(math.isnan(self.input(ABSENT)))
        self.assertTrue(self.gateway.has_said(f"{DEVICE}:analog-input:999: unknown-object"))
        self.device.do(set=["analog-input", 1, 23.25])
        until(lambda: self.input(ROOM) == 23.25)

    def test_commands_at_its_priority_reads_back_at_once_and_relinquishes_at_an_orderly_stop(self):
        self.assertEqual(self.holding(SETPOINT), DEFAULT_DEGC)
        self.assertEqual(self.write(SETPOINT, 19.5), 0)
        self.assertEqual(self.holding(SETPOINT), 19.5)
        self.assertEqual(self.device.slots(), {10: 19.5})
        self.assertEqual(self.gateway.kill(signal.SIGTERM), 0)
        self.assertEqual(self.device.slots(), {})

    def test_a_higher_priority_shows_in_the_read_back_and_is_left_alone(self):
        operator = self.operator()
        operator.command(22.0, 8)
        self.assertEqual(self.write(SETPOINT, 19.5), 0)
        self.assertEqual(self.holding(SETPOINT), 22.0)
        self.assertEqual(self.device.slots(), {8: 22.0, 10: 19.5})
        operator.relinquish(8)
        self.assertEqual(self.holding(SETPOINT), 19.5)
        operator.command(23.0, 14)  # below: has no effect, and is still there afterwards
        self.assertEqual(self.holding(SETPOINT), 19.5)
        self.assertEqual(self.gateway.kill(signal.SIGTERM), 0)
        self.assertEqual(self.device.slots(), {14: 23.0})

    def test_relinquishes_when_the_heartbeat_stands_still_and_not_before(self):
        self.assertEqual(self.write(SETPOINT, 19.5), 0)
        began = time.monotonic()
        while time.monotonic() - began < 60 / self.speed + 1:
            self.assertEqual(self.write(HEARTBEAT, time.monotonic() % 1000), 0)
            self.assertEqual(self.device.slots(), {10: 19.5})
            time.sleep(0.2)
        self.assertNotEqual(self.holding(HEARTBEAT), 0)
        while self.device.slots():
            self.assertLess(time.monotonic() - began, 60 / self.speed + 10)
            time.sleep(0.05)
        self.assertTrue(self.gateway.has_said("the heartbeat has stood still for 60 s"))

    def test_a_beat_that_repeats_its_number_is_none(self):
        self.assertEqual(self.write(SETPOINT, 19.5), 0)
        self.assertEqual(self.write(HEARTBEAT, 7.0), 0)
        began = time.monotonic()
        while time.monotonic() - began < 60 / self.speed - 1:
            self.assertEqual(self.write(HEARTBEAT, 7.0), 0)
            time.sleep(0.1)
        until(lambda: not self.device.slots(), 5)

    def test_a_start_after_a_crash_relinquishes_what_the_crashed_one_commanded(self):
        self.write(SETPOINT, 19.5)
        self.gateway.kill(signal.SIGKILL)
        self.assertEqual(self.device.slots(), {10: 19.5})
        self.start_gateway()
        self.assertEqual(self.device.slots(), {})

    def test_a_stop_while_the_device_is_silent_ends_says_what_is_left_and_fails(self):
        self.write(SETPOINT, 19.5)
        self.device.do(mute=True)
        began = time.monotonic()
        self.assertEqual(self.gateway.kill(signal.SIGTERM), 1)
        self.assertLess(time.monotonic() - began, 10)
        self.assertTrue(self.gateway.has_said("its priority 10 is still to be relinquished"))
        self.assertTrue(self.gateway.has_said("is left as it was commanded"))
        self.assertEqual(self.device.slots(), {10: 19.5})

    def test_a_silent_device_gives_no_old_values_and_is_relinquished_when_it_returns(self):
        self.write(SETPOINT, 19.5)
        self.device.do(mute=True)
        self.assertEqual(self.holding(SETPOINT), ("exception", NO_ANSWER))
        self.assertEqual(self.write(SETPOINT, 20.0), NO_ANSWER)
        until(lambda: math.isnan(self.input(ROOM)))
        self.device.do(mute=False)
        until(lambda: self.gateway.has_said("answers\n"))
        until(lambda: self.input(ROOM) == 24.0)
        until(lambda: self.device.slots() == {})

    def test_a_device_that_returns_ends_the_connection_so_that_all_is_read_anew(self):
        self.assertEqual(self.holding(SETPOINT), DEFAULT_DEGC)
        connection = self.modbus.socket
        self.device.do(mute=True)
        until(lambda: self.gateway.has_said("no answer\n"))
        self.device.do(mute=False)
        until(lambda: self.gateway.has_said("answers\n"))
        connection.setblocking(True)
        connection.settimeout(5)
        self.assertEqual(connection.recv(1), b"")

    def test_fault_and_out_of_service_are_no_value_and_a_setpoint_that_is_unknown(self):
        for order, why in (("fault", "fault (open-loop)"), ("out_of_service", "out of service")):
            with self.subTest(order):
                self.device.do(**{order: ["analog-input", 1, True]})
                until(lambda: math.isnan(self.input(ROOM)))
                self.assertTrue(self.gateway.has_said(why), self.gateway.said())
                self.device.do(**{order: ["analog-input", 1, False]})
                until(lambda: self.input(ROOM) == 24.0)
        self.device.do(out_of_service=["analog-output", 1, True])
        self.assertEqual(self.holding(SETPOINT), ("exception", NO_ANSWER))
        self.device.do(out_of_service=["analog-output", 1, False])
        self.assertEqual(self.holding(SETPOINT), DEFAULT_DEGC)

    def test_refuses_what_is_none_of_its_registers_and_listens_on_the_loopback_alone(self):
        self.assertEqual(self.holding(ROOM), ("exception", ILLEGAL_ADDRESS))
        self.assertEqual(self.write(ROOM, 1.0), ILLEGAL_ADDRESS)
        for address, count in ((SETPOINT, 2), (ROOM + 1, 1), (ROOM, 1), (2 * 1000, 2)):
            answer = self.modbus.read_input_registers(address, count=count, device_id=1)
            self.assertEqual(answer.exception_code, ILLEGAL_ADDRESS)
        self.assertEqual(self.modbus.write_register(SETPOINT, 1, device_id=1).exception_code, ILLEGAL_FUNCTION)
        self.assertEqual(self.modbus.read_coils(0, count=1, device_id=1).exception_code, ILLEGAL_FUNCTION)
        self.assertEqual(self.write(SETPOINT, math.nan), ILLEGAL_VALUE)
        self.assertEqual(self.device.slots(), {})
        with open("/proc/net/tcp", encoding="ascii") as file:
            local = [line.split()[1] for line in file if line.split()[3] == "0A"]
        self.assertIn(f"0100007F:{self.modbus_port:04X}", local)
        self.assertNotIn(f"00000000:{self.modbus_port:04X}", local)


class DeviceIsAwayAtTheStop(GatewayCase):
    speed = 1

    def test_it_is_waited_for_and_relinquished(self):
        self.assertEqual(self.write(SETPOINT, 19.5), 0)
        self.device.do(mute=True)
        self.gateway.process.send_signal(signal.SIGTERM)
        until(lambda: self.gateway.has_said("its priority 10 is still to be relinquished"), 15)
        self.device.do(mute=False)
        self.assertEqual(self.gateway.process.wait(30), 0, self.gateway.said())
        self.assertEqual(self.device.slots(), {})


class ShortAnswers(GatewayCase):
    """A device without segmentation: it aborts what does not fit into one answer."""

    points = full_map()
    orders = {"most_at_once": 6}

    def test_a_device_of_short_answers_is_asked_for_fewer_at_once(self):
        self.assertEqual([self.input(2 * place) for place in range(26)].count(24.0), 10)
        self.assertRegex(self.gateway.said(), r"aborts a longer answer .*; 5 objects are read at once")


class OddAnswers(BacnetTest):
    def test_an_answer_that_no_library_reads_spoils_its_object_alone(self):
        async def odd():
            raise ValueError("tag 9")

        operator = self.operator()
        with self.assertRaisesRegex(Refused, "cannot be read .ValueError: tag 9"):
            operator.run(operator.client._exchange(odd()))


class WithoutReadPropertyMultiple(GatewayCase):
    """A small controller that has ReadProperty alone: it rejects the other service."""

    orders = {"no_multiple": True}

    def test_reads_judges_and_commands_as_well(self):
        self.assertTrue(self.gateway.has_said("has no ReadPropertyMultiple"))
        self.assertEqual((self.input(ROOM), self.input(VAV)), (24.0, 1.0))
        self.assertTrue(math.isnan(self.input(ABSENT)))
        self.device.do(fault=["analog-input", 1, True])
        until(lambda: math.isnan(self.input(ROOM)))
        self.assertEqual(self.write(SETPOINT, 19.5), 0)
        self.assertEqual(self.holding(SETPOINT), 19.5)


class HeartbeatOfTheAhu(GatewayCase):
    points = FEW.replace("heartbeat,,bacnet,gateway", f"heartbeat,,bacnet,{DEVICE}:analog-value:1")

    def test_is_written_to_its_object_and_relinquished_too(self):
        self.assertEqual(self.write(HEARTBEAT, 7), 0)
        self.assertEqual(self.device.do(priorities=["analog-value", 1])["slots"], {"10": 7.0})
        self.assertEqual(self.holding(HEARTBEAT), 7.0)
        self.assertEqual(self.gateway.kill(signal.SIGTERM), 0)
        self.assertEqual(self.device.do(priorities=["analog-value", 1])["slots"], {})


class NotCommandable(GatewayCase):
    points = FEW.replace("analog-output:1", "analog-value:2")

    def test_is_never_written_since_nobody_could_give_it_back(self):
        self.assertEqual(self.write(SETPOINT, 20.0), ILLEGAL_VALUE)
        self.assertEqual(self.holding(SETPOINT), 19.0)
        self.assertTrue(self.gateway.has_said("has no priority array"))


class DeviceThatComesLater(GatewayCase):
    def start_device(self, with_plant=False):
        """Not before the gateway."""

    def test_is_found_and_relinquished_before_anything_is_shown(self):
        self.assertEqual(self.holding(SETPOINT), ("exception", NO_ANSWER))
        device = super().start_device()
        until(lambda: self.holding(SETPOINT) == DEFAULT_DEGC)
        self.assertEqual(device.slots(), {})
        self.assertTrue(self.gateway.has_said("priority 10 relinquished"))
