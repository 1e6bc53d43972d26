/** A participant's pages, one after the other. The server decides what is shown, after a reload as well. */

import { calibrate } from "./calibration.js";
import { deviceFacts } from "./device.js";
import { button, holdStill, make, tell } from "./dom.js";
import { FingerSounds } from "./finger.js";
import { measured } from "./millimetres.js";
import { inMillimetres, showMoment, showPage } from "./page_view.js";
import { Outbox, ask, bytes, insist, passes, statusOf } from "./server.js";
import { BrowserSounds, ServerSounds } from "./sound.js";
import { guessed, nameOf, remedy, say } from "./wording.js";

const base = location.pathname.replace(/\/+$/, "");
const ticket = base.split("/").pop();
const DISPLAY_BUSY = 423;
const outbox = new Outbox(ticket);
/** Whether the author of a study looks at it: without code, card and full screen, and without a trace on this device. */
const previewing = new URLSearchParams(location.search).has("preview");
/** In the studio's language: only authors read it. */
const PREVIEW = { title: "Preview", text: "As participants see it. Answers are not stored." };
const stage = document.getElementById("stage");
const head = document.getElementById("head");
/** Replaced with each page. */
const now = { state: null, view: null, sounds: null, images: new Map(), sending: false, started: false, left: new Set(leftBefore()) };

const language = () => now.state?.language ?? guessed;
const address = (what, slot) => `${base}/${what}?token=${encodeURIComponent(now.state.page.token)}&slot=${encodeURIComponent(slot)}`;

const tellAway = (away, status) => tell(away ? remedy(language(), status) : "");
const tellUnplayed = (status) => tell(say(language(), status === DISPLAY_BUSY ? "display_busy" : "no_sound"));

/** Adopt the state that the server returned. */
function take(state) {
  now.state = state;
  document.documentElement.lang = state.language;
  document.title = typeof state.title === "string" ? state.title : (state.title?.[state.language] ?? "");
  if (!previewing && (state.state !== "going" || !state.page)) forget();
}

/** Forget that a study was begun on this device and is not finished. */
function forget() {
  try {
    localStorage.removeItem("tactogram.unfinished");
  } catch {
    // Nothing was kept.
  }
}

async function start() {
  holdStill();
  document.addEventListener("visibilitychange", () => document.hidden && now.view?.hush());
  window.addEventListener("pagehide", () => now.view?.hush());
  try {
    take(await insist(() => (outbox.kept() ? deliverOnce() : ask(`${base}/page`)), tellAway));
  } catch {
    return deadEnd();
  }
  now.sounds = soundsOf(now.state.played_by);
  if (ended()) return showEnd();
  return showWelcome();
}

function soundsOf(playedBy) {
  if (playedBy === "stream") {
    return new FingerSounds(() => `${base}/finger?token=${encodeURIComponent(now.state.page.token)}`, (status) => (status ? tellUnplayed(status) : tell("")));
  }
  if (playedBy !== "server") {
    const fetched = (slot) => insist(() => bytes(address("sound", slot)), tellAway);
    return new BrowserSounds(fetched, (silent) => tell(silent ? say(language(), "no_sound") : ""));
  }
  const play = async (slot) => {
    try {
      await ask(`${base}/play`, { token: now.state.page.token, slot });
      return true;
    } catch (error) {
      tellUnplayed(statusOf(error));
      return false;
    }
  };
  return new ServerSounds(play, () => ask(`${base}/stop`, {}).catch(() => null));
}

const ended = () => now.state.state !== "going" || !now.state.page;

function showHead() {
  const { state } = now;
  const parts = [make("span", { class: "title", text: document.title })];
  if (now.started && !ended()) parts.push(progressOf(state.page));
  const tools = make("span", { class: "tools" }, make("span", { class: "code-small", text: previewing ? PREVIEW.title : state.code }));
  if ((state.languages ?? []).length > 1 && !ended()) {
    const names = state.languages.map((one) => make("option", { value: one, lang: one, selected: one === state.language, text: nameOf(one) }));
    const choice = make("select", { class: "small", "aria-label": say(language(), "language"), onchange: () => speak(choice.value) }, ...names);
    tools.append(choice);
  }
  const can = document.fullscreenEnabled && !document.fullscreenElement;
  if (now.started && can && !ended()) tools.append(make("button", { type: "button", class: "small", text: say(language(), "full_screen"), onclick: fullScreen }));
  head.replaceChildren(...parts, tools);
}

