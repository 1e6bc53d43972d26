/**
 * Draws a sensor's traces and level, a classifier's output, and a session's beat.
 * Each request waits until the data before it are drawn, so that a slow tab does not pile them up.
 */

import { keepAwake } from "/participants/static/awake.js";

/** @typedef {{from: number, next: number, bin_s: number, low: (number|null)[][], high: (number|null)[][], lost: number[]}} Traces */

const SHOWN_S = 8;
const LEAST_MS = 50;
const COLOURS = ["#0b5d66", "#b3541e", "#5b3f8c", "#3d6b1f", "#8c2f52", "#44546a"];
const INK = "#17202a";
const QUIET = "#51606e";
const LINE = "#d5dce2";
const LOST = "#f3c6c6";

const state = { number: 0, next: 0, first: 0, binS: 0.01, low: [], high: [], lost: [], axes: [], described: -1, beat: 0, drawn: 0, since: performance.now() };
/** @type {AudioContext | null} */
let sound = null;

/** @param {string} id */
const find = (id) => document.getElementById(id);

/** Append new bins, or start over after another request. @param {any} now */
function take(now) {
  const t = now.traces;
  if (now.number !== state.number || t.from !== state.next) {
    Object.assign(state, { low: t.low.map(() => []), high: t.low.map(() => []), lost: [], first: t.from });
  }
  state.number = now.number;
  if (state.low.length !== t.low.length && t.low.length) {
    state.low = t.low.map(() => []);
    state.high = t.low.map(() => []);
    state.lost = [];
  }
  t.low.forEach((row, i) => { state.low[i].push(...row); state.high[i].push(...t.high[i]); });
  state.lost.push(...t.lost);
  state.next = t.next;
  state.binS = t.bin_s || state.binS;
  const keep = Math.round(SHOWN_S / state.binS);
  const over = state.lost.length - keep;
  if (over > 0) {
    for (const rows of [state.low, state.high]) rows.forEach((row) => row.splice(0, over));
    state.lost.splice(0, over);
  }
  if (now.axes) state.axes = now.axes;
}

/** Round up to 1, 2 or 5 times a power of ten, so that scales rarely change. @param {number} value */
function nice(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((f) => f * power).find((f) => f >= value) ?? value;
}

/** Return a unit for people; a ratio has none. @param {string} unit */
const unitText = (unit) => (unit === "1" ? "" : unit.replace("^2", "²"));

/**
 * Draw one row for each axis, centred on its own middle, on one scale.
 * @param {HTMLCanvasElement} canvas
 * @param {string} unit
 */
function draw(canvas, unit) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  if (!pen) return;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const left = 84, bottom = 20, wide = width - left - 8;
  const rows = state.low.length || 1;
  const high = (height - bottom) / rows;
  const bins = Math.round(SHOWN_S / state.binS);
  pen.font = "12px system-ui, sans-serif";
  pen.lineWidth = 1;
  pen.fillStyle = QUIET;
  pen.textAlign = "center";
  for (let s = 0; s <= SHOWN_S; s += 2) {
    const x = left + wide * (1 - s / SHOWN_S);
    pen.strokeStyle = LINE;
    pen.beginPath(); pen.moveTo(x, 0); pen.lineTo(x, height - bottom); pen.stroke();
    pen.fillText(s === 0 ? "now" : `−${s} s`, Math.min(x, width - 16), height - 5);
  }
  let span = 0;
  const middles = state.low.map((row, i) => {
    let least = Infinity, most = -Infinity;
    row.forEach((v, k) => { if (v !== null) { least = Math.min(least, v); most = Math.max(most, state.high[i][k]); } });
    if (least > most) return 0;
    const middle = (least + most) / 2;
    span = Math.max(span, (most - least) / 2);
    return middle;
  });
  const scale = nice(span * 1.02);
  const x0 = left + wide - (state.lost.length / bins) * wide;
  const step = wide / bins;
  pen.fillStyle = LOST;
  state.lost.forEach((lost, k) => { if (lost) pen.fillRect(x0 + k * step, 0, Math.max(1, step), height - bottom); });
  state.low.forEach((row, i) => {
    const centre = high * (i + 0.5);
    const y = (/** @type {number} */ v) => centre - ((v - middles[i]) / scale) * (high / 2 - 4);
    pen.strokeStyle = LINE;
    pen.beginPath(); pen.moveTo(left, high * (i + 1)); pen.lineTo(width - 8, high * (i + 1)); pen.stroke();
    pen.strokeStyle = COLOURS[i % COLOURS.length];
    pen.lineWidth = Math.max(1, step);
    pen.beginPath();
    let before = null;
    row.forEach((v, k) => {
      if (v === null) { before = null; return; }
      const x = x0 + (k + 0.5) * step, top = y(state.high[i][k]), foot = y(v);
      if (before !== null) { pen.moveTo(x - step, before); pen.lineTo(x, (top + foot) / 2); }
      pen.moveTo(x, top); pen.lineTo(x, Math.max(foot, top + 1));
      before = (top + foot) / 2;
    });
    pen.stroke();
    pen.lineWidth = 1;
    pen.fillStyle = INK;
    pen.textAlign = "left";
    pen.fillText(state.axes[i] ?? `axis ${i + 1}`, 4, centre - 4);
    pen.fillStyle = QUIET;
    pen.fillText(`±${scale} ${unitText(unit)}`, 4, centre + 11);
  });
}

