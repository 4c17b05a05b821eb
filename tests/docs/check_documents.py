"""Checks the documents without running anything: python3 check_documents.py ROOT CHECK

CHECK is one of the functions below named after it, or `itself`: each rule must find what breaks it.
Prints one line a finding; exit code 1 if there is any."""

import os
import re
import sys
import tempfile

from documents import anchors, documents, headings, links, prose_lines, text_of, without_code

LONGEST = {"README.md": 150, "DESIGN.md": 250}
WIDTH = 120
CODE = ("lib", "hal", "sim", "tools", "firmware", "tests", "toolchains", ".ci")
CODE_ENDINGS = (".hpp", ".cpp", ".py", ".cmake", ".txt", ".in", ".ld", ".json", ".sh", ".toml", ".csv", "")


def sizes(root):
    """README.md and DESIGN.md keep to their number of lines."""
    for name, most in LONGEST.items():
        lines = len(text_of(os.path.join(root, name)).splitlines())
        if lines > most:
            yield f"{name}: {lines} lines; expected {most} at most; move detail to docs/"


def width(root):
    """Lines of prose and code are no wider than a screen. Table rows and lines that are one link may be."""
    for document in documents(root):
        for number, line in enumerate(text_of(os.path.join(root, document)).split("\n"), 1):
            alone = re.fullmatch(r"\s*[-*>]?\s*!?\[[^\]]*\]\([^)]*\)\S?", line)
            if len(line) > WIDTH and not line.startswith("|") and not alone:
                yield f"{document}:{number}: {len(line)} characters; expected {WIDTH} at most"


def resolve(root):
    """Relative links lead to a file, and to a heading of it."""
    for document in documents(root):
        folder = os.path.dirname(os.path.join(root, document))
        for number, target in links(text_of(os.path.join(root, document))):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            file = os.path.normpath(os.path.join(folder, path)) if path else os.path.join(root, document)
            if not os.path.exists(file):
                yield f"{document}:{number}: link to {target}: no such file"
            elif anchor and anchor not in anchors(text_of(file)):
                yield f"{document}:{number}: link to {target}: no such heading"


def paths(root):
    """What looks like a path of the source tree in backticks is one."""
    for document in documents(root):
        for number, line in prose_lines(text_of(os.path.join(root, document))):
            for code in re.findall(r"`([^`]+)`", line):
                path = re.match(r"\.?/?((?:%s|docs)/[\w./-]*[\w/])(?::\d+)?$" % "|".join(map(re.escape, CODE)), code)
                if path and "NAME" not in code and not os.path.exists(os.path.join(root, path[1])):
                    yield f"{document}:{number}: `{code}`: no such file or folder"


def retired_words(folder):
    lines = text_of(os.path.join(folder, "retired_words.txt")).splitlines()
    return [line.split("->") for line in lines if "->" in line and not line.startswith("#")]


def words(root):
    """Documents do not use the words of retired_words.txt outside backticks."""
    retired = [(re.compile(r"\b%s\b" % re.escape(word.strip()).replace(r"\ ", r"\s+"), re.IGNORECASE), instead.strip())
               for word, instead in retired_words(os.path.dirname(os.path.abspath(__file__)))]
    for document in documents(root):
        # A phrase may go on in the next line, so each line is read with the one behind it.
        lines = [(number, without_code(line)) for number, line in prose_lines(text_of(os.path.join(root, document)))]
        for (number, line), following in zip(lines, [line for _, line in lines[1:]] + [""]):
            for word, instead in retired:
                hit = word.search(line + " " + following)
                if hit and hit.start() < len(line):
                    yield f"{document}:{number}: \"{hit[0]}\"; write: {instead}"


WRITTEN = {"adopt.md"}  # documents that a program writes for its user


