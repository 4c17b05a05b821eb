"""What import_points --example writes: a list as it is expected, in both forms, and a mapping to start from."""

import csv
import os
from pathlib import Path

from complaint import refuse
from mapping import DEFAULTS

HEADINGS = ("Point name", "Description", "Register", "Data type", "Byte order", "Scale", "Unit", "R/W")
ROWS = [
    ("AHU3.VAV1.ZN-T", "VAV 1 zone temperature", "30001", "INT16", "", "0.1", "°C", "R"),
    ("AHU3.VAV2.ZN-T", "VAV 2 zone temperature", "30002", "INT16", "", "0.1", "°C", "R"),
    ("AHU3.VAV3.ZN-T", "VAV 3 zone temperature", "30003", "INT16", "", "0.1", "°C", "R"),
    ("AHU3.VAV1.DMPR-POS", "VAV 1 damper position", "30011", "UINT16", "", "0.1", "%", "R"),
    ("AHU3.VAV2.DMPR-POS", "VAV 2 damper position", "30012", "UINT16", "", "0.1", "%", "R"),
    ("AHU3.VAV3.DMPR-POS", "VAV 3 damper position", "30013", "UINT16", "", "0.1", "%", "R"),
    ("AHU3.SAT", "Supply air temperature", "30021", "INT16", "", "0.1", "°F", "R"),
    ("AHU3.OAT", "Outdoor air temperature", "30022", "INT16", "", "0.1", "°C", "R"),
    ("AHU3.KW", "Fan power", "30031", "FLOAT32", "CDAB", "1", "W", "R"),
    ("AHU3.FILTER", "Filter pressure drop", "30041", "UINT16", "", "1", "Pa", "R"),
    ("AHU3.SF-STS", "Supply fan status", "10001", "BOOL", "", "", "", "R"),
    ("AHU3.SAT-SP", "Supply air temperature setpoint", "40001", "INT16", "", "0.1", "°C", "RW"),
    ("AHU3.WATCHDOG", "Counted up by the supervisor", "40002", "UINT16", "", "", "", "RW")]


def write_example(folder):
    """list.csv, list.xlsx (where openpyxl is) and map.toml into a folder that has none of them. Returns their names."""
    folder = Path(folder)
    names = ["list.csv", "map.toml"]
    try:
        import openpyxl
        names.append("list.xlsx")
    except ImportError:
        openpyxl = None
    there = [name for name in names if (folder / name).exists()]
    if there:
        refuse(str(folder / there[0]), "a file that is already there", "a folder without " + ", ".join(names),
               "choose another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "list.csv", "x", encoding="utf-8-sig", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([HEADINGS, *ROWS])
        with open(folder / "map.toml", "x", encoding="utf-8") as file:
            file.write(DEFAULTS.read_text(encoding="utf-8"))
        if openpyxl:
            book = openpyxl.Workbook()
            book.active.title = "Points"
            for row in [HEADINGS, *ROWS]:
                book.active.append([float(c) if i == 5 and c and row is not HEADINGS else int(c) if c.isdecimal() else c
                                    for i, c in enumerate(row)])
            book.save(folder / "list.xlsx")
    except OSError as wrong:
        refuse(str(folder), wrong.strerror or str(wrong), "a folder that can be written", "choose another place")
    return [os.path.join(folder, name) for name in names]