/** @param {string} id @param {string} text */
function write(id, text) {
  const place = find(id);
  if (place && place.textContent !== text) place.textContent = text;
}

/** @param {any} now */
function meter(now) {
  const levels = now.levels;
  const bar = find("live-level"), clip = find("live-clip");
  if (!levels || now.state === "idle") {
    write("live-facts", now.state === "idle" ? "" : "Opening the source …");
    write("live-rms", "");
    if (bar) bar.style.width = "0";
    if (clip) clip.hidden = true;
    return;
  }
  const top = levels.full_scale ?? 100;
  const share = Math.min(1, Math.max(0, 1 + 20 * Math.log10(Math.max(levels.rms, 1e-9) / top) / 60));
  if (bar) { bar.style.width = `${100 * share}%`; bar.dataset.clipped = levels.clipped ? "1" : "0"; }
  if (clip) clip.hidden = !levels.clipped;
  const unit = unitText(now.unit) && ` ${unitText(now.unit)}`;
  const rate = levels.rate === null ? "rate unknown" : `${levels.rate.toFixed(1)} Hz measured`;
  const lost = now.samples ? `${levels.lost} of ${now.samples} samples lost (${((100 * levels.lost) / now.samples).toFixed(2)} %)` : "no samples yet";
  const silent = now.silent_s > 2 ? `; no samples for ${now.silent_s.toFixed(0)} s: is the sensor on and in range?` : "";
  write("live-facts", `${rate} · ${lost}${silent}`);
  write("live-rms", `${levels.rms.toFixed(3)}${unit} rms · peak ${levels.peak.toFixed(2)}${unit}`);
  const period = Math.floor(performance.now() / 2000);
  if (period !== state.described) {
    state.described = period;
    const text = `Traces of the last ${SHOWN_S} seconds, axes ${state.axes.join(", ")}. ${rate}, ${lost}, level ${levels.rms.toFixed(2)}${unit} rms.`;
    find("live-traces")?.setAttribute("aria-label", text);
  }
}

/** @param {any} guess */
function classification(guess) {
  const place = find("live-guess");
  if (!place || !guess) return;
  const none = find("live-none");
  if (none) none.hidden = !guess.none_of_these;
  if (!guess.probabilities) { write("live-guess-line", "Too many samples of this window were lost to classify it."); return; }
  const ranked = Object.entries(guess.probabilities).sort((a, b) => b[1] - a[1]).slice(0, 6);
  while (place.children.length < ranked.length) {
    const row = document.createElement("div");
    row.className = "guess";
    row.innerHTML = '<span class="guess-name"></span><span class="guess-track"><span class="guess-bar"></span></span><span class="guess-share"></span>';
    place.append(row);
  }
  ranked.forEach(([name, share], i) => {
    const row = place.children[i];
    /** @type {HTMLElement} */ (row.children[0]).textContent = name;
    /** @type {HTMLElement} */ (row.children[1].firstElementChild).style.width = `${100 * share}%`;
    /** @type {HTMLElement} */ (row.children[2]).textContent = share.toFixed(2);
  });
  const latency = guess.latency_s === null ? "" : ` · ${(1000 * guess.latency_s).toFixed(0)} ms after the last sample`;
  write("live-guess-line", `${guess.none_of_these ? "None of these" : ranked[0][0]}${latency}`);
}