def references(root):
    """A document that the code names is there, and so is the heading that is quoted behind it."""
    named = re.compile(r"\b((?:docs/)?[A-Za-z_-]+\.md)\b(?:,? \"([^\"]+)\")?(?:, decisions? (\d+))?")
    known = {}
    for document in documents(root):  # the outermost of a name is meant
        known.setdefault(os.path.basename(document), document)
    for top in CODE:
        for folder, folders, files in os.walk(os.path.join(root, top)):
            skipped = ("vendor", "found", "data", "docs", "house", "__pycache__")
            folders[:] = [name for name in folders if name not in skipped]
            for name in files:
                file = os.path.join(folder, name)
                if os.path.splitext(name)[1] not in CODE_ENDINGS:
                    continue
                try:
                    text = text_of(file)
                except UnicodeDecodeError:
                    continue
                # Comments go on in the next line: a quoted heading may be broken there.
                joined = re.sub(r"\n[ \t]*(?:///?|#|\*)?[ \t]*(?:\")?", " ", text.replace("\\\"", "\""))
                for document, heading, decision in named.findall(joined):
                    if document in WRITTEN:
                        continue
                    path = document if document.startswith("docs/") else known.get(document)
                    where = os.path.relpath(file, root)
                    if path is None or not os.path.exists(os.path.join(root, path)):
                        yield f"{where}: names {document}, which is not there"
                        continue
                    text_there = text_of(os.path.join(root, path))
                    if heading and not any(heading in known_heading for known_heading in headings(text_there)):
                        yield f"{where}: names {document}, \"{heading}\": no such heading"
                    if decision and f"**{decision}. " not in text_there:
                        yield f"{where}: names {document}, decision {decision}: no such decision"


def wings(root):
    """Every wing of tests/arrows/arrows.txt has its line in docs/architecture.md."""
    told = text_of(os.path.join(root, "docs/architecture.md"))
    for wing in re.findall(r"^([\w/]+):", text_of(os.path.join(root, "tests/arrows/arrows.txt")), re.MULTILINE):
        if f"`{wing}`" not in told:
            yield f"docs/architecture.md: no `{wing}`; say which question this wing answers"


CHECKS = {"sizes": sizes, "width": width, "links": resolve, "paths": paths, "words": words, "references": references,
          "wings": wings}


def itself(_):
    """Each rule finds what breaks it, and nothing in a document that keeps to it."""
    right = "# A\n\nSee [B](docs/b.md#one-two) and `lib/there.hpp`.\n\n```sh\ntrue\n```\n"
    wrong = {
        "sizes": {"README.md": "a\n" * 151},
        "width": {"README.md": "word " * 25 + "\n"},
        "links": {"README.md": "[a](docs/none.md)\n", "DESIGN.md": "[a](docs/b.md#three)\n"},
        "paths": {"README.md": "`lib/gone.hpp`\n"},
        "words": {"README.md": "A defect that was\nmended.\n"},
        "references": {"lib/there.hpp": "// Source: docs/none.md.\n",
                       "lib/other.hpp": "// docs/b.md, \"One\n// three\"\n"},
        "wings": {"tests/arrows/arrows.txt": "# list\nlib:\nlib/gone: lib\n    lib/more\n"},
    }
    for check, files in wrong.items():
        for broken in (False, True):
            with tempfile.TemporaryDirectory() as root:
                made = {"README.md": right, "DESIGN.md": "# D\n", "docs/b.md": "# B\n\n## One two\n",
                        "lib/there.hpp": "// docs/b.md, \"One\n// two\"\n",
                        "docs/architecture.md": "| `lib` | what? |\n", "tests/arrows/arrows.txt": "lib:\n"}
                made.update(files if broken else {})
                for name, text in made.items():
                    os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                    with open(os.path.join(root, name), "w", encoding="utf-8") as file:
                        file.write(text)
                found = list(CHECKS[check](root))
                wanted = len(files) if broken else 0
                if len(found) != wanted:
                    yield f"{check}: {len(found)} findings where {wanted} were expected: {found}"


def main(arguments):
    every = {**CHECKS, "itself": itself}
    if len(arguments) != 2 or arguments[1] not in every:
        print(f"usage: check_documents.py ROOT {'|'.join(every)}", file=sys.stderr)
        return 2
    found = list(every[arguments[1]](arguments[0]))
    print("\n".join(found) if found else f"{arguments[1]}: nothing to complain of")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
