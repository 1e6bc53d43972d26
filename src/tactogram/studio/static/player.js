/**
 * Plays what buttons with `data-player-url` name, one at a time. While one plays, another's button, or its key 1 to 9,
 * changes over to it at the same place within 20 ms, so that two can be heard against each other; Escape stops.
 * A page's checkbox in `[data-player-loop]` says whether it goes on from the beginning. Nothing plays before a click.
 */

import { BEGINS_MS, keepAwake } from "/participants/static/awake.js";

const CHANGE_S = 0.02;

/** @typedef {{buffer: AudioBuffer, gain: number, limited: number, own: boolean}} Loaded */

/** @type {AudioContext | null} */
let context = null;
/** @type {Map<string, Promise<Loaded>>} */
const loaded = new Map();
/** @type {{url: string, source: AudioBufferSourceNode, fade: GainNode, begun: number, seconds: number, loop: boolean} | null} */
let playing = null;
let wanted = "";

/** @param {string} url @returns {Promise<Loaded>} */
function load(url) {
  const held = loaded.get(url);
  if (held) return held;
  const asked = (async () => {
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(await answer.text());
    const [gain, limited] = ["X-Gain", "X-Limited"].map((name) => Number(answer.headers.get(name)));
    const own = answer.headers.get("X-Own-Level") === "1";
    const buffer = await audio().decodeAudioData(await answer.arrayBuffer());
    return { buffer, gain, limited, own };
  })();
  loaded.set(url, asked);
  asked.catch(() => loaded.delete(url));
  if (loaded.size > 40) loaded.delete(loaded.keys().next().value);
  return asked;
}

/** @returns {AudioContext} */
function audio() {
  if (!context) {
    context = new AudioContext();
    keepAwake(context, () => wanted !== "" || playing !== null);
  }
  return context;
}

/** @returns {boolean} */
function looped() {
  const box = document.querySelector('[data-player-loop] [role="checkbox"], [data-player-loop] [role="switch"]');
  return box?.getAttribute("aria-checked") === "true";
}

/** Where the playing one is, s. @returns {number} */
function place() {
  if (!playing) return 0;
  const run = Math.max(0, audio().currentTime - playing.begun);
  return playing.loop ? run % playing.seconds : Math.min(run, playing.seconds);
}

/** @param {string} url */
async function play(url) {
  wanted = url;
  audio().resume().catch(() => null);
  mark();
  let found;
  try {
    found = await load(url);
  } catch (error) {
    tell(url, `Could not be played: ${error instanceof Error ? error.message : error}`);
    if (wanted === url) wanted = "";
    mark();
    return;
  }
  tell(url, levelOf(url, found));
  if (wanted !== url) return;
  const offset = playing ? place() % found.buffer.duration : 0;
  fadeOut();
  const source = audio().createBufferSource();
  const fade = audio().createGain();
  source.buffer = found.buffer;
  source.loop = looped();
  const now = audio().currentTime;
  fade.gain.setValueAtTime(0, now);
  fade.gain.linearRampToValueAtTime(1, now + CHANGE_S);
  source.connect(fade).connect(audio().destination);
  source.start(now, offset);
  const mine = { url, source, fade, begun: now - offset, seconds: found.buffer.duration, loop: source.loop };
  playing = mine;
  source.onended = () => {
    if (playing === mine) stop();
  };
  mark();
  setTimeout(() => {
    if (playing === mine && audio().state !== "running") tell(url, "The browser has not begun the sound: is there a sound output?");
  }, BEGINS_MS);
  requestAnimationFrame(follow);
}

function fadeOut() {
  if (!playing) return;
  const { source, fade } = playing;
  const now = audio().currentTime;
  fade.gain.cancelScheduledValues(now);
  fade.gain.setValueAtTime(fade.gain.value, now);
  fade.gain.linearRampToValueAtTime(0, now + CHANGE_S);
  source.onended = null;
  source.stop(now + CHANGE_S);
  playing = null;
}

function stop() {
  wanted = "";
  fadeOut();
  mark();
}

/** Shows which button plays. */
function mark() {
  for (const button of document.querySelectorAll("[data-player-url]")) {
    const url = button.getAttribute("data-player-url");
    const now = playing?.url === url;
    button.setAttribute("aria-pressed", String(now));
    if (wanted === url && !now) button.setAttribute("data-state", "loading");
    else button.removeAttribute("data-state");
  }
  for (const head of document.querySelectorAll("[data-player-head]")) {
    if (head.getAttribute("data-player-head") !== playing?.url) head.style.setProperty("--at", "0");
  }
}

function follow() {
  if (!playing) return;
  for (const head of document.querySelectorAll(`[data-player-head="${CSS.escape(playing.url)}"]`)) {
    head.style.setProperty("--at", String(place() / playing.seconds));
  }
  requestAnimationFrame(follow);
}

/** @param {string} url @param {string} text */
function tell(url, text) {
  for (const told of document.querySelectorAll(`[data-player-told="${CSS.escape(url)}"]`)) told.textContent = text;
}

/** @param {string} url @param {Loaded} found @returns {string} */
function levelOf(url, found) {
  const unit = document.querySelector(`[data-player-told="${CSS.escape(url)}"]`)?.getAttribute("data-unit") || "unit";
  const gain = found.own ? `${Number(found.gain.toPrecision(3))} of full scale per ${unit}` : "";
  const bent = found.limited > 0 ? `limiter bent ${Number((100 * found.limited).toPrecision(2))} % of samples` : "";
  return [gain, bent].filter(Boolean).join("; ");
}

document.addEventListener("click", (event) => {
  const button = event.target instanceof Element ? event.target.closest("[data-player-url]") : null;
  const url = button?.getAttribute("data-player-url");
  if (!url) return;
  if (playing?.url === url || wanted === url) stop();
  else play(url);
});

document.addEventListener("keydown", (event) => {
  const at = event.target;
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (at instanceof HTMLElement && at.closest("input, textarea, select, [contenteditable], [role='slider']")) return;
  if (event.key === "Escape") stop();
  if (!/^[1-9]$/.test(event.key)) return;
  const button = document.querySelector(`[data-player-key="${event.key}"]`);
  if (button instanceof HTMLElement) button.click();
});

/** For tests and other scripts. */
window.tactogramPlayer = { state: () => ({ url: playing?.url ?? "", place: place() }), stop, play };
