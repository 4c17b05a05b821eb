"""A vendor's list as rows of text, each cell with its place, from CSV or from one sheet of an XLSX file."""

import csv
import io
import zipfile

from complaint import complaint, quoted, refuse

MOST_BYTES = 20 << 20
SEPARATORS = {",": ",", ";": ";", "tab": "\t"}


class Table:
    """`rows`: (number as the file counts it, cells). `merged`: ranges such as A5:C5 with their first and last row."""

    def __init__(self, path, sheet, rows, merged=(), decimal=".", notes=()):
        self.path, self.sheet, self.rows, self.merged = path, sheet, rows, merged
        self.decimal, self.notes = decimal, list(notes)

    def row_place(self, number):
        return f"{self.path}, sheet {self.sheet}, row {number}" if self.sheet else f"{self.path}:{number}"

    def place(self, number, column, heading=""):
        name = letters(column) if self.sheet else str(column + 1)
        return f"{self.row_place(number)}, column {name}" + (f" ({heading})" if heading else "")


def letters(column):
    """A, B, ... AA of a column from 0."""
    text = ""
    column += 1
    while column:
        column, digit = divmod(column - 1, 26)
        text = chr(ord("A") + digit) + text
    return text


def read_table(path, options, recognise):
    """`recognise(cells)` counts the headings that a row has; it decides on the separator of a CSV and on the sheet.
    Errors: BadInput."""
    try:
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as wrong:
        refuse(path, wrong.strerror, "a point list as CSV or XLSX", "check the path and its permissions")
    if len(data) > MOST_BYTES:
        refuse(path, f"more than {MOST_BYTES >> 20} MiB", "the point list of one AHU", "check that this is the right file")
    if not data.strip():
        refuse(path, "an empty file", "a point list as CSV or XLSX", "export it again")
    if data.startswith(b"PK\x03\x04"):
        return read_workbook(path, data, options, recognise)
    if data.startswith(b"\xd0\xcf\x11\xe0"):
        refuse(path, "a workbook of the old form XLS, or one with a password", "XLSX or CSV",
               "save it as XLSX without a password, or as CSV UTF-8")
    if data.startswith(b"%PDF"):
        refuse(path, "a PDF", "XLSX or CSV", "ask the vendor for the table, or copy it into a spreadsheet")
    return read_csv(path, data, options, recognise)


# ---- CSV


def decoded(path, data, encoding):
    if encoding is None and data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        encoding = "utf-16"  # what Excel calls Unicode text
    try:
        text = data.decode(encoding or "utf-8-sig")
    except UnicodeDecodeError as wrong:
        line = data.count(b"\n", 0, wrong.start) + 1
        column = wrong.start - (data.rfind(b"\n", 0, wrong.start) + 1) + 1
        refuse(f"{path}:{line}, character {column}", f"the byte 0x{data[wrong.start]:02X}", encoding or "text in UTF-8",
               'save it as "CSV UTF-8", or say what it is, such as --encoding cp1252')
    except LookupError:
        refuse("--encoding", quoted(encoding), "an encoding that Python knows", "try cp1252, latin-1, gb18030 or big5")
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        refuse(f"{path}:{line}", "a NUL character", "plain text",
               "it may be UTF-16 without a mark: give --encoding utf-16-le, or save it as CSV UTF-8")
    return text


def read_csv(path, data, options, recognise):
    text = decoded(path, data, options.encoding)
    found = []
    for name, separator in SEPARATORS.items():
        if options.separator not in (None, name):
            continue
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
        rows, line = [], 1
        try:
            for cells in reader:
                rows.append((reader.line_num, [" ".join(cell.split()) for cell in cells]))
                line = reader.line_num + 1
        except csv.Error:
            if options.separator or text.count(separator):
                found.append((known_headings(text, separator, recognise) or -1, name, None, line))
            continue
        found.append((max((recognise(cells) for _, cells in rows[:60]), default=0), name, rows, 0))
    best = max(found, key=lambda entry: entry[0])
    if best[2] is None:
        refuse(f"{path}:{best[3]}", "a quote that is not closed in this line, or one inside a quoted cell",
               "cells with quotes around the whole cell or none",
               "close the quote, and double a quote that belongs to the text")
    notes = [] if best[1] == "," else [f"cells are separated by {'tabs' if best[1] == 'tab' else 'semicolons'}"]
    table = Table(path, "", [row for row in best[2] if any(row[1])], notes=notes)
    table.decimal = options.decimal or ("," if best[1] != "," and has_decimal_comma(table.rows) else ".")
    if table.decimal == "," and not options.decimal:
        table.notes.append("numbers have a decimal comma")
    return table


