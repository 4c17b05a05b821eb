// Why this setpoint: what the last decision weighed, as a chart and a table; and how far forecasts were from the rooms.

import { el, page, say, sentences, t } from '/app.js';

const $ = (id) => document.getElementById(id);
const known = (v) => typeof v === 'number' && Number.isFinite(v);
const deg = (v) => (known(v) ? `${v.toFixed(2)} °C` : '–');
const plain = (v) => (known(v) ? v.toFixed(2) : '–');
const kelvin = (v) => (known(v) ? v.toFixed(3) : '–');

function svg(name, attributes = {}, ...children) {
  const e = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
  e.append(...children);
  return e;
}
/** A path through the points that are known. */
function line(points, kind) {
  let d = '', pen = 'M';
  for (const [x, y] of points) {
    if (!known(y)) { pen = 'M'; continue; }
    d += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  }
  return svg('path', { d, class: kind });
}
const ticks = (low, high, count) => {
  const raw = (high - low) / count, unit = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((f) => f * unit).find((s) => s >= raw);
  const list = [];
  for (let v = Math.ceil(low / step) * step; v <= high + step * 1e-6; v += step) list.push(Number(v.toFixed(6)));
  return list;
};
/** `stacks`: on a phone each row is a card. It then is no table to the browser any more, so the roles are said. */
export function table(id, caption, heads, rows, stacks = false) {
  const role = (name) => (stacks ? { role: name } : {});
  const head = el('tr', '', role('row'), ...heads.map((h) => el('th', h, { scope: 'col', ...role('columnheader') })));
  const lines = rows.map((r) => el('tr', '', role('row'), ...r.map((c, i) => {
    const cell = i === 0 ? el('th', '', { scope: 'row', ...role('rowheader') }) : el('td', '', { 'data-head': heads[i], ...role('cell') });
    cell.append(c);
    return cell;
  })));
  if (stacks) $(id).setAttribute('role', 'table');
  $(id).replaceChildren(el('caption', caption), el('thead', '', role('rowgroup'), head), el('tbody', '', role('rowgroup'), ...lines));
}

