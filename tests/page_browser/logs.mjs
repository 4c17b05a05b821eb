// What the page says of a log, computed a second time from the daemon's files.

import { mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
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
/** Writes a log as the daemon's files of a day each, with forecasts that are wrong by `worse_k` more from `from` on. */
export function write_days(log, folder, { from, worse_k }) {
  const [head, ...lines] = readFileSync(log, 'utf8').trim().split('\n'), at = head.split(',').indexOf('expected_held_degc');
  if (at < 0) throw new Error(`${log} has no forecasts`);
  const days = new Map();
  for (const line of lines) {
    const fields = line.split(','), day = line.slice(0, 10);
    if (day >= from && fields[at] !== '') fields[at] = (Number(fields[at]) + worse_k).toFixed(2);
    days.set(day, [...(days.get(day) ?? [head]), fields.join(',')]);
  }
  mkdirSync(folder, { recursive: true });
  for (const [day, rows] of days) writeFileSync(join(folder, `airside-${day}.csv`), `${rows.join('\n')}\n`);
}

/** Of the newest week: the newest row's setpoints of zones, and degree-hours beyond them and 0.5 K while people are in
 *  and the fan runs. */
export function zones_of_logs(folder, zones) {
  const rows = rows_of(folder).slice(-7 * 240), each = (row, name) => Array.from({ length: zones }, (_, i) => number(row[name.replace('#', i + 1)]));
  let warm_kh = 0, cold_kh = 0;
  for (const row of rows) {
    if (row.occupied === '0' || row.ahu_on === '0') continue;
    const rooms = each(row, 'room_temp_#_degc'), cool = each(row, 'zone_setpoint_#_degc'), heat = each(row, 'zone_heating_setpoint_#_degc');
    rooms.forEach((v, i) => {
      if (v - cool[i] > 0.5) warm_kh += 0.1 * (v - cool[i] - 0.5);
      if (heat[i] - v > 0.5) cold_kh += 0.1 * (heat[i] - v - 0.5);
    });
  }
  return { warm_kh, cold_kh, cooling_degc: each(rows.at(-1), 'zone_setpoint_#_degc'), heating_degc: each(rows.at(-1), 'zone_heating_setpoint_#_degc') };
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
