// A real box for a browser: a simulated room on Modbus, airsided beside it, airside-page beside that.

import { spawn, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, openSync, readFileSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** Waits until `look` gives something; says what was awaited where it does not. */
export async function until(what, look, seconds = 30) {
  const end = Date.now() + 1000 * seconds;
  for (;;) {
    let found = null;
    try { found = await look(); } catch { /* not yet */ }
    if (found) return found;
    if (Date.now() > end) throw new Error(`after ${seconds} s still not: ${what}`);
    await pause(50);
  }
}

export class Box {
  /** `init`: options of `airside init`; `room`: of `airside serve`; `dir`, `file`: names of the site's folder and file;
   *  `weights`: pretrained ones to start with, for an objective that has some; `zone`: the TZ of its programs. */
  constructor(bin, { init = [], room = '301', dir = 'site', file = 'site.toml', weights = true, zone = 'UTC' } = {}) {
    Object.assign(this, { bin, room, dir, file, zone });
    this.folder = mkdtempSync(join(tmpdir(), 'airside_browser_'));
    this.children = [];
    this.run('airside', 'init', this.path(dir), ...init);
    renameSync(this.path(dir, 'site.toml'), this.site());
    this.run('airside', 'keygen', '-o', this.path('ann'));
    for (const part of ['keys', 'inbox']) mkdirSync(this.path(dir, part), { recursive: true });
    writeFileSync(this.path(dir, 'keys', 'ann.pub'), readFileSync(this.path('ann.pub')));
    this.edit((text) => text.replace('source = "system"', 'source = "plant"'));
    if (!weights) return;
    this.run('airside', 'pretrain', '--plant', 'rc', '--room', room, '--days', '4', '-o', this.path('room.blob'));
    this.edit((text) => text.replace('blob = ""', `blob = "${this.path('room.blob')}"`));
  }
  path(...parts) { return join(this.folder, ...parts); }
  site() { return this.path(this.dir, this.file); }
  edit(change) { writeFileSync(this.site(), change(readFileSync(this.site(), 'utf8'))); }
  program(name) { return join(this.bin, name); }

  run(name, ...words) { return this.run_with('', name, ...words); }
  run_with(input, name, ...words) {
    const done = spawnSync(this.program(name), words, { input, encoding: 'utf8', timeout: 120000 });
    if (done.status !== 0) throw new Error(`${name} ${words.join(' ')}: ${done.status}\n${done.stdout}${done.stderr}`);
    return done.stdout;
  }
  start(log, name, ...words) {
    const out = openSync(this.path(log), 'a');
    const child = spawn(this.program(name), words, { stdio: ['ignore', out, out], env: { ...process.env, TZ: this.zone } });
    child.ended = new Promise((done) => child.on('exit', (code) => done(code)));
    this.children.push(child);
    return child;
  }
  async end(child) {
    child.kill('SIGTERM');
    const code = await child.ended;
    this.children = this.children.filter((c) => c !== child);
    return code;
  }

  async serve(...words) {
    rmSync(this.path('served'), { force: true });
    this.server = this.start('serve.txt', 'airside', 'serve', '--site', this.site(), '--plant', 'rc', '--room', this.room, '--port', '0', '--ready', this.path('served'), ...words);
    const where = await until('a served room', () => existsSync(this.path('served')) && readFileSync(this.path('served'), 'utf8'));
    this.edit((text) => text.replace(/(\[modbus\][^[]*\nport = )\d+/, `$1${where.trim().split(':').pop()}`));
  }
  daemon(...words) { return this.start('daemon.txt', 'airsided', '--site', this.site(), '--no-sync', '--crash-limit', '0', ...words); }
  async open_page(scheme = 'http') {
    rmSync(this.path('page'), { force: true });
    this.page = this.start('page.txt', 'airside-page', '--site', this.site(), '--port', '0', '--ready', this.path('page'));
    const where = await until('a page', () => existsSync(this.path('page')) && readFileSync(this.path('page'), 'utf8'));
    this.address = `${scheme}://${where.trim()}`;
  }
  status() { return JSON.parse(readFileSync(this.path(this.dir, 'state', 'status.json'), 'utf8')); }

  async close(keep) {
    for (const child of this.children) child.kill('SIGTERM');
    await Promise.all(this.children.map((c) => c.ended));
    if (!keep) rmSync(this.folder, { recursive: true, force: true });
  }
}
