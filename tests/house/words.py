"""Names, comments and messages use the field's words: none of retired_words.txt is in the sources."""

import os
import re

from cpp_text import sources

REMEDY = "use the word that retired_words.txt has instead, unless it is a frozen file key or log word"


def retired(path):
    """(pattern, what to use instead) of each line `WORDS -> instead`. A word also matches as part of a name: rung in
    stand_on_rung and RungTable, not in wrung. Behind a `=` comes a regular expression."""
    found = []
    for line in open(path, encoding="utf-8"):
        word, arrow, instead = line.partition("->")
        word = word.strip()
        if not arrow or line.startswith("#"):
            continue
        if word.startswith("="):
            pattern = word[1:].strip()
        else:
            parts = [f"[{part[0].upper()}{part[0].lower()}]{re.escape(part[1:])}" for part in word.split()]
            # Between words: a blank, a line's end with comment marks, an underscore, or nothing where a capital follows.
            joint = r"(?:\s+(?://+<?\s*)?|_|(?=[A-Z]))"
            before = r"(?<![A-Za-z])"
            pattern = rf"(?:{before}|(?<=[a-z])(?=[A-Z])){joint.join(parts)}(?![a-z])"
        found.append((word.lstrip("= "), re.compile(pattern), instead.strip()))
    return found


def findings(root):
    words = retired(os.path.join(root, "tests/house/retired_words.txt"))
    found = {}
    for path, text in sources(root):
        lower = text.lower()
        for word, pattern, _ in words:
            first = word.split()[0]
            if "\\" not in word and first not in lower:
                continue  # most are not there at all
            count = len(pattern.findall(text))
            if count:
                found[f"{path}: {word}"] = count
    return found


def counterexamples():
    listed = {"tests/house/retired_words.txt": "# words\nrung -> control mode\nway back -> rollback\n= OPEN-\\d+ -> docs/method.md\n"}

    def case(text, found):
        return {"lib/a.hpp": text, **listed}, {f"lib/a.hpp: {word}": count for word, count in found.items()}

    yield case("wrung, arrung, way backwards, OPEN-n", {})
    yield case("a rung; Rung::learn; stand_on_rung(); TopRung; rung_of()", {"rung": 5})
    yield case("// the way\n  /// back; way_back_; WayBack", {"way back": 3})
    yield case("// OPEN-19", {"OPEN-\\d+": 1})
