"""The mapping of a vendor's words to ours: vendor.toml, and a person's own file before it."""

import re
import sys
from pathlib import Path

from complaint import quoted, refuse
from guesses import guessed_columns

try:
    import tomllib
except ImportError:
    sys.exit("tools/points/import_points: found Python "
             f"{sys.version_info.major}.{sys.version_info.minor}; expected 3.11 or later, which reads TOML; "
             "run it with a newer python3")

DEFAULTS = Path(__file__).with_name("vendor.toml")
LIST_KEYS = {"sheet": str, "header_row": int, "addresses": str, "function": int, "type": str, "scale": (int, float),
             "order": str, "device": int, "numbers": str}
EXPECTED = {str: "a text", int: "a whole number"}
CHOICES = {"addresses": ("modicon", "zero-based", "one-based"), "numbers": ("as-written", "in-order"),
           "type": ("int16", "uint16", "int32", "uint32", "float32"), "order": ("ABCD", "CDAB", "BADC", "DCBA"),
           "function": (1, 2, 3, 4)}


def words_of(text, at_capitals=True):
    """`AHU3.VAV-03_ZoneTemp` -> `ahu 3 vav 3 zone temp`."""
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", text.strip()) if at_capitals else text
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
        self.own_roles = {role for role in own.get("roles", {}) if self.roles[role] != base["roles"].get(role)}
        self.words = sorted(((words_of(v), key) for key, variants in self.tables["words"].items() for v in variants),
                            key=lambda pair: -len(pair[0]))

    def _check_list(self):
        for key, value in self.list.items():
            place = f"{self.file}: list.{key}"
            if key not in LIST_KEYS:
                refuse(place, "an unknown key", "one of " + ", ".join(LIST_KEYS), "correct its name, or remove it")
            if not isinstance(value, LIST_KEYS[key]) or isinstance(value, bool):
                refuse(place, repr(value), EXPECTED.get(LIST_KEYS[key], "a number"), "correct the value")
            if key == "scale" and not 0 < abs(value) < float("inf"):
                refuse(place, repr(value), "a factor other than 0",
                       "write 1 where registers hold the values themselves")
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
                if other != key:  # a word that one's own file has under both stays with both
                    kept = own.get(other, [])
                    merged[other] = [v for v in merged[other] if v in kept or plain_of(name, v) not in taken]
            merged[key] = [*variants, *merged.get(key, [])]
        return merged

    def word(self, table, text):
        """The key of a fixed list under which `text` is; None: nowhere."""
        text = plain_of(table, text)
        return next((key for key, variants in self.tables[table].items()
                     if text in (plain_of(table, v) for v in [*variants, key])), None)

    def accepted(self, table):
        return ", ".join(f"{key} ({', '.join(v for v in variants[:3] if v)})" for key, variants in self.tables[table].items())

    def in_our_words(self, text, at_capitals=True):
        """A point's name with the words of the table `words`, the longest first."""
        padded = f" {words_of(text, at_capitals)} "
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
    return re.sub(r"[(\[（【].*?[)\]）】]", "", heading)


def recogniser(mapping):
    def recognise(cells):
        return len(places_of(cells, mapping.columns))
    return recognise


def find_heading(table, mapping, header_row=None):
    """Errors: BadInput where there is no heading row or it lacks a column."""
    rows = [(number, cells) for number, cells in table.rows if header_row in (None, number)]
    if not rows:
        refuse(table.path, f"no row {header_row}", "the heading row there", "correct list.header_row, or leave it out")
    number, cells = max(rows[:60], key=lambda row: heading_likeness(row[1], mapping))
    places = places_of(cells, mapping.columns)
    if "instance" in places and "type" in places and not {"object_type", "address", "object"} & set(places):
        places["object_type"] = places.pop("type")  # beside an instance a type is an object's
    has_place = "address" in places or "object" in places or {"object_type", "instance"} <= set(places)
    if "name" in places and has_place:
        return Heading(number, cells, places)
    refuse_heading(table, Heading(number, cells, places), mapping)


def heading_likeness(cells, mapping):
    """Where hardly a heading is known the first row with most cells: titles above it have few, and RW is a cell too."""
    known = len(places_of(cells, mapping.columns))
    return (known, 0) if known > 1 else (0, sum(map(bool, cells)))


def refuse_heading(table, heading, mapping):
    """What is missing and every heading that is not known, at once."""
    missing = [] if "name" in heading.places else ["name"]
    if not {"address", "object"} & set(heading.places) and not {"object_type", "instance"} <= set(heading.places):
        missing.append("instance" if "object_type" in heading.places else "address")
    seen = ", ".join(quoted(c) for c in heading.cells if c) or "nothing"
    columns = guessed_columns(table, heading, mapping)
    said = ", ".join(quoted(text) + (f" (could be {' or '.join(keys)})" if keys else "") for text, keys in columns)
    sample = next(((keys[0], text) for text, keys in columns if keys and keys[0] in missing),
                  (missing[0], "your heading"))
    refuse(table.row_place(heading.number),
           " and ".join(f"no column of the {key}" for key in missing) + f" among the headings {seen}",
           "; ".join(f"one for the {key}, named {', '.join(mapping.columns[key][:6])} or the like" for key in missing),
           (f"not known: {said}; " if said else "") + "rename the headings, or add lines such as "
           f'{sample[0]} = ["{sample[1]}"] to [columns] of a file for --map')
