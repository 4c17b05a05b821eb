// The page: asks the box for its state, and lets those who have signed in ask something of it. One request at a time:
// the box gives few sockets to one address.

const $ = (id) => document.getElementById(id);
export const page = { texts: {}, session: {}, site: {}, status: null, age: 0, alarms: [], weights: {}, trends: null, gap: null, span_text: String, span: 'day' };

export const t = (key, values = {}) =>
  (page.texts[key] ?? key).replace(/\{(\w+)\}/g, (_, name) => values[name] ?? '');
export const has = (key) => key in page.texts;

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

let queue = Promise.resolve();
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

/** One exchange after the other; a connection that the box has no place for is tried again. */
function ask(path, options = {}) {
  const run = async () => {
    for (let attempt = 0; ; ++attempt) {
      try {
        return await fetch(path, { cache: 'no-cache', credentials: 'same-origin', ...options });
      } catch (error) {
        if (attempt === 3 || options.method === 'POST') throw error;
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
  if (answer.status === 401) throw new Error('401');
  if (!answer.ok) throw new Error(`${answer.status}`);
  return { json: await answer.json(), age: Number(answer.headers.get('Age') ?? 0) };
}
async function post(path, body = '') {
  const answer = await ask(path, { method: 'POST', body, headers: { 'X-Airside-Token': page.session.token ?? '' } });
  let said = {};
  try { said = await answer.json(); } catch { /* an answer without a text */ }
  return { status: answer.status, reason: said.reason ?? '', wait: Number(answer.headers.get('Retry-After') ?? 0) };
}
export async function post_and_tell(place, path, body, ok) {
  let said;
  try { said = await post(path, body); } catch { said = { status: 0, reason: t('no-answer') }; }
  const good = said.status >= 200 && said.status < 300;
  $(place).classList.toggle('bad', !good);
  say(place, good ? ok : t('refused', { status: said.status, reason: has(`said.${said.status}`) ? t(`said.${said.status}`) : said.reason }));
  if (said.status === 401) await load_session();
  return good;
}

function apply_texts() {
  for (const e of document.querySelectorAll('[data-t]')) e.textContent = t(e.dataset.t);
  document.documentElement.lang = page.texts.lang ?? 'en';
  $('language').value = page.texts.lang ?? 'en';
}
async function load_texts(language) {
  page.texts = (await get(`/texts/${language}.json`)).json;
  apply_texts();
}
function wished_language() {
  const kept = localStorage.getItem('airside-language');
  if (kept === 'en' || kept === 'zh-Hant') return kept;
  return navigator.languages.some((l) => /^zh\b/i.test(l)) && !/^en\b/i.test(navigator.language) ? 'zh-Hant' : 'en';
}

let views = null, checkout = null;
async function load_session() {
  page.session = (await get('/session.json')).json;
  const s = page.session;
  say('who', s.role === 'none' ? t('not-signed-in') : t('signed-in-as', { role: t(`role.${s.role}`) }));
  $('sign-in').hidden = s.role !== 'none' || s.roles.length === 0;
  $('sign-out').hidden = s.role === 'none';
  $('orders').hidden = !s.operate;
  $('rollback').hidden = !s.operate;
  $('upload').hidden = !s.install;
  checkout?.show();
  say('trouble', s.trouble ? t('access-trouble') : s.see ? '' : t('see-needs-sign-in'));
  $('trouble').hidden = !s.trouble && s.see;
  $('role').replaceChildren(...s.roles.map((r) => el('option', t(`role.${r}`), { value: r })));
  if (s.roles.includes('operator')) $('role').value = 'operator';
}

async function refresh_state() {
  if (!page.session.see) return;
  try {
    const answer = await get('/status.json');
    page.status = answer.json;
    page.age = answer.age;
    say('trouble', '');
    $('trouble').hidden = true;
  } catch (error) {
    if (error.message === '401') return load_session();
    say('trouble', error.message === '503' ? t('no-status') : t('no-answer'));
    $('trouble').hidden = false;
    if (error.message === '503') page.status = null;
    return;
  }
  page.alarms = (await get('/alarms.json')).json;
  page.weights = (await get('/weights.json')).json;
  views.show();
}
async function refresh_trends() {
  if (!page.session.see) return;
  for (let again = true; again;) {
    page.trends = (await get(`/trends.json?span=${page.span}`)).json;
    if (!page.trends.reading) page.gap = (await get('/gap.json')).json;
    await views.show_trends();
    again = page.trends.reading;
    if (again) await pause(500);
  }
}
const quietly = (work) => work.catch(() => { say('trouble', t('no-answer')); $('trouble').hidden = false; });

/** Asks before something is done that a person would regret. */
function confirm(title, text, yes) {
  say('confirm-h', title);
  say('confirm-said', text);
  say('confirm-yes', yes);
  $('confirm-d').showModal();
  return new Promise((done) => {
    $('confirm-yes').onclick = () => { $('confirm-d').close('yes'); };
    $('confirm-d').onclose = () => { done($('confirm-d').returnValue === 'yes'); $('confirm-d').returnValue = ''; };
  });
}

export async function acknowledge(id) {
  await post_and_tell('order-said', '/alarms/seen', String(id), t('seen-done'));
  await refresh_state();
}

function listen() {
  $('language').onchange = async () => {
    localStorage.setItem('airside-language', $('language').value);
    await load_texts($('language').value);
    await load_session();
    views.show();
    if (page.trends) await views.show_trends();
    checkout.show();
  };
  $('sign-in').onclick = () => { say('sign-in-said', ''); $('sign-in-d').showModal(); $('password').focus(); };
  for (const b of document.querySelectorAll('[data-close]')) b.onclick = () => b.closest('dialog').close();
  $('sign-in-f').onsubmit = async (event) => {
    event.preventDefault();
    let said;
    try { said = await post('/login', `${$('role').value}\n${$('password').value}`); } catch { said = { status: 0 }; }
    $('password').value = '';
    if (said.status !== 200) {
      say('sign-in-said', said.status === 403 ? t('wrong-password') : said.status === 429 ? t('locked', { s: said.wait }) : t('try-again'));
      return $('password').focus();
    }
    $('sign-in-d').close();
    await load_session();
    $('sign-out').focus();  // now, and not from under the hands of whoever has gone on meanwhile
    await refresh_state();
    if (!page.trends) await refresh_trends();
    await checkout.load();
  };
  $('sign-out').onclick = async () => { await post('/logout'); await load_session(); $('sign-in').focus(); if (page.status) views.show(); };
  $('release').onclick = async () => {
    const hours = $('release-hours').value;
    const text = hours ? t('release-confirm-h', { h: hours }) : t('release-confirm');
    if (!(await confirm(t('release-title'), text, t('release')))) return;
    await post_and_tell('order-said', '/release', hours, hours ? t('release-done-h', { h: hours }) : t('release-done'));
  };
  $('hand-back').onclick = async () => {
    if (!(await confirm(t('hand-back-title'), t('hand-back-confirm'), t('hand-back')))) return;
    await post_and_tell('order-said', '/hand-back', '', t('hand-back-done', { min: page.site.cycle_min ?? 18 }));
  };
  $('rollback').onclick = async () => {
    if (!(await confirm(t('rollback-title'), t('rollback-confirm'), t('rollback')))) return;
    await post_and_tell('weights-order-said', '/rollback', '', t('rollback-done'));
    await refresh_state();
  };
  $('upload').onsubmit = async (event) => {
    event.preventDefault();
    const file = $('blob').files[0];
    if (!file) return;
    if (await post_and_tell('weights-order-said', '/weights', file, t('upload-done'))) $('upload').reset();
    await refresh_state();
  };
  $('seen-all').onclick = () => acknowledge('all');
  for (const b of document.querySelectorAll('.span')) {
    b.onclick = async () => {
      page.span = b.dataset.span;
      for (const other of document.querySelectorAll('.span')) other.setAttribute('aria-pressed', String(other === b));
      $('csv').href = `/trends.csv?span=${page.span}`;
      await quietly(refresh_trends());
    };
  }
  matchMedia('(prefers-color-scheme: dark)').onchange = () => { if (page.trends) views.show_trends(); };
  let width = innerWidth;
  addEventListener('resize', () => { if (page.trends && innerWidth !== width) { width = innerWidth; views.show(); views.show_trends(); } });
}

async function start() {
  try { await load_texts(wished_language()); } catch { await load_texts('en'); }
  views = await import('/views.js');
  checkout = await import('/checkout.js');
  await load_session();
  listen();
  checkout.listen();
  if (page.session.see) page.site = (await get('/site.json')).json;
  await refresh_state();
  await refresh_trends();
  await checkout.load();
  let since = 0;
  setInterval(async () => {
    if (document.hidden) return;
    if (page.session.see && !page.site.site) page.site = (await get('/site.json')).json;
    await quietly(refresh_state());
    since += 1;
    if (since % 12 === 0) await quietly(refresh_trends().then(checkout.load));
  }, 15000);
}
quietly(start()).finally(() => { document.documentElement.dataset.ready = 'yes'; });
