// Point checkout: what the daemon read of each point, and who has signed it off.

import { el, get, has, once, page, post_and_tell, quietly, say, t } from '/app.js';
import { table } from '/why.js';

const $ = (id) => document.getElementById(id);
const known = (v) => typeof v === 'number' && Number.isFinite(v);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const moment = (text) => text.replace('T', ' ').slice(0, 16);
const may_sign = () => page.session.operate && page.session.install;
let points = null;
let filled_in = false;
let shown = '';

function verdict(p) {
  const key = `point.${p.verdict}`;
  const words = has(key) ? t(key) : has(`fault.${p.verdict}`) ? t(`fault.${p.verdict}`) : p.verdict;
  const good = p.verdict === 'plausible' || p.verdict === 'not readable';
  return el('span', `${good ? '✓' : '✗'} ${words}`, { class: good ? 'good' : 'poor' });
}
const units = { degc: '°C', degf: '°F', kw: 'kW', w: 'W', kwh: 'kWh', k: 'K', pa: 'Pa', kpa: 'kPa', hz: 'Hz', percent: '%' };
const number = (v, unit) => (known(v) ? `${+v.toFixed(3)} ${units[unit.toLowerCase()] ?? unit}`.trim() : '–');
const register = (p) => (p.object ? p.object : t('point-register', { fc: p.fc, addr: p.addr, type: p.type }));

function signed(p) {
  const s = p.signed, place = el('span');
  if (s) {
    place.append(el('span', t(s.valid ? 'point-signed' : 'point-void', { by: s.by, at: moment(s.at), value: s.value || '–' }), { class: s.valid ? 'good' : 'poor' }), ' ');
  } else if (!may_sign()) place.textContent = '–';
  if (!may_sign()) return place;
  const act = (key, work) => {
    const b = el('button', t(key), { type: 'button', 'aria-label': `${t(key)}: ${p.name}`, 'data-point': p.name, 'data-act': key });
    b.onclick = once(b, work);
    place.append(b);
  };
  if (s?.valid) act('point-withdraw', () => change('/points/withdraw', p.name, t('point-withdrawn', { name: p.name }), p.name));
  else if (p.verdict === 'plausible' || p.verdict === 'not readable') act('point-sign', () => sign(p));
  return place;
}
async function sign(p) {
  const person = $('points-name').value.trim();
  if (!person) {
    say('points-said', t('point-name-needed'));
    return $('points-name').focus();
  }
  await change('/points/sign', `${p.name}\n${person}\n${points.time}`, t('point-sign-done', { name: p.name, by: person }), p.name);
}
async function change(path, body, done, name) {
  await post_and_tell('points-said', path, body, done);
  await quietly(load());
  $('points').querySelector(`[data-point="${CSS.escape(name)}"]`)?.focus();
}

/** What became of the last write that was tried. */
function show_write(w) {
  $('points-written').hidden = !w;
  if (!w) return;
  const degc = (v) => number(v, 'degC'), good = w.fault === 'none';
  const key = good ? 'write-good' : w.fault === 'released' ? 'write-not-ours' : w.fault === 'out of range' ? 'write-no-room' : known(w.sent) ? 'write-poor' : 'write-unread';
  const why = has(`fault.${w.fault}`) ? t(`fault.${w.fault}`) : w.fault;
  $('points-written').className = good ? 'good' : 'poor';
  $('points-written').textContent = `${good ? '✓' : '✗'} ${t(key, { at: moment(w.time), before: degc(w.before), sent: degc(w.sent), taken: degc(w.taken), restored: degc(w.restored), why })}`;
}

export function show() {
  if (!points) return;
  const p = points;
  say('points-count', p.total === 0 ? t('points-none', { why: p.trouble }) : t('points-count', { n: p.signed, m: p.total }));
  $('points-progress').max = Math.max(1, p.total);
  $('points-progress').value = p.signed;
  $('points-read').hidden = !page.session.operate;
  for (const id of ['points-sign', 'points-write', 'points-write-why']) $(id).hidden = !may_sign();
  $('points-needs').hidden = may_sign();
  const ahead = p.age_s < -60;  // of a box whose clock has gone back since
  say('points-time', p.waiting ? t('points-waiting') : p.time ? t(ahead ? 'points-time-ahead' : 'points-time', { at: moment(p.time), age: page.span_text(Math.abs(p.age_s)) }) : t('points-never'));
  say('points-trouble', [p.trouble && p.total ? p.trouble : '', p.kept ? '' : t('points-not-kept')].filter(Boolean).join(' '));
  show_write(p.write);
  const now = JSON.stringify([filled_in, p.points, may_sign(), page.texts.lang]);
  if (!filled_in || now === shown) return;
  shown = now;  // anew only where it differs: somebody may be at a button
  table('points', t('points-caption'), [t('point'), t('point-value'), t('point-verdict'), t('point-sign-off'), t('point-raw'), t('point-limits'), t('point-where')],
    p.points.map((q) => [q.name, number(q.value, q.unit), verdict(q), signed(q), q.raw.length ? q.raw.join(' ') : '–', `${q.min} – ${q.max}`, register(q)]), true);
}
export function forget() {
  points = null;
  shown = '';
  for (const id of ['points-count', 'points-time', 'points-trouble', 'points-said', 'points-written', 'points']) $(id).replaceChildren();
}
export async function load() {
  if (!page.session.see) return;
  const answer = (await get('/points.json')).json;
  if (!page.session.see) return;
  points = answer;
  show();
}
/** Until the daemon has done what was asked for: it looks with each heartbeat and each row. `of`: the time of the last
 *  reading, or of the last write; a wish that was thrown away leaves it as it was. */
async function follow(before, done, of) {
  for (let i = 0; i < 150; ++i) {
    await load();
    if (!points) return;
    if (!points.waiting && of(points) && of(points) !== before) return say('points-said', t(done, { at: moment(points.time) }));
    if (!points.waiting && i > 3) return say('points-said', '');
    await pause(i < 20 ? 500 : 3000);
  }
}
export function listen() {
  $('points-d').ontoggle = () => { filled_in = $('points-d').open; show(); };
  const ask = (id, path, asked, done, of) => {
    $(id).onclick = once($(id), async () => {
      const before = points ? of(points) : undefined;
      if (await post_and_tell('points-said', path, '', t(asked))) await quietly(follow(before, done, of));
    });
  };
  ask('points-read', '/points/read', 'points-asked', 'points-read-done', (p) => p.time);
  ask('points-write', '/points/write', 'points-write-asked', 'points-write-done', (p) => p.write?.time);
}
