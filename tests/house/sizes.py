"""Files, functions and folders stay small enough to be read at once."""

import os

from cpp_text import TOPS, functions, sources

FILE_LINES = {".cpp": 400, ".hpp": 250}
FUNCTION_LINES = 80
FOLDER_FILES = 20
REMEDY = "split it"


def findings(root):
    found, folders = {}, {}
    for path, text in sources(root, (*TOPS, "tests")):
        lines = text.count("\n")
        if lines > FILE_LINES[os.path.splitext(path)[1]]:
            found[path] = lines
        folder = os.path.dirname(path) + "/"
        folders[folder] = folders.get(folder, 0) + 1
        for name, _, length in functions(text):
            if length > FUNCTION_LINES:
                found[f"{path} {name}()"] = length
    found.update({folder: count for folder, count in folders.items() if count > FOLDER_FILES})
    return found


def counterexamples():
    short = "int f() {\n" + "  g();\n" * 78 + "}\n"
    yield {"lib/a.cpp": short, "lib/b.hpp": "\n" * 250}, {}
    yield {"lib/a.cpp": short.replace("{\n", "{\n  // }\n")}, {"lib/a.cpp f()": 81}
    yield (
        {"hal/a.cpp": "namespace n {\nA::A(int x)\n    : a_(x), b_{x} {\n" + "  if (x) {\n  }\n" * 40 + "}\n}\n"},
        {"hal/a.cpp A::A()": 82},
    )
    yield {"lib/a.cpp": "\n" * 401}, {"lib/a.cpp": 401}
    yield {"tests/x/b.hpp": "\n" * 251}, {"tests/x/b.hpp": 251}
    yield {f"sim/{n}.cpp": "" for n in range(20)}, {}
    yield {f"sim/{n}.cpp": "" for n in range(21)}, {"sim/": 21}
