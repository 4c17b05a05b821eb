// What is shown of state, alarms, rooms, setpoint, balance and weights.

import { acknowledge, asked, asked_done, el, has, once, page, say, sentences, t } from '/app.js';
import { forget_why, show_gap, show_why, table } from '/why.js';

const $ = (id) => document.getElementById(id);
const known = (v) => typeof v === 'number' && Number.isFinite(v);
const deg = (v, digits = 2) => (known(v) ? `${v.toFixed(digits)} °C` : '–');
const number = (v, digits, unit) => (known(v) ? `${v.toFixed(digits)}${unit}` : '–');
export const moment = (text) => (text ?? '').replace('T', ' ').slice(0, 16);

const short = (text) => moment(text).slice(5);
const silent_ms = 60000, ahead_s = 60, stale_s = 900, late_ms = 600000, zones_apart_ms = 3600000;

const age = () => page.age + (Date.now() - page.answered) / 1000;
/** As `airside status` has it: a status that is old says what was, not what is. So does one that the page's program has
 *  not repeated for a few questions. */
function condition() {
  if (!page.status) return 'none';
  if (Date.now() - page.answered > silent_ms) return 'silent';
  if (page.status.stopped) return 'stopped';
  return Math.abs(age()) > stale_s ? 'stale' : 'running';
}
const is_old = () => ['stopped', 'stale', 'silent'].includes(condition());
/** Nobody writes to the AHU, and a wish waits. */
export const is_idle = () => ['none', 'stopped', 'stale'].includes(condition());
const ended_by_hand = ['state lost', 'overridden', 'two masters', 'writes refused', 'released by hand'];
export function is_in_control() {
  const s = page.status, met = s ? [s.reason, ...s.alarms.map((a) => a.reason)] : [];
  return condition() === 'running' && s.state !== 'release' && !met.some((r) => ended_by_hand.includes(r));
}
const unreached = () => page.status.reason === 'no reading';
const active_alarms = () => (page.alarms?.alarms ? page.alarms.alarms.filter((a) => !a.ended) : page.status?.alarms ?? []);
const reason_text = (name, part, otherwise) => (has(`reason.${name}.${part}`) ? t(`reason.${name}.${part}`) : otherwise);

/** What of a failing storage to mend the box knows better than the table of reasons, in English. */
function ending(reason, otherwise) {
  const ends = reason === 'released by hand' && page.status?.release_ends, own = ends && own_time(ends);
  if (ends) return t(own ? 'release-ends-here' : 'release-ends', { at: moment(ends), own: own.slice(0, 10) === ends.slice(0, 10) ? own.slice(11) : own });
  const box_knows = reason === 'storage failed' && page.status?.reason === reason && page.texts.lang === 'en';
  return box_knows ? page.status.way_out : reason_text(reason, 'out', otherwise);
}
function sentence() {
  if (!page.status) return t('nothing-known');
  const s = page.status, c = condition(), runs = c === 'running';
  let text = c === 'silent' ? `${t('silent')}\n` : '';
  text += s.stopped ? `${t('stopped', { at: moment(s.stopped_at) })}\n` : c === 'stale' ? `${t('stale')}\n` : '';
  text += t(`state.${unreached() ? 'unreached' : s.state}.${runs ? 'now' : 'then'}`);
  if (s.reason !== 'none') text += t(s.state === 'learn' ? 'because-alarm' : 'because', { why: reason_text(s.reason, 'why', s.why), out: ending(s.reason, s.way_out) });
  if (s.fault === 'none') text += t('no-fault');
  else {
    const fault = has(`fault.${s.fault}`) ? t(`fault.${s.fault}`) : s.fault;
    text += s.fault_signal ? t('fault-at', { fault, signal: s.fault_signal }) : t('fault', { fault });
  }
  const n = runs ? active_alarms().length : 0, waiting = page.session.waiting;
  const waits = waiting === 'hand-back' || (waiting === 'release' && s.state !== 'release');
  return sentences([text, waits && t(`waiting.${waiting}`), n > 0 && t(n === 1 ? 'alarm-active' : 'alarms-active', { n })]);
}
function span_text(seconds) {
  if (seconds < 120) return t('seconds', { n: Math.round(seconds) });
  if (seconds < 7200) return t('minutes', { n: Math.round(seconds / 60) });
  return seconds < 172800 ? t('hours', { n: Math.round(seconds / 3600) }) : t('days', { n: Math.round(seconds / 86400) });
}