/** What is drawn: setpoints, curves over them, and marks. */
function weighed() {
  const s = page.status, c = s.candidates;
  if (!c || !c.count_of) return null;
  const curves = [], marks = [];
  if (c.cost_kw) curves.push(['w-head', 'why-cost', c.cost_kw]);
  if (known(c.head_from_degc)) curves.push(['w-head', 'p.head-expects', c.setpoints.map((_, i) => c.head_from_degc + c.head_gain * c.step_k * i)]);
  if (c.network_held_degc) curves.push(['w-network', 'p.network-expects', c.network_held_degc]);
  const add = (kind, key, v) => { if (known(v)) marks.push([kind, key, v]); };
  add('m-set', 'why-commanded', c.commanded_degc);
  if (!c.cost_kw) { add('m-head', 'p.head', s.head_setpoint_degc); add('m-network', 'p.network', s.network_setpoint_degc); }
  add('m-schedule', 'p.schedule', s.expert_setpoint_degc);
  add('m-g36', 'p.g36', s.g36_setpoint_degc);
  return { curves, marks };
}
function chart(c, { curves, marks }) {
  const width = Math.max(260, Math.min(720, $('why-chart').clientWidth || 320)), height = 210, left = 54, right = 8, top = 8, bottom = 34;
  const x0 = Math.min(c.setpoints[0], ...marks.map(([, , v]) => v)), x1 = Math.max(c.setpoints.at(-1), ...marks.map(([, , v]) => v));
  const aim = c.cost_kw ? null : known(c.head_aim_degc) ? c.head_aim_degc : page.status.target_degc;
  const all = [...curves.flatMap(([, , v]) => v), aim].filter(known);
  const pad = 0.08 * (Math.max(...all) - Math.min(...all)) || 0.1;
  const y0 = Math.min(...all) - pad, y1 = Math.max(...all) + pad;
  const x = (v) => left + ((v - x0) / (x1 - x0)) * (width - left - right);
  const y = (v) => (known(v) ? top + ((y1 - v) / (y1 - y0)) * (height - top - bottom) : null);
  const parts = [];
  for (const v of ticks(y0, y1, 6)) parts.push(svg('path', { d: `M${left} ${y(v)}H${width - right}`, class: 'grid' }), text(left - 5, y(v) + 4, `${v}`, 'end'));
  for (const v of ticks(x0, x1, width < 400 ? 4 : 7)) parts.push(text(x(v), height - bottom + 15, `${v}`, 'middle'));
  parts.push(text((left + width - right) / 2, height - 3, t('why-x'), 'middle'));
  if (known(aim)) parts.push(svg('path', { d: `M${left} ${y(aim)}H${width - right}`, class: 'w-aim' }));
  for (const [kind, , v] of [...marks].reverse()) parts.push(svg('path', { d: `M${x(v).toFixed(1)} ${top}V${height - bottom}`, class: kind }));
  for (const [kind, , values] of curves) parts.push(line(values.map((v, i) => [x(c.setpoints[i]), y(v)]), kind));
  return { picture: svg('svg', { viewBox: `0 0 ${width} ${height}`, width, height, role: 'img', 'aria-label': alternative(c, curves, marks, aim) }, ...parts), aim };
}
function text(x, y, words, anchor) {
  const e = svg('text', { x: x.toFixed(1), y: y.toFixed(1), 'text-anchor': anchor });
  e.textContent = words;
  return e;
}
const unit_of = (c) => (c.cost_kw ? 'kW' : '°C');
function alternative(c, curves, marks, aim) {
  const ends = curves.map(([, key, v]) => t('why-alt-curve', { what: t(key), a: `${v[0]?.toFixed(2) ?? '–'}`, b: `${v.at(-1)?.toFixed(2) ?? '–'}`, unit: unit_of(c) }));
  const places = marks.map(([, key, v]) => `${t(key)} ${deg(v)}`);
  return `${t('why-alt', { from: deg(c.setpoints[0]), to: deg(c.setpoints.at(-1)) })} ${ends.join(' ')} ${known(aim) ? `${t('why-aim')} ${deg(aim)}. ` : ''}${places.join('; ')}. ${t('why-alt-table')}`;
}
/** A dozen of the candidates, and those that the marks are nearest to. */
function candidate_rows(c, { marks }) {
  const nearest = (v) => c.setpoints.reduce((best, s, i) => (Math.abs(s - v) < Math.abs(c.setpoints[best] - v) ? i : best), 0);
  const remarks = new Map();
  for (const [, key, v] of marks) remarks.set(nearest(v), [...(remarks.get(nearest(v)) ?? []), t(key)]);
  const every = Math.max(1, Math.round(c.setpoints.length / 12));
  return c.setpoints.map((v, i) => [v, i]).filter(([, i]) => i % every === 0 || remarks.has(i)).map(([v, i]) => {
    const values = c.cost_kw ? [kelvin(c.cost_kw[i])]
      : [known(c.head_from_degc) ? plain(c.head_from_degc + c.head_gain * c.step_k * i) : '–', plain(c.network_held_degc?.[i]), kelvin(c.network_score_k?.[i])];
    return [plain(v), ...values, (remarks.get(i) ?? []).join(', ')];
  });
}

