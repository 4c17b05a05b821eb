"""The mapping of a vendor's words to ours: vendor.toml, and a person's own file before it."""

import re
import sys
from pathlib import Path

from complaint import quoted, refuse

try:
    import tomllib
except ImportError:
    sys.exit("tools/points/import_points: found Python "
             f"{sys.version_info.major}.{sys.version_info.minor}; expected 3.11 or later, which reads TOML; "
             "run it with a newer python3")

DEFAULTS = Path(__file__).with_name("vendor.toml")
LIST_KEYS = {"sheet": str, "header_row": int, "addresses": str, "function": int, "type": str, "order": str,
             "device": int, "numbers": str}
CHOICES = {"addresses": ("modicon", "zero-based", "one-based"), "numbers": ("as-written", "in-order"),
           "type": ("int16", "uint16", "int32", "uint32", "float32"), "order": ("ABCD", "CDAB", "BADC", "DCBA"),
           "function": (1, 2, 3, 4)}


def words_of(text):
    """`AHU3.VAV-03_ZoneTemp` -> `ahu 3 vav 3 zone temp`."""
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", text.strip())
    text = re.sub(r"([^\W\d_])(\d)", r"\1 \2", text)
    text = re.sub(r"(\d)([^\W\d_])", r"\1 \2", text)
    words = re.sub(r"[\W_]+", " ", text.lower()).split()
    return " ".join(str(int(w)) if w.isdecimal() else w for w in words)


def plain(text):
    """A heading or a word of a fixed list: case and gaps do not count."""
    return re.sub(r"[\W_]+", " ", text.lower()).strip()


class Mapping:
    """Tables of the two files; each complaint names the file."""

    def __init__(self, path):
        base = _load(DEFAULTS)
        own = _load(path) if path else {}
        self.file = str(path or DEFAULTS)
        for table in own:
            if table not in base:
                refuse(f"{self.file}: [{table}]", "an unknown table", "one of " + ", ".join(base),
                       "correct its name; import_points --example shows each")
            if not isinstance(own[table], dict):
                refuse(f"{self.file}: {table}", "no table", f"[{table}] with keys", "see import_points --example")
        self.list = dict(own.get("list", {}))
        self._check_list()
        self.tables = {name: self._merged(name, base[name], own.get(name, {})) for name in base if name != "list"}
        self.columns, self.roles, self.names = (self.tables[name] for name in ("columns", "roles", "names"))
        self.words = sorted(((words_of(v), key) for key, variants in self.tables["words"].items() for v in variants),
                            key=lambda pair: -len(pair[0]))

    def _check_list(self):
        for key, value in self.list.items():
            place = f"{self.file}: list.{key}"
            if key not in LIST_KEYS:
                refuse(place, "an unknown key", "one of " + ", ".join(LIST_KEYS), "correct its name, or remove it")
            if not isinstance(value, LIST_KEYS[key]) or isinstance(value, bool):
                refuse(place, repr(value), "a text" if LIST_KEYS[key] is str else "a whole number", "correct the value")
            if key in CHOICES and value not in CHOICES[key]:
                refuse(place, repr(value), "one of " + ", ".join(map(str, CHOICES[key])), "use one of these")

    def _merged(self, name, base, own):
        if name == "names":
            for key, value in own.items():
                if not isinstance(value, str):
                    refuse(f"{self.file}: names.{key}", repr(value), 'a name of ours, or ""', "write it as text")
            return dict(own)
        merged = dict(base)
        for key, value in own.items():
            if key not in base and name not in ("words", "roles"):
                refuse(f"{self.file}: {name}.{key}", "an unknown key", "one of " + ", ".join(base),
                       "correct its name, or remove it")
            variants = [value] if isinstance(value, str) else value
            if not isinstance(variants, list) or not all(isinstance(v, str) for v in variants):
                refuse(f"{self.file}: {name}.{key}", repr(value), "a list of texts", 'write it as ["..."]')
            if name == "roles":
                merged[key] = variants  # patterns for a role replace the ones of old, which might fit other points
                continue
            taken = {plain_of(name, v) for v in variants}
            for other in merged:
                if other != key:
                    merged[other] = [v for v in merged[other] if plain_of(name, v) not in taken]
            merged[key] = [*variants, *merged.get(key, [])]
        return merged

    def word(self, table, text):
        """The key of a fixed list under which `text` is; None: nowhere."""
        text = plain_of(table, text)
        return next((key for key, variants in self.tables[table].items()
                     if text in (plain_of(table, v) for v in [*variants, key])), None)

    def accepted(self, table):
        return ", ".join(f"{key} ({', '.join(v for v in variants[:3] if v)})" for key, variants in self.tables[table].items())

    def in_our_words(self, text):
        """A point's name with the words of the table `words`, the longest first."""
        padded = f" {words_of(text)} "
        for _ in range(2):  # "supply t" is found once "da" has become "supply"
            for variant, key in self.words:
                padded = padded.replace(f" {variant} ", f" {key} ")
        return padded.strip()


def plain_of(table, text):
    return " ".join(text.lower().split()) if table == "units" else plain(text)


def _load(path):
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except OSError as wrong:
        refuse(str(path), wrong.strerror, "a mapping in TOML", "check the path; import_points --example writes one")
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as wrong:
        refuse(str(path), f"no TOML: {wrong}", "a mapping in TOML", "correct the line; quote names with spaces or {n}")


# ---- Headings


class Heading:
    """Where the columns are: key of [columns] -> place from 0."""

    def __init__(self, number, cells, places):
        self.number, self.cells, self.places = number, cells, places


def places_of(cells, columns):
    """Places of the known headings; of two that fit one key, the one that its list has first."""
    places = {}
    for key, variants in columns.items():
        known = [plain(v) for v in variants]
        fitting = [(known.index(plain(bare)), place) for place, bare in enumerate(map(without_hint, cells))
                   if plain(bare) in known]
        if fitting:
            places[key] = min(fitting)[1]
    return places


def without_hint(heading):
    """`Address (0-based)` -> `Address`."""
    return re.sub(r"[(\[].*?[)\]]", "", heading)


def recogniser(mapping):
    def recognise(cells):
        return len(places_of(cells, mapping.columns))
    return recognise


def find_heading(table, mapping, header_row=None):
    """Errors: BadInput where there is no heading row or it lacks a column."""
    rows = [(number, cells) for number, cells in table.rows if header_row in (None, number)]
    if not rows:
        refuse(table.path, f"no row {header_row}", "the heading row there", "correct list.header_row, or leave it out")
    number, cells = max(rows[:60], key=lambda row: len(places_of(row[1], mapping.columns)))
    places = places_of(cells, mapping.columns)
    if "instance" in places and "type" in places and not {"object_type", "address", "object"} & set(places):
        places["object_type"] = places.pop("type")  # beside an instance a type is an object's
    has_place = "address" in places or "object" in places or {"object_type", "instance"} <= set(places)
    if "name" in places and has_place:
        return Heading(number, cells, places)
    missing = "name" if "name" not in places else "address"
    accepted = mapping.columns[missing]
    if missing == "address" and "object_type" in places:
        missing, accepted = "instance", mapping.columns["instance"]
    seen = ", ".join(quoted(c) for c in cells if c) or "nothing"
    refuse(table.row_place(number), f"no column of the {missing} among the headings {seen}",
           f"one named {', '.join(accepted[:6])} or the like",
           f'rename the heading, or add a line to [columns] of a file for --map: {missing} = ["your heading"]')
