"""index.html of a campaign's folder: failures first, then mean and spread over seeds, with the look of reports."""

import html
import math
import statistics
from pathlib import Path

from airside_campaign.results import whole_file

SEED = "seed"
MOST_FIGURES = 6
MOST_FAILURES = 200
STYLE = Path(__file__).parent / "style"  # links to the files of tools/report
# Name, unit and decimals, as the table "All methods" of a run's report has them.
WORDS = {
    "dae_degc": ("DAE", "K", 3),
    "darv_degc": ("DARV", "K", 3),
    "me_degc": ("ME", "K", 3),
    "hvac_kwh_per_day": ("energy", "kWh a day", 1),
    "day1_dae_degc": ("day 1", "K", 3),
    "degree_hours_per_day_degch": ("degree-hours", "K h a day", 2),
    "degree_hours_above_per_day_degch": ("above target", "K h a day", 2),
    "cdh_degch": ("CDH", "K h", 1),
    "hdh_degch": ("HDH", "K h", 1),
}
FIRST = tuple(WORDS)[:4]
esc = html.escape


def style_of():
    return "".join((STYLE / name).read_text(encoding="utf-8") for name in ("palette.css", "page.css"))


def shown_figures(campaign, rows, entry):
    """Those that the file names, else the first that its jobs have."""
    if campaign.figures.get(entry):
        return campaign.figures[entry]
    have = {key for row in rows if row["entry"] == entry for key in row["figures"] if key != "seeds"}
    first = [key for key in FIRST if key in have]
    return (first + sorted(have - set(first)))[:MOST_FIGURES]


def number(value, figure=""):
    if not math.isfinite(value):
        return "–"
    if figure in WORDS:
        return f"{value:.{WORDS[figure][2]}f}"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}" if abs(value) >= 1 or value == 0 else f"{value:.3f}"


def groups_of(rows, entry):
    """Jobs that differ in their seed alone."""
    groups = {}
    for row in rows:
        if row["entry"] == entry:
            groups.setdefault(tuple((k, v) for k, v in row["values"].items() if k != SEED), []).append(row)
    return groups


def values_of(group, figure):
    values = [row["figures"][figure] for row in group if figure in row["figures"]]
    return [v for v in values if math.isfinite(v)]


def dots_svg(groups, figure):
    """A dot for each seed, a bar at the mean: one line a group."""
    lines = [(", ".join(str(v) for _, v in name) or "all", values_of(rows, figure)) for name, rows in groups.items()]
    lines = [(name, values) for name, values in lines if values]
    if not lines:
        return ""
    low, high = min(min(v) for _, v in lines), max(max(v) for _, v in lines)
    low = min(low, 0) if low < 0.5 * high else low
    span = (high - low) or 1
    left, width, step = 190, 520, 24

    def x(value):
        return left + width * (value - low) / span

    means = "; ".join(f"{name} {number(statistics.fmean(values), figure)}" for name, values in lines)
    box = f"0 0 {left + width + 50} {step * len(lines) + 34}"
    parts = [f'<svg class="rank" viewBox="{box}" role="img" aria-label="{esc(figure)}, means: {esc(means)}">']
    for tick in (low, low + span / 2, low + span):
        parts.append(
            f'<line class="grid" x1="{x(tick):.1f}" x2="{x(tick):.1f}" y1="4" y2="{step * len(lines) + 8}"/>'
            f'<text x="{x(tick):.1f}" y="{step * len(lines) + 26}" text-anchor="middle">{number(tick, figure)}</text>'
        )
    for i, (name, values) in enumerate(lines):
        y = step * i + 18
        parts.append(
            f'<text x="{left - 12}" y="{y + 4}" text-anchor="end" style="font-size:13px">{esc(name[:26])}'
            f"<title>{esc(name)}</title></text>"
        )
        parts += [f'<circle class="found" fill-opacity=".55" cx="{x(v):.1f}" cy="{y}" r="4"/>' for v in values]
        mean = statistics.fmean(values)
        parts.append(f'<line class="mark" x1="{x(mean):.1f}" x2="{x(mean):.1f}" y1="{y - 8}" y2="{y + 8}"/>')
    return "".join(parts) + "</svg>"


def head_of(campaign, rows, version):
    done = sum(r["done"] for r in rows)
    failed = len(rows) - done
    seeds = len({r["values"][SEED] for r in rows if SEED in r["values"]})
    said = f"{done} of {len(rows)} jobs done" + (f", {failed} failed: they come first." if failed else ".")
    figures = [("Jobs done", str(done), f"of {len(rows)}"), ("Jobs that failed", str(failed), "")]
    if seeds:
        figures.append(("Seeds", str(seeds), ""))
    cells = "".join(
        f'<div><dt>{label}</dt><dd><strong>{value}</strong> <span class="unit">{unit}</span></dd></div>'
        for label, value, unit in figures
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n"
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{esc(campaign.path.stem)}</title>\n<style>\n{style_of()}</style>\n</head>\n<body>\n<header>\n"
        f'<p class="kicker">{esc(f"{campaign.path.name}, {version}")}</p>\n<h1>{esc(campaign.path.stem)}</h1>\n'
        f'<p class="headline">{said}</p>\n<dl class="figures">{cells}</dl>\n</header>\n<main>\n'
    )


