"""Runs the commands of documents as a reader would type them: python3 run_commands.py BIN DOCUMENT...

Blocks that begin with ```sh are run, one document in one shell and one empty folder, with the programs of BIN in the
PATH. ```sh elsewhere: REASON is not run here: its shell grammar, programs, subcommands and options are checked instead,
as are all commands in backticks (--names). A block ```output behind one of ```sh is what the commands show: `...` in a
line stands for anything, and alone for any lines. Port 1502 is exchanged for a free one: tests can run side by side."""

import argparse
import glob
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import tempfile

from documents import blocks, documents, text_of

PORT = "1502"
PROGRAMS = ("airside", "airsided", "airside-page", "airside-mqtt", "airside-bench")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def reference_buildings(root):
    """The folder of EnergyPlus models that other people wrote; empty where tools/setup has not installed them."""
    venv = os.environ.get("AIRSIDE_VENV", os.path.join(root, "build", "venv"))
    found = glob.glob(os.path.join(venv, "lib", "python3*", "site-packages", "pyenergyplus", "data", "model"))
    return os.environ.get("AIRSIDE_FOREIGN_MODELS", found[0] if found else "")


def script_of(document, found, port):
    lines = ["set -euo pipefail"]
    for block in found:
        lines.append(f"echo '== {document}:{block.line}'")
        lines.append(block.text)
    return "\n".join(lines).replace(PORT, port)


def shown_by(fenced):
    """The block of output that stands behind a block of commands, by the line of that block."""
    return {block.line: following for block, following in zip(fenced, fenced[1:])
            if block.language == "sh" and following.language == "output"}


def pattern_of(shown):
    """`...` stands for anything in its line, and for any lines where it is alone."""
    lines = ["(?:.*\n)*?" if line == "..." else re.escape(line).replace(r"\.\.\.", ".*") + "\n"
             for line in shown.rstrip("\n").split("\n")]
    return "".join(lines)


def complaints_of_output(document, output, shown):
    """Blocks of output that are not what came."""
    said = dict(re.findall(r"^== %s:(\d+)\n((?:(?!== ).*\n)*)" % re.escape(document), output, re.MULTILINE))
    for line, block in shown.items():
        if re.fullmatch(pattern_of(block.text), said.get(str(line), "")) is None:
            yield f"{document}:{block.line}: the commands above show something else:\n{said.get(str(line), '')[-3000:]}"


def run(bin_dir, document, found, shown, seconds):
    """Whether all blocks ended with exit code 0 and showed what they should. What they leave running is ended."""
    port = free_port()
    with tempfile.TemporaryDirectory(prefix="airside-docs-") as top:
        folder = os.path.join(top, "empty")
        os.mkdir(folder)
        environment = {**os.environ, "PATH": bin_dir + os.pathsep + os.environ["PATH"], "HOME": folder}
        with open(os.path.join(top, "output"), "w+", encoding="utf-8", errors="replace") as file:
            shell = subprocess.Popen(["bash", "-c", script_of(document, found, port)], cwd=folder, env=environment,
                                     stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT,
                                     start_new_session=True)
            try:
                shell.wait(timeout=seconds)
                ended = f"exit code {shell.returncode}"
            except subprocess.TimeoutExpired:
                ended = f"not done after {seconds} s"
            finally:
                try:
                    os.killpg(shell.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
                shell.wait()
            file.seek(0)
            output = file.read().replace(port, PORT)
        if ended != "exit code 0":
            print(output[-6000:])
            print(f"{document}: {ended}; expected 0. The last \"==\" above names the block")
            return False
        wrong = list(complaints_of_output(document, output, shown))
        print("\n".join(wrong))
        return not wrong


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
        fenced = blocks(text_of(os.path.join(root, document)))
        shown = shown_by(fenced)
        shell = [block for block in fenced if block.language == "sh"]
        here = [block for block in shell if not block.info]
        if any("AIRSIDE_FOREIGN_MODELS" in block.text for block in here):
            models = reference_buildings(root)
            if not os.path.isdir(models):
                print(f"{document}: NOT CHECKED: the reference buildings are not installed; run tools/setup --for test")
                return 77
            os.environ["AIRSIDE_FOREIGN_MODELS"] = models
        good = (not here or run(bin_dir, document, here, shown, chosen.seconds)) and good
        print(f"{document}: {len(here)} blocks run, {len(shown)} shown outputs compared, "
              f"{len(shell) - len(here)} blocks are run elsewhere")
        for block in shell:
            if block.info:
                print(f"  line {block.line}, {block.info}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
