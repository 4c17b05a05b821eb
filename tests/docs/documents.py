"""Reads the project's documents: which there are, their blocks of code, their headings and links."""

import os
import re
from dataclasses import dataclass

FOREIGN = {"build", "out", ".git", ".cache", "vendor", "__pycache__"}


def documents(root):
    """Paths of every .md file of the project, relative to `root`, in order."""
    found = []
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(name for name in folders if name not in FOREIGN)
        found += [os.path.relpath(os.path.join(folder, name), root) for name in sorted(files) if name.endswith(".md")]
    return found


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


@dataclass
class Block:
    """A fenced block of code: where it begins, its language, the rest of its info string, its text."""

    line: int
    language: str
    info: str
    text: str


def blocks(text):
    """The fenced blocks of a document. A fence that is never closed is a ValueError."""
    found, opened, lines = [], None, []
    for number, line in enumerate(text.split("\n"), 1):
        fence = re.match(r"\s*```([^\s`]*)\s*([^`]*)$", line)
        if not fence:
            lines.append(line)
        elif opened is None:
            opened, lines = (number, fence[1], fence[2].strip()), []
        else:
            found.append(Block(*opened, "\n".join(lines) + "\n"))
            opened = None
    if opened is not None:
        raise ValueError(f"line {opened[0]}: the block that begins here is not closed; close it with ```")
    return found


def prose_lines(text):
    """(number, line) of every line that is no code: neither fenced nor indented by four blanks."""
    fenced = False
    for number, line in enumerate(text.split("\n"), 1):
        if re.match(r"\s*```[^`]*$", line):
            fenced = not fenced
        elif not fenced and not line.startswith("    "):
            yield number, line


def without_code(line):
    """The line without what stands in backticks: names of files, keys and log words are no prose."""
    return re.sub(r"`[^`]*`", "``", line)


def anchors(text):
    """The anchors of a document's headings, as GitHub makes them."""
    found = set()
    for _, line in prose_lines(text):
        heading = re.match(r"#+\s+(.*?)\s*$", line)
        if heading:
            anchor = re.sub(r"[^\w\- ]", "", heading[1].replace("`", "").lower()).replace(" ", "-")
            number, once = 1, anchor
            while anchor in found:
                anchor = f"{once}-{number}"
                number += 1
            found.add(anchor)
    return found


def headings(text):
    """The documents' headings as they are read, without marks."""
    found = []
    for _, line in prose_lines(text):
        heading = re.match(r"#+\s+(.*?)\s*$", line)
        if heading:
            found.append(re.sub(r"[`*]", "", heading[1]))
    return found


def links(text):
    """(line, target) of every link and picture."""
    for number, line in prose_lines(text):
        for target in re.findall(r"\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)", without_code(line)):
            yield number, target
