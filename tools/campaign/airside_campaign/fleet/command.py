"""Sends signed weights to many boxes: a canary share first, then waves. It halts by itself when trials end badly."""

import argparse
import functools
import json
import os
import sys
import tempfile
import time

from airside_campaign.complaint import BadInput
from airside_campaign.fleet.box import unfit
from airside_campaign.fleet.boxes import PHASES, Boxes
from airside_campaign.fleet.fleet_file import EXAMPLE, read_fleet
from airside_campaign.fleet.push import Halt, Push
from airside_campaign.fleet.record import Record, read_states
from airside_campaign.fleet.undo import take_back
from airside_campaign.fleet.weights import check_again, read_weights
from airside_campaign.program import find_program

EPILOG = """\
  airside fleet push --example > fleet.toml
  airside fleet push fleet.toml --blob room301.blob --dry-run
  airside fleet push fleet.toml --blob room301.blob      again after a stop: it goes on, and sends nothing twice
  airside fleet status fleet.toml
  airside fleet undo fleet.toml 3f2a91c0
Exit codes: 0 all boxes keep the weights (status: all answer and none has an alarm; undo: all went back);
1 bad input, halted, or boxes that were not reached; 2 bad command line."""


MOST_LINES = 20  # of single boxes; --json has all


def parser():
    """And those of the actions, by name."""
    p = argparse.ArgumentParser(
        prog="airside fleet", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG
    )
    p.add_argument("--program", default="airside", help=argparse.SUPPRESS)
    actions = p.add_subparsers(dest="action", required=True, metavar="ACTION")

    def action(name, text):
        a = actions.add_parser(name, help=text, description=text)
        a.add_argument("file", nargs="?" if name == "push" else None, metavar="FILE", help="fleet.toml (docs/fleet.md)")
        a.add_argument("--json", action="store_true", help="print one JSON object and nothing else on standard output")
        return a

    push = action("push", "send signed weights to every box, in waves; the same command goes on after a stop")
    push.add_argument("--blob", metavar="FILE", help="the weights, signed and for any site")
    push.add_argument("--from-library", metavar="DIGEST", help="the weights, from a library: first 8 or more digits")
    push.add_argument(
        "--library", metavar="ADDRESS", help="whose revoked weights are refused (default: $AIRSIDE_LIBRARY, else none)"
    )
    push.add_argument(
        "--library-keys",
        metavar="PLACE",
        help="whose index is believed (default: $AIRSIDE_LIBRARY_KEYS, else ./keys)",
    )
    push.add_argument("--at-least", type=int, default=0, metavar="SERIAL", help="refuse an index that is older")
    push.add_argument("--dry-run", action="store_true", help="check everything, print the waves, send nothing")
    push.add_argument("--by", metavar="NAME", help="for the ledger (default: the user's name)")
    push.add_argument("--example", action="store_true", help="print a fleet file to begin with")
    action("status", "ask every box what it does and what became of pushed weights; with the last push")
    undo = action("undo", "let every box of a push return to the weights before it")
    undo.add_argument("digest", metavar="DIGEST", help="of the pushed weights: its first 8 or more digits")
    undo.add_argument("--by", metavar="NAME", help="for the ledger (default: the user's name)")
    return p, actions.choices


def span(seconds):
    minutes = int(seconds / 60 + 0.5)
    if minutes < 60:
        return f"{minutes} min"
    if minutes < 2880:
        return f"{minutes // 60} h {minutes % 60} min"
    return f"{minutes // 1440} d {minutes // 60 % 24} h"


class Progress:
    """A line where something has changed, and each ten minutes."""

    def __init__(self, stream):
        self.stream, self.said, self.text = stream, 0.0, None

    def __call__(self, push):
        counts = {phase: len(push.named(phase)) for phase in PHASES}
        text = f"wave {push.at_wave()} of {len(push.fleet.waves)}: of {len(push.fleet.boxes)} boxes "
        text += ", ".join(f"{n} {phase}" for phase, n in counts.items() if n)
        if text == self.text and time.monotonic() - self.said < 600:
            return
        self.text, self.said = text, time.monotonic()
        about, most = push.left_s()
        left = f"; about {span(about)} left, at most {span(most)}" if about or most else ""
        print(f"  {text}{left}", file=self.stream, flush=True)


