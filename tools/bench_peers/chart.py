"""Draws the figures of tools/bench-peers (JSON on standard input): chart.py FILE"""

import json
import math
import sys

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.fonttype"] = "none"
import matplotlib.pyplot as plt
from matplotlib.ticker import NullFormatter

STEP_FLOP = 2 * 178368
OURS, PEER, LIMIT = "#0072b2", "#999999", "#d55e00"


def main():
    data = json.load(sys.stdin)
    works = list(dict.fromkeys((f["kind"], f["count"]) for f in data["figures"]))
    works = [
        w
        for w in works
        if any(f["kind"] == w[0] and f["count"] == w[1] and not f["row"].startswith("airside") for f in data["figures"])
    ]
    peak = max((p["gflops"] for p in data["fma_peak"].values()), default=0)
    columns = 4
    lines = -(-len(works) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(12, 2.9 * lines), layout="constrained", squeeze=False)
    for axis in axes.flat[len(works) :]:
        axis.axis("off")
    for axis, (kind, count) in zip(axes.flat, works):
        rows = sorted(
            (f for f in data["figures"] if (f["kind"], f["count"]) == (kind, count)), key=lambda f: -f["median_us"]
        )
        names = [f["row"].replace("airside_", "airside ") for f in rows]
        times = [f["median_us"] for f in rows]
        bars = axis.barh(names, times, color=[OURS if f["row"].startswith("airside") else PEER for f in rows])
        axis.bar_label(bars, labels=[f"{t:.3g}" if t < 1000 else f"{t:.0f}" for t in times], padding=3, fontsize=8)
        if kind == "step" and peak:
            limit = STEP_FLOP * count / 1e3 / peak
            axis.axvline(limit, color=LIMIT, linestyle="--", linewidth=1)
            axis.set_xlabel(f"us; dashed: all FLOPs at {peak:.0f} GFLOP/s, {limit:.0f} us", fontsize=8)
        else:
            axis.set_xlabel("us", fontsize=8)
        axis.set_xscale("log")
        axis.set_xlim(10 ** math.floor(math.log10(0.9 * min(times))), 4 * max(times))
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.tick_params(labelsize=8)
        axis.set_title(f"{kind} {count}", fontsize=10)
        axis.spines[["top", "right"]].set_visible(False)
    figure.suptitle("One thread, medians of wall time, one run; shorter is better", fontsize=11)
    figure.savefig(sys.argv[1], dpi=110)


if __name__ == "__main__":
    main()
