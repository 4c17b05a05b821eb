"""A yard of real boxes for tests of `airside fleet`: each an airsided beside an RC room of its own behind Modbus TCP.
All clocks run SPEED times as fast."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ["AIRSIDE_BIN"])
SPEED = 5000  # a row each 0.07 s, a day of trial in 17 s
TOPOLOGY = "1vav-0fcu-0power"  # the smallest
CYCLE_MIN = 24  # the fewest decisions
SKIPPED_POINTS = ("clock_s", "clock_advance_s", "heartbeat")  # boxes have their own clock; a beat would come each 7 ms
sys.path.insert(0, str(ROOT / "tools" / "campaign"))
from airside_campaign.fleet.weights import crc32c


def worse(path, to, degc):
    """Weights whose network is wrong by so much in every forecast: the bias of its last layer, and a right digest."""
    blob = bytearray(path.read_bytes())
    scale_at = 192 + 6 * 8  # after the means of the six inputs of TOPOLOGY
    parameters = int.from_bytes(blob[92:96], "little")
    bias_at = 192 + 2 * 6 * 8 + 4 * (parameters - 1)
    (scale,) = memoryview(blob)[scale_at : scale_at + 8].cast("d")
    view = memoryview(blob)[bias_at : bias_at + 4].cast("f")
    view[0] = view[0] + degc / scale
    view.release()
    blob[104:136] = bytes(32)
    blob[104:108] = crc32c(blob[:-64]).to_bytes(4, "little")
    to.write_bytes(blob)


class Yard:
    """`names`: of the boxes. Each has a folder with site.toml, state, log and inbox."""

    def __init__(self, names):
        memory = Path("/dev/shm")
        self.folder = Path(
            tempfile.mkdtemp(prefix="airside-fleet-", dir=memory if os.access(memory, os.W_OK) else None)
        )
        self.names, self.children = list(names), []
        self.environment = dict(os.environ, PYTHONPATH=str(ROOT / "tools" / "campaign"), TZ="UTC")

    def airside(self, *words):
        done = subprocess.run(
            [str(BIN / "airside"), *map(str, words)], cwd=self.folder, capture_output=True, text=True, check=False
        )
        if done.returncode:
            raise AssertionError(done.stderr)

    def make_weights(self):
        """One training, signed thrice by Ann: as it is, and worse; once by Bob, whom no box knows."""
        self.airside("init", "plan", "--topology", TOPOLOGY, "--name", "plan")
        site = self.folder / "plan" / "site.toml"
        site.write_text(site.read_text().replace("cycle_min = 18", f"cycle_min = {CYCLE_MIN}"))
        self.airside(
            "pretrain", "--plant", "rc", "--room", "301", "--site", "plan/site.toml", "--days", "7", "-o", "first.blob"
        )
        (self.folder / "keys").mkdir()
        for name in ("ann", "bob"):
            self.airside("keygen", "-o", name)
        shutil.copy(self.folder / "ann.pub", self.folder / "keys")
        worse(self.folder / "first.blob", self.folder / "worse.blob", 2.0)
        for blob, key, out, counter in (
            ("worse.blob", "ann.key", "bad.blob", 1),
            ("first.blob", "ann.key", "good.blob", 2),
            ("first.blob", "bob.key", "unknown.blob", 3),
        ):
            self.airside("sign", blob, "--key", key, "-o", out, "--counter", counter)

    def make_sites(self):
        points = (self.folder / "plan" / "points.csv").read_text().splitlines(keepends=True)
        points = "".join(row for row in points if not row.startswith(SKIPPED_POINTS))
        text = (self.folder / "plan" / "site.toml").read_text()
        for old, new in (
            ('blob = ""', 'blob = "../first.blob"'),
            ('keys = "keys"', 'keys = "../keys"'),
            (
                "[controller.override]",
                "[controller.override]\nbatch = 16\nrecent_in_batch = 4\nupdates_per_cycle = 0\n#",
            ),
            ("deadline_s = 5.0", "deadline_s = 10.0"),
            ("heartbeat_s = 20.0", "heartbeat_s = 360.0"),
        ):
            if old not in text:
                raise AssertionError(old)
            text = text.replace(old, new)
        for name in self.names:
            site = self.folder / name
            site.mkdir()
            (site / "points.csv").write_text(points)
            (site / "site.toml").write_text(text.replace('name = "plan"', f'name = "{name}"'))

    def start(self, words, said, **more):
        with open(said, "ab") as out:
            child = subprocess.Popen(
                [str(word) for word in words], stdout=out, stderr=out, stdin=subprocess.DEVNULL, **more
            )
        self.children.append(child)
        return child

    def start_boxes(self):
        for name in self.names:
            site = self.folder / name
            words = [
                BIN / "airside",
                "serve",
                "--site",
                site / "site.toml",
                "--plant",
                "rc",
                "--room",
                "301",
                "--port",
                "0",
            ]
            words += ["--speed", SPEED, "--days", "300", "--ready", site / "ready"]
            self.start(words, site / "plant.txt")
        self.until(lambda: all((self.folder / name / "ready").exists() for name in self.names), 60)
        for name in self.names:
            site = self.folder / name
            port = (site / "ready").read_text().strip().rsplit(":", 1)[1]
            text = (site / "site.toml").read_text()
            (site / "site.toml").write_text(text.replace("port = 502", f"port = {port}"))
            # The room began at midnight; this zone lets the box have the same hour.
            at_room_s = (time.time() - (site / "ready").stat().st_mtime) * SPEED
            west = int(time.time() - at_room_s) % 86400
            zone = f"BOX+{west // 3600:02}:{west // 60 % 60:02}:{west % 60:02}"
            words = [BIN / "airsided", "--site", site / "site.toml", "--clock-speed", SPEED, "--crash-limit", "0"]
            self.start([*words, "--no-sync"], site / "daemon.txt", env=dict(os.environ, TZ=zone))

    def start_page(self, name):
        """The page of a box, with a key for programs. Returns its address."""
        site = self.folder / name
        words = [str(BIN / "airside-page"), "--site", str(site / "site.toml")]
        made = subprocess.run([*words, "--new-key", "installer"], capture_output=True, text=True, check=True)
        (site / "access").write_text(made.stdout)
        self.page = self.start([*words, "--port", "0", "--ready", site / "page-ready"], site / "page.txt")
        self.until(lambda: (site / "page-ready").exists())
        return "http://" + (site / "page-ready").read_text().strip().removeprefix("http://")

    def until(self, is_so, limit_s=60):
        begun = time.monotonic()
        while not is_so():
            if time.monotonic() - begun > limit_s:
                raise AssertionError(f"not within {limit_s} s")
            time.sleep(0.1)

    def status(self, name):
        try:
            return json.loads((self.folder / name / "state" / "status.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    def said(self, name):
        return (self.folder / name / "daemon.txt").read_text(encoding="utf-8", errors="replace")

    def fleet_words(self, *words):
        words = [str(word) for word in words]
        return [sys.executable, "-B", "-m", "airside_campaign.fleet.command", "--program", str(BIN / "airside"), *words]

    def fleet(self, *words):
        return subprocess.run(
            self.fleet_words(*words),
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=400,
        )

    def fleet_file(self, text, name="fleet.toml"):
        (self.folder / name).write_text(text, encoding="utf-8")

    def ledger(self, out="fleet-push"):
        path = self.folder / out / "ledger.jsonl"
        return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []

    def stop(self):
        for child in self.children:
            child.send_signal(signal.SIGTERM)
        for child in self.children:
            try:
                child.wait(10)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()

    def clear(self):
        self.stop()
        shutil.rmtree(self.folder, ignore_errors=True)
