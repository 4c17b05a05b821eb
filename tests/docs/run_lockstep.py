"""Runs docs/examples/lockstep_client.py against a served room: python3 run_lockstep.py BIN

Seven days, within 25 lines, and the room is at its target. Its time is printed, not judged."""

import os
import re
import resource
import subprocess
import sys
import tempfile
import time

CLIENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "examples", "lockstep_client.py")
MOST_LINES, MOST_K = 25, 0.25


def serve(bin_dir, folder):
    ready = os.path.join(folder, "ready")
    server = subprocess.Popen([os.path.join(bin_dir, "airside"), "serve", "--plant", "rc", "--room", "301-real", "--port", "0",
                               "--ready", ready], stdout=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while not os.path.exists(ready):
        if server.poll() is not None or time.monotonic() > until:
            server.kill()
            sys.exit("airside serve did not answer within 60 s")
        time.sleep(0.05)
    with open(ready, encoding="utf-8") as file:
        return server, file.read().strip().rsplit(":", 1)


def main(arguments):
    if len(arguments) != 1:
        sys.exit(__doc__)
    with open(CLIENT, encoding="utf-8") as file:
        lines = [line for line in file if line.strip()]
    if len(lines) > MOST_LINES:
        sys.exit(f"{CLIENT}: {len(lines)} lines; expected {MOST_LINES} at most")
    with tempfile.TemporaryDirectory(prefix="airside-lockstep-") as folder:
        server, address = serve(arguments[0], folder)
        try:
            before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
            client = subprocess.run([sys.executable, CLIENT, *address], capture_output=True, text=True, timeout=60, check=False)
            took, after = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
        finally:
            server.kill()
            server.wait()
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(f"{client.stdout.strip()}; {took:.2f} s, of them {cpu_s:.2f} s of the client's own")
    said = re.fullmatch(r"(\d\.\d\d) K from the target in working hours of seven days\n", client.stdout)
    if client.returncode or not said:
        sys.exit(f"exit code {client.returncode}: {client.stderr}")
    if float(said[1]) > MOST_K:
        sys.exit(f"expected at most {MOST_K} K")


if __name__ == "__main__":
    main(sys.argv[1:])
