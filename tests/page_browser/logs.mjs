// What the page says of a log, computed a second time from the daemon's files.

import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';

export function close_to(found, expected, within, what) {
  if (!(Math.abs(found - expected) <= within)) throw new Error(`not so: ${what}: found ${found}, expected ${expected} within ${within}`);
}

function rows_of(folder) {
  const rows = [];
  for (const file of readdirSync(folder).filter((f) => f.endsWith('.csv')).sort()) {
    const [head, ...lines] = readFileSync(join(folder, file), 'utf8').trim().split('\n').map((l) => l.split(','));
    for (const line of lines) rows.push(Object.fromEntries(head.map((name, i) => [name, line[i]])));
  }
  return rows;
}
const number = (text) => (text === undefined || text === '' ? NaN : Number(text));

/** Bias and root mean square of the held value (their mean) and of each room, over the working hours of 14 days. */
export function gap_of_logs(folder, site, rooms) {
  const rows = rows_of(folder), cycle = site.cycle_min / 6;
  const at = new Map(rows.map((r) => [Date.parse(`${r.time}Z`), r]));
  const last_day = Math.floor(Math.max(...at.keys()) / 864e5), errors = Array.from({ length: rooms + 1 }, () => []);
  const temps = (r) => Array.from({ length: rooms }, (_, i) => number(r[`room_temp_${i + 1}_degc`]));
  const mean = (v) => v.reduce((a, b) => a + b, 0) / v.length;
  for (const [ms, r] of at) {
    const second = (ms / 1000) % 86400, weekday = (Math.floor(ms / 864e5) + 4) % 7, day = Math.floor(ms / 864e5);
    if (day <= last_day - 14 || second < site.work_start_s || second >= site.work_end_s || (site.weekday_only && (weekday === 0 || weekday === 6))) continue;
    const within = Array.from({ length: cycle - 1 }, (_, i) => at.get(ms + (i + 1) * 360e3)), end = at.get(ms + cycle * 360e3);
    if (!end || within.some((w) => !w || w.setpoint_degc !== r.setpoint_degc)) continue;
    const forecast = number(r.expected_held_degc) - mean(temps(r)), moved = mean(temps(end)) - mean(temps(r));
    if (!Number.isFinite(forecast) || !Number.isFinite(moved)) continue;
    errors[0].push(moved - forecast);
    temps(end).forEach((v, i) => errors[i + 1].push(v - temps(r)[i] - forecast));
  }
  return { n: errors[0].length, bias_k: errors.map(mean), rms_k: errors.map((e) => Math.sqrt(mean(e.map((x) => x * x)))) };
}