document.addEventListener("fullscreenchange", () => now.state && showHead());

function progressOf(page) {
  if (!page.total) return make("span", { class: "progress" });
  const values = { trial: page.trial, total: page.total };
  const text = say(language(), page.layout.at_most && !page.layout.practice ? "trial_at_most" : "trial", values);
  const name = `${page.layout.practice ? say(language(), "practice") : say(language(), "progress")}: ${text}`;
  const bar = make("progress", { value: page.trial - 1, max: page.total, "aria-label": name });
  return make("span", { class: "progress" }, bar, make("span", { text }));
}

/** Switch to another language; answers so far stay. */
async function speak(chosen) {
  if (now.sending) return showHead();
  try {
    await ask(`${base}/language`, { language: chosen });
    take(await ask(`${base}/page`));
  } catch {
    showHead();
    return tell(say(language(), "waiting"));
  }
  tell("");
  if (!now.started) return showWelcome();
  return show();
}

function fullScreen() {
  document.documentElement.requestFullscreen?.({ navigationUI: "hide" }).catch(() => null);
}

function showWelcome() {
  showHead();
  const first = now.state.page.kind === "consent";
  const l = language();
  const go = async () => {
    now.sounds.unlock();
    if (!previewing) fullScreen();
    now.started = true;
    await show();
  };
  const possible = now.state.played_by !== "browser" || BrowserSounds.possible;
  const silent = possible ? [] : [make("p", { class: "feedback wrong", text: say(l, "no_audio") })];
  if (previewing) return showMoment(stage, { ...PREVIEW, go: say(l, "start_plain"), press: go, more: silent });
  const code = make("div", { class: "code-block" }, make("span", { class: "quiet", text: say(l, "code") }), make("strong", { class: "code", text: now.state.code }), make("p", { text: say(l, "note_code") }), make("p", { class: "quiet", text: say(l, "no_names") }));
  const more = [code, ...silent];
  const label = document.fullscreenEnabled ? "start" : "start_plain";
  return showMoment(stage, { title: say(l, first ? "welcome" : "welcome_back"), text: document.title, go: say(l, label), press: go, more });
}


/** Show the current page, after a rest or the end of the practice; measure the screen before the first page in millimetres. */
async function show() {
  now.view?.stop();
  now.view = null;
  showHead();
  if (ended()) return showEnd();
  const { page } = now.state;
  if (measured() === null && !previewing && inMillimetres(page, now.sounds)) await calibrate(stage, language());
  const l = language();
  if (page.rest && !now.left.has(`rest ${page.token}`)) {
    return showMoment(stage, { title: say(l, "rest"), text: say(l, "rest_text"), go: say(l, "go_on"), press: () => leave(`rest ${page.token}`) });
  }
  const over = page.layout.practice_ended;
  if (over && !now.left.has(`practice ${page.token}`)) {
    const { feedback } = over;
    const more = feedback ? [make("p", { class: feedback.correct ? "feedback right" : "feedback wrong", text: feedback.text })] : [];
    const press = () => leave(`practice ${page.token}`);
    return showMoment(stage, { title: say(l, "practice"), text: over.text, go: say(l, "go_on"), press, more });
  }
  if (now.sounds.test && !previewing && !now.left.has("sound") && page.slots.some((slot) => slot.played)) {
    const more = [button(say(l, "play_one"), () => now.sounds.test(), { class: "large sound-test" })];
    return showMoment(stage, { title: say(l, "sound_check"), text: say(l, "sound_check_text"), go: say(l, "go_on"), press: () => leave("sound"), more });
  }
  try {
    await load(page);
  } catch (error) {
    if (statusOf(error) === 409) return refresh();
    if (statusOf(error) === 404) return deadEnd();
    return showMoment(stage, { title: say(l, "no_sound"), go: say(l, "go_on"), press: show });
  }
  if (now.state.page !== page) return undefined;
  now.view = showPage({ page, language: l, sounds: now.sounds, images: now.images, stage, draft: draftOf(page), send: submit });
  return undefined;
}

