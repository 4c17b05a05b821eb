// The charts, by uPlot, with a band behind them for every mode but learning. tools/report/chart_parts.js stands before
// this file in what is served: colours, patterns, keys, bands and ticks are those of reports.

import { el, page, t } from '/app.js';

const $ = (id) => document.getElementById(id);
let loading = null;
let drawn = [];
let drawn_as = '', drawn_span = '';

/** The library is no module: it becomes a global of the window. */
function library() {
  loading ??= new Promise((done, fail) => {
    const script = el('script', '', { src: '/uplot.js' });
    script.onload = done;
    script.onerror = () => { loading = null; fail(new Error('uplot')); };
    document.head.append(script);
  });
  return loading;
}

const seconds = (text) => Date.parse(`${text}Z`) / 1000;

/** The modes but learning, and what was not logged. */
const bands = (spells, gaps) => draw_bands([...gaps.map(([from, to]) => ['gap', from, to]), ...spells.filter((s) => s.mode !== 'learn').map((s) => [s.mode, seconds(s.from), seconds(s.to)])]);
function axis(extra = {}) {
  return { stroke: colour('quiet'), grid: { stroke: colour('line'), width: 1 }, ticks: { stroke: colour('line') }, ...extra };
}
const upper = (words) => words[0].toUpperCase() + words.slice(1);

function chart(key, d, gaps, series, unit, digits, height) {
  const shown = series.filter(([, values]) => values.some((v) => v !== null));
  if (shown.length === 0) return null;
  const place = el('div'), title = t(key);
  const figure = el('figure', '', {}, el('figcaption', title), place);
  $('charts').append(figure);
  const options = {
    width: Math.max(240, $('charts').clientWidth), height,
    tzDate: (ts) => window.uPlot.tzDate(new Date(ts * 1000), 'Etc/UTC'),
    cursor: { drag: { x: true, y: false } },
    scales: { x: { time: true, range: (_, min, max) => (min === max ? [min - 1800, max + 1800] : [min, max]) } },
    axes: [axis({ values: (_, splits) => time_ticks(splits, d.span === 'month'), space: 60 }),
      axis({ size: 56, values: (_, splits) => splits.map((v) => `${+v.toFixed(2)}`) })],
    series: [{ label: t('time'), value: (_, v) => (v === null ? '' : `${tick(v, true)} ${tick(v, false)}`) },
      ...shown.map(([label, , stroke, width, dash]) => ({ label, stroke, width, dash, points: { show: false }, value: (u, v) => (v !== null ? `${v.toFixed(digits)} ${unit}` : u.cursor.idx == null ? '' : '–') }))],
    hooks: { drawClear: [bands(d.spells, gaps)], setCursor: [(u) => place.classList.toggle('read', u.cursor.idx != null)] },
  };
  const u = new window.uPlot(options, [d.time_s, ...shown.map(([, values]) => values)], place);
  drawn.push([key, u]);
  draw_keys(place, u);
  for (const canvas of place.querySelectorAll('canvas')) { canvas.setAttribute('role', 'img'); canvas.setAttribute('aria-label', `${title}. ${t('chart-alternative')}`); }
  return figure;
}

/** The stretches that somebody has enlarged, by chart. */
function enlarged(d) {
  if (drawn_span !== d.span || !$('charts').firstChild) return {};
  const part = drawn.filter(([, u]) => u.scales.x.min > u.data[0][0] || u.scales.x.max < u.data[0].at(-1));
  return Object.fromEntries(part.map(([key, u]) => [key, { min: u.scales.x.min, max: u.scales.x.max }]));
}
export async function draw(d, gaps) {
  await library();
  if (page.trends !== d) return;
  // The same once more, every few minutes: nothing is to be done. Else whoever has enlarged a stretch keeps it.
  const now = JSON.stringify([page.texts.lang, innerWidth, colour('quiet'), page.status?.hold ?? page.site.hold, d]);
  if (now === drawn_as && $('charts').firstChild) return;
  drawn_as = now;
  const kept = enlarged(d);
  for (const [, u] of drawn) u.destroy();
  drawn = [];
  drawn_span = d.span;
  $('charts').replaceChildren();
  const rooms = d.rooms_degc.map((values, i) => [t('room', { n: i + 1 }), values, colour(`c${i % 8}`), 1.3, pattern(`d${i % 8 + 1}`)]);
  const target = d.target_degc === null ? [] : [[t('target'), d.time_s.map(() => d.target_degc), colour('schedule'), 1.5, pattern('dref')]];
  const few = rooms.length <= 8 ? rooms : [[t('coldest'), d.low_degc, colour('c4'), 1.3, pattern('d1')], [t('warmest'), d.high_degc, colour('c0'), 1.3, pattern('d2')]];
  const tall = innerWidth < 600 ? 220 : 260;
  chart('chart-rooms', d, gaps, [...few, ...target, [upper(t(`hold.${page.status?.hold ?? page.site.hold ?? 'mean'}`)), d.held_degc, colour('held'), 2.5]], '°C', 2, tall);
  chart('chart-setpoint', d, gaps, [[t('p.schedule'), d.schedule_degc, colour('schedule'), 1, pattern('dref')], [t('p.g36'), d.g36_degc, colour('outdoor'), 1, pattern('d2')],
    [t('supply'), d.supply_degc, colour('supply'), 1.5, pattern('d1')], [t('setpoint'), d.setpoint_degc, colour('set'), 2.5]], '°C', 2, tall);
  chart('chart-power', d, gaps, [[t('power'), d.power_kw, colour('power'), 2]], 'kW', 2, 180);
  chart('chart-outdoor', d, gaps, [[t('outdoor'), d.outdoor_degc, colour('outdoor'), 2]], '°C', 1, 180);
  for (const [key, u] of drawn) if (kept[key]) u.setScale('x', kept[key]);
}
