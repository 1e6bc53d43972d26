/**
 * Plays the sounds of buttons with `data-player-url`, one at a time. While one plays, another button with a key 1 to 9,
 * or the key, switches to that sound at the same position within 20 ms, for direct comparison; Escape stops. A checkbox in
 * `[data-player-loop]` repeats the sound. Nothing plays before a click.
 */

import { BEGINS_MS, keepAwake } from "/participants/static/awake.js";

const FADE_S = 0.02;

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
  const known = loaded.get(url);
  if (known) return known;
  const request = (async () => {
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(await answer.text());
    const [gain, limited] = ["X-Gain", "X-Limited"].map((name) => Number(answer.headers.get(name)));
    const own = answer.headers.get("X-Own-Level") === "1";
    const buffer = await audio().decodeAudioData(await answer.arrayBuffer());
    return { buffer, gain, limited, own };
  })();
  loaded.set(url, request);
  request.catch(() => loaded.delete(url));
  if (loaded.size > 40) loaded.delete(loaded.keys().next().value);
  return request;
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
  const box = document.querySelector("[data-player-loop]");
  return box?.getAttribute("aria-checked") === "true";
}

/** Position of the current sound, s. @returns {number} */
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
  let sound;
  try {
    sound = await load(url);
  } catch (error) {
    tell(url, `Cannot play: ${error instanceof Error ? error.message : error}`);
    if (wanted === url) wanted = "";
    mark();
    return;
  }
  tell(url, levelOf(url, sound));
  if (wanted !== url) return;
  const compared = document.querySelector(`[data-player-url="${CSS.escape(url)}"][data-player-key]`);
  const offset = playing && compared ? place() % sound.buffer.duration : 0;
  fadeOut();
  const source = audio().createBufferSource();
  const fade = audio().createGain();
  source.buffer = sound.buffer;
  source.loop = looped();
  const now = audio().currentTime;
  fade.gain.setValueAtTime(0, now);
  fade.gain.linearRampToValueAtTime(1, now + FADE_S);
  source.connect(fade).connect(audio().destination);
  source.start(now, offset);
  const mine = { url, source, fade, begun: now - offset, seconds: sound.buffer.duration, loop: source.loop };
  playing = mine;
  source.onended = () => {
    if (playing !== mine) return;
    playing = null;
    if (wanted === url) wanted = ""; // otherwise the next sound is being loaded
    mark();
  };
  mark();
  setTimeout(() => {
    if (playing === mine && audio().state !== "running") tell(url, "The browser has not started the sound; check the sound output.");
  }, BEGINS_MS);
  requestAnimationFrame(follow);
}

function fadeOut() {
  if (!playing) return;
  const { source, fade } = playing;
  const now = audio().currentTime;
  fade.gain.cancelScheduledValues(now);
  fade.gain.setValueAtTime(fade.gain.value, now);
  fade.gain.linearRampToValueAtTime(0, now + FADE_S);
  source.onended = null;
  source.stop(now + FADE_S);
  playing = null;
}

function stop() {
  wanted = "";
  fadeOut();
  mark();
}

/** Mark the button that plays. */
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
  for (const label of document.querySelectorAll(`[data-player-status="${CSS.escape(url)}"]`)) label.textContent = text;
}

/** @param {string} url @param {Loaded} sound @returns {string} */
function levelOf(url, sound) {
  const unit = document.querySelector(`[data-player-status="${CSS.escape(url)}"]`)?.getAttribute("data-unit") || "unit";
  const gain = sound.own ? `${Number(sound.gain.toPrecision(3))} of full scale per ${unit}` : "";
  const bent = sound.limited > 0 ? `limited: ${Number((100 * sound.limited).toPrecision(2))} % of samples` : "";
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
