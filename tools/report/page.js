// Draws the line charts of a report from the JSON beside it. One cursor and one zoom for all charts over time.
// chart_parts.js stands before this file: what it shares with the operator's page.
(() => {
  "use strict";
  const charts = JSON.parse(document.getElementById("charts").textContent);
  const root = document.documentElement;
  const plots = [];
  const DAY = 86400;
  let range = null;      // of all charts over time; null: everything
  let spreading = false; // a zoom is being passed on to the other charts

  const times = charts.filter((c) => c.time && c.x.length);
  const first = Math.min(...times.map((c) => c.x[0]));
  const last = Math.max(...times.map((c) => c.x[c.x.length - 1]));
  const utc = (s) => uPlot.tzDate(new Date(s * 1e3), "Etc/UTC");
  const day = uPlot.fmtDate("{WWW} {YYYY}-{MM}-{DD}");
  const minute = uPlot.fmtDate("{WWW} {YYYY}-{MM}-{DD} {HH}:{mm}");
  const clock = (u, splits, axis, space, step) => step >= 28 * DAY
    ? splits.map((s) => new Date(s * 1e3).toISOString().slice(0, 7)) : time_ticks(splits, step >= DAY);

  function show(from, to) {
    const width = Math.max(to - from, 1800);
    range = from <= first && to >= last ? null : [from, from + width];
    const [min, max] = range || [first, last];
    spreading = true;
    for (const p of plots) if (p.isTime) p.setScale("x", { min, max });
    spreading = false;
    showDays();
  }

  // What holds at a time, such as a control mode, in words beside the cursor.
  const stretch_at = (c) => (u, v, series, i) => {
    if (i == null) return "\u2013";
    const now = c.stretches.filter(([from, to]) => from <= c.x[i] && c.x[i] < to).pop();
    return now ? now[3] : c.otherwise;
  };
  // On a phone a long name stands in two lines.
  const folded = (name) => name.replace(/^(.{8,}?) /, "$1\n");

  // Two fingers zoom, one finger moves what is zoomed; up and down still scroll the page.
  function touch(u) {
    let start = null;
    const grip = (e) => {
      const rect = u.over.getBoundingClientRect();
      const at = [...e.touches].map((t) => t.clientX - rect.left);
      const { min, max } = u.scales.x;
      return { at, min, per: (max - min) / rect.width, n: at.length };
    };
    u.over.addEventListener("touchstart", (e) => { start = grip(e); }, { passive: true });
    u.over.addEventListener("touchmove", (e) => {
      const now = grip(e);
      if (!start || now.n !== start.n || now.n > 2 || (now.n === 1 && !range)) return;
      const span = (g) => Math.max(Math.abs(g.at[0] - g.at[1]), 20);
      const per = now.n === 2 ? start.per * span(start) / span(now) : start.per;
      const middle = (g) => g.at.reduce((a, b) => a + b) / g.n;
      const from = start.min + middle(start) * start.per - middle(now) * per;
      const width = u.over.clientWidth * per;
      const a = Math.max(first, Math.min(from, last - width));
      if (e.cancelable && now.n === 2) e.preventDefault();
      show(a, Math.min(a + width, last));
    }, { passive: false });
  }

  function draw(place, c) {
    const narrow = place.clientWidth < 560;
    const ink = () => colour("soft");
    const axis = {
      stroke: ink, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
      grid: { stroke: () => colour("grid"), width: 1 }, ticks: { stroke: () => colour("grid"), width: 1, size: 4 },
    };
    const named = c.yNames.length > 0, has_stretches = c.stretches.length > 0;
    if (named) place.style.minHeight = "0";
    const names = narrow ? c.yNames.map(folded) : c.yNames;
    const letters = Math.max(0, ...names.flatMap((n) => n.split("\n").map((part) => part.length)));
    const value = (u, v) => v == null ? "\u2013"
      : named ? (v - Math.floor(v + 0.01) >= 0.5 ? c.raised : c.raised ? "" : c.yNames[Math.round(v)])
      : c.log ? Number(v.toPrecision(3)).toString() : v.toFixed(c.decimals).replace("-", "\u2212");
    const stepped = uPlot.paths.stepped({ align: 1 });
    const opts = {
      width: place.clientWidth, height: named ? 80 + 26 * c.yNames.length : narrow ? 260 : 300, tzDate: utc,
      cursor: {
        focus: { prox: 14 }, points: { size: 6 },
        ...(c.time ? { sync: { key: "time", setSeries: false } } : {}),
      },
      focus: { alpha: 0.35 },
      legend: { live: true },
      scales: {
        x: { time: c.time },
        y: c.log ? { distr: 3 } : named ? { range: () => [-0.3, c.yNames.length - (c.raised ? 0.1 : 0.7)] } : {
          range: (u, low, high) => {
            if (low == null) return [0, 1];
            if (c.yMin != null) low = Math.min(low, c.yMin);
            if (c.yMax != null) high = Math.max(high, c.yMax);
            const pad = (high - low || 1) * 0.06;
            return [c.yMin != null && low >= c.yMin ? low : low - pad, high + pad];
          },
        },
      },
      axes: [
        { ...axis, size: 40, ...(c.time ? { values: clock } : { label: c.xLabel, labelSize: 22 }), space: narrow ? 56 : 64 },
        {
          ...axis, label: c.unit, labelSize: 20, size: Math.max(66, 22 + 6.4 * letters),
          ...(named ? { splits: () => names.map((_, i) => i), values: () => names } : {}),
          ...(c.log ? { values: (u, all) => all.map((v) => v == null ? "" : Number.isInteger(Math.round(Math.log10(v) * 1e6) / 1e6) ? String(Number(v.toPrecision(1))) : "") } : {}),
        },
      ],
      series: [
        { label: c.time ? "time" : c.xLabel, value: (u, v) => v == null ? "\u2013" : c.time ? minute(utc(v)) : String(v) },
        ...c.series.map((s) => ({
          label: s.name, value, stroke: () => colour(s.colour) + (s.muted ? "c0" : ""),
          width: s.colour === "main" ? 2.4 : s.muted ? 1.2 : 1.5, dash: pattern(s.dash),
          paths: s.step ? stepped : undefined, points: { show: false }, spanGaps: false,
        })),
        ...(has_stretches ? [{ label: c.stretchesName, value: stretch_at(c), class: "stretch-now", points: { show: false } }] : []),
      ],
      hooks: {
        drawClear: [draw_bands([...c.bands.map(([from, to]) => ["", from, to]), ...c.stretches.map(([from, to, kind]) => [kind, from, to])])],
        setScale: [(u, key) => {
          if (key !== "x" || !c.time || spreading || !u.status) return;
          const { min, max } = u.scales.x;
          const now = range || [first, last];
          if (min !== now[0] || max !== now[1]) show(min, max);
        }],
      },
    };
    const n = c.x.length;
    const data = [c.x, ...c.series.map((s) => Array.isArray(s.y) ? s.y : new Array(n).fill(s.y)), ...(has_stretches ? [new Array(n).fill(null)] : [])];
    place.replaceChildren();
    const u = new uPlot(opts, data, place);
    draw_keys(place, u, has_stretches ? [c.series.length + 1] : []);
    u.isTime = c.time;
    u.place = place;
    if (c.time) touch(u);
    plots.push(u);
  }

  function drawAll() {
    for (const u of plots.splice(0)) u.destroy();
    for (const place of document.querySelectorAll("[data-chart]")) draw(place, charts[place.dataset.chart]);
    if (range) show(range[0], range[1]);
  }

  // One day at a time, for those who would rather tap than drag.
  const bar = document.getElementById("days");
  const button = (text, label, act) => {
    const b = document.createElement("button");
    b.type = "button";
    b.textContent = text;
    b.setAttribute("aria-label", label);
    b.addEventListener("click", act);
    return b;
  };
  const midnight = (s) => Math.floor(s / DAY) * DAY;
  const step = (by) => () => {
    const from = range ? midnight((range[0] + range[1]) / 2) + by * DAY : midnight(by > 0 ? first : last - 1);
    show(from, from + DAY);
  };
  const all = button("All days", "Show all days", () => show(first, last));
  const back = button("\u2039", "Day before", step(-1));
  const next = button("\u203a", "Next day", step(1));
  const label = document.createElement("output");
  const hint = document.createElement("span");
  hint.className = "hint";
  hint.textContent = "Drag across a chart to zoom, double-click to go back";
  bar.append(all, back, label, next, hint);
  function showDays() {
    const [from, to] = range || [first, last];
    const one = midnight(from) === midnight(to - 1);
    label.textContent = one ? day(utc(from)) : day(utc(from)) + " \u2013 " + day(utc(to - 1));
    all.disabled = !range;
    back.disabled = range !== null && midnight((from + to) / 2) <= midnight(first);
    next.disabled = range !== null && midnight((from + to) / 2) >= midnight(last - 1);
  }
  if (times.length && last - first > DAY) {
    bar.hidden = false;
    showDays();
  }

  // A key of a bar chart brings its method forward.
  for (const chart of document.querySelectorAll(".bars")) {
    let held = null;
    const bring = (key) => {
      for (const g of chart.querySelectorAll("svg g")) g.classList.toggle("away", key !== null && !g.classList.contains("g" + key));
    };
    for (const b of chart.querySelectorAll("button")) {
      b.addEventListener("mouseenter", () => bring(b.dataset.group));
      b.addEventListener("mouseleave", () => bring(held));
      b.addEventListener("click", () => {
        held = held === b.dataset.group ? null : b.dataset.group;
        for (const o of chart.querySelectorAll("button")) o.setAttribute("aria-pressed", String(o.dataset.group === held));
        bring(held);
      });
    }
  }

  drawAll();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  let width = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth === width) return;
    width = innerWidth;
    for (const u of plots) u.setSize({ width: u.place.clientWidth, height: u.height });
  });
  root.dataset.drawn = String(plots.length);
})();
