// The charts, by uPlot, with a band behind them for every mode but learning.

import { el, page, t } from '/app.js';

const $ = (id) => document.getElementById(id);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
let loading = null;
let drawn = [];

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

/** Bands of the modes and of what was not logged, behind the curves. */
function bands(spells, gaps) {
  const all = [...gaps.map(([from, to]) => ['gap', from, to]), ...spells.filter((s) => s.mode !== 'learn').map((s) => [s.mode, seconds(s.from), seconds(s.to)])];
  return (u) => {
    const { ctx, bbox } = u;
    ctx.save();
    for (const [kind, begin, end] of all) {
      const from = Math.max(bbox.left, u.valToPos(begin, 'x', true));
      const to = Math.min(bbox.left + bbox.width, u.valToPos(end, 'x', true));
      if (to <= from) continue;
      ctx.fillStyle = colour(`band-${kind}`);
      ctx.fillRect(from, bbox.top, Math.max(1, to - from), bbox.height);
    }
    ctx.restore();
  };
}
/** Colour alone tells nobody apart whose eyes see few: each room has a pattern too. */
const room_lines = [['c0', []], ['c1', [9, 3]], ['c2', [2, 3]], ['c3', [9, 3, 2, 3]], ['c4', [5, 3]], ['c5', [14, 3, 2, 3, 2, 3]], ['c6', [1, 5]], ['c7', [16, 6]]];
/** What the curve looks like, before its name in the legend. */
function swatch(place, u) {
  place.querySelectorAll('.u-marker').forEach((marker, i) => {
    if (i === 0) return marker.remove();  // of the time
    const s = u.series[i], ns = 'http://www.w3.org/2000/svg', picture = document.createElementNS(ns, 'svg'), path = document.createElementNS(ns, 'path');
    for (const [k, v] of Object.entries({ viewBox: '0 0 30 10', width: 30, height: 10, 'aria-hidden': 'true', class: 'swatch' })) picture.setAttribute(k, v);
    for (const [k, v] of Object.entries({ d: 'M0 5H30', stroke: s.stroke(u, i), 'stroke-width': Math.max(1.5, s.width), 'stroke-dasharray': (s.dash ?? []).join(' ') })) path.setAttribute(k, v);
    picture.append(path);
    marker.replaceWith(picture);
  });
}
function axis(extra = {}) {
  return { stroke: colour('quiet'), grid: { stroke: colour('line'), width: 1 }, ticks: { stroke: colour('line') }, ...extra };
}
const date = new Intl.DateTimeFormat('en-CA', { timeZone: 'UTC', month: '2-digit', day: '2-digit' });
const clock = new Intl.DateTimeFormat('en-GB', { timeZone: 'UTC', hour: '2-digit', minute: '2-digit' });
/** Dates where a day begins; within a month nothing else. */
const x_ticks = (splits, span) => splits.map((v) => tick(v, v % 86400 === 0 || span === 'month'));
const upper = (words) => words[0].toUpperCase() + words.slice(1);
const tick = (v, day) => (day ? date : clock).format(new Date(v * 1000));

function chart(title, d, gaps, series, unit, digits, height) {
  const shown = series.filter(([, values]) => values.some((v) => v !== null));
  if (shown.length === 0) return null;
  const place = el('div');
  const figure = el('figure', '', {}, el('figcaption', title), place);
  $('charts').append(figure);
  const options = {
    width: Math.max(240, $('charts').clientWidth), height,
    tzDate: (ts) => window.uPlot.tzDate(new Date(ts * 1000), 'Etc/UTC'),
    cursor: { drag: { x: true, y: false } },
    scales: { x: { time: true, range: (_, min, max) => (min === max ? [min - 1800, max + 1800] : [min, max]) } },
    axes: [axis({ values: (_, splits) => x_ticks(splits, d.span), space: 60 }),
      axis({ size: 56, values: (_, splits) => splits.map((v) => `${+v.toFixed(2)}`) })],
    series: [{ label: t('time'), value: (_, v) => (v === null ? '' : `${tick(v, true)} ${tick(v, false)}`) },
      ...shown.map(([label, , stroke, width, dash]) => ({ label, stroke, width, dash, points: { show: false }, value: (u, v) => (v !== null ? `${v.toFixed(digits)} ${unit}` : u.cursor.idx == null ? '' : '–') }))],
    hooks: { drawClear: [bands(d.spells, gaps)], setCursor: [(u) => place.classList.toggle('read', u.cursor.idx != null)] },
  };
  const u = new window.uPlot(options, [d.time_s, ...shown.map(([, values]) => values)], place);
  drawn.push(u);
  swatch(place, u);
  for (const canvas of place.querySelectorAll('canvas')) { canvas.setAttribute('role', 'img'); canvas.setAttribute('aria-label', `${title}. ${t('chart-alternative')}`); }
  return figure;
}

export async function draw(d, gaps) {
  await library();
  if (page.trends !== d) return;
  for (const u of drawn) u.destroy();
  drawn = [];
  $('charts').replaceChildren();
  const rooms = d.rooms_degc.map((values, i) => [t('room', { n: i + 1 }), values, colour(room_lines[i % 8][0]), 1.3, room_lines[i % 8][1]]);
  const target = d.target_degc === null ? [] : [[t('target'), d.time_s.map(() => d.target_degc), colour('schedule'), 1.5, [4, 4]]];
  const few = rooms.length <= 8 ? rooms : [[t('coldest'), d.low_degc, colour('c4'), 1.3, [5, 3]], [t('warmest'), d.high_degc, colour('c0'), 1.3]];
  const tall = innerWidth < 600 ? 220 : 260;
  chart(t('chart-rooms'), d, gaps, [...few, ...target, [upper(t(`hold.${page.status?.hold ?? page.site.hold ?? 'mean'}`)), d.held_degc, colour('held'), 2.5]], '°C', 2, tall);
  chart(t('chart-setpoint'), d, gaps, [[t('p.schedule'), d.schedule_degc, colour('schedule'), 1, [4, 4]], [t('p.g36'), d.g36_degc, colour('outdoor'), 1, [2, 3]],
    [t('supply'), d.supply_degc, colour('supply'), 1.5], [t('setpoint'), d.setpoint_degc, colour('set'), 2.5]], '°C', 2, tall);
  chart(t('chart-power'), d, gaps, [[t('power'), d.power_kw, colour('power'), 2]], 'kW', 2, 180);
  chart(t('chart-outdoor'), d, gaps, [[t('outdoor'), d.outdoor_degc, colour('outdoor'), 2]], '°C', 1, 180);
}
