"""C++ sources as text: which there are, and their code without comments and literals."""

import os
import re

TOPS = ("lib", "hal", "sim", "firmware", "tools")

# Comments, raw strings, strings, characters; a ' between digits belongs to a number.
SKIPPED = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<mark>[^()\s"\\]*)\(.*?\)(?P=mark)"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'',
    re.DOTALL,
)


def sources(root, tops=TOPS):
    """(path relative to `root`, text) of every .cpp and .hpp, in order."""
    for top in tops:
        for folder, folders, files in os.walk(os.path.join(root, top)):
            folders.sort()
            for name in sorted(files):
                if name.endswith((".cpp", ".hpp")):
                    path = os.path.join(folder, name)
                    with open(path, encoding="utf-8") as file:
                        yield os.path.relpath(path, root), file.read()


def code_alone(text):
    """The text with comments and literals blanked; lines stay where they are."""
    blank = SKIPPED.sub(lambda hit: re.sub(r"[^\n]", " ", hit[0]), text)
    # A macro's body is not a scope.
    return re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", lambda hit: re.sub(r"[^\n]", " ", hit[0]), blank, flags=re.MULTILINE)


def comments(text):
    """(line number, text) of every // comment; lines that follow one another are one comment, joined by a blank."""
    found, begun, words, last = [], 0, [], -1
    for number, line in enumerate(text.split("\n"), 1):
        comment = re.search(r'(?:^|\s)//[/!]?<?\s?(.*)$', line)
        if comment and '"' not in line[: comment.start()]:
            if number != last + 1 or not line.lstrip().startswith("//"):
                if words:
                    found.append((begun, " ".join(words)))
                begun, words = number, []
            words.append(comment[1].strip())
            last = number
    if words:
        found.append((begun, " ".join(words)))
    return found


def functions(text):
    """(name, first line, lines) of every function with a body, outermost ones alone: a lambda belongs to its function."""
    code = code_alone(text)
    found, scopes = [], []  # a scope is None or (name, line) of a function
    start = inside = 0  # of the text before a brace; depth of functions
    line = 1
    for hit in re.finditer(r"[{};\n]", code):
        at, mark = hit.start(), hit[0]
        if mark == "\n":
            line += 1
        elif mark == ";":
            start = at + 1
        elif mark == "{":
            before = code[start:at]
            name = function_name(before)
            # `member_{x}` of a constructor's list is an initialiser, and what stands before it goes on.
            initialiser = re.search(r"[\w>]$", before) is not None and not before.endswith(("const", "override"))
            if inside == 0 and name and not initialiser:
                scopes.append((name, line))
                inside += 1
            else:
                scopes.append("initialiser" if initialiser and name else None)
                if inside:
                    inside += 1
            if scopes[-1] != "initialiser":
                start = at + 1
        elif scopes:
            scope = scopes.pop()
            if inside:
                inside -= 1
            if isinstance(scope, tuple):
                found.append((scope[0], scope[1], line - scope[1] + 1))
            if scope != "initialiser":
                start = at + 1
    return found


def function_name(before):
    """The name of the function whose head this is; None for namespaces, types and initialisers."""
    head = re.sub(r"\s+", " ", before).strip()
    head = re.sub(r"^(template <.*?> (?=\w)|requires .*? (?=\w))", "", head)
    if "(" not in head or re.match(r"(namespace|enum|extern)\b", head) or head.endswith("="):
        return None
    if re.match(r"(class|struct|union)\b", head) and not re.search(r"\)\s*(const|noexcept|override|->.*)?$", head):
        return None
    name = re.search(r"(~?[\w:]+|operator\s*\S+)\s*\(", head)
    return name[1] if name else None
