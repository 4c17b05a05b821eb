"""Whether the published orderings hold in the rows that there are. None: a row that it needs is missing."""

from . import published

PEERS_OF_TRANSFER = ("fatdm-head", "fatdm-tail", "daf")


def _of(rows, name):
    return {row["method"]: row[name] for row in rows if name in row}


def _lowest(values, ours, others):
    if ours not in values or any(other not in values for other in others):
        return None
    return all(values[ours] < values[other] for other in others)


def _rising(values, methods):
    if any(method not in values for method in methods):
        return None
    return all(values[a] < values[b] for a, b in zip(methods, methods[1:]))


def _all(found):
    found = list(found)
    return None if not found or None in found else all(found)


def _control(rows):
    dae, darv = _of(rows, "dae_degc"), _of(rows, "darv_degc")
    first, cdh, seconds = (_of(rows, name) for name in ("first_days_degc", "cdh_degch", "decision_s"))
    yield 4, "DAE: ed below expert, pid-spec, osln, ddqn", _lowest(dae, "ed", ("expert", "pid-spec", "osln", "ddqn"))
    yield 4, "DARV: ed < osln < ddqn", _rising(darv, ("ed", "osln", "ddqn"))
    yield 4, "first three days: ed below osln and ddqn", _lowest(first, "ed", ("osln", "ddqn"))
    yield 4, "expert above 1 °C", dae["expert"] > 1 if "expert" in dae else None
    yield 15, "DAE: ed below pid-spec and ddqn", _lowest(dae, "ed", ("pid-spec", "ddqn"))
    yield 15, "DARV: ed below ddqn", _lowest(darv, "ed", ("ddqn",))
    yield 15, "CDH: ed below osln and pid-spec", _lowest(cdh, "ed", ("osln", "pid-spec"))
    yield 16, "DAE: ed below every LSTM and Transformer", _lowest(dae, "ed", published.SERIES)
    yield 16, "time: ed < LSTM < Transformer in each shape", _all(
        _rising(seconds, ("ed", f"lstm-{length}-{layers}", f"transformer-{length}-{layers}"))
        for length, layers in published.SHAPES)
    yield 16, "lowest DARV: lstm-3-4", _lowest(darv, "lstm-3-4",
                                               [name for name in published.SERIES if name != "lstm-3-4"])


def _transfer(rows):
    rooms = {}
    for row in rows:
        rooms.setdefault(row["room"], []).append(row)
    for room, mine in rooms.items():
        summer, winter, average = (_of(mine, f"mae_{name}_degc") for name in ("summer", "winter", "average"))
        for season, values in (("summer", summer), ("winter", winter)):
            yield 11, f"{room}, {season}: dynamic below FATDM and DAF", _lowest(values, "dynamic", PEERS_OF_TRANSFER)
        yield 12, f"{room}, average: dynamic < static < none", _rising(average, ("dynamic", "static", "none"))
        yield 13, f"{room}: winter above summer for dynamic", (
            winter["dynamic"] > summer["dynamic"] if "dynamic" in winter else None)


def verdicts(study, rows):
    """[{claim, condition, holds}]; numbers of claims as in docs/peers.md."""
    found = {"control": _control, "transfer": _transfer}[study](rows)
    return [{"claim": claim, "condition": condition, "holds": holds} for claim, condition, holds in found]


def markdown(found):
    words = {True: "yes", False: "no", None: "not known yet"}
    lines = ["| claim | condition | holds |", "| --- | --- | --- |"]
    lines += [f"| {one['claim']} | {one['condition']} | {words[one['holds']]} |" for one in found]
    return "\n".join(lines)
