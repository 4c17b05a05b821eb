"""What people do wrong with files, words and machines, each before a program: python3 run_careless.py BIN MODEL [NAME...]

A case breaks one thing in a folder of whole files and runs one command. The answer must name the place, what was
found, what was expected and what to do, with the case's words in each, and leave every file as it was. A mistake
that is no matter must be taken as it was meant. NAME is a part of the names of cases to run alone."""

import os
import pathlib
import re
import shutil
import sys
import tempfile

import cases_of_commands
import cases_of_logs
import cases_of_sites
import desk

TABLE = (("Log", cases_of_logs.LOGS), ("Model", cases_of_logs.WEATHER_AND_MODELS), ("Site", cases_of_sites.SITES),
         ("Points", cases_of_sites.POINT_MAPS), ("Answers", cases_of_sites.ANSWERS), ("Blob", cases_of_commands.BLOBS),
         ("Command", cases_of_commands.COMMANDS), ("Machine", cases_of_commands.MACHINES))
PARTS = ("place", "found", "expected", "remedy")
SAID = re.compile(r"^(?P<place>[^\n]*?): found (?P<found>[^\n]*); expected (?P<expected>[^\n]*?); (?P<remedy>[^\n]*)$",
                  re.MULTILINE)
FEWEST = 60


def falls_short(case, got, changed):
    """What is wrong with an answer, a line each."""
    text = (got.stderr + got.stdout).decode(errors="replace")
    wanted_code = 0 if case.want is None else case.code
    if got.returncode != wanted_code:
        yield f"exit code {got.returncode}, expected {wanted_code}"
    written = [name for name in changed if not any(name == one or name.startswith(one + "/") for one in case.leaves)]
    if written:
        yield f"changed {', '.join(written)}"
    if case.want is None:
        return
    said = SAID.search(text)
    if case.free or case.code == 2:
        yield from (f"no \"{word}\" ({part})" for part, word in zip(PARTS, case.want) if word not in text)
    elif said is None:
        yield "no line of the form PLACE: found FINDING; expected EXPECTATION; REMEDY"
    else:
        yield from (f"{part} is \"{said[part]}\", expected \"{word}\" in it"
                    for part, word in zip(PARTS, case.want) if word not in said[part])


def answers(bin_dir, whole, folder, case):
    """What falls short in the answer to `case`, and what the program said."""
    shutil.copytree(whole, folder)
    case.breaks(folder)
    desk.hand_over(folder)
    before = desk.state(folder)
    got = desk.run(bin_dir, folder, case.command)
    after = desk.state(folder)
    changed = sorted(name for name in {*before, *after} if before.get(name) != after.get(name))
    shutil.rmtree(folder)
    return list(falls_short(case, got, changed)), (got.stderr + got.stdout).decode(errors="replace")


def main(arguments):
    if len(arguments) < 2:
        sys.exit(__doc__)
    bin_dir, model, names = os.path.abspath(arguments[0]), arguments[1], arguments[2:]
    cases = [(f"{title}.{case.name}", case) for title, group in TABLE for case in group]
    if len({name for name, _ in cases}) < max(FEWEST, len(cases)):
        sys.exit(f"{len(cases)} cases; expected at least {FEWEST}, each of a name of its own")
    bad = 0
    with tempfile.TemporaryDirectory(prefix="airside-careless-") as top:
        os.chmod(top, 0o755)
        whole = pathlib.Path(top, "whole")
        whole.mkdir()
        desk.make(bin_dir, whole, model)
        chosen = [one for one in cases if not names or any(name in one[0] for name in names)]
        for name, case in chosen:
            wrong, text = answers(bin_dir, whole, pathlib.Path(top, "case"), case)
            bad += bool(wrong)
            if wrong or names:
                print(f"{name}: $ {case.command}\n{text.strip()[-700:]}")
            for line in wrong:
                print(f"  {name}: {line}")
    print(f"{len(chosen) - bad} of {len(chosen)} mistakes were answered as they should be")
    return 1 if bad or not chosen else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
