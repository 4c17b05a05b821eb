"""A folder with a campaign file, and the command that runs it."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ["AIRSIDE_BIN"])
SHORT = '["simulate", "--plant", "rc", "--room", "{room}-real", "--seed", "{seed}", "--expert-days", "0", "--days", "1", "--method", "expert", "--json"]'


class Desk:
    def __init__(self, test):
        self.folder = Path(tempfile.mkdtemp(prefix="airside-campaign-"))
        test.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.environment = dict(os.environ, PYTHONPATH=str(ROOT / "tools" / "campaign"))

    def write(self, text, name="campaign.toml"):
        (self.folder / name).write_text(text, encoding="utf-8")

    def words(self, *words, file="campaign.toml"):
        return [
            sys.executable,
            "-B",
            "-m",
            "airside_campaign.command",
            str(self.folder / file),
            "--program",
            str(BIN / "airside"),
            *words,
        ]

    def commands(self, folder="runs/jobs"):
        """By the name of a job: what job.json says of it."""
        records = (json.loads(p.read_text()) for p in (self.folder / folder).glob("*/job.json"))
        return {record["name"]: record["command"] for record in records}

    def run(self, *words, file="campaign.toml"):
        return subprocess.run(
            self.words(*words, file=file),
            capture_output=True,
            text=True,
            check=False,
            env=self.environment,
            cwd=self.folder,
        )

    def files(self, out="runs"):
        """Every byte of the finished jobs."""
        jobs = self.folder / out / "jobs"
        return {str(p.relative_to(jobs)): p.read_bytes() for p in sorted(jobs.rglob("*")) if p.is_file()}