def failures_of(rows):
    failed = [r for r in rows if not r["done"]]
    if not failed:
        return ""
    lines = "".join(
        f'<tr><th scope="row">{esc(r["job"])}</th><td class="text" data-name="why">{esc(r["why"])}</td></tr>\n'
        for r in failed[:MOST_FAILURES]
    )
    more = f"<p>and {len(failed) - MOST_FAILURES} more</p>" if len(failed) > MOST_FAILURES else ""
    return (
        f'<section><h2>{len(failed)} failed</h2>\n<p class="note">What they left is in failed/, each in the folder of '
        "its key. The same command tries them again.</p>\n"
        '<div class="scroll"><table class="figures-table prose"><thead><tr><th scope="col">job</th>'
        f'<th scope="col">why</th></tr></thead><tbody>\n{lines}</tbody></table></div>{more}</section>\n'
    )


def column_head(figure):
    name, unit, _ = WORDS.get(figure, (figure, "", 0))
    below = f'<span class="unit">{esc(unit)}</span>' if unit else ""
    return f'<th scope="col" title="{esc(figure)}">{esc(name)}{below}</th>'


def cell_of(group, figure):
    values = values_of(group, figure)
    if not values:
        return '<td class="text">–</td>'
    spread = f'<span class="pm"> ± {number(statistics.stdev(values), figure)}</span>' if len(values) > 1 else ""
    done = sum(row["done"] for row in group)
    some = f'<span class="unit"> {len(values)} of {done}</span>' if len(values) < done else ""  # the others have none
    return f"<td>{number(statistics.fmean(values), figure)}{spread}{some}</td>"


def entry_of(campaign, rows, entry):
    """One [[job]] of the file: dots of its first figure, a table of all."""
    groups, figures = groups_of(rows, entry), shown_figures(campaign, rows, entry)
    first = next(job for job in campaign.jobs if job.entry == entry)
    keys = [k for k in first.values if k != SEED]
    names = [job.name for job in campaign.jobs if job.entry == entry]
    note = f"{names[0]} to {names[-1]}. " if len(names) > 1 else f"{names[0]}. "
    note += "Mean ± standard deviation where there are several seeds; n of m: m jobs are done, n have this figure."
    renamed = [f"{WORDS[f][0]} is {f}" for f in figures if f in WORDS]
    if renamed:
        note += " In results.parquet " + ", ".join(renamed) + "."
    parts = [f'<section><h2>airside {esc(first.command[0])}</h2>\n<p class="note">{esc(note)}</p>\n']
    dots = dots_svg(groups, figures[0]) if figures else ""
    if dots:
        name, unit, _ = WORDS.get(figures[0], (figures[0], "", 0))
        parts.append(
            f'<p class="note">{esc(name)}{", " + unit if unit else ""}: dots are the seeds, the bar is their mean.</p>\n'
            f'<div class="pictures"><figure>{dots}</figure></div>\n'
        )
    heads = "".join(f'<th scope="col">{esc(k)}</th>' for k in keys or ["jobs"]) + '<th scope="col">done</th>'
    parts.append(
        '<div class="scroll"><table class="figures-table"><thead><tr>'
        + heads
        + "".join(column_head(f) for f in figures)
        + "</tr></thead><tbody>\n"
    )
    for name, group in groups.items():
        values = [str(v) for _, v in name] or ["all"]
        parts.append(
            f'<tr><th scope="row">{esc(values[0])}</th>'
            + "".join(f'<td class="text">{esc(v)}</td>' for v in values[1:])
            + f"<td>{sum(r['done'] for r in group)} of {len(group)}</td>"
            + "".join(cell_of(group, f) for f in figures)
            + "</tr>\n"
        )
    return "".join(parts) + "</tbody></table></div></section>\n"


def page_of(campaign, rows, version):
    facts = [("file", campaign.path.name), ("program", version), ("numbers", "results.parquet, a row a job")]
    return (
        head_of(campaign, rows, version)
        + failures_of(rows)
        + "".join(entry_of(campaign, rows, entry) for entry in dict.fromkeys(job.entry for job in campaign.jobs))
        + '<section class="facts"><h2>How to repeat this campaign</h2>\n'
        + f"<pre><code>airside campaign {esc(campaign.path.name)}</code></pre>\n<dl>\n"
        + "".join(f"<div><dt>{esc(name)}</dt><dd>{esc(value)}</dd></div>\n" for name, value in facts if value)
        + "</dl></section>\n</main>\n</body>\n</html>\n"
    )


def write_page(campaign, rows, version, path):
    whole_file(path, lambda part: Path(part).write_text(page_of(campaign, rows, version), encoding="utf-8"))