/** Leave a screen between pages, for this tab. */
function leave(moment) {
  now.left.add(moment);
  try {
    sessionStorage.setItem(`tactogram.left.${ticket}`, JSON.stringify([...now.left]));
  } catch {
    // Without storage a reload shows it again.
  }
  return show();
}

function leftBefore() {
  try {
    return JSON.parse(sessionStorage.getItem(`tactogram.left.${ticket}`) ?? "[]");
  } catch {
    return [];
  }
}

async function load(page) {
  for (const old of now.images.values()) URL.revokeObjectURL(old);
  now.images.clear();
  now.sounds.clear();
  const seen = page.slots.filter((slot) => slot.picture);
  const played = page.slots.filter((slot) => slot.played).map((slot) => slot.slot);
  const late = setTimeout(() => stage.replaceChildren(make("div", { class: "moment" }, make("p", { class: "lead", role: "status", text: say(language(), "loading") }))), 400);
  try {
    await Promise.all([
      now.sounds.load(played),
      ...seen.map(async (slot) => {
        const found = await insist(() => bytes(address("image", slot.slot)), tellAway);
        now.images.set(slot.slot, URL.createObjectURL(new Blob([found], { type: "image/png" })));
      }),
    ]);
  } finally {
    clearTimeout(late);
  }
}

/** Return the answers to a page that are not sent yet; they survive a reload. */
function draftOf(page) {
  const key = `tactogram.draft.${ticket}`;
  let kept = {};
  try {
    const found = JSON.parse(sessionStorage.getItem(key) ?? "{}");
    if (found.token === page.token) kept = found.answers;
  } catch {
    // Nothing was kept.
  }
  const keep = (answers) => {
    try {
      sessionStorage.setItem(key, JSON.stringify({ token: page.token, answers }));
    } catch {
      // Without storage they last as long as the page is open.
    }
  };
  return { kept, keep };
}

async function submit({ answers, rt_ms, facts }) {
  if (now.sending) return;
  now.sending = true;
  outbox.keep({ token: now.state.page.token, answers, rt_ms, device: deviceFacts(facts) });
  const late = setTimeout(() => tell(say(language(), "sending")), 600);
  const sent = () => {
    clearTimeout(late);
    now.sending = false;
  };
  try {
    const state = await insist(deliverOnce, (away, status) => {
      clearTimeout(late);
      if (away && status === 0) tell(say(language(), "kept"));
      else tellAway(away, status);
    });
    take(state);
    sent();
    await show(); // until the screen is measured, where it has to be
  } catch (error) {
    const status = statusOf(error);
    if ([401, 403, 404].includes(status)) deadEnd();
    else await refresh(status);
  } finally {
    sent();
  }
}

/** Send the answers in the outbox; clear it once the server has them or refuses them for good. */
async function deliverOnce() {
  try {
    const state = await ask(`${base}/answers`, outbox.kept());
    outbox.clear();
    return state;
  } catch (error) {
    if (!passes(error)) {
      outbox.clear();
      if ([400, 409, 422].includes(error.status) && !now.started) return ask(`${base}/page`);
    }
    throw error;
  }
}

/** Show the server's current page, and what to do about a refused answer. */
async function refresh(refused = null) {
  try {
    take(await insist(() => ask(`${base}/page`), tellAway));
  } catch {
    return deadEnd();
  }
  await show();
  if (refused !== null && !ended()) tell(remedy(language(), refused));
  return undefined;
}

function deadEnd() {
  now.view?.stop();
  tell("");
  showMoment(stage, { title: say(language(), "no_ticket") });
}

function showEnd() {
  showHead();
  tell("");
  now.sounds?.clear();
  if (previewing) return showMoment(stage, { title: PREVIEW.title, text: "The end of the study. Answers were not stored." });
  const key = ["declined", "aborted"].includes(now.state.state) ? now.state.state : "done";
  showMoment(stage, { title: say(language(), key), text: say(language(), `${key}_text`), more: [make("p", { class: "code", text: now.state.code })] });
  if (document.fullscreenElement) document.exitFullscreen().catch(() => null);
  return undefined;
}

start();
