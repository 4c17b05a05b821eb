"""What a campaign's jobs printed, as rows and as results.parquet; written whole or not at all."""

import json
import os
import tempfile
from pathlib import Path

from airside_campaign.complaint import BadInput, nearest


def figures_of(text):
    """Numbers of the JSON object that a job printed, by dotted name; {} where it printed none."""
    try:
        content = json.loads(text)
    except ValueError:
        return {}
    figures = {}

    def walk(prefix, value):
        if isinstance(value, dict):
            for key, inner in value.items():
                walk(f"{prefix}.{key}" if prefix else key, inner)
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            figures[prefix] = float(value)

    if isinstance(content, dict):
        walk("", content)
    return figures


def rows_of(campaign, folder, records):
    """One a job, in the file's order."""
    rows = []
    for job in campaign.jobs:
        record = records.get(job.name, {})
        row = {
            "job": job.name,
            "entry": job.entry,
            "key": job.key,
            "done": bool(record.get("done")),
            "why": record.get("why", ""),
            "values": job.values,
            "figures": {},
        }
        if row["done"]:
            printed = folder.path / "jobs" / job.key / "stdout"
            try:
                row["figures"] = figures_of(printed.read_text(encoding="utf-8", errors="replace"))
            except OSError as error:
                row |= {"done": False, "why": f"{printed}: {error.strerror.lower()}; run the campaign again"}
        rows.append(row)
    return rows


def missing_figures(campaign, rows):
    """A complaint for each figure that the file names and none of its jobs printed."""
    complaints = []
    for entry, names in campaign.figures.items():
        done = [row for row in rows if row["entry"] == entry and row["done"]]
        have = sorted({key for row in done for key in row["figures"]})
        for name in names if done else ():
            if name in have:
                continue
            near = nearest(name, have)
            expected = "one of " + ", ".join(have[:20]) + (" ..." if len(have) > 20 else "")
            remedy = f"did you mean {near}?" if near else "correct it"
            if not have:
                expected, remedy = "a number of the JSON object that it prints", "add --json to run"
            place = f"{campaign.path}: job {entry + 1}: figures"
            complaints.append(BadInput(place, f"{name}, which no job printed", expected, remedy))
    return complaints


def write_parquet(rows, path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    values = list(dict.fromkeys(key for row in rows for key in row["values"]))
    figures = sorted({key for row in rows for key in row["figures"]})
    columns = {
        "job": pa.array([r["job"] for r in rows]),
        "key": pa.array([r["key"] for r in rows]),
        "done": pa.array([r["done"] for r in rows]),
    }
    for key in values:
        found = [r["values"].get(key) for r in rows]
        numbers = all(v is None or isinstance(v, (int, float)) for v in found)
        whole = all(v is None or isinstance(v, int) for v in found)
        kind = pa.int64() if whole else pa.float64() if numbers else pa.string()
        columns["over." + key] = pa.array([v if v is None or numbers else str(v) for v in found], kind)
    for key in figures:
        columns[key] = pa.array([r["figures"].get(key) for r in rows], pa.float64())
    whole_file(path, lambda part: pq.write_table(pa.table(columns), part))


def whole_file(path, write):
    handle, part = tempfile.mkstemp(dir=Path(path).parent, prefix=f".{Path(path).name}.")
    os.close(handle)
    try:
        write(part)
        os.chmod(part, 0o644)
        os.replace(part, path)
    except BaseException:
        os.unlink(part)
        raise
