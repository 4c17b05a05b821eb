"""What the service manager and the journal are told."""

import os
import socket
import sys


def say(text):
    print(f"airside-bacnet: {text}", file=sys.stderr, flush=True)


def tell_service_manager(state):
    where = os.environ.get("NOTIFY_SOCKET")
    if not where:
        return
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
        try:
            out.sendto(state.encode(), "\0" + where[1:] if where.startswith("@") else where)
        except OSError as error:
            say(f"the service manager cannot be reached ({error.strerror})")