def some(names, most=12):
    names = list(names)
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def report(push, halted, as_json):
    by_phase = {phase: push.named(phase) for phase in PHASES}
    missing = {n: push.unfit.get(n, "not its turn yet") for n in push.fleet.boxes if push.phase(n) is None}
    all_kept = len(by_phase["kept"]) == len(push.fleet.boxes)
    if as_json:
        boxes = {
            n: {k: b[k] for k in ("phase", "wave", "why") if k in b} for n, b in push.record.state["boxes"].items()
        }
        out = {"weights": push.weights.digest, "crc": push.weights.crc, "all_kept": all_kept, "halted": halted}
        print(json.dumps(out | {"boxes": boxes, "not_sent": missing}, ensure_ascii=False))
        return 0 if all_kept else 1
    print(f"weights {push.weights.digest[:12]} ({push.weights.crc})")
    for phase, names in by_phase.items():
        if names:
            print(f"{len(names):6} {phase}: {some(names)}")
    if missing:
        print(f"{len(missing):6} not sent: {some(missing)}")
    for name in [n for n in missing if n in push.unfit][:MOST_LINES]:
        print(f"{name}: {missing[name]}", file=sys.stderr)
    for name in [n for n, b in push.record.state["boxes"].items() if b.get("why") and b["phase"] != "kept"][
        :MOST_LINES
    ]:
        print(f"{name}: {push.phase(name)}: {push.of(name)['why']}", file=sys.stderr)
    if halted:
        print(
            f"airside fleet: halted, {halted}; boxes that rolled back use the weights before. To take the others back: "
            f"airside fleet undo {push.fleet.path} {push.weights.digest[:12]}",
            file=sys.stderr,
        )
    return 0 if all_kept else 1


def push_command(arguments, program):
    fleet = read_fleet(arguments.file)
    record = Record(fleet.out, arguments.by)
    with tempfile.TemporaryDirectory(prefix="airside-fleet-") as folder:
        weights = read_weights(arguments, fleet, program, folder)
        if arguments.dry_run:
            record.open(weights)
            return dry_run(Push(fleet, weights, program, record), arguments.json)
        with record.alone():
            record.open(weights)
            again = functools.partial(check_again, arguments, fleet, program, weights, folder)
            push = Push(fleet, weights, program, record, Progress(sys.stderr), again)
            push.check()
            source = arguments.blob or f"library {arguments.from_library}"
            record.set({}, [{"event": "push", "source": source, "boxes": len(fleet.boxes), "crc": weights.crc}])
            halted = None
            try:
                push.run()
            except Halt as error:
                halted = str(error)
            record.note({"event": "end", "kept": len(push.named("kept"))})
            return report(push, halted, arguments.json)


def dry_run(push, as_json):
    waves = push.plan(push.check())
    nobody = bool(push.unfit) and not any(waves)
    if as_json:
        out = {"weights": push.weights.digest, "crc": push.weights.crc, "waves": waves, "not_fit": push.unfit}
        print(json.dumps(out, ensure_ascii=False))
        return 1 if nobody else 0
    for number, names in enumerate(waves, 1):
        print(f"wave {number}: {len(names)} boxes: {some(names)}")
    for name, why in push.unfit.items():
        print(f"not now: {name}: {why}")
    if nobody:
        print("airside fleet: no box is fit for these weights now, so a push would send nothing", file=sys.stderr)
        return 1
    print(f"nothing was sent; at least {span(86400 * sum(bool(names) for names in waves))}, a day of trial a wave")
    return 0


