// One file a language, all with the same keys; every text that the page asks for is there; reasons are the daemon's own.
// usage: node texts.mjs SOURCE_DIR

import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';

const root = process.argv[2];
const web = join(root, 'firmware/page/web');
const wrong = [];
const texts = Object.fromEntries(readdirSync(join(web, 'texts')).map((f) => [f.replace('.json', ''), JSON.parse(readFileSync(join(web, 'texts', f), 'utf8'))]));
const { en } = texts;

for (const [language, all] of Object.entries(texts)) {
  if (all.lang !== language) wrong.push(`${language}: lang is ${all.lang}`);
  for (const key of Object.keys(en)) if (!(key in all)) wrong.push(`${language} lacks ${key}`);
  for (const [key, text] of Object.entries(all)) {
    if (!(key in en)) { wrong.push(`${language} has ${key}, en has not`); continue; }
    if (text === '') wrong.push(`${language}: ${key} is empty`);
    const places = (t) => [...t.matchAll(/\{(\w+)\}/g)].map((m) => m[1]).sort().join();
    if (places(text) !== places(en[key])) wrong.push(`${language}: ${key} has other places than en: ${places(text)}, ${places(en[key])}`);
  }
}

const table = readFileSync(join(root, 'lib/airside/supervision/mode_table.hpp'), 'utf8');
const literal = '((?:"[^"]*"\\s*)+)';  // a long one goes on in the next line
const joined = (text) => [...text.matchAll(/"([^"]*)"/g)].map((m) => m[1]).join('');
const rows = [...table.matchAll(new RegExp(`\\.name = ${literal}[\\s\\S]*?\\.why =\\s*${literal},\\s*\\.way_out =\\s*${literal}`, 'g'))]
  .map((m) => ['', ...m.slice(1).map(joined)]).filter((m) => m[1] !== 'unknown');
if (rows.length < 29) wrong.push(`only ${rows.length} reasons found in mode_table.hpp`);
for (const [, name, why, out] of rows) {
  for (const [part, text] of [['name', name], ['why', why], ['out', out]]) {
    if (en[`reason.${name}.${part}`] !== text) wrong.push(`en: reason.${name}.${part} is not "${text}"`);
  }
}

// What the server refuses has a code; the page shows that code's text, with the words for what was found in it.
const codes = [...readFileSync(join(root, 'firmware/page/http/refusals.hpp'), 'utf8').matchAll(/Refused \w+\{\s*"(\w+)",/g)].map((m) => m[1]);
if (codes.length < 50 || new Set(codes).size !== codes.length) wrong.push(`${codes.length} codes found in refusals.hpp, ${new Set(codes).size} of them different`);
for (const code of codes) if (!(`refused.${code}` in en)) wrong.push(`en lacks refused.${code}, a code of refusals.hpp`);
for (const key of Object.keys(en)) if (key.startsWith('refused.') && !codes.includes(key.slice(8))) wrong.push(`${key} is no code of refusals.hpp`);
const values = new Set(['found', 'expected', 'field']);
for (const code of codes) for (const m of (en[`refused.${code}`] ?? '').matchAll(/\{(\w+)\}/g)) if (!values.has(m[1])) wrong.push(`refused.${code} has {${m[1]}}, which no refusal has`);
const store = readFileSync(join(root, 'hal/storage/store_error.cpp'), 'utf8');
const given = new Set([...store.split('StoreError store_error(')[1].matchAll(/StoreFault::(\w+)/g)].map((m) => m[1]));
given.delete('no_space');  // has a code of its own
if (given.size < 4) wrong.push(`only ${given.size} faults found in store_error.cpp`);
for (const fault of given) {
  const text = new RegExp(`case StoreFault::${fault}: return "([^;"]*)";\\n`).exec(store.split('text_of(StoreFault fault) {')[1])[1];
  if (!(`found.${text}` in en)) wrong.push(`en lacks found.${text}, the storage fault ${fault}`);
}

let asked = 0;
for (const file of ['app.js', 'views.js', 'why.js', 'checkout.js', 'charts.js', 'index.html']) {
  const source = readFileSync(join(web, file), 'utf8');
  for (const m of source.matchAll(/\bt\('([^'`$]+)'|data-t="([^"]+)"/g)) {
    ++asked;
    if (!((m[1] ?? m[2]) in en)) wrong.push(`${file} asks for ${m[1] ?? m[2]}, which en lacks`);
  }
}
if (asked < 100) wrong.push(`only ${asked} texts are asked for: the pattern of this test is wrong`);

if (wrong.length) {
  console.error(wrong.join('\n'));
  process.exit(1);
}
console.log(`${Object.keys(texts).length} languages, ${Object.keys(en).length} keys, ${asked} places`);
