// What is shown of state, alarms, rooms, setpoint, balance and weights.

import { acknowledge, el, has, page, say, t } from '/app.js';
import { show_gap, show_why, table } from '/why.js';

const $ = (id) => document.getElementById(id);
const known = (v) => typeof v === 'number' && Number.isFinite(v);
const deg = (v, digits = 2) => (known(v) ? `${v.toFixed(digits)} °C` : '–');
const number = (v, digits, unit) => (known(v) ? `${v.toFixed(digits)}${unit}` : '–');
export const moment = (text) => (text ?? '').replace('T', ' ').slice(0, 16);

/** As `airside status` has it: a status that is old says what was, not what is. */
function condition() {
  if (page.status.stopped) return 'stopped';
  return page.age > 900 ? 'stale' : page.status.alarms.length ? 'alarm' : 'running';
}
const reason_text = (name, part, otherwise) => (has(`reason.${name}.${part}`) ? t(`reason.${name}.${part}`) : otherwise);

function sentence() {
  const s = page.status, c = condition(), runs = c === 'running' || c === 'alarm';
  let text = c === 'stopped' ? `${t('stopped', { at: moment(s.stopped_at) })}\n` : c === 'stale' ? `${t('stale')}\n` : '';
  text += t(`state.${s.state}.${runs ? 'now' : 'then'}`);
  if (s.reason !== 'none') {
    const out = s.release_ends ? t('release-ends', { at: moment(s.release_ends) }) : reason_text(s.reason, 'out', s.way_out);
    text += t('because', { why: reason_text(s.reason, 'why', s.why), out });
  }
  if (s.fault === 'none') return text + t('no-fault');
  const fault = has(`fault.${s.fault}`) ? t(`fault.${s.fault}`) : s.fault;
  return text + (s.fault_signal ? t('fault-at', { fault, signal: s.fault_signal }) : t('fault', { fault }));
}
function span_text(seconds) {
  if (seconds < 120) return t('seconds', { n: Math.round(seconds) });
  if (seconds < 7200) return t('minutes', { n: Math.round(seconds / 60) });
  return seconds < 172800 ? t('hours', { n: Math.round(seconds / 3600) }) : t('days', { n: Math.round(seconds / 86400) });
}

page.span_text = span_text;

function show_state() {
  const c = condition(), s = page.status;
  const word = c === 'stopped' || c === 'stale' ? c : s.state;
  $('badge').className = `badge ${word}`;
  say('badge', t(`badge.${word}`));
  say('sentence', sentence());
  say('age', t('written', { age: span_text(page.age), at: moment(s.time) }));
  say('site', s.site);
  say('topology', s.topology);
  document.title = `${t(`badge.${word}`)} – ${s.site} – airside`;
}

function alarm_line(a) {
  const times = a.ended ? t('alarm-ended', { since: moment(a.since), ended: moment(a.ended) }) : t('alarm-since', { since: moment(a.since) });
  const words = el('div', '', {}, el('b', reason_text(a.reason, 'name', a.reason)), ` – ${reason_text(a.reason, 'why', '')}`, el('br'),
    el('span', `${times}${a.seen_at ? ` · ${t('alarm-seen', { by: has(`role.${a.seen_by}`) ? t(`role.${a.seen_by}`) : a.seen_by, at: moment(a.seen_at) })}` : ''}${a.ended ? '' : ` · ${reason_text(a.reason, 'out', '')}`}`, { class: 'quiet' }));
  const item = el('li', '', { class: a.ended ? (a.seen_at ? 'past' : 'ended') : 'active' }, words);
  if (!a.seen_at && page.session.operate) {
    const button = el('button', t('seen'), { type: 'button', 'aria-label': `${t('seen')}: ${reason_text(a.reason, 'name', a.reason)}` });
    button.onclick = () => acknowledge(a.id);
    item.append(button);
  }
  return item;
}
let shown_alarms = '';
function show_alarms() {
  // Lists are built anew only where they differ: focus and what a screen reader reads stay where they are.
  const now = JSON.stringify([page.alarms, page.session.operate, page.texts.lang]);
  if (now === shown_alarms) return;
  shown_alarms = now;
  const all = page.alarms.alarms ?? [];
  const open = all.filter((a) => !a.ended || !a.seen_at), past = all.filter((a) => a.ended && a.seen_at);
  $('no-alarms').hidden = open.length > 0;
  $('alarms').replaceChildren(...open.map(alarm_line));
  $('alarms-past').hidden = past.length === 0;
  $('alarms-old').replaceChildren(...past.slice(0, 20).map(alarm_line));
  $('seen-needs').hidden = page.session.operate || !open.some((a) => !a.seen_at);
  $('seen-all').hidden = !page.session.operate || open.filter((a) => !a.seen_at).length < 2;
}