def status_command(arguments, program):
    fleet = read_fleet(arguments.file)
    rows = {}
    for name, seen in Boxes(fleet, program).seen(fleet.boxes).items():
        if isinstance(seen, Exception):
            rows[name] = {"condition": "no answer", "why": str(seen)}
            continue
        keys = ("time", "topology", "state", "condition", "alarms", "crc", "weights", "refusal")
        rows[name] = {key: getattr(seen, key) for key in keys} | {"why": unfit(seen, seen.crc)}
    pushes = read_states(fleet.out)
    last = None
    if pushes:
        counts = {p: sum(b["phase"] == p for b in pushes[-1]["boxes"].values()) for p in PHASES}
        last = {key: pushes[-1].get(key) for key in ("digest", "crc", "begun", "halted", "undone")}
        last["boxes"] = {phase: n for phase, n in counts.items() if n}
    fit = all(row["condition"] == "running" for row in rows.values())
    if arguments.json:
        print(json.dumps({"boxes": rows, "last_push": last}, ensure_ascii=False))
        return 0 if fit else 1
    groups = {}
    for row in rows.values():
        key = (row["condition"], row.get("state", ""), row.get("crc", ""), row.get("weights", ""))
        groups[key] = groups.get(key, 0) + 1
    for (condition, state, crc, weights), count in sorted(groups.items(), key=lambda item: -item[1]):
        pushed = f"weights {crc} {weights}" if weights not in ("", "none") else "no weights pushed" if weights else ""
        print(f"{count:6}  {condition:10} {state:8} {pushed}".rstrip())
    bad = [name for name, row in rows.items() if row["condition"] != "running"]
    for name in bad[:MOST_LINES]:
        print(f"{name}: {rows[name]['why']}", file=sys.stderr)
    if len(bad) > MOST_LINES:
        print(f"and {len(bad) - MOST_LINES} more; --json has them all", file=sys.stderr)
    if last:
        print(f"last push: {last['digest'][:12]}, begun {last['begun']}: {last['boxes']}")
        if last["halted"]:
            print(f"halted, {last['halted']['why']}")
    return 0 if fit else 1


def one_push(fleet, digest):
    """Its state, by the first digits. Raises BadInput."""
    known = read_states(fleet.out)
    found = [state for state in known if state["digest"].startswith(digest)]
    if len(digest) >= 8 and len(found) == 1:
        return found[0]
    remedy = "give one of " + some((state["digest"][:12] for state in known), 4) if known else "nothing is to be undone"
    raise BadInput("DIGEST", f"{len(found)} pushes of {digest}", "one, by its first 8 or more digits", remedy)


def undo_command(arguments, program):
    fleet = read_fleet(arguments.file)
    record = Record(fleet.out, arguments.by)
    one_push(fleet, arguments.digest)  # a wrong number leaves no folder and no lock
    with record.alone():
        record.state = one_push(fleet, arguments.digest)
        record.path = fleet.out / f"{record.state['digest'][:16]}.json"

        def progress(left, missing):
            if left:
                print(f"  {left} boxes have not gone back yet", file=sys.stderr, flush=True)

        missing = take_back(fleet, program, record, progress)
    done = [name for name, box in record.state["boxes"].items() if box["phase"] == "undone"]
    if arguments.json:
        print(json.dumps({"weights": record.state["digest"], "undone": done, "not": missing}, ensure_ascii=False))
        return 1 if missing else 0
    print(f"{len(done)} boxes went back; {len(missing)} did not")
    for name, why in missing.items():
        print(f"{name}: {why}", file=sys.stderr)
    return 1 if missing else 0


def main(words=None):
    p, actions = parser()
    arguments, unknown = p.parse_known_args(words)
    p = actions[arguments.action]  # an error shows the usage of the action
    if unknown:
        p.error("unrecognized arguments: " + " ".join(unknown))
    if arguments.action == "push":
        if arguments.example:
            print(EXAMPLE, end="")
            return 0
        if arguments.file is None:
            p.error("no fleet file; airside fleet push --example prints one to begin with")
        if (arguments.blob is None) == (arguments.from_library is None):
            p.error("give the weights by one of --blob and --from-library")
    try:
        commands = {"push": push_command, "status": status_command, "undo": undo_command}
        return commands[arguments.action](arguments, find_program(arguments.program))
    except BadInput as error:
        print(f"airside fleet: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("\nairside fleet: stopped; boxes go on with their trials, and the same command goes on", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