page.span_text = span_text;

/** What was asked for in this browser, until a status that was written since has it. */
function show_asked() {
  const a = asked(), s = page.status;
  if (!a) return;
  const by_hand = s && s.state === 'release' && [s.reason, ...s.alarms.map((x) => x.reason)].includes('released by hand');
  const follows = s && page.answered - 1000 * Math.abs(page.age) > a.at && (a.what === 'release' ? by_hand : !by_hand && (s.state !== 'release' || s.reason !== 'none'));
  if (follows) {
    asked_done();
    $('order-said').classList.remove('bad');
    return say('order-said', t(`followed.${a.what}`));
  }
  const at = new Date(a.at).toTimeString().slice(0, 5);
  if (Date.now() - a.at > late_ms) say('order-said', t(`late.${a.what}`, { at }));
  else if (!$('order-said').textContent) say('order-said', sentences([t(`asked.${a.what}`, { at }), t(`${is_idle() ? 'waits' : 'follows'}.${a.what}`)]));
}
const written_text = () => t(age() < -ahead_s ? 'written-ahead' : 'written', { age: span_text(Math.abs(age())), at: moment(page.status.time) });
const clock_of = (minutes) => `${minutes < 0 ? '−' : '+'}${[Math.floor(Math.abs(minutes) / 60), Math.abs(minutes) % 60].map((n) => String(n).padStart(2, '0')).join(':')}`;
/** A time of the site's clock by the clock of this device; '' where both show the same, or where nobody knows. */
function own_time(text) {
  const offset = page.site.utc_offset_min, at = new Date(Date.parse(`${text}Z`) - 60000 * offset);
  if (!known(offset) || Number.isNaN(at.getTime()) || -at.getTimezoneOffset() === offset) return '';
  return moment(new Date(at.getTime() - 60000 * at.getTimezoneOffset()).toISOString());
}
/** Where the site's clock is not this device's: people compare times with their own. */
function show_clock_note() {
  const offset = page.site.utc_offset_min, own = -new Date().getTimezoneOffset();
  const differs = known(offset) && page.session.see && offset !== own;
  $('clock-note').hidden = !differs;
  say('clock-note', differs ? t('clock-note', { site: clock_of(offset), own: clock_of(own) }) : '');
}
function show_state() {
  const c = condition(), s = page.status;
  const word = c === 'none' || c === 'stopped' ? c : c === 'stale' || c === 'silent' ? 'stale' : unreached() ? 'unreached' : s.state;
  const name = s?.site ?? page.site.site ?? '';
  $('badge').className = `badge ${word}`;
  say('badge', t(`badge.${word}`));
  say('sentence', sentence());
  const quiet_s = (Date.now() - page.answered) / 1000;
  say('age', s ? `${written_text()}${quiet_s > 30 ? ` · ${t('answered', { age: span_text(quiet_s) })}` : ''}` : '');
  say('site', name || 'airside');
  say('topology', s?.topology ?? page.site.topology ?? '');
  document.title = [t(`badge.${word}`), name, 'airside'].filter(Boolean).join(' – ');
  show_clock_note();
  show_asked();
  const then = is_old() ? t('as-of', { at: moment(s.time) }) : '';
  for (const id of ['rooms', 'setpoint', 'box']) {
    $(`${id}-s`).classList.toggle('old', then !== '');
    say(`${id}-as-of`, then);
  }
  say('alarms-as-of', then ? t('alarms-as-of', { at: moment(s.time) }) : s || !page.alarms?.alarms.length ? '' : t('alarms-noted'));
}
let shown_condition = '', shown_role = '';
/** Between two answers: what is shown grows older. */
export function tick() {
  if (condition() !== shown_condition) show();
  else show_state();
}

