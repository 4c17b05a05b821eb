"""No ten lines of code are there twice outside the tests."""

import re

from cpp_text import sources

LINES = 10
REMEDY = "give what both do one place"


def lines_of(text):
    """(number, line) of what counts: neither blank, brace, include nor comment alone; blanks inside count once."""
    kept = []
    for number, line in enumerate(text.split("\n"), 1):
        line = re.sub(r"\s+", " ", line).strip()
        if re.fullmatch(r"[{}()\[\];,\s]*", line) or re.match(r"#\s*include|#pragma once|//|using |namespace ", line):
            continue
        kept.append((number, line))
    return kept


def findings(root):
    texts = {path: lines_of(text) for path, text in sources(root)}
    first, found = {}, {}
    for path, lines in texts.items():
        at = 0
        while at + LINES <= len(lines):
            window = tuple(line for _, line in lines[at : at + LINES])
            other = first.setdefault(window, (path, at))
            if other == (path, at) or (other[0] == path and other[1] + LINES > at):
                at += 1
                continue
            other_path, other_at = other
            there = texts[other_path]
            length = LINES
            while (
                at + length < len(lines)
                and other_at + length < len(there)
                and lines[at + length][1] == there[other_at + length][1]
            ):
                length += 1
            key = f"{other_path} = {path}"
            found[key] = found.get(key, 0) + length
            at += length
    return found


def counterexamples():
    ten = "".join(f"  call({n});\n" for n in range(10))
    yield {"lib/a.cpp": ten, "tests/b.cpp": ten}, {}
    yield {"lib/a.cpp": ten, "sim/b.cpp": ten.replace("call(9)", "other(9)")}, {}
    yield (
        {"lib/a.cpp": ten, "sim/b.cpp": "#include <a>\n" + ten.replace("\n", "\n\n  }\n  // why\n").replace("  call", " call")},
        {"lib/a.cpp = sim/b.cpp": 10},
    )
    yield {"lib/a.cpp": ten + "  between();\n" + ten}, {"lib/a.cpp = lib/a.cpp": 10}
