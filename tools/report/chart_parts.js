// What the charts of reports and of the operator's page share: colours and patterns, keys, bands, ticks of time. It goes
// before the script of either, into the same file of the page and into a script of its own in a report.

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
/** A pattern of palette.css as lengths of dash and gap; none: a whole line. */
const pattern = (name) => (colour(name).match(/\d+/g) ?? []).map(Number);

/** What each curve looks like, before its name in the legend; `skipped`: series that are no curve. */
function draw_keys(place, u, skipped = []) {
  place.querySelectorAll('.u-marker').forEach((marker, i) => {
    if (i === 0 || skipped.includes(i)) return marker.remove();  // 0: the time
    const s = u.series[i], ns = 'http://www.w3.org/2000/svg', picture = document.createElementNS(ns, 'svg'), path = document.createElementNS(ns, 'path');
    for (const [k, v] of Object.entries({ viewBox: '0 0 30 10', width: 30, height: 10, 'aria-hidden': 'true', class: 'swatch' })) picture.setAttribute(k, v);
    for (const [k, v] of Object.entries({ d: 'M0 5H30', stroke: s.stroke(u, i), 'stroke-width': Math.max(1.5, s.width), 'stroke-dasharray': (s.dash ?? []).join(' ') })) path.setAttribute(k, v);
    picture.append(path);
    marker.replaceWith(picture);
  });
}

/** The less the controller has the say, the thicker is the edge at the top of the band, px. */
const band_edge = { alarm: 2, run: 3, expert: 6, release: 10 };
/** Bands behind the curves: [kind, from, to]; of no kind: the hours that a report shades. */
const draw_bands = (all) => (u) => {
  const { ctx, bbox } = u;
  ctx.save();
  for (const [kind, begin, end] of all) {
    const from = Math.max(bbox.left, u.valToPos(begin, 'x', true));
    const to = Math.min(bbox.left + bbox.width, u.valToPos(end, 'x', true));
    if (to <= from) continue;
    const shade = colour(kind ? `band-${kind}` : 'band');
    ctx.fillStyle = shade;
    ctx.fillRect(from, bbox.top, Math.max(2, to - from), bbox.height);
    if (!band_edge[kind]) continue;
    ctx.fillStyle = shade.slice(0, 7);
    ctx.fillRect(from, bbox.top, Math.max(2, to - from), band_edge[kind] * devicePixelRatio);
  }
  ctx.restore();
};

/** "08-02" where a day begins or `day` is asked for, else "14:30": the dates of the log, without a year. */
const utc_date = new Intl.DateTimeFormat('en-CA', { timeZone: 'UTC', month: '2-digit', day: '2-digit' });
const utc_clock = new Intl.DateTimeFormat('en-GB', { timeZone: 'UTC', hour: '2-digit', minute: '2-digit' });
const tick = (v, day) => (day ? utc_date : utc_clock).format(new Date(v * 1000));
/** Dates where a day begins, and alone where `only_days`. */
const time_ticks = (splits, only_days) => splits.map((v) => tick(v, v % 86400 === 0 || only_days));
