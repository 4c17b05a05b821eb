"""The airside program: where it is, and whether it has the commands that a campaign runs."""

import re
import shutil
import subprocess
from pathlib import Path

from airside_campaign.complaint import BadInput


def find_program(name):
    """The program's path. Raises BadInput where there is none."""
    found = shutil.which(name)
    if found is None:
        raise BadInput(
            "--program",
            f"{name}, which is no program here",
            "the airside program",
            "put it into the PATH, or name it with --program",
        )
    return Path(found).resolve()


def check_commands(campaign, program):
    """Asks the program once for each first word of a job. Raises BadInput for one that is no command of it."""
    entries = {}
    for job in campaign.jobs:
        entries.setdefault(job.run[0], job.entry)
    for word, entry in entries.items():
        try:
            asked = subprocess.run(
                [program, word, "--help"], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL
            )
        except OSError as error:
            raise BadInput(
                "--program",
                f"{program}, which does not run ({error.strerror.lower()})",
                "the airside program",
                "name another with --program",
            ) from error
        if asked.returncode:
            near = re.search(r"did you mean (\S+)\?", asked.stderr)
            raise BadInput(
                f"{campaign.path}: job {entry + 1}: run",
                f"{word}, which is no command of {program}",
                f"one that `{program} --help` lists",
                f"did you mean {near[1]}?" if near else "correct it",
            )