function alarm_line(a, place) {
  const times = a.ended ? t(a.times > 1 ? 'alarm-ended-times' : 'alarm-ended', { n: a.times, since: moment(a.since), ended: moment(a.ended) }) : t('alarm-since', { since: moment(a.since) });
  const words = el('div', '', {}, el('b', reason_text(a.reason, 'name', a.reason)), ` – ${reason_text(a.reason, 'why', '')}`, el('br'),
    el('span', `${times}${a.seen_at ? ` · ${t('alarm-seen', { by: has(`role.${a.seen_by}`) ? t(`role.${a.seen_by}`) : a.seen_by, at: moment(a.seen_at) })}` : ''}${a.ended ? '' : ` · ${ending(a.reason, '')}`}`, { class: 'quiet' }));
  const item = el('li', '', { class: a.ended ? (a.seen_at ? 'past' : 'ended') : 'active' }, words);
  if (!a.seen_at && page.session.operate) {
    const button = el('button', t('seen'), { type: 'button', 'aria-label': `${t('seen')}: ${reason_text(a.reason, 'name', a.reason)}` });
    button.onclick = once(button, () => acknowledge(a.id, place));
    item.append(button);
  }
  return item;
}
let shown_alarms = '';
function show_alarms() {
  // Lists are built anew only where they differ: focus and what a screen reader reads stay where they are.
  const now = JSON.stringify([page.alarms, page.session.operate, page.texts.lang, page.status?.release_ends, condition(), page.status && is_old() ? page.status.time : '']);
  if (now === shown_alarms) return;
  shown_alarms = now;
  const all = page.alarms?.alarms ?? [];
  const open = all.filter((a) => !a.ended || !a.seen_at), past = all.filter((a) => a.ended && a.seen_at);
  say('no-alarms', open.length ? '' : !page.status || !page.alarms ? t('alarms-unknown') : is_old() ? t('no-alarms-then', { at: moment(page.status.time) }) : t('no-alarms'));
  $('no-alarms').hidden = open.length > 0;
  let buttons = 0;
  $('alarms').replaceChildren(...open.map((a) => alarm_line(a, a.seen_at ? buttons : buttons++)));
  $('alarms-past').hidden = past.length === 0;
  $('alarms-old').replaceChildren(...past.slice(0, 20).map((a) => alarm_line(a, 0)));
  $('seen-needs').hidden = page.session.operate || !open.some((a) => !a.seen_at);
  $('seen-all').hidden = !page.session.operate || open.filter((a) => !a.seen_at).length < 2;
}

/** A point on a scale, with marks and a band; for the eye alone, since the value is beside it. */
function track(value, from, to, marks, band = null) {
  const at = (v) => `${Math.max(0, Math.min(100, (100 * (v - from)) / (to - from)))}%`;
  const e = el('span', '', { class: 'track', 'aria-hidden': 'true' });
  if (band) { const i = el('i', '', { class: 'band' }); i.style.left = at(band[0]); i.style.right = `calc(100% - ${at(band[1])})`; e.append(i); }
  for (const m of marks.filter(known)) { const i = el('i'); i.style.left = at(m); e.append(i); }
  if (known(value)) { const b = el('b'); b.style.left = at(value); e.append(b); }
  return e;
}
/** The zones' own setpoints and bands, where the log has them of about the time of the status. */
function zone_bands() {
  const z = page.trends?.zones, apart_ms = z ? Math.abs(Date.parse(z.time) - Date.parse(page.status.time)) : Infinity;
  if (apart_ms > zones_apart_ms) return null;
  return z.cooling_degc.map((cool, i) => {
    const heat = z.heating_degc?.[i];
    return known(cool) ? { cool, low: known(heat) && heat <= cool ? heat - page.site.band_k : null, high: cool + page.site.band_k } : null;
  });
}
function show_zones() {
  const s = page.status, zones = zone_bands() ?? [], seen = zones.filter(Boolean);
  const all = [...s.room_temp_degc, ...seen.flatMap((z) => [z.low, z.high])].filter(known);
  const from = Math.min(...all) - 0.5, to = Math.max(...all) + 0.5;
  $('rooms').replaceChildren(...s.room_temp_degc.map((v, i) => {
    const z = zones[i], value = el('span', known(v) ? deg(v) : t('no-value'), { class: 'value' });
    if (z) value.append(el('small', t('zone-setpoint', { at: deg(z.cool) })));
    return el('li', '', {}, el('span', t('room', { n: i + 1 })), track(v, from, to, z ? [z.cool] : [], z && [z.low ?? from, z.high]), value);
  }));
  say('zones-said', seen.length === 0 ? t('zones-unknown') : t(seen.every((z) => known(z.low)) ? 'zones-band' : 'zones-band-open', { k: page.site.band_k }));
}
function show_rooms() {
  const s = page.status, band = s.objective === 'band';
  const off = s.held_degc - s.target_degc;
  let said = t('rooms-unknown');
  if (unreached()) said = t('rooms-unknown');
  else if (band && known(s.warmest_zone_above_setpoint_k)) {
    said = t(s.warmest_zone_above_setpoint_k > 0 ? 'zones-above' : 'zones-below', { k: Math.abs(s.warmest_zone_above_setpoint_k).toFixed(2) });
    if (known(s.most_open_damper)) said = sentences([said, t('damper', { n: Math.round(100 * s.most_open_damper) })]);
  } else if (!band && known(s.held_degc) && known(s.target_degc)) {
    const place = Math.abs(off) < 0.005 ? 'on' : off > 0 ? 'above' : 'below';
    said = t(`held-${place}`, { rule: t(`hold.${s.hold}`), held: deg(s.held_degc), k: Math.abs(off).toFixed(2), target: deg(s.target_degc) });
  }
  say('rooms-said', said);
  $('rooms').classList.toggle('zones', band);
  if (band) return show_zones();
  say('zones-said', '');
  const middle = known(s.target_degc) ? s.target_degc : 24;
  const values = s.room_temp_degc.filter(known);
  const reach = Math.max(1.5, ...values.map((v) => Math.abs(v - middle))) * 1.1;
  $('rooms').replaceChildren(...s.room_temp_degc.map((v, i) => el('li', '', {}, el('span', t('room', { n: i + 1 })),
    track(v, middle - reach, middle + reach, [s.target_degc]), el('span', known(v) ? deg(v) : t('no-value'), { class: 'value' }))));
}