/** A point on a scale, with marks; for the eye alone, since the value is beside it. */
function track(value, from, to, marks) {
  const at = (v) => `${Math.max(0, Math.min(100, (100 * (v - from)) / (to - from)))}%`;
  const e = el('span', '', { class: 'track', 'aria-hidden': 'true' });
  for (const m of marks.filter(known)) { const i = el('i'); i.style.left = at(m); e.append(i); }
  if (known(value)) { const b = el('b'); b.style.left = at(value); e.append(b); }
  return e;
}
function show_rooms() {
  const s = page.status, band = s.objective === 'band';
  const off = s.held_degc - s.target_degc;
  let said = t('rooms-unknown');
  if (band && known(s.warmest_zone_above_setpoint_k)) {
    said = t(s.warmest_zone_above_setpoint_k > 0 ? 'zones-above' : 'zones-below', { k: Math.abs(s.warmest_zone_above_setpoint_k).toFixed(2) });
    if (known(s.most_open_damper)) said += ` ${t('damper', { n: Math.round(100 * s.most_open_damper) })}`;
  } else if (!band && known(s.held_degc) && known(s.target_degc)) {
    const place = Math.abs(off) < 0.005 ? 'on' : off > 0 ? 'above' : 'below';
    said = t(`held-${place}`, { rule: t(`hold.${s.hold}`), held: deg(s.held_degc), k: Math.abs(off).toFixed(2), target: deg(s.target_degc) });
  }
  say('rooms-said', said);
  const middle = known(s.target_degc) && !band ? s.target_degc : 24;
  const values = s.room_temp_degc.filter(known);
  const reach = Math.max(1.5, ...values.map((v) => Math.abs(v - middle))) * 1.1;
  $('rooms').replaceChildren(...s.room_temp_degc.map((v, i) => el('li', '', {}, el('span', t('room', { n: i + 1 })),
    track(v, middle - reach, middle + reach, band ? [] : [s.target_degc]), el('span', known(v) ? deg(v) : t('no-value'), { class: 'value' }))));
}

function show_setpoint() {
  const s = page.status, site = page.site;
  say('setpoint', deg(s.setpoint_degc));
  const rows = [['in-force', s.setpoint_degc, 'in-force'], ['p.head', s.head_setpoint_degc, ''], ['p.network', s.network_setpoint_degc, ''],
    ['p.schedule', s.expert_setpoint_degc, 'shadow'], ['p.g36', s.g36_setpoint_degc, 'shadow']].filter(([, v]) => known(v));
  const values = rows.map(([, v]) => v);
  const from = Math.min(site.setpoint_min_degc ?? 20, ...values), to = Math.max(site.setpoint_max_degc ?? 26, ...values);
  $('proposals').replaceChildren(...rows.map(([key, v, kind]) => el('li', '', { class: kind }, el('span', t(key)),
    track(v, from, to, [site.setpoint_min_degc, site.setpoint_max_degc]), el('span', deg(v), { class: 'value' }))));
  const why = [];
  if (s.state === 'release') why.push(t('why-release'));
  else if (s.state === 'expert') why.push(t('why-schedule', { at: deg(s.expert_setpoint_degc) }));
  else if (s.objective === 'band') why.push(t(s.band_cycles < s.band_ready_cycles ? 'why-band-young' : 'why-band', { n: s.band_cycles, needed: s.band_ready_cycles }));
  else if (known(s.head_setpoint_degc)) why.push(t('why-head', { at: deg(s.head_setpoint_degc) }));
  else if (known(s.network_setpoint_degc)) why.push(t('why-network', { at: deg(s.network_setpoint_degc) }));
  if (known(s.expected_held_degc)) why.push(t('why-expected', { at: deg(s.expected_held_degc), target: deg(s.target_degc) }));
  if (known(site.setpoint_min_degc)) why.push(t('why-limits', { min: deg(site.setpoint_min_degc, 1), max: deg(site.setpoint_max_degc, 1) }));
  say('why', why.join(' '));
  $('confidence-line').hidden = !known(s.confidence);
  if (known(s.confidence)) { $('confidence').value = s.confidence; say('confidence-said', `${Math.round(100 * s.confidence)}\u00a0%`); }
}

