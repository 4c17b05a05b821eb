"""Rows and Markdown tables: mean and standard deviation over rooms and seeds beside the published figure."""

import statistics

from . import published, runs

FIRST_DAYS = 3
FIGURES = {"control": ("dae_degc", "me_degc", "darv_degc", "first_days_degc", "cdh_degch", "hdh_degch", "decision_s"),
           "transfer": ("mae_summer_degc", "mae_winter_degc")}


def _value(figures, name):
    if name == "first_days_degc":
        return statistics.fmean(figures["daily_dae_degc"][:FIRST_DAYS])
    return figures.get(name)


def rows_of(found):
    """[row] of {run: figures}: one a method, and in the transfer study one a method and room."""
    groups = {}
    for run, figures in found.items():
        room = run.room if run.study == "transfer" else None
        groups.setdefault((run.study, room, run.method), []).append(figures)
    order = {method: place for costs in runs.COSTS.values() for place, method in enumerate(costs)}
    return [_row(*key, groups[key]) for key in sorted(groups, key=lambda k: (k[0], k[1] or "", order[k[2]]))]


def _row(study, room, method, several):
    row = {"method": method, "runs": len(several), **({"room": room} if room else {})}
    for name in FIGURES[study]:
        values = [_value(figures, name) for figures in several]
        if None in values:
            continue
        row[name] = statistics.fmean(values)
        row[name + "_sd"] = statistics.stdev(values) if len(values) > 1 else None
    days = [figures["daily_dae_degc"] for figures in several if figures.get("daily_dae_degc")]
    if len(days) == len(several):
        row["daily_dae_degc"] = [statistics.fmean(day) for day in zip(*days)]
    if study == "transfer":
        row["mae_average_degc"] = (row["mae_summer_degc"] + row["mae_winter_degc"]) / 2
    return row


def _cell(row, name, digits=3, factor=1.0):
    if name not in row:
        return ""
    spread = row.get(name + "_sd")
    return f"{factor * row[name]:.{digits}f}" + ("" if spread is None else f" ± {factor * spread:.{digits}f}")


def _table(head, lines):
    texts = ["| " + " | ".join(cells) + " |" for cells in [head, ["---"] * len(head), *lines]]
    return "\n".join(texts) + "\n"


def _number(value):
    return "" if value is None else f"{value:g}"


def control_table(rows):
    head = ["method", "runs", "DAE °C", "published", "ME °C", "DARV °C", "published", f"first {FIRST_DAYS} days °C",
            "CDH °C h", "published", "ms a decision", "published (no unit)"]
    lines = []
    for row in rows:
        said = published.CONTROL.get(row["method"], {})
        lines.append([row["method"], str(row["runs"]), _cell(row, "dae_degc"), _number(said.get("dae_degc")),
                      _cell(row, "me_degc"), _cell(row, "darv_degc"), _number(said.get("darv_degc")),
                      _cell(row, "first_days_degc"), _cell(row, "cdh_degch", 0), _number(said.get("cdh_degch")),
                      _cell(row, "decision_s", 2, 1e3), _number(said.get("decision"))])
    return _table(head, lines)


def transfer_table(rows):
    head = ["room", "method", "runs", "summer °C", "published", "winter °C", "published", "average °C", "published"]
    lines = []
    for row in rows:
        number = row["room"].removesuffix("-real")
        said = [published.TRANSFER.get((number, season), {}).get(row["method"]) for season in ("summer", "winter")]
        mean = None if None in said else sum(said) / 2
        lines.append([row["room"], row["method"], str(row["runs"]), _cell(row, "mae_summer_degc"), _number(said[0]),
                      _cell(row, "mae_winter_degc"), _number(said[1]), _cell(row, "mae_average_degc"), _number(mean)])
    return _table(head, lines)


def markdown(study, rows):
    return {"control": control_table, "transfer": transfer_table}[study](rows)
