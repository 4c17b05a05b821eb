"""Headings that no key of [columns] knows: which they are, and what each could be by its cells and its words."""

import difflib
import re

LIKE_A_FACTOR = re.compile(r"(?:[xX×*/:÷]|1\s*/)?\s*\d*[.,]?\d+")
LIKE_AN_ADDRESS = re.compile(r"[0134]\d{4,5}|[134][xX:]\d{1,5}|0[xX][0-9A-Fa-f]+|[0-9A-Fa-f]+[hH]|"
                             r"(?:HR|IR|DI|CO|%?MW)\d+")
WORDS_OF = {"type": "types", "access": "access", "unit": "units", "object_type": "object_types", "order": "orders",
            "function": "functions"}
MOST_CELLS = 50


def unused_columns(heading):
    """(place, heading) of the columns that nothing is read from."""
    used = set(heading.places.values())
    return [(place, cell) for place, cell in enumerate(heading.cells) if cell and place not in used]


def guessed_columns(table, heading, mapping):
    """(heading, keys of [columns] that it could be) of each column that is not used."""
    return [(text, guesses_of(cells_below(table, heading.number, place), text, heading.places, mapping))
            for place, text in unused_columns(heading)]


def cells_below(table, number, place):
    return [row[place] for at, row in table.rows if at > number and place < len(row) and row[place]][:MOST_CELLS]


def guesses_of(cells, heading, taken, mapping):
    by_cells = [key for key in of_cells(cells, mapping) if key not in taken]
    by_words = [key for key in of_words(heading, mapping) if key not in taken]
    agreed = [key for key in by_cells if key in by_words]
    if agreed or (by_cells and by_cells[0] not in ("name", "address")):
        return agreed or by_cells[:1]
    return by_words or by_cells


def of_cells(cells, mapping):
    """Keys that all the cells fit, the surest first."""
    if not cells:
        return []
    keys = [key for key, table in WORDS_OF.items() if all(mapping.word(table, cell) for cell in cells)]
    if all(map(LIKE_A_FACTOR.fullmatch, cells)) and any(re.search(r"[.,/:÷]", cell) for cell in cells):
        keys.append("scale")
    distinct = len(set(cells)) == len(cells)
    is_counted = len(cells) > 1 and distinct and all(cell.isdecimal() for cell in cells)
    if is_counted or all(map(LIKE_AN_ADDRESS.fullmatch, cells)):
        keys.append("address")
    if not keys and len(cells) > 1 and distinct and all(re.search(r"[^\W\d_]{2}", cell) for cell in cells):
        keys += ["name", "description"]
    return keys


def of_words(heading, mapping):
    """Keys with a known heading that is nearly this one, or begins as it does."""
    text = re.sub(r"[\W_]+", " ", heading.lower()).strip()
    known = {variant: key for key, variants in mapping.columns.items() for variant in variants}
    if len(text) < 3:
        return []
    near = difflib.get_close_matches(text, known, n=2, cutoff=0.65)
    near += [variant for variant in known if (variant.startswith(text) or text.startswith(variant + " "))]
    return list(dict.fromkeys(known[variant] for variant in near))[:2]
