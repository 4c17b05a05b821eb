"""The airside program: where it is, one run of a command, and a served room as a child process."""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import weakref

from .failure import AirsideError, refused
from .modbus import Client

# A child that outlives its parent would hold its port and, with EnergyPlus, a core. The standard input of the group is
# a pipe that closes however the parent ends; the program itself replaces the shell, so that its number stays the same.
WITH_WATCH = 'exec 3<&0; (read -r _ <&3; kill $$) >/dev/null 2>&1 & exec "$@" 3<&- </dev/null'
SECONDS_TO_END = 5


def find_program(named):
    """Path of airside: what is named, else the variable AIRSIDE_PROGRAM, else the one in the PATH."""
    wanted = named or os.environ.get("AIRSIDE_PROGRAM") or "airside"
    found = shutil.which(os.fspath(wanted))
    if found is None:
        raise refused("airside", f"no program {str(wanted)!r}", "the program airside",
                      "build it, then put it into the PATH, name it in AIRSIDE_PROGRAM or give airside=PATH")
    return os.path.abspath(found)


def complaint_of(text, status):
    """The program's own complaint in its standard error, which may hold progress lines too."""
    lines = [line for line in text.strip().splitlines() if line.startswith("airside: ")]
    return "\n".join(lines) or text.strip()[-1000:] or f"airside ended without a word, exit code {status}"


def run(program, *arguments):
    """Standard output of one command.  Errors: AirsideError with the program's own words."""
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
    if done.returncode:
        raise AirsideError(complaint_of(done.stderr, done.returncode))
    return done.stdout


def _end(process):
    """Ends the whole group, the engine's process and the watch included."""
    try:
        os.killpg(process.pid, signal.SIGTERM)
    except ProcessLookupError:
        pass
    try:
        process.wait(SECONDS_TO_END)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    process.stdin.close()
    process.stdout.close()


class ServedRoom:
    """`airside serve` in lockstep and a client of it. It ends by close(), when nobody holds it any more, and with
    this process, however that ends."""

    def __init__(self, program, options):
        self._complaints = tempfile.TemporaryFile(mode="w+")
        command = [program, "serve", *options, "--port", "0", "--json"]
        process = subprocess.Popen(["/bin/sh", "-c", WITH_WATCH, "airside-gym", *command], stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE, stderr=self._complaints, text=True, start_new_session=True)
        self.pid = process.pid
        self._process, self._end, self._client = process, weakref.finalize(self, _end, process), None
        try:
            told = process.stdout.readline()
            if not told:
                self._explain(None)
            self.facts = json.loads(told)
            host, port = self.facts["address"].rsplit(":", 1)
            self._client = Client(host, int(port))
        except BaseException:
            self.close()
            raise

    def exchange(self, requests):
        """Client.exchange(); where that fails, the complaint of a program that has ended is told too."""
        try:
            return self._client.exchange(requests)
        except AirsideError as cause:
            self._explain(cause)

    def _explain(self, cause):
        """Raises what the program said, or `cause` where it has not ended."""
        try:
            status = self._process.wait(0.5 if cause else SECONDS_TO_END)
        except subprocess.TimeoutExpired:
            raise cause or AirsideError("airside serve has told no address and goes on; expected a line of JSON")
        self._complaints.seek(0)
        said = complaint_of(self._complaints.read(), status)
        raise AirsideError(f"{said}\n({cause})" if cause else said) from cause

    def close(self):
        if self._client is not None:
            self._client.close()
        self._end()
        self._complaints.close()