/** @param {any} now */
function session(now) {
  const status = now.status;
  const bar = find("session-share");
  if (status && status.phase !== "question") {
    const words = { countdown: "Starts in", recording: "Recording", waiting: "Waiting" };
    write("session-phase", `${words[status.phase] ?? status.phase} ${status.text}`);
    if (bar) bar.style.width = `${100 * Math.min(1, status.share)}%`;
  } else {
    write("session-phase", "");
    if (bar) bar.style.width = "0";
  }
  const dot = find("session-dot");
  if (!dot) return;
  const beat = now.beat;
  dot.parentElement?.toggleAttribute("data-still", !beat);
  if (!beat || beat.number === state.beat) return;
  state.beat = beat.number;
  const began = performance.now() - 1000 * beat.elapsed_s;
  let last = -1;
  const move = () => {
    if (state.beat !== beat.number) return;
    const strokes = (performance.now() - began) / 1000 / beat.interval_s;
    const whole = Math.floor(strokes);
    const back = beat.back_and_forth && whole % 2 === 1;
    const place = back ? 1 - (strokes - whole) : strokes - whole;
    dot.style.left = `${100 * place}%`;
    if (whole !== last) { last = whole; tick(back); }
    if (document.contains(dot)) requestAnimationFrame(move);
  };
  requestAnimationFrame(move);
}

/** Play a beat: 1200 Hz out, 800 Hz back, as on the terminal. @param {boolean} back */
function tick(back) {
  const on = /** @type {HTMLInputElement | null} */ (document.querySelector("#session-sound input"));
  if (find("session-sound")?.getAttribute("data-on") === "0" || (on && !on.checked)) return;
  if (sound?.state !== "running") return;
  const tone = sound.createOscillator(), gain = sound.createGain(), t = sound.currentTime;
  tone.frequency.value = back ? 800 : 1200;
  gain.gain.setValueAtTime(0.0001, t);
  gain.gain.linearRampToValueAtTime(0.3, t + 0.015);
  gain.gain.linearRampToValueAtTime(0.0001, t + 0.03);
  tone.connect(gain).connect(sound.destination);
  tone.start(t);
  tone.stop(t + 0.04);
}

/** Prepare the sound: browsers start it in a gesture only, and the first beat comes after one. */
function prepareSound() {
  if (sound || !find("session-sound")) return;
  sound = new AudioContext();
  keepAwake(sound);
}

for (const name of ["click", "keydown"]) document.addEventListener(name, prepareSound, true);

async function loop() {
  for (;;) {
    const began = performance.now();
    let wait = LEAST_MS;
    try {
      const answer = await fetch(`/live/now?after=${state.next}&number=${state.number}`, { cache: "no-store" });
      if (answer.ok) {
        const now = await answer.json();
        const traces = /** @type {HTMLCanvasElement | null} */ (find("live-traces"));
        if (now.state !== "idle" || now.number !== state.number || traces?.dataset.drawn !== "1") take(now);
        if (!now.beat) state.beat = 0;
        if (traces) {
          draw(traces, now.unit ?? "1");
          traces.dataset.drawn = "1";
          state.drawn += 1;
          traces.dataset.pictures = String(state.drawn);
          traces.dataset.samples = String(now.samples ?? 0);
        }
        meter(now);
        classification(now.guess);
        session(now);
        if (now.state === "idle") wait = 400;
      } else {
        wait = 1000;
      }
    } catch {
      wait = 1000; // the server is down: NiceGUI shows it, and reloads the page when it is back
    }
    await new Promise((done) => setTimeout(done, Math.max(0, wait - (performance.now() - began))));
  }
}

loop();