function show_setpoint() {
  const s = page.status, site = page.site;
  say('setpoint', deg(s.setpoint_degc));
  const in_force = is_old() ? t('in-force-then', { at: short(s.time) }) : unreached() ? t('in-force-last') : '';
  say('setpoint-then', in_force);
  const rows = [['in-force', s.setpoint_degc, 'in-force'], ['p.head', s.head_setpoint_degc, ''], ['p.network', s.network_setpoint_degc, ''],
    ['p.schedule', s.expert_setpoint_degc, 'shadow'], ['p.g36', s.g36_setpoint_degc, 'shadow']].filter(([, v]) => known(v));
  const values = rows.map(([, v]) => v);
  const from = Math.min(site.setpoint_min_degc ?? 20, ...values), to = Math.max(site.setpoint_max_degc ?? 26, ...values);
  $('proposals').replaceChildren(...rows.map(([key, v, kind]) => el('li', '', { class: kind }, el('span', (key === 'in-force' && in_force) || t(key)),
    track(v, from, to, [site.setpoint_min_degc, site.setpoint_max_degc]), el('span', deg(v), { class: 'value' }))));
  const why = [];
  if (unreached()) why.push(t('why-unreached'));
  else if (s.state === 'release') why.push(t('why-release'));
  else if (s.state === 'expert') why.push(t('why-schedule', { at: deg(s.expert_setpoint_degc) }));
  else if (s.objective === 'band') why.push(t(s.band_cycles < s.band_ready_cycles ? 'why-band-young' : 'why-band', { n: s.band_cycles, needed: s.band_ready_cycles }));
  else if (known(s.head_setpoint_degc)) why.push(t('why-head', { at: deg(s.head_setpoint_degc) }));
  else if (known(s.network_setpoint_degc)) why.push(t('why-network', { at: deg(s.network_setpoint_degc) }));
  const writes = !unreached() && s.state !== 'release';  // else the limits would seem to be the AHU's
  if (writes && known(s.expected_held_degc)) why.push(t('why-expected', { at: deg(s.expected_held_degc), target: deg(s.target_degc) }));
  if (writes && known(site.setpoint_min_degc)) why.push(t('why-limits', { min: deg(site.setpoint_min_degc, 1), max: deg(site.setpoint_max_degc, 1) }));
  say('why', sentences(why));
  const c = s.candidates, decided = writes && (c?.network_held_degc ?? c?.cost_kw ?? []).length > 0;
  $('confidence-line').hidden = !decided || !known(s.confidence) || s.objective === 'band';  // band forecasts no held value
  if (known(s.confidence)) { $('confidence').value = s.confidence; say('confidence-said', `${Math.round(100 * s.confidence)}\u00a0%`); }
}

