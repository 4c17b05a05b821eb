"""Modbus TCP client of one server on this machine. Many requests go out in one packet and are answered in order."""

import socket
import struct

from .failure import AirsideError

READ_BITS, WRITE_COIL, WRITE_REGISTER, WRITE_REGISTERS = (1, 2), 5, 6, 16
MOST_OF_ONE_READ = {1: 2000, 2: 2000, 3: 125, 4: 125}


def read_request(function, address, count):
    return struct.pack(">BHH", function, address, count)


def write_request(function, address, words):
    """words: register contents; of a coil, one that is 0 or not."""
    if function == WRITE_COIL:
        return struct.pack(">BHH", function, address, 0xFF00 if words[0] else 0)
    if function == WRITE_REGISTER:
        return struct.pack(">BHH", function, address, words[0])
    return struct.pack(f">BHHB{len(words)}H", WRITE_REGISTERS, address, len(words), 2 * len(words), *words)


class Client:
    """Raises AirsideError for refusals, foreign answers and a connection that is lost or silent for timeout_s."""

    def __init__(self, host, port, timeout_s=300.0):
        self._place, self._number = f"{host}:{port}", 0
        try:
            self._socket = socket.create_connection((host, port), timeout_s)
        except OSError as cause:
            raise AirsideError(f"{self._place}: cannot connect ({cause})") from cause
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._stream = self._socket.makefile("rb")

    def close(self):
        self._stream.close()
        self._socket.close()

    def exchange(self, requests):
        """Answers of requests, in order: register contents or bits as a tuple of int; empty for writes."""
        numbers = [(self._number + i) & 0xFFFF for i in range(len(requests))]
        self._number += len(requests)
        frames = [struct.pack(">HHHB", n, 0, len(pdu) + 1, 1) + pdu for n, pdu in zip(numbers, requests)]
        try:
            self._socket.sendall(b"".join(frames))
            return [self._answer(n, pdu) for n, pdu in zip(numbers, requests)]
        except OSError as cause:
            raise AirsideError(f"{self._place}: no answer ({cause})") from cause

    def _answer(self, number, request):
        head = self._exactly(7)
        told, protocol, length, _ = struct.unpack(">HHHB", head)
        if (told, protocol) != (number, 0) or not 3 <= length <= 254:
            raise AirsideError(f"{self._place}: found the answer head {head.hex()}; expected transaction {number}")
        pdu = self._exactly(length - 1)
        if pdu[0] == request[0] | 0x80:
            raise AirsideError(f"{self._place}: request {request.hex()} is refused with exception {pdu[1]}")
        if pdu[0] != request[0]:
            raise AirsideError(f"{self._place}: found an answer of function {pdu[0]}; expected {request[0]}")
        if request[0] > 4:
            return ()
        count = struct.unpack_from(">H", request, 3)[0]
        size = (count + 7) // 8 if request[0] in READ_BITS else 2 * count
        if len(pdu) != size + 2 or pdu[1] != size:
            raise AirsideError(f"{self._place}: found an answer of {len(pdu) - 2} bytes; expected {size}")
        if request[0] in READ_BITS:
            return tuple(pdu[2 + i // 8] >> (i % 8) & 1 for i in range(count))
        return struct.unpack_from(f">{count}H", pdu, 2)

    def _exactly(self, size):
        content = self._stream.read(size)
        if len(content) != size:
            raise AirsideError(f"{self._place}: the connection was closed")
        return content