let shown = '';
export const forget_why = () => { shown = ''; $('why-chart').replaceChildren(); $('why-weighed').hidden = true; };
export function show_why() {
  const s = page.status, c = s.candidates;
  if (c) {
    c.count_of = (c.cost_kw ?? c.network_held_degc ?? []).length;
    c.setpoints = Array.from({ length: c.count_of }, (_, i) => c.from_degc + i * c.step_k);
  }
  const now = JSON.stringify([c, s.reason, s.expert_setpoint_degc, s.g36_setpoint_degc, s.head_setpoint_degc, s.network_setpoint_degc, page.texts.lang, $('why-chart').clientWidth]);
  if (now === shown) return;
  shown = now;
  const found = s.reason === 'no reading' ? null : weighed();
  $('why-weighed').hidden = !found;
  say('why-none', found ? '' : t(c ? 'why-none-now' : 'why-none', { min: page.site.cycle_min ?? 18 }));
  say('why-shares', found && known(c.schedule_share) ? shares(c) : '');
  if (!found) return;
  const { picture, aim } = chart(c, found);
  $('why-chart').replaceChildren(picture);
  const sign = (kind, words) => el('li', '', {}, el('i', '', { class: kind }), words);
  $('why-legend').replaceChildren(...found.curves.map(([kind, key]) => sign(kind, `${t(key)}, ${unit_of(c)}`)), ...(known(aim) ? [sign('w-aim', `${t('why-aim')} ${deg(aim)}`)] : []),
    ...found.marks.map(([kind, key, v]) => sign(`${kind} mark`, `${t(key)} ${deg(v)}`)));
  table('candidates', t(c.cost_kw ? 'why-caption-cost' : 'why-caption', { n: c.count_of, at: c.time.replace('T', ' ').slice(0, 16) }),
    c.cost_kw ? [t('why-x'), t('why-cost-kw'), t('why-remark')] : [t('why-x'), `${t('p.head-expects')}, °C`, `${t('p.network-expects')}, °C`, t('why-score'), t('why-remark')], candidate_rows(c, found));
}
function shares(c) {
  const own = 1 - c.schedule_share, head = known(c.head_share) ? c.head_share : 0, percent = (v) => Math.round(100 * v);
  return t('why-shares', { h: percent(own * head), n: percent(own * (1 - head)), s: percent(c.schedule_share), at: deg(c.proposed_degc), cmd: deg(c.commanded_degc) });
}

/** A curve as long as a word: root mean square by day. */
function spark(values) {
  const most = Math.max(0.01, ...values.filter(known)), n = Math.max(1, values.length - 1);
  return svg('svg', { viewBox: '0 0 120 24', width: 120, height: 24, 'aria-hidden': 'true', class: 'spark' }, line(values.map((v, i) => [3 + (i / n) * 114, known(v) ? 21 - (v / most) * 18 : null]), 'w-head'));
}
export function show_gap() {
  const g = page.gap;
  if (!g) return;
  const names = g.bias_k.map((_, i) => (i === 0 ? t('gap-held', { rule: t(`hold.${page.status?.hold ?? 'mean'}`) }) : t('room', { n: i })));
  const growing = names.filter((_, i) => g.grows[i]);
  $('gap-shown').hidden = g.n === 0;
  let said = t('gap-none');
  if (g.n > 0 && !g.enough) said = t('gap-few', { n: g.recent_days + g.before_days });
  else if (g.n > 0) said = growing.length ? t('gap-grows', { who: growing.join(', '), d: g.recent_days, n: g.before_days }) : t('gap-same', { d: g.recent_days, n: g.before_days });
  say('gap-said', said);
  const installer = page.session.role === 'installer';
  $('gap-do').hidden = growing.length === 0 || !installer;
  const commands = g.commands.join('\n');
  say('gap-commands', $('gap-do').hidden ? '' : commands);
  say('gap-do-said', $('gap-do').hidden ? '' : sentences([t('gap-do'), g.commands.length > 1 && t('gap-do-fit'), commands.includes('STATION.epw') && t('gap-do-weather')]));
  $('gap-tell').hidden = growing.length === 0 || installer;
  if (g.n === 0) return;
  table('gap', t('gap-caption', { n: g.n, days: g.days.length, min: g.cycle_min }), [t('gap-of'), t('bias'), t('rms'), t('rms-recent', { d: g.recent_days }), t('rms-before', { n: g.before_days }), t('rms-by-day')],
    names.map((name, i) => [g.grows[i] ? el('strong', `${name} ▲`) : name, kelvin(g.bias_k[i]), kelvin(g.rms_k[i]), kelvin(g.recent_rms_k[i]), kelvin(g.before_rms_k[i]), spark(g.days.map((d) => d.rms_k[i]))]));
  table('gap-days', t('gap-days-caption'), [t('date'), ...names], [...g.days].reverse().map((d) => [d.date, ...d.rms_k.map((v, i) => `${kelvin(d.bias_k[i])} / ${kelvin(v)}`)]));
}