const event_words = { 'on trial': 'event.trial', confirmed: 'event.confirmed', 'rolled back': 'event.rolled', refused: 'event.refused', uploaded: 'event.uploaded', 'rollback asked': 'event.asked' };
function show_weights() {
  const s = page.status, w = page.weights;
  const states = { none: 'pushed.none', 'on trial': 'pushed.trial', confirmed: 'pushed.confirmed', 'rolled back': 'pushed.rolled' };
  let said = t(states[s.pushed_weights] ?? 'pushed.none', { crc: s.pushed_crc });
  if (s.pushed_refusal !== 'none') said += ` ${t('pushed.refused', { why: s.pushed_refusal, field: s.pushed_refusal_field })}`;
  said += ` ${t('learned', { n: s.cycles, m: s.replay_transitions, r: s.rejected_updates })}`;
  say('weights-said', said);
  const g = w.given_out;
  say('given-out', g ? t('given-out', { at: moment(g.created), from: g.provenance }) : t('given-out-none'));
  const events = w.events ?? [];
  $('history').replaceChildren(...(events.length ? events.map((e) => el('li', `${moment(e.at)} – ${t(event_words[e.what] ?? e.what)}${e.detail ? `: ${e.detail}` : ''}${e.by ? ` (${has(`role.${e.by}`) ? t(`role.${e.by}`) : e.by})` : ''}`)) : [el('li', t('history-none'))]));
}

function show_box() {
  const s = page.status;
  const facts = [['storage', s.storage === 'ok' ? t('in-order') : s.storage], ['clock', s.clock === 'ok' ? t('in-order') : s.clock],
    ['generation', s.generation], ['writes', s.setpoint_writes],
    ['link', t('link-counts', { a: s.link_timeouts, b: s.link_bad_frames, c: s.link_wrong_ids, d: s.link_exceptions })]];
  if (known(s.row_late_ms)) facts.push(['lateness', `${s.row_late_ms.toFixed(1)} ms`]);
  if (s.lost_until) facts.push(['lost', moment(s.lost_until)]);
  if (page.alarms.kept === false) facts.push(['page-memory', t('page-memory-lost')]);
  $('box').replaceChildren(...facts.flatMap(([k, v]) => [el('dt', t(`box.${k}`)), el('dd', String(v))]));
  say('version', `airside ${page.site.version ?? ''}`);
}

export function show() {
  if (!page.status) return;
  show_state();
  show_alarms();
  show_rooms();
  show_setpoint();
  show_why();
  show_weights();
  show_box();
}

function show_balance() {
  const d = page.trends, s = page.status;
  const said = [];
  if (s && known(s.mean_error_k) && known(s.schedule_mean_error_k)) said.push(t('balance-day', { ours: s.mean_error_k.toFixed(2), theirs: s.schedule_mean_error_k.toFixed(2) }));
  if (!d.has_meters) said.push(t('no-meters'));
  say('balance-said', said.join(' '));
  const rows = ['airside', 'schedule', 'released'].map((who) => [who, d.by_control?.[who]]).filter(([, c]) => c && c.hours > 0);
  table('balance', t('balance-caption', { span: t(page.span) }), [t('control'), t('hours-h'), t('energy-kwh'), t('power-kw'), t('degree-hours'), t('distance-k')],
    rows.map(([who, c]) => [t(`control.${who}`), number(c.hours, 1, ''), number(c.energy_kwh, 1, ''), number(c.mean_power_kw, 2, ''), number(c.degree_hours_kh, 2, ''), number(c.mean_distance_k, 3, '')]));
}
export async function show_trends() {
  const d = page.trends;
  say('trends-said', d.reading ? t('trends-reading') : d.points === 0 ? t('trends-none') : d.trouble ? t('trends-trouble', { what: d.trouble }) : '');
  if (!d.points) return;
  show_balance();
  show_gap();
  table('days', t('days-caption'), [t('date'), t('energy-kwh'), t('degree-hours'), t('distance-k'), t('badge.learn'), t('badge.run'), t('badge.expert'), t('badge.release')],
    [...d.days].reverse().map((x) => [x.date, number(x.energy_kwh, 1, ''), number(x.degree_hours_kh, 2, ''), number(x.mean_distance_k, 3, ''), ...['learn_h', 'run_h', 'expert_h', 'release_h'].map((k) => number(x[k], 1, ' h'))]));
  table('spells', t('spells-caption'), [t('from'), t('to'), t('mode'), t('reason')],
    [...d.spells].reverse().slice(0, 100).map((x) => [moment(x.from), moment(x.to), t(`badge.${x.mode}`), reason_text(x.reason, 'name', x.reason)]));
  $('bands').replaceChildren(...['run', 'expert', 'release'].map((m) => el('li', '', {}, el('i', '', { class: m }), t(`badge.${m}`))));
  const charts = await import('/charts.js');
  await charts.draw(d);
}
