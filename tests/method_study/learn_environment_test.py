"""tools/learn_environment on a room whose law is known: what it finds, what its file holds, what it refuses."""

import json
import math
import random
import os
import subprocess
import sys
import tempfile
from datetime import datetime, timedelta
from pathlib import Path

TOOL = Path(__file__).resolve().parents[2] / "tools" / "learn_environment"
HEAD = "time,room_temp_1_degc,vav_on_1,mau_temp_degc,outdoor_temp_degc,rain,setpoint_degc,supply_temp_degc"
SKIPPED = 77


def write_log(path, days=9, noise_k=0.01):
    """dS = 0.2 (A + 3 - S) + 0.02 (outdoors - 30) in a row, and noise."""
    draw = random.Random(1)
    room, lines, setpoint = 25.0, [HEAD], 22.0
    for row in range(240 * days):
        outdoors = 30 + 4 * math.sin(2 * math.pi * row / 240)
        if row % 3 == 0:
            setpoint = 22 + draw.uniform(-1, 1)
        time = datetime(2021, 5, 1) + timedelta(minutes=6 * row)
        lines.append(f"{time.isoformat()},{room:.3f},1,18,{outdoors:.3f},0,{setpoint:.3f},{setpoint:.3f}")
        room += 0.2 * (setpoint + 3 - room) + 0.02 * (outdoors - 30) + draw.gauss(0, noise_k)
    path.write_text("\n".join(lines) + "\n")


def run(*words):
    return subprocess.run([sys.executable, "-B", str(TOOL), *map(str, words)], capture_output=True, text=True)


def check(holds, said):
    if not holds:
        sys.exit(f"learn_environment_test: {said}")


def learns_the_law(folder):
    log, model = folder / "room.csv", folder / "environment.json"
    write_log(log)
    done = run(log, "-o", model, "--epochs", 40, "--json")
    check(done.returncode == 0, done.stderr)
    found = json.loads(done.stdout)
    check(found["train_days"] == 6 and found["test_days"] == 3, found)
    check(found["one_step_error_k"] < 0.03 < found["persistence_error_k"], found)
    check(found["setpoint_slope_positive_share"] > 0.99 and found["accepted"], found)
    check(abs(found["setpoint_slope_mean"] - 0.2) < 0.05, found)
    held = json.loads(model.read_text())
    check(held["log"] == "room.csv" and held["test_from"] == "2021-05-07", held["test_from"])
    check([len(held["layers"][0]["weight"]), len(held["layers"][0]["weight"][0])] == [128, 6], "shape of layer 0")
    before = model.read_bytes()
    run(log, "-o", model, "--epochs", 40)
    check(model.read_bytes() == before, "the same log gave another file")


def says_when_it_is_no_good(folder):
    log = folder / "noise.csv"
    write_log(log, days=6, noise_k=0.3)
    done = run(log, "-o", folder / "bad.json", "--epochs", 10)
    check(done.returncode == 0 and "not accepted" in done.stdout, done.stdout + done.stderr)


def refuses(folder):
    bad = folder / "bad.csv"
    for text, part in (("a,b\n1,2\n", "setpoint_degc"), (HEAD + "\n2021-05-01T00:00:00,warm,1,18,30,0,22,22\n", "warm"),
                       (HEAD + "\n2021-05-01T00:00:00,25,1,18,30,0,22,22\n", "1 days; expected at least 3")):
        bad.write_text(text)
        done = run(bad, "-o", folder / "none.json")
        check(done.returncode != 0 and part in done.stderr and "Traceback" not in done.stderr, done.stderr)
    check(not (folder / "none.json").exists(), "a file was written for a log that was refused")
    done = run(folder / "missing.csv", "-o", folder / "none.json")
    check(done.returncode != 0 and "missing.csv" in done.stderr and "Traceback" not in done.stderr, done.stderr)


def in_the_projects_python():
    """Runs this test again in the environment of tools/setup, which has numpy."""
    root = Path(__file__).resolve().parents[2]
    python = os.path.join(os.environ.get("AIRSIDE_VENV") or root / "build" / "venv", "bin", "python3")
    if os.environ.get("AIRSIDE_HERE") or not os.access(python, os.X_OK):
        print("*** NOT TESTED: no numpy in", sys.executable, "or", python, "***")
        sys.exit(SKIPPED)
    sys.exit(subprocess.run([python, "-B", __file__], env={**os.environ, "AIRSIDE_HERE": "1"}, check=False).returncode)


def main():
    try:
        import numpy  # noqa: F401
    except ImportError:
        in_the_projects_python()
    with tempfile.TemporaryDirectory() as folder:
        for test in (learns_the_law, says_when_it_is_no_good, refuses):
            test(Path(folder))
            print("passed", test.__name__)


main()