const event_words = { 'on trial': 'event.trial', confirmed: 'event.confirmed', 'rolled back': 'event.rolled', refused: 'event.refused', uploaded: 'event.uploaded', 'rollback asked': 'event.asked' };
const rejected = (why, field) => (has(`refusal.${why}`) ? t(`refusal.${why}`) : t('refusal-other', { why, field }));
/** The page's history has `reason (field)`. */
function event_detail(e) {
  const parts = e.what === 'refused' ? /^(.*) \((.*)\)$/.exec(e.detail) : null;
  return parts ? rejected(parts[1], parts[2]) : e.detail;
}
function show_weights() {
  const s = page.status, w = page.weights ?? {};
  const states = { none: 'pushed.none', 'on trial': 'pushed.trial', confirmed: 'pushed.confirmed', 'rolled back': 'pushed.rolled' };
  $('rollback').hidden = !page.session.operate || !['on trial', 'confirmed'].includes(s?.pushed_weights);
  const said = [];
  if (s) {
    said.push(t(states[s.pushed_weights] ?? 'pushed.none', { crc: s.pushed_crc }));
    const why = s.pushed_refusal, text = rejected(why, s.pushed_refusal_field);
    if (why === 'no way back') said.push(text);
    else if (why !== 'none') said.push(t(why === 'state invalid' ? 'pushed.waits' : 'pushed.refused', { why: text }));
    said.push(t('learned', { n: s.cycles, m: s.replay_transitions, r: s.rejected_updates }));
  }
  say('weights-said', sentences(said));
  const g = w.given_out;
  say('given-out', g ? t('given-out', { at: moment(g.created), from: g.provenance }) : t('given-out-none'));
  const events = w.events ?? [];
  $('history').replaceChildren(...(events.length ? events.map((e) => el('li', `${moment(e.at)} – ${t(event_words[e.what] ?? e.what)}${e.detail ? t('event-detail', { what: event_detail(e) }) : ''}${e.by ? ` (${has(`role.${e.by}`) ? t(`role.${e.by}`) : e.by})` : ''}`)) : [el('li', t('history-none'))]));
}

function show_box() {
  const s = page.status;
  const facts = [['storage', s.storage === 'ok' ? t('in-order') : s.storage], ['clock', s.clock === 'ok' ? t('in-order') : s.clock],
    ['generation', s.generation], ['writes', s.setpoint_writes],
    ['link', t('link-counts', { a: s.link_timeouts, b: s.link_bad_frames, c: s.link_wrong_ids, d: s.link_exceptions })]];
  if (known(s.row_late_ms)) facts.push(['lateness', `${s.row_late_ms.toFixed(1)} ms`]);
  if (s.lost_until) facts.push(['lost', moment(s.lost_until)]);
  if (page.alarms?.kept === false) facts.push(['page-memory', t('page-memory-lost')]);
  $('box').replaceChildren(...facts.flatMap(([k, v]) => [el('dt', t(`box.${k}`)), el('dd', String(v))]));
  say('version', `airside ${page.site.version ?? ''}`);
}

/** The objective of the site file: without a target, and without forecasts of a held value. */
const of_band = () => page.site.objective === 'band';
/** The columns of comfort: a head, the member of the sums, digits. */
const comfort = () => (of_band() ? [['zones-warm-kh', 'zones_too_warm_kh', 2], ['zones-cold-kh', 'zones_too_cold_kh', 2]].filter(([, of]) => Object.values(page.trends.by_control).some((c) => known(c[of])))
  : [['degree-hours', 'degree_hours_kh', 2], ['distance-k', 'mean_distance_k', 3]]);
/** A section is there when what it shows is known. */
function show_sections() {
  const log = page.session.see && page.trends?.points > 0;
  const there = { see: page.session.see, status: page.session.see && page.status, log, forecasts: log && !of_band() };
  for (const e of document.querySelectorAll('[data-needs]')) e.hidden = !there[e.dataset.needs];
}
export function show() {
  shown_condition = condition();
  show_sections();
  show_state();
  if (!page.session.see) return;
  show_alarms();
  show_weights();
  if (page.session.role !== shown_role && page.trends?.points) show_gap();
  shown_role = page.session.role;
  if (!page.status) return;
  show_rooms();
  show_setpoint();
  show_why();
  show_box();
}
export function forget() {
  for (const e of document.querySelectorAll('[data-needs] :is(ul, dl, table, #charts, [id$=-said], [id$=-as-of]), #rooms-said, #setpoint, #why, #why-shares, #given-out, #order-said, #trends-span, #trends-gap')) e.replaceChildren();
  shown_alarms = '';
  forget_why();
  show();
}