def known_headings(text, separator, recognise):
    """Of a file whose quotes are wrong: line by line, without minding them."""
    lines = text.splitlines()[:60]
    return max((recognise([cell.strip(' "') for cell in line.split(separator)]) for line in lines), default=0)


def has_decimal_comma(rows):
    """Whether some cell is a number with a comma, and none one with a point."""
    def like(cell, sign):
        whole, found, rest = cell.partition(sign)
        return bool(found) and whole.lstrip("-").isdigit() and rest.isdigit() and len(whole.lstrip("-")) < 3
    cells = [cell for _, row in rows for cell in row]
    return any(like(cell, ",") for cell in cells) and not any(like(cell, ".") for cell in cells)


# ---- XLSX


def read_workbook(path, data, options, recognise):
    try:
        import openpyxl
    except ImportError:
        refuse(path, "an XLSX file, and no openpyxl to read it with", "openpyxl (PyPI)",
               "run tools/setup --for test, or pip install openpyxl, or save the list as CSV UTF-8")
    if options.separator or options.encoding:
        refuse(path, "--separator or --encoding beside an XLSX file", "these options for CSV alone", "leave them out")
    try:
        book = openpyxl.load_workbook(io.BytesIO(data), data_only=True)
        formulas = openpyxl.load_workbook(io.BytesIO(data))
    except (zipfile.BadZipFile, KeyError, ValueError, OSError, EOFError) as wrong:
        refuse(path, f"a file that is no whole XLSX ({wrong})", "a workbook as Excel or LibreOffice saves it",
               "open it there and save it again")
    sheets = {sheet.title: sheet for sheet in book.worksheets}
    name = options.sheet or chosen_sheet(path, sheets, recognise)
    if name not in sheets:
        refuse(f"{path}, --sheet", quoted(name), "one of " + ", ".join(sheets), "name the sheet of the points")
    sheet = sheets[name]
    rows = []
    table = Table(path, name, rows, merged=[(str(r), r.min_row, r.max_row) for r in sheet.merged_cells.ranges],
                  decimal=options.decimal or ".")
    for row, formula_row in zip(sheet.iter_rows(), formulas[name].iter_rows()):
        cells = []
        for place, (cell, formula) in enumerate(zip(row, formula_row)):
            if cell.value is None and isinstance(formula.value, str) and formula.value.startswith("="):
                refuse(table.place(row[0].row, place), f"the formula {quoted(formula.value)} without a stored value",
                       "values", "open the file in a spreadsheet program, save it, and import that")
            cells.append(cell_text(cell.value))
        if any(cells):
            rows.append((row[0].row, cells))
    if not rows:
        refuse(f"{path}, sheet {name}", "an empty sheet", "a heading row and a row a point",
               "name another sheet: --sheet " + " or ".join(quoted(s) for s in sheets if s != name) if len(sheets) > 1
               else "export the list again")
    return table


def chosen_sheet(path, sheets, recognise):
    """The sheet whose headings are recognised; the first where there is no other."""
    counts = {name: max((recognise([cell_text(c) for c in row]) for row in sheet.iter_rows(max_row=60, values_only=True)),
                        default=0) for name, sheet in sheets.items()}
    most = max(counts.values(), default=0)
    best = [name for name, count in counts.items() if count == most]
    if most > 1 and len(best) > 1:
        refuse(path, "headings of a point list in the sheets " + ", ".join(best), "one sheet",
               f"name it: --sheet {quoted(best[0])}")
    return best[0] if best else ""


def cell_text(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else f"{value:.10g}"
    return " ".join(str(value).split())


def refuse_merged(table, first_row):
    """Merged cells from the heading on: what they stand for in the covered cells is anybody's guess."""
    bad = [complaint(f"{table.path}, sheet {table.sheet}, cells {cells}", "merged cells", "a cell for itself in every row",
                     "unmerge them in the spreadsheet program, and fill in what each row means")
           for cells, _, last in table.merged if last >= first_row]
    return bad
