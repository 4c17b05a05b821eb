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

/** Bands of the modes, behind the curves. */
function bands(spells) {
  return (u) => {
    const { ctx, bbox } = u;
    ctx.save();
    for (const s of spells) {
      if (s.mode === 'learn') continue;
      const from = Math.max(bbox.left, u.valToPos(seconds(s.from), 'x', true));
      const to = Math.min(bbox.left + bbox.width, u.valToPos(seconds(s.to), 'x', true));
      if (to <= from) continue;
      ctx.fillStyle = colour(`band-${s.mode}`);
      ctx.fillRect(from, bbox.top, Math.max(1, to - from), bbox.height);
    }
    ctx.restore();
  };
}
function axis(extra = {}) {
  return { stroke: colour('quiet'), grid: { stroke: colour('line'), width: 1 }, ticks: { stroke: colour('line') }, ...extra };
}
const date = new Intl.DateTimeFormat('en-CA', { timeZone: 'UTC', month: '2-digit', day: '2-digit' });
const clock = new Intl.DateTimeFormat('en-GB', { timeZone: 'UTC', hour: '2-digit', minute: '2-digit' });
const tick = (v, day) => (day ? date : clock).format(new Date(v * 1000));

function chart(title, d, series, unit, digits, height) {
  const shown = series.filter(([, values]) => values.some((v) => v !== null));
  if (shown.length === 0) return null;
  const place = el('div');
  const figure = el('figure', '', {}, el('figcaption', title), place);
  $('charts').append(figure);
  const long = d.span !== 'day';
  const options = {
    width: Math.max(240, $('charts').clientWidth), height,
    tzDate: (ts) => window.uPlot.tzDate(new Date(ts * 1000), 'Etc/UTC'),
    cursor: { drag: { x: true, y: false } },
    scales: { x: { time: true } },
    axes: [axis({ values: (_, splits) => splits.map((v) => (long && v % 86400 === 0 ? tick(v, true) : long && d.span === 'month' ? tick(v, true) : tick(v, false))), space: 60 }),
      axis({ size: 56, values: (_, splits) => splits.map((v) => `${+v.toFixed(2)}`) })],
    series: [{ label: t('time'), value: (_, v) => (v === null ? '–' : `${tick(v, true)} ${tick(v, false)}`) },
      ...shown.map(([label, , stroke, width, dash]) => ({ label, stroke, width, dash, points: { show: false }, value: (_, v) => (v === null ? '–' : `${v.toFixed(digits)} ${unit}`) }))],
    hooks: { drawClear: [bands(d.spells)] },
  };
  drawn.push(new window.uPlot(options, [d.time_s, ...shown.map(([, values]) => values)], place));
  for (const canvas of place.querySelectorAll('canvas')) { canvas.setAttribute('role', 'img'); canvas.setAttribute('aria-label', `${title}. ${t('chart-alternative')}`); }
  return figure;
}

export async function draw(d) {
  await library();
  for (const u of drawn) u.destroy();
  drawn = [];
  $('charts').replaceChildren();
  const rooms = d.rooms_degc.map((values, i) => [t('room', { n: i + 1 }), values, colour('room'), 1]);
  const target = d.target_degc === null ? [] : [[t('target'), d.time_s.map(() => d.target_degc), colour('schedule'), 1, [4, 4]]];
  const few = rooms.length <= 8 ? rooms : [[t('coldest'), d.low_degc, colour('room'), 1], [t('warmest'), d.high_degc, colour('room'), 1]];
  const tall = innerWidth < 600 ? 220 : 260;
  chart(t('chart-rooms'), d, [...few, ...target, [t(`hold.${page.status?.hold ?? 'mean'}`), d.held_degc, colour('held'), 2.5]], '°C', 2, tall);
  chart(t('chart-setpoint'), d, [[t('p.schedule'), d.schedule_degc, colour('schedule'), 1, [4, 4]], [t('p.g36'), d.g36_degc, colour('outdoor'), 1, [2, 3]],
    [t('supply'), d.supply_degc, colour('supply'), 1.5], [t('setpoint'), d.setpoint_degc, colour('set'), 2.5]], '°C', 2, tall);
  chart(t('chart-power'), d, [[t('power'), d.power_kw, colour('power'), 2]], 'kW', 2, 180);
  chart(t('chart-outdoor'), d, [[t('outdoor'), d.outdoor_degc, colour('outdoor'), 2]], '°C', 1, 180);
}
