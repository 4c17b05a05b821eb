"""airside-campaign: runs campaign.toml, on this machine or on a Ray cluster."""

import argparse
import json
import os
import subprocess
import sys

from airside_campaign import one_job
from airside_campaign.campaign_file import read_campaign
from airside_campaign.complaint import BadInput
from airside_campaign.keys import add_keys
from airside_campaign.page import write_page
from airside_campaign.program import check_commands, find_program
from airside_campaign.results import missing_figures, rows_of, write_parquet
from airside_campaign.run import Folder, OnRay, Serial, check_cpus, run_jobs

EXAMPLE = """\
# Six trainings, and what each is worth in the room that it was trained for. {room} and {seed} are values of `over`,
# {out} is the job's own folder, {train} that of the job which `after` names, {dir} the folder of this file.
[campaign]
out = "runs"             # beside this file
retries = 2              # of a job whose machine was lost

[[job]]
name = "train-{room}-{seed}"
run = ["pretrain", "--plant", "rc", "--room", "{room}", "--seed", "{seed}", "--days", "14", "-o", "{out}/weights.blob",
       "--json"]
over = {room = ["301", "401"], seed = [1, 2, 3]}

[[job]]
name = "control-{room}-{seed}"
after = {train = "train-{room}-{seed}"}
run = ["simulate", "--plant", "rc", "--room", "{room}-real", "--seed", "{seed}", "--weights", "{train}/weights.blob",
       "--transfer", "--days", "7", "--json"]
over = {room = ["301", "401"], seed = [1, 2, 3]}
figures = ["dae_degc", "darv_degc", "hvac_kwh_per_day"]
"""


def parser():
    p = argparse.ArgumentParser(
        prog="airside campaign",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Jobs that are done are left out: a campaign that was stopped goes on with the same command.\n"
        "Exit codes: 0 all done; 1 bad input, or jobs that failed; 2 bad command line.",
    )
    p.add_argument("file", nargs="?", help="campaign.toml (docs/campaigns.md)")
    p.add_argument("--address", help="of a Ray cluster, such as 10.0.0.5:6379; without: this machine")
    p.add_argument(
        "--jobs", type=int, default=os.cpu_count(), metavar="N", help="processes on this machine (default: %(default)s)"
    )
    p.add_argument("--serial", action="store_true", help="one after the other, without Ray")
    p.add_argument(
        "--program",
        default="airside",
        help="the program that jobs run (default: airside of the PATH)",
    )
    p.add_argument(
        "--list", action="store_true", help="run nothing: each job, its key, whether it is done, its command"
    )
    p.add_argument("--example", action="store_true", help="print a campaign file to begin with")
    p.add_argument("--json", action="store_true", help="print one JSON object and nothing else on standard output")
    return p


def is_done(campaign, job):
    return one_job.is_done(campaign.out / "jobs" / job.key)


def listed(campaign):
    for job in campaign.jobs:
        print(f"{job.key}  {'done' if is_done(campaign, job) else 'open'}  {job.name}: airside {' '.join(job.command)}")
    return 0


def older_failures(campaign, folder):
    """Says which folders there are of no job of this file; they stay, since nobody asked to lose them."""
    keys = {job.key for job in campaign.jobs}
    older = sorted(path.name for path in (folder.path / "failed").glob("*") if path.name not in keys)
    if not older:
        return ""
    return f"; of no job of this file, so free to be deleted: {', '.join(older[:5])}" + (
        f" and {len(older) - 5} more" if len(older) > 5 else ""
    )


def run(arguments):
    campaign = read_campaign(arguments.file)
    program = find_program(arguments.program)
    check_commands(campaign, program)
    used = add_keys(campaign, program)
    if arguments.list:
        return listed(campaign)
    folder = Folder(campaign.out)
    with os.fdopen(os.dup(2), "w", encoding="utf-8") as people:  # stays theirs while Ray's words go into a file
        if arguments.serial or all(is_done(campaign, job) for job in campaign.jobs):  # Ray takes seconds to start
            executor = Serial()
        else:
            executor = OnRay(arguments.address, arguments.jobs, campaign.retries, folder.path / "ray.log")
        try:
            check_cpus(campaign, executor)
            records = run_jobs(campaign, folder, program, used, executor, people)
        finally:
            executor.close()
            folder.clear()
    rows = rows_of(campaign, folder, records)
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout.strip()
    try:
        write_parquet(rows, folder.path / "results.parquet")
        write_page(campaign, rows, version, folder.path / "index.html")
    except OSError as error:
        raise BadInput(
            error.filename or folder.path,
            error.strerror.lower(),
            "room for the results",
            "make room; jobs that are done stay",
        ) from error
    for complaint in missing_figures(campaign, rows):
        print(f"airside campaign: {complaint}", file=sys.stderr)
    failed = [row for row in rows if not row["done"]]
    if arguments.json:
        kept = sum(bool(r.get("kept")) for r in records.values())
        print(
            json.dumps(
                {
                    "jobs": len(rows),
                    "done": len(rows) - len(failed),
                    "kept": kept,
                    "failed": [{"job": r["job"], "why": r["why"]} for r in failed],
                    "results": str(folder.path / "results.parquet"),
                    "page": str(folder.path / "index.html"),
                }
            )
        )
    else:
        for row in failed[:20]:
            print(f"{row['job']}: {row['why']}", file=sys.stderr)
        if failed:
            print(
                f"{len(failed)} of {len(rows)} jobs failed; what they left is in {folder.path / 'failed'}"
                + older_failures(campaign, folder),
                file=sys.stderr,
            )
        print(f"{folder.path / 'results.parquet'}\n{folder.path / 'index.html'}")
    return 1 if failed else 0


def main(words=None):
    arguments = parser().parse_args(words)
    if arguments.example:
        print(EXAMPLE, end="")
        return 0
    if arguments.file is None:
        parser().error("no campaign file; --example prints one to begin with")
    if arguments.jobs is not None and arguments.jobs < 1:
        parser().error(f"--jobs: found {arguments.jobs}; expected 1 or more")
    try:
        return run(arguments)
    except BadInput as error:
        print(f"airside campaign: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:  # whoever read the list has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("\nairside campaign: stopped; the same command goes on", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