function show_balance() {
  const d = page.trends, s = page.status;
  const said = [];
  if (s && !of_band() && known(s.mean_error_k) && known(s.schedule_mean_error_k)) said.push(t('balance-day', { ours: s.mean_error_k.toFixed(2), theirs: s.schedule_mean_error_k.toFixed(2) }));
  if (!d.has_meters) said.push(t('no-meters'));
  if (of_band() && comfort().length === 0) said.push(t('zones-no-hours'));
  say('balance-said', said.join(' '));
  const rows = ['airside', 'schedule', 'released'].map((who) => [who, d.by_control?.[who]]).filter(([, c]) => c && c.hours > 0);
  table('balance', t(of_band() ? 'balance-caption-band' : 'balance-caption', { span: t(page.span) }), [t('control'), t('hours-h'), t('energy-kwh'), t('power-kw'), ...comfort().map(([head]) => t(head))],
    rows.map(([who, c]) => [t(`control.${who}`), number(c.hours, 1, ''), number(c.energy_kwh, 1, ''), number(c.mean_power_kw, 2, ''), ...comfort().map(([, of, digits]) => number(c[of], digits, ''))]));
}
/** Stretches without a row, as [from, to] in s. */
function gaps_of(d) {
  const gaps = [];
  d.mode.forEach((m, i) => {
    if (m !== null) return;
    const from = d.time_s[i];
    if (gaps.length && gaps.at(-1)[1] === from) gaps.at(-1)[1] = from + d.step_s;
    else gaps.push([from, from + d.step_s]);
  });
  return gaps;
}
export async function show_trends() {
  const d = page.trends;
  if (!d) return;
  say('trends-said', d.reading ? t('trends-reading') : d.points === 0 ? t('trends-none') : d.trouble ? t('trends-trouble', { what: d.trouble }) : '');
  show_sections();
  if (!d.points) return;
  show_balance();
  if (page.status?.objective === 'band') show_rooms();  // with the zones' setpoints, which the log has
  show_gap();
  table('days', t('days-caption'), [t('date'), t('energy-kwh'), ...comfort().map(([head]) => t(head)), t('badge.learn'), t('badge.run'), t('badge.expert'), t('badge.release')],
    [...d.days].reverse().map((x) => [x.date, number(x.energy_kwh, 1, ''), ...comfort().map(([, of, digits]) => number(x[of], digits, '')), ...['learn_h', 'run_h', 'expert_h', 'release_h'].map((k) => number(x[k], 1, ' h'))]));
  table('spells', t('spells-caption'), [t('from'), t('to'), t('mode'), t('reason')],
    [...d.spells].reverse().slice(0, 100).map((x) => [short(x.from), short(x.to), t(`badge.${x.mode}`), reason_text(x.reason, 'name', x.reason)]));
  say('trends-span', t('trends-span', { from: moment(d.from), to: moment(d.to) }));
  const gaps = gaps_of(d), lost_s = gaps.reduce((sum, [a, b]) => sum + b - a, 0), clock = (s) => moment(new Date(1000 * s).toISOString());
  say('trends-gap', gaps.length ? t(gaps.length === 1 ? 'trends-gap' : 'trends-gaps', { n: gaps.length, for: span_text(lost_s), from: clock(gaps.at(-1)[0]), to: clock(gaps.at(-1)[1]) }) : '');
  const modes = ['run', 'expert', 'release'].filter((m) => d.spells.some((x) => x.mode === m));
  $('bands').replaceChildren(...[...modes.map((m) => [m, t(`badge.${m}`)]), ...(gaps.length ? [['gap', t('no-data')]] : [])].map(([kind, words]) => el('li', '', {}, el('i', '', { class: kind }), words)));
  const charts = await import('/charts.js');
  if (page.trends === d) await charts.draw(d, gaps);
}
