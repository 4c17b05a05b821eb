"""results.parquet and index.html of a campaign's folder, from what its jobs printed; written whole or not at all."""

import html
import json
import math
import os
import statistics
import tempfile
from pathlib import Path

from airside_campaign.complaint import BadInput, nearest

SEED = "seed"
MOST_FIGURES = 6
FIGURE_ORDER = ("dae_degc", "darv_degc", "me_degc", "hvac_kwh_per_day")


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
            row["figures"] = figures_of(
                (folder.path / "jobs" / job.key / "stdout").read_text(encoding="utf-8", errors="replace")
            )
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


def shown_figures(campaign, rows, entry):
    """Those that the file names, else the first that its jobs have."""
    if campaign.figures.get(entry):
        return campaign.figures[entry]
    have = {key for row in rows if row["entry"] == entry for key in row["figures"] if key != "seeds"}
    first = [key for key in FIGURE_ORDER if key in have]
    return (first + sorted(have - set(first)))[:MOST_FIGURES]


def number(value):
    if not math.isfinite(value):
        return "–"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}" if abs(value) >= 1 or value == 0 else f"{value:.3f}"


def groups_of(rows, entry):
    """Jobs that differ in their seed alone."""
    groups = {}
    for row in rows:
        if row["entry"] == entry:
            groups.setdefault(tuple((k, v) for k, v in row["values"].items() if k != SEED), []).append(row)
    return groups


def dots_svg(groups, figure):
    """A dot for each seed, a bar at the mean: one line a group."""
    lines = []
    for name, rows in groups.items():
        values = [r["figures"][figure] for r in rows if figure in r["figures"] and math.isfinite(r["figures"][figure])]
        if values:
            lines.append((", ".join(str(v) for _, v in name) or "all", values))
    if not lines:
        return ""
    low, high = min(min(v) for _, v in lines), max(max(v) for _, v in lines)
    low = min(low, 0) if low < 0.5 * high else low
    span = (high - low) or 1
    left, width, step = 190, 520, 24

    def x(value):
        return left + width * (value - low) / span

    parts = [
        f'<svg viewBox="0 0 {left + width + 40} {step * len(lines) + 34}" role="img" aria-label="{html.escape(figure)}">'
    ]
    for tick in (low, low + span / 2, high):
        parts.append(
            f'<line class="grid" x1="{x(tick):.1f}" x2="{x(tick):.1f}" y1="4" y2="{step * len(lines) + 8}"/>'
            f'<text x="{x(tick):.1f}" y="{step * len(lines) + 26}" text-anchor="middle">{number(tick)}</text>'
        )
    for i, (name, values) in enumerate(lines):
        y = step * i + 18
        parts.append(f'<text x="{left - 12}" y="{y + 4}" text-anchor="end">{html.escape(name[:28])}</text>')
        parts += [f'<circle class="dot" cx="{x(v):.1f}" cy="{y}" r="4"/>' for v in values]
        mean = statistics.fmean(values)
        parts.append(f'<line class="mean" x1="{x(mean):.1f}" x2="{x(mean):.1f}" y1="{y - 8}" y2="{y + 8}"/>')
    return "".join(parts) + "</svg>"


STYLE = """
:root{--paper:#fff;--sheet:#f5f7f9;--ink:#161c24;--soft:#56616e;--rule:#dfe4e9;--grid:#e9edf1;--main:#0b62b4;--bad:#a3243b}
@media (prefers-color-scheme:dark){:root{--paper:#14181d;--sheet:#1b2027;--ink:#e8ecf0;--soft:#9aa5b1;--rule:#2c343d;
--grid:#252c34;--main:#63b0f7;--bad:#ff95a6}}
body{margin:0 auto;max-width:1080px;padding:36px 24px;background:var(--paper);color:var(--ink);
font:16px/1.55 system-ui,sans-serif;font-variant-numeric:tabular-nums}
h1{font-size:30px;margin:0 0 10px}h2{font-size:19px;margin:40px 0 6px}.quiet{color:var(--soft);font-size:14px}
table{border-collapse:collapse;font-size:14.5px;width:100%}th,td{padding:6px 10px;text-align:right;
border-bottom:1px solid var(--rule);white-space:nowrap}.text{text-align:left;white-space:normal}
.scroll{overflow-x:auto}svg{width:100%;max-width:760px;height:auto;display:block}text{font-size:12px;fill:var(--soft)}
.grid{stroke:var(--grid)}.dot{fill:var(--main);opacity:.55}.mean{stroke:var(--ink);stroke-width:2}.bad{color:var(--bad)}
"""


def page_of(campaign, rows, facts):
    done = sum(r["done"] for r in rows)
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
        'content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
        f"<title>{html.escape(campaign.path.stem)}</title><style>{STYLE}</style></head><body>"
        f"<h1>{html.escape(campaign.path.stem)}: {done} of {len(rows)} jobs done</h1>"
        f'<p class="quiet">{html.escape(facts)}</p>'
    ]
    failed = [r for r in rows if not r["done"]]
    if failed:
        parts.append(
            f'<h2 class="bad">{len(failed)} failed</h2><div class="scroll"><table><tr><th class="text">job</th>'
            '<th class="text">why</th></tr>'
        )
        parts += [
            f'<tr><td class="text">{html.escape(r["job"])}</td><td class="text">{html.escape(r["why"])}</td></tr>'
            for r in failed[:200]
        ]
        parts.append("</table></div>" + (f"<p>and {len(failed) - 200} more</p>" if len(failed) > 200 else ""))
    for entry in dict.fromkeys(job.entry for job in campaign.jobs):
        groups, figures = groups_of(rows, entry), shown_figures(campaign, rows, entry)
        first = next(job for job in campaign.jobs if job.entry == entry)
        keys = [k for k in first.values if k != SEED]
        parts.append(
            f'<h2>{html.escape(first.command[0])}</h2><p class="quiet">Mean, and standard deviation where there are '
            "several seeds; dots are the seeds, the bar is their mean.</p>"
        )
        if figures:
            parts.append(f'<p class="quiet">{html.escape(figures[0])}</p>' + dots_svg(groups, figures[0]))
        parts.append(
            '<div class="scroll"><table><tr>'
            + "".join(f'<th class="text">{html.escape(k)}</th>' for k in keys)
            + "<th>done</th>"
            + "".join(f"<th>{html.escape(f)}</th>" for f in figures)
            + "</tr>"
        )
        for name, group in groups.items():
            parts.append(
                "<tr>"
                + "".join(f'<td class="text">{html.escape(str(v))}</td>' for _, v in name)
                + f"<td>{sum(r['done'] for r in group)} of {len(group)}</td>"
            )
            for figure in figures:
                values = [r["figures"][figure] for r in group if figure in r["figures"]]
                spread = f" ± {number(statistics.stdev(values))}" if len(values) > 1 else ""
                parts.append(f"<td>{number(statistics.fmean(values)) + spread if values else '–'}</td>")
            parts.append("</tr>")
        parts.append("</table></div>")
    return "".join(parts) + "</body></html>\n"


def write_page(campaign, rows, facts, path):
    whole_file(path, lambda part: Path(part).write_text(page_of(campaign, rows, facts), encoding="utf-8"))
