"""Every `Source:` of a comment leads to a place in this repository, or to a published work.

A source is one or more of these, with commas or semicolons between them:
  docs/method.md 6.1, 6.3          numbered headings of the document are there
  docs/method.md "Open point 4"    a heading that begins with these words, case aside
  DESIGN.md decisions 1-4, 10      numbered decisions
  docs/box-and-safety.md rows 1-6  rows of its tables, by the number in the first column
  a path of the source tree, `airside ...` (a command that prints it), or a work with its year or number
"""

import os
import re

from cpp_text import TOPS, comments, sources

REMEDY = "name docs/method.md and a section, another document and a heading, or a work with its year or number"

DOCUMENT = re.compile(r"[\w./-]+\.md\b")
PATH = re.compile(r"(?<![\w/])(?:lib|hal|sim|firmware|tools|tests|docs)/[\w./-]*\w")
WORK = re.compile(r"\b(1[89]|20)\d\d\b|\b[A-Z][\w-]* (V?\d+(\.\d+)+|\d+-\d{4})\b|\b(ISO|EN|IEC|RFC|IEEE|VDI) ?\d+")
# Numbers that are not sections: an equation is named beside the section that has it.
INSIDE = re.compile(r"\b(Eqs?\.?|equations?|steps?|terms?|tables?|figures?|pages?)\s*\(?\d+\)?((,|-| and) ?\(?\d+\)?)*", re.I)


def numbers(text):
    """1, 2, 3 and 10 of "1-3, 10"."""
    found = set()
    for low, high in re.findall(r"(\d+)(?:\s*(?:-|\.\.)\s*(\d+))?", text):
        found.update(range(int(low), int(high or low) + 1))
    return found


def origin_texts(text):
    """What stands behind each `Source:`, up to the end of its sentence or the next label of the doc block."""
    for _, comment in comments(text):
        for hit in re.finditer(r"\bSource:\s*(.*)", comment):
            rest = hit[1] + " "
            end = re.search(r"(?<!\b[A-Z])(?<!Soc)(?<!Am)(?<!Stat)(?<!Assoc)\. |\s(?:Units|Shape|Errors|Cost|Source): ", rest)
            yield (rest[: end.start()] if end else rest).strip().rstrip(".")


class Documents:
    def __init__(self, root):
        self.root, self.texts = root, {}

    def text(self, path):
        if path not in self.texts:
            full = os.path.join(self.root, path)
            self.texts[path] = open(full, encoding="utf-8").read() if os.path.isfile(full) else None
        return self.texts[path]

    def unresolved(self, path, locator):
        """What of `locator` is not in the document, as words; empty if all is."""
        text = self.text(path)
        if text is None:
            return f"no {path}"
        headings = [re.sub(r"[`*]", "", h) for h in re.findall(r"^#+\s+(.*?)\s*$", text, re.MULTILINE)]
        for quoted in re.findall(r'"([^"]+)"', locator):
            wanted = re.escape(quoted.strip(" ,."))
            if not any(re.match(rf"(?:[\d.]+ )?{wanted}(?!\w)", h, re.I) for h in headings):
                return f'no "{quoted}" in {path}'
        rest = INSIDE.sub("", re.sub(r'"[^"]*"', "", locator))
        for kind, heads in (
            ("decisions?", lambda n: rf"^(?:\*\*)?{n}\. |^#+ .*\b{n}\b"),
            ("rows?", lambda n: rf"^\|\s*{n}\b"),
            ("open points?", lambda n: rf"^#+ Open point {n}\b"),
        ):
            for hit in re.findall(rf"\b{kind} ((?:\d+(?:\s*(?:-|\.\.)\s*\d+)?(?:, | and )?)+)", rest, re.I):
                for n in numbers(hit):
                    if not re.search(heads(n), text, re.MULTILINE):
                        return f"no {kind.rstrip('?')[:-1]} {n} in {path}"
            rest = re.sub(rf"\b{kind} ((?:\d+(?:\s*(?:-|\.\.)\s*\d+)?(?:, | and )?)+)", "", rest, flags=re.I)
        for section in re.findall(r"(?<![\w.])\d+(?:\.\d+)*(?![\w])", rest):
            if not any(re.match(rf"{re.escape(section)}[. ]", h) for h in headings):
                return f"no section {section} in {path}"
        return ""


def unresolved(documents, origin):
    hits = list(DOCUMENT.finditer(origin))
    if hits:
        ends = [hit.start() for hit in hits[1:]] + [len(origin)]
        return next(filter(None, (documents.unresolved(h[0], origin[h.end() : e]) for h, e in zip(hits, ends))), "")
    paths = PATH.findall(origin)
    if paths:
        return next((f"no {path}" for path in paths if not os.path.exists(os.path.join(documents.root, path))), "")
    return "" if WORK.search(origin) or "`airside " in origin else "neither in the repository nor a work with its year or number"


def findings(root):
    documents, found = Documents(root), {}
    for path, text in sources(root, (*TOPS, "tests")):
        for origin in origin_texts(text):
            if unresolved(documents, origin):
                key = f"{path}: {origin}"
                found[key] = found.get(key, 0) + 1
    return found


def counterexamples():
    there = {
        "docs/method.md": "# Method\n## 4. Losses\n### 6.1 Score and choice\n### Open point 4: label\n",
        "DESIGN.md": "## Room head\n1. **Static.** x\n2. **Rows.** y\n",
        "docs/box.md": "| 7 | drift | alarm |\n",
    }

    def case(origin, holds):
        text = f"/// What it does.  Cost: O(n).  Source: {origin}. And more.\nint a;\n"
        return {"lib/a.hpp": text, **there}, {} if holds else {f"lib/a.hpp: {origin}": 1}

    for origin in (
        "docs/method.md 6.1, Eq 26",
        "docs/method.md 4, 6.1; DESIGN.md decisions 1, 2",
        'docs/method.md "Open point 4"',
        "docs/method.md open point 4",
        'DESIGN.md "Room head"',
        "docs/box.md row 7",
        'MacKay 1992, "Bayesian interpolation"',
        "ASHRAE Guideline 14-2014, hourly limits: 30 % and 10 %",
        "Modbus over Serial Line V1.02, 6.2.2",
        "`airside study tune --plant rc`",
    ):
        yield case(origin, True)
    for origin in (
        "docs/method.md 6.2",
        "docs/gone.md 4",
        "spec 6.1",
        "RELIABILITY rows 1-6",
        "DESIGN.md decisions 1-3",
        'DESIGN.md "Roof head"',
        "docs/box.md rows 7, 8",
        "docs/method.md open point 5",
        "lib/airside/gone.hpp",
    ):
        yield case(origin, False)
    yield {"lib/a.hpp": "/// Broken over\n/// lines. Source: docs/method.md\n/// 6.3.\n", **there}, {"lib/a.hpp: docs/method.md 6.3": 1}
