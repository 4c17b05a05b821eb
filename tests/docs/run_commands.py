"""Runs the commands of documents as a reader would type them: python3 run_commands.py BIN DOCUMENT...

Blocks that begin with ```sh are run, one document in one shell and one empty folder, with the programs of BIN in the
PATH. ```sh elsewhere: REASON is not run here: its shell grammar, programs, subcommands and options are checked instead,
as are all commands in backticks (--names). Port 1502 is exchanged for a free one: tests can run side by side."""

import argparse
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import tempfile

from documents import blocks, documents, text_of

PROGRAMS = ("airside", "airsided", "airside-page", "airside-mqtt", "airside-bench")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def script_of(document, found):
    lines = ["set -euo pipefail"]
    for block in found:
        lines.append(f"echo '== {document}:{block.line}'")
        lines.append(block.text)
    return "\n".join(lines).replace("1502", free_port())


def run(bin_dir, document, found, seconds):
    """Whether all blocks ended with exit code 0. What they leave running is ended with the folder."""
    with tempfile.TemporaryDirectory(prefix="airside-docs-") as folder:
        environment = {**os.environ, "PATH": bin_dir + os.pathsep + os.environ["PATH"], "HOME": folder}
        shell = subprocess.Popen(["bash", "-c", script_of(document, found)], cwd=folder, env=environment,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
        try:
            output, _ = shell.communicate(timeout=seconds)
            ended = f"exit code {shell.returncode}"
        except subprocess.TimeoutExpired as late:
            output, ended = (late.stdout or b"").decode(errors="replace"), f"not done after {seconds} s"
        finally:
            try:
                os.killpg(shell.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        if shell.returncode == 0:
            return True
        print(output[-6000:])
        print(f"{document}: {ended}; expected 0. The last \"==\" above names the block")
        return False


class Help:
    """What `--help` of a program and its subcommands says, asked once."""

    def __init__(self, bin_dir):
        self.bin_dir, self.known = bin_dir, {}

    def of(self, *words):
        if words not in self.known:
            program = os.path.join(self.bin_dir, words[0])
            got = subprocess.run([program, *words[1:], "--help"], capture_output=True, text=True, check=False)
            self.known[words] = got.stdout if got.returncode == 0 else None
        return self.known[words]


def subcommands(text):
    listed = text.split("\nSubcommands:\n", 1)
    return re.findall(r"^  (\S+)", listed[1], re.MULTILINE) if len(listed) == 2 else []


def complaints_of_names(words, said):
    """Program, subcommands and options of one command line exist. Words that stand for a value are not looked at."""
    path = [words[0]]
    text = said.of(*path)
    if text is None:
        return [f"{words[0]} --help fails"]
    rest = words[1:]
    while rest and rest[0] in subcommands(text):
        path.append(rest[0])
        text, rest = said.of(*path), rest[1:]
        if text is None:
            return [f"{' '.join(path)} --help fails"]
    if len(path) == 1 and subcommands(text) and rest and not rest[0].startswith("-") and rest[0].islower():
        return [f"{words[0]} has no command {rest[0]}"]
    parents = [said.of(*path[:n]) or "" for n in range(1, len(path) + 1)]
    options = {option for page in parents for option in re.findall(r"(?<![\w-])--?[a-z][\w-]*", page)} | {"--version"}
    return [f"{' '.join(path)} has no option {word}" for word in rest
            if re.fullmatch(r"--?[a-z][\w-]*(=.*)?", word) and word.split("=")[0] not in options]


def command_lines(text):
    """Single commands of a block of shell: comments, continued lines and pipes taken apart."""
    for line in text.replace("\\\n", " ").split("\n"):
        for part in re.split(r"\|\||&&|[|;&](?!\w)|\d?>", re.sub(r"(^|\s)#.*", "", line)):
            yield part.strip()


def complaints(root, document, said):
    text = text_of(os.path.join(root, document))
    fenced = blocks(text)
    lines = [(block.line, line) for block in fenced if block.language == "sh" for line in command_lines(block.text)]
    without_blocks = re.sub(r"```.*?```", lambda block: "\n" * block[0].count("\n"), text, flags=re.DOTALL)
    for number, line in enumerate(without_blocks.split("\n"), 1):
        lines += [(number, code) for code in re.findall(r"`([^`]+)`", line)]
    for number, line in lines:
        line = re.sub(r"^(sudo|time|env) +", "", line)
        line = re.sub(r"^(?:[A-Z_]+=\S+ +)*(?:build/release/bin/)?", "", line)
        try:
            words = shlex.split(line.replace("...", ""))
        except ValueError:
            continue
        if words and words[0] in PROGRAMS and len(words) > 1:
            yield from (f"{document}:{number}: {said_of}" for said_of in complaints_of_names(words, said))
        if words and re.match(r"\./?(tools|tests)/", words[0]) and not os.path.exists(os.path.join(root, words[0])):
            yield f"{document}:{number}: no {words[0]}"
    for block in fenced:
        if block.language != "sh":
            continue
        if block.info and not re.match(r"elsewhere: \S", block.info):
            yield f"{document}:{block.line}: found ```sh {block.info}; expected ```sh, or ```sh elsewhere: REASON"
        checked = subprocess.run(["bash", "-n"], input=block.text, capture_output=True, text=True, check=False)
        if checked.returncode:
            yield f"{document}:{block.line}: {checked.stderr.strip()}"


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    options.add_argument("bin", help="folder of the programs")
    options.add_argument("documents", nargs="*", help="relative to --root; with --names, all where none is given")
    options.add_argument("--root", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
    options.add_argument("--names", action="store_true", help="run nothing; check that what is named exists")
    options.add_argument("--seconds", type=float, default=500, help="of one document")
    chosen = options.parse_intermixed_args()
    bin_dir, root = os.path.abspath(chosen.bin), os.path.abspath(chosen.root)
    if not chosen.documents and not chosen.names:
        options.error("name the documents whose commands shall be run")
    good, said = True, Help(bin_dir)
    for document in chosen.documents or documents(root):
        if chosen.names:
            found = list(complaints(root, document, said))
            print("\n".join(found) if found else f"{document}: everything that it names exists")
            good = good and not found
            continue
        shell = [block for block in blocks(text_of(os.path.join(root, document))) if block.language == "sh"]
        here = [block for block in shell if not block.info]
        good = (not here or run(bin_dir, document, here, chosen.seconds)) and good
        print(f"{document}: {len(here)} blocks run, {len(shell) - len(here)} are run elsewhere")
        for block in shell:
            if block.info:
                print(f"  line {block.line}, {block.info}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
