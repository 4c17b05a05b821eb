// The page: asks the box for its state, and lets those who have signed in ask something of it. One request at a time:
// the box gives few sockets to one address.

const $ = (id) => document.getElementById(id);
const nothing = { site: {}, status: null, age: 0, answered: 0, alarms: null, weights: null, trends: null, gap: null };
/** What is known. `age`: of the status, s, when it was given out at `answered`, below 0 for one from the future; `lost`: the last question had no answer. */
export const page = { texts: {}, session: { roles: [] }, ...nothing, lost: false, span_text: String, span: 'day' };

export const t = (key, values = {}) =>
  (page.texts[key] ?? key).replace(/\{(\w+)\}/g, (_, name) => values[name] ?? '');
export const has = (key) => key in page.texts;
/** One sentence behind the other: Chinese has no blank between them. */
export const sentences = (list) => list.filter(Boolean).join(page.texts.lang === 'zh-Hant' ? '' : ' ');

/** An element with text and children; text never becomes markup. */
export function el(name, text = '', attributes = {}, ...children) {
  const e = document.createElement(name);
  if (text !== '') e.textContent = text;
  for (const [k, v] of Object.entries(attributes)) if (v !== null && v !== undefined) e.setAttribute(k, v);
  e.append(...children);
  return e;
}
/** Writes a text only where it differs, so that a screen reader says only what is new. */
export function say(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

class NoAnswer extends Error {}
let queue = Promise.resolve();
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** One exchange after the other; a connection that the box has no place for is tried again. */
function ask(path, options = {}, seconds = 20) {
  const run = async () => {
    for (let attempt = 0; ; ++attempt) {
      try {
        return await fetch(path, { cache: 'no-cache', credentials: 'same-origin', signal: AbortSignal.timeout?.(1000 * seconds), ...options });
      } catch (error) {
        // A pulled cable gives no error for minutes: who has waited that long does not wait again.
        if (attempt === 3 || options.method === 'POST' || error.name === 'TimeoutError') throw new NoAnswer(error.message);
        await pause(300 * 2 ** attempt);
      }
    }
  };
  const answer = queue.then(run, run);
  queue = answer.catch(() => {});
  return answer;
}
export async function get(path) {
  const answer = await ask(path);
  if (!answer.ok) throw new Error(`${answer.status}`);
  try {
    const ahead = Number(answer.headers.get('X-Airside-Ahead') ?? 0);  // of a file from the future
    return { json: await answer.json(), age: ahead ? -ahead : Number(answer.headers.get('Age') ?? 0) };
  } catch (error) { throw new NoAnswer(error.message); }
}
async function post(path, body = '') {
  const answer = await ask(path, { method: 'POST', body, headers: { 'X-Airside-Token': page.session.token ?? '' } }, path === '/weights' ? 120 : 20);
  let said = {};
  try { said = await answer.json(); } catch { /* an answer without a text */ }
  return { ...said, status: answer.status, reason: said.reason ?? '', wait: Number(answer.headers.get('Retry-After') ?? 0) };
}
/** What stands in the way, in the reader's language; in the box's English where the page has no text for it. */
function why_refused(said) {
  const key = `refused.${said.code}`;
  if (!has(key)) return said.reason;
  const found = ['found', 'point', 'fault'].map((kind) => `${kind}.${said.found}`).find(has);
  return t(key, { ...said, found: found ? t(found) : said.found });
}
/** Whether the box took it. Without an answer nobody knows: `unsure` is what is said then. */
export async function post_and_tell(place, path, body, ok, unsure = t('unsure')) {
  let said;
  try { said = await post(path, body); } catch { said = { status: 0 }; page.lost = true; }
  const good = said.status >= 200 && said.status < 300;
  $(place).classList.toggle('bad', !good);
  say(place, good ? ok : said.status === 0 ? unsure : t('refused', { status: said.status, reason: why_refused(said) }));
  show_trouble();
  if (said.status === 401) {
    await quietly(load_session());
    if (page.session.role === 'none' && page.session.roles.length) open_sign_in(t('session-over'));
  }
  return good;
}
export async function quietly(work) {
  try { return await work; } catch (error) {
    if (error.message === '401') return quietly(load_session());
    if (!(error instanceof NoAnswer) && !/^\d+$/.test(error.message)) console.error(error);
    page.lost = true;
    show_trouble();
    views?.tick();
  }
}
/** A handler that does nothing while its work is under way: of two taps the second would be answered as a mistake. */
export const once = (button, work) => async (...values) => {
  if (button.disabled) return;
  const had_focus = document.activeElement === button;
  button.disabled = true;
  try { return await work(...values); } finally {
    button.disabled = false;
    if (had_focus && document.activeElement === document.body && button.isConnected) button.focus();
  }
};

function apply_texts() {
  for (const e of document.querySelectorAll('[data-t]')) e.textContent = t(e.dataset.t);
  document.documentElement.lang = page.texts.lang ?? 'en';
  $('language').value = page.texts.lang ?? 'en';
}
const languages = {};
async function load_texts(language) {
  languages[language] ??= (await get(`/texts/${language}.json`)).json;
  page.texts = languages[language];
  apply_texts();
}
function wished_language() {
  const kept = localStorage.getItem('airside-language');
  if (kept === 'en' || kept === 'zh-Hant') return kept;
  return navigator.languages.some((l) => /^zh\b/i.test(l)) && !/^en\b/i.test(navigator.language) ? 'zh-Hant' : 'en';
}

let views = null, checkout = null, shown_roles = '';
/** One banner: the gravest of what keeps the page from showing what is. */
function show_trouble() {
  const s = page.session;
  const text = page.lost ? t('no-answer') : s.trouble ? t('access-trouble') : s.see === false ? t('see-needs-sign-in') : s.see && !page.status ? t('no-status') : '';
  say('trouble', text);
  $('trouble').hidden = !text;
}
function show_session() {
  const s = page.session, open = s.roles.length === 0 && !s.trouble;
  say('who', s.role !== 'none' ? t('signed-in-as', { role: t(`role.${s.role}`) }) : open ? '' : t('not-signed-in'));
  $('no-password').hidden = !open;
  $('sign-in').hidden = s.role !== 'none' || s.roles.length === 0;
  $('sign-out').hidden = s.role === 'none';
  $('orders').hidden = !s.operate;
  $('upload').hidden = !s.install;
  const roles = JSON.stringify([s.roles, page.texts.lang]);
  if (roles === shown_roles) return;
  shown_roles = roles;  // anew only where they differ: somebody may be choosing
  $('role').replaceChildren(...s.roles.map((r) => el('option', t(`role.${r}`), { value: r })));
  if (s.roles.includes('operator')) $('role').value = 'operator';
}
async function load_session() {
  const before = page.session;
  page.session = (await get('/session.json')).json;
  show_session();
  if (!page.session.see) forget();
  if (before.role === page.session.role && page.session.see) return;
  views?.show();
  checkout?.show();
}
/** What may not be seen any more is neither shown nor kept. */
function forget() {
  Object.assign(page, nothing);
  sessionStorage.removeItem('airside-asked');
  checkout?.forget();
  views?.forget();
}

async function read_status() {
  try {
    const answer = await get('/status.json');
    Object.assign(page, { status: answer.json, age: answer.age, answered: Date.now(), lost: false });
  } catch (error) {
    if (error.message !== '503') throw error;
    Object.assign(page, { status: null, lost: false });
  }
}
async function read_state() {
  await load_session();
  if (!page.session.see) {
    page.lost = false;
    return show_trouble();
  }
  if (!page.site.site) page.site = (await get('/site.json')).json;
  await read_status();
  page.alarms = (await get('/alarms.json')).json;
  page.weights = (await get('/weights.json')).json;
  show_trouble();
  views.show();
}
const refresh_state = () => quietly(read_state());
async function refresh_trends() {
  for (let again = true; again && page.session.see;) {
    const trends = (await get(`/trends.json?span=${page.span}`)).json;
    if (!page.session.see) return;
    page.trends = trends;
    if (!trends.reading && page.site.objective !== 'band') page.gap = (await get('/gap.json')).json;
    await views.show_trends();
    again = trends.reading;
    if (again) await pause(500);
  }
}

/** The order of this browser that the status does not show yet. */
export function asked() {
  try { return JSON.parse(sessionStorage.getItem('airside-asked')); } catch { return null; }
}
export const asked_done = () => sessionStorage.removeItem('airside-asked');
let following = false;
/** Looks every 2 s until the state follows what was asked for; at the latest the next row has it. */
async function follow() {
  if (following) return;
  following = true;
  while (asked() && Date.now() - asked().at < 420000) {
    await pause(2000);
    if (document.hidden || !page.session.see) continue;
    await quietly(read_status().then(() => { show_trouble(); views.show(); }));
  }
  following = false;
  await refresh_state();
}
function note_asked(what) {
  sessionStorage.setItem('airside-asked', JSON.stringify({ what, at: Date.now() }));
  quietly(follow());
}
async function until_weights(state) {
  for (let i = 0; i < 200 && page.status?.pushed_weights !== state; ++i) {
    await pause(2000);
    if (!document.hidden) await refresh_state();
  }
}

let unlock = 0;
/** Asks before something is done that a person would regret. A second tap or a held key is no answer: it comes before
 *  anybody can have read the question. */
function confirm(title, text, yes) {
  say('confirm-h', title);
  say('confirm-said', text);
  say('confirm-yes', yes);
  const dialog = $('confirm-d'), opened = Date.now();
  $('confirm-yes').disabled = true;
  clearTimeout(unlock);
  unlock = setTimeout(() => { $('confirm-yes').disabled = false; }, 500);
  dialog.onkeydown = (event) => { if (event.repeat && ['Enter', ' '].includes(event.key)) event.preventDefault(); };
  dialog.showModal();
  $('confirm-no').focus();
  return new Promise((done) => {
    $('confirm-yes').onclick = () => { dialog.close('yes'); };
    $('confirm-no').onclick = () => { if (Date.now() - opened > 500) dialog.close(); };
    dialog.onclose = () => { done(dialog.returnValue === 'yes'); dialog.returnValue = ''; };
  });
}

export async function acknowledge(id, place) {
  if (!(await post_and_tell('alarms-said', '/alarms/seen', String(id), t('seen-done')))) return;
  await refresh_state();
  const left = [...$('alarms').querySelectorAll('button')];
  (left[Math.min(place, left.length - 1)] ?? $('alarms-h')).focus();
}

/** As a file with the name of the AHU: of ten boxes the files lie in one folder. */
async function download(link) {
  const answer = await ask(link.getAttribute('href'), {}, 120);
  if (!answer.ok) throw new Error(`${answer.status}`);
  const words = [page.site.site, ...(link.id === 'csv' ? [page.span, page.trends?.from?.slice(0, 10), page.trends?.to?.slice(0, 10)] : ['points'])];
  const address = URL.createObjectURL(await answer.blob());
  el('a', '', { href: address, download: `${words.filter(Boolean).join('_').replace(/[^\p{L}\p{N}_.-]+/gu, '-')}.csv` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

let countdown = 0;
function lock_out(seconds) {
  const end = Date.now() + 1000 * seconds;
  clearInterval(countdown);
  const show = () => {
    const left = Math.ceil((end - Date.now()) / 1000);
    say('sign-in-wait', left > 0 ? t('locked-wait', { s: left }) : t('locked-over'));
    if (left <= 0) clearInterval(countdown);
  };
  show();
  countdown = setInterval(show, 1000);
}
function open_sign_in(said = '') {
  say('sign-in-said', said);
  if (!$('sign-in-d').open) $('sign-in-d').showModal();
  $('password').focus();
}

function listen() {
  $('language').onchange = async () => {
    try { await load_texts($('language').value); } catch {
      $('language').value = page.texts.lang;  // no answer: the page stays in its language, and says so
      page.lost = true;
      return show_trouble();
    }
    localStorage.setItem('airside-language', page.texts.lang);
    for (const id of ['order-said', 'alarms-said', 'weights-order-said', 'points-said']) say(id, '');  // in the other language
    show_session();
    show_trouble();
    views.show();
    await quietly(views.show_trends());
    checkout.show();
  };
  $('sign-in').onclick = () => open_sign_in();
  for (const b of document.querySelectorAll('[data-close]')) b.onclick = () => b.closest('dialog').close();
  let signing_in = false;  // until the box has answered; what follows may be behind a dialog that is open again
  $('sign-in-f').onsubmit = async (event) => {
    event.preventDefault();
    if (signing_in) return;
    signing_in = true;
    let said;
    try { said = await post('/login', `${$('role').value}\n${$('password').value}`); } catch { said = { status: 0 }; }
    $('password').value = '';
    signing_in = false;
    if (said.status !== 200) {
      say('sign-in-said', said.status === 0 ? t('unsure') : why_refused(said));
      if (said.status === 429) lock_out(said.wait);
      return $('password').focus();
    }
    clearInterval(countdown);
    say('sign-in-wait', '');
    $('sign-in-d').close();
    await quietly(load_session());
    $('sign-out').focus();  // now, and not from under the hands of whoever has gone on meanwhile
    await refresh_state();
    if (!page.trends) await quietly(refresh_trends());
    await quietly(checkout.load());
  };
  $('sign-out').onclick = once($('sign-out'), async () => {
    await quietly(post('/logout').then(load_session));
    if (page.session.role !== 'none') return;
    $('sign-in').focus();
    show_trouble();
    views.show();
  });
  const send = (id, ...words) => once($(id), () => post_and_tell(...words))();
  $('release').onclick = async () => {
    const hours = $('release-hours').value, idle = views.is_idle();
    const text = sentences([idle && t('idle'), hours ? t('release-confirm-h', { h: hours }) : t('release-confirm')]);
    if (!(await confirm(t('release-title'), text, t('release')))) return;
    const done = idle ? t('release-done-idle') : hours ? t('release-done-h', { h: hours }) : t('release-done');
    if (await send('release', 'order-said', '/release', hours, done, t('unsure-release'))) note_asked('release');
  };
  $('hand-back').onclick = async () => {
    const idle = views.is_idle(), already = views.is_in_control() && asked()?.what !== 'release';
    if (!(await confirm(t('hand-back-title'), t(idle ? 'hand-back-confirm-idle' : already ? 'hand-back-already' : 'hand-back-confirm'), t('hand-back')))) return;
    const done = t(idle ? 'hand-back-done-idle' : already ? 'hand-back-done-already' : 'hand-back-done', { min: page.site.cycle_min ?? 18 });
    if (await send('hand-back', 'order-said', '/hand-back', '', done) && !already) note_asked('hand-back');
  };
  $('rollback').onclick = async () => {
    if (!(await confirm(t('rollback-title'), t('rollback-confirm'), t('rollback')))) return;
    if (await send('rollback', 'weights-order-said', '/rollback', '', t('rollback-done'))) until_weights('rolled back');
  };
  const upload = once($('upload').querySelector('button'), async () => {
    const file = $('blob').files[0];
    if (!file) return;
    const good = await post_and_tell('weights-order-said', '/weights', file, t('upload-done'));
    if (good) $('upload').reset();
    await refresh_state();
    if (good) until_weights('on trial');
  });
  $('upload').onsubmit = (event) => { event.preventDefault(); upload(); };
  $('seen-all').onclick = once($('seen-all'), () => acknowledge(`all ${Math.max(...page.alarms.alarms.map((a) => a.id))}`, 0));
  for (const link of document.querySelectorAll('a[download]')) {
    link.onclick = (event) => { event.preventDefault(); quietly(download(link)); };
  }
  for (const b of document.querySelectorAll('.span')) {
    b.onclick = async () => {
      page.span = b.dataset.span;
      for (const other of document.querySelectorAll('.span')) other.setAttribute('aria-pressed', String(other === b));
      $('csv').href = `/trends.csv?span=${page.span}`;
      await quietly(refresh_trends());
    };
  }
  matchMedia('(prefers-color-scheme: dark)').onchange = () => quietly(views.show_trends());
  let width = innerWidth;
  addEventListener('resize', () => { if (innerWidth !== width) { width = innerWidth; views.show(); quietly(views.show_trends()); } });
}

async function start() {
  try { await load_texts(wished_language()); } catch { await load_texts('en'); }
  views = await import('/views.js');
  checkout = await import('/checkout.js');
  listen();
  checkout.listen();
  await read_state();
  if (asked()) quietly(follow());
  await refresh_trends();
  await checkout.load();
}
let since = 0, polling = false;
async function poll() {
  if (document.hidden || polling || !views) return;
  polling = true;
  await refresh_state();
  since += 1;
  if (since % 12 === 0) await quietly(refresh_trends().then(checkout.load));
  polling = false;
}
quietly(start()).finally(() => {
  document.documentElement.dataset.ready = 'yes';
  setInterval(poll, 15000);
  setInterval(() => { if (!document.hidden) views?.tick(); }, 5000);
  document.addEventListener('visibilitychange', poll);
});
