/** The page Touch: passes textures and the hand's motion to the sound, and shows its reports. */

import { BEGINS_MS } from "/participants/static/awake.js";

import { Pad } from "./touch_pad.js";
import { Rows } from "./touch_rows.js";
import { ASSUMED, calibrate, measured } from "./touch_scale.js";
import { SAFE_DB, Sound, drawSpectrum, quantile } from "./touch_sound.js";
import { Vibration } from "./touch_vibration.js";

/** Textures with a higher peak reduce the gain to `SAFE_DB` when they are chosen. */
const LOUD_DB = -6;
/** Approximate difference between a texture's peak and the loudest bin of its spectrum. */
const HEADROOM_DB = 20;
const SETTINGS = "tactogram.touch";
const $ = (id) => document.getElementById(`touch-${id}`);

await present($("pad") === null);

const report = { state: "lost", speed: 0, force: 0, rms: 0, limited: 0, field: 0, time: 0 };
const kept = stored();
const sound = new Sound(reported);
const pad = new Pad($("pad"), (message) => sound.tellNow(message));
const vibration = new Vibration((pattern) => navigator.vibrate?.(pattern) ?? false);
const rows = new Rows({ list: $("rows"), waiting: $("waiting"), rate: sound.rate, kept: kept.rows }, loaded);
const bins = new Float32Array(sound.analyser.frequencyBinCount);
let open = false;
let gain = 0;
/** Largest magnitude of the textures under a simulated hand, and their unit. */
let strongest = { peak: 0, unit: "" };
let limitedSince = 0;
/** Time of the last request to start the sound. */
let startedAt = Infinity;

/** For tests and other scripts. */
window.tactogramTouch = { pad, rows, sound, report, vibration, loaded: () => $("pad") && rows.ready };

function reported(update) {
  if (update.limited > report.limited) limitedSince = performance.now();
  Object.assign(report, update);
  vibration.follow(update, rows.fields()[update.field] ?? []);
}

/** Apply a change of textures or weights. */
async function loaded({ changed }) {
  const tables = rows.tables();
  const fields = rows.fields();
  arrange();
  pad.fields = rows.shown();
  scale();
  $("pad").setAttribute("aria-label", rows.words());
  const width_mm = pad.size.width / fields.length;
  vibration.tables = tables;
  if (changed) {
    setStrongest(tables.map(({ head }) => head));
    const sent = tables.map(({ head, buffer }) => ({ head, buffer }));
    await sound.tell({ kind: "textures", tables: sent, seed: 1, fields, width_mm });
  } else await sound.tell({ kind: "fields", fields, width_mm });
  keep();
  $("share").href = `/touch/shared?${new URLSearchParams({ rows: JSON.stringify(rows.state()) })}`;
  $("share").hidden = !tables.length;
  $("pad").closest(".touch-page").dataset.ready = String(tables.length > 0);
}

/** Keep the gain, so that strengths can be compared, unless it is too high or the unit differs. */
function setStrongest(heads) {
  if (!heads.length) return;
  const peak = Math.max(...heads.map((head) => head.peak));
  const unit = heads[0].unit;
  const louder = gain * peak > 10 ** (LOUD_DB / 20);
  const other = strongest.peak > 0 && unit !== strongest.unit;
  strongest = { peak, unit };
  const known = kept.gain?.[unit];
  if (gain === 0 && known > 0 && known * peak <= 10 ** (SAFE_DB / 20)) setGain(known);
  else if (gain === 0 || louder || other) setGain(10 ** (SAFE_DB / 20) / peak);
  else setGain(gain);
}

function setGain(to) {
  gain = to;
  const peak = gain * strongest.peak;
  const db = Math.round(20 * Math.log10(peak));
  $("volume").value = String(db);
  $("volume-value").value = `${db} dB`;
  const one = `1 ${unitText(strongest.unit)}`.trim();
  $("gain").textContent =
    `${one} of the texture plays at ${figure(100 * gain)} % of the loudest possible output, its largest sample at ` +
    `${figure(100 * peak)} %. How strong that is on the skin depends on sound card, amplifier and actuator, which are ` +
    `not known here. In commands: gain=${figure(gain)} or peak=${figure(peak)}.`;
  sound.tell({ kind: "output", gain });
}

async function begin(on) {
  if (on) {
    startedAt = performance.now();
    await sound.begin();
  }
  sound.wanted = open = on;
  // A user who started with the keyboard continues with it, on the pad.
  if (document.activeElement === $("begin")) $("pad").focus();
  $("begin").hidden = true;
  $("mute").textContent = on ? "Turn the sound off" : "Turn the sound on";
  await sound.tell({ kind: "output", gain, open });
}

function arrange() {
  $("arrangement").hidden = rows.count < 2;
  for (const input of document.getElementsByName("touch-arrangement")) input.checked = input.value === rows.arrangement;
}

function scale() {
  const known = measured();
  const photograph = pad.scale(known ?? ASSUMED);
  const { width, height } = pad.size;
  const size = `${width.toFixed(0)} by ${height.toFixed(0)} mm`;
  $("scale").textContent = photograph
    ? `The pad shows ${size} of the photograph; speeds are those on it.`
    : `The pad is ${size}, ` +
      (known
        ? `measured with a card: ${known.toFixed(2)} pixels per mm.`
        : `assumed: ${ASSUMED.toFixed(2)} pixels per mm, the CSS default. Measure it for true speeds.`);
  sound.tell({ kind: "fields", fields: rows.fields(), width_mm: width / rows.fields().length });
}

function showNumbers() {
  const sliding = report.state === "slide";
  $("speed").value = `${sliding ? report.speed.toFixed(0) : 0} mm/s`;
  $("force").value = report.state === "lost" || report.state === "air" ? "lifted" : `${report.force.toFixed(2)} N`;
  const level = report.rms < 1e-4 ? 0 : report.rms; // a fading level is not shown in powers of ten
  $("level").value = strongest.unit ? `${figure(level)} ${unitText(strongest.unit)}` : "–";
  const late = sound.latencies;
  $("latency").value = late.length > 4 ? `${(1e3 * quantile(late, 0.5)).toFixed(0)} ms` : "–";
  const delays = sound.delays();
  const ms = (value) => (value === null ? "not reported" : `${(1e3 * value).toFixed(1)} ms`);
  const facts = {
    "pointer to output, median": late.length > 4 ? ms(quantile(late, 0.5)) : "–",
    "95 % below": late.length > 4 ? ms(quantile(late, 0.95)) : "–",
    "including the browser's buffer": ms(delays.base),
    "including output, as reported by the system": ms(delays.output),
    "samples made in": sound.threaded ? "the audio thread" : "the page's thread",
    "motion used / dropped": `${report.counts?.used ?? 0} / ${(report.counts?.late ?? 0) + (report.counts?.out_of_order ?? 0)}`,
  };
  $("facts").replaceChildren(
    ...Object.entries(facts).flatMap(([name, value]) => [made("dt", name), made("dd", value)]),
  );
  warn();
}

function warn() {
  const now = performance.now();
  const limiting = now - limitedSince < 2000 && limitedSince > 0;
  const silent = sound.wanted && sound.context.state !== "running" && now - startedAt > BEGINS_MS;
  const text = silent
    ? "The browser has not started the sound. Press again; if that does not help, check the sound output and other programs that use it."
    : limiting
      ? "The output exceeds full scale and is limited. Turn the volume down."
      : "";
  if ($("limited").textContent !== text) $("limited").textContent = text;
}

function draw() {
  pad.draw(report);
  const top = 20 * Math.log10(Math.max(1e-6, gain * strongest.peak)) - HEADROOM_DB;
  if (open) drawSpectrum($("spectrum"), sound.analyser, bins, top);
  requestAnimationFrame(draw);
}

/** Return a unit for people. */
function unitText(unit) {
  return unit === "1" ? "" : unit.replace("^2", "²");
}

/** Wait until the page is drawn: NiceGUI does that after starting the scripts. */
async function present(absent) {
  while (absent) {
    await new Promise((resolve) => setTimeout(resolve, 20));
    absent = $("pad") === null;
  }
}

function figure(value) {
  return value === 0 ? "0" : Number(value.toPrecision(3)).toString();
}

function made(name, text) {
  const element = document.createElement(name);
  element.textContent = text;
  return element;
}

/** Return the settings of this tab, else of the last visit, or those that a saved page comes with. */
function stored() {
  try {
    return JSON.parse($("settings")?.textContent ?? sessionStorage.getItem(SETTINGS) ?? localStorage.getItem(SETTINGS) ?? "{}");
  } catch {
    return {};
  }
}

/** Store the settings, so that they survive a reload. */
function keep() {
  const gains = { ...kept.gain, [strongest.unit]: gain };
  const values = { rows: rows.state(), gain: gains, force: pad.force, hover: pad.hover, vibrate: vibration.on };
  try {
    for (const storage of [sessionStorage, localStorage]) storage.setItem(SETTINGS, JSON.stringify(values));
  } catch {
    // Without storage, a reload starts over.
  }
}

function listen() {
  $("begin").addEventListener("click", () => begin(true));
  $("pad").addEventListener("pointerdown", (event) => {
    if (!open && !$("begin").hidden && event.target !== $("begin")) begin(true);
  });
  $("mute").addEventListener("click", () => begin(!open));
  $("hand").addEventListener("click", () => {
    pad.hand = !pad.hand;
    if (pad.hand && !open && !$("begin").hidden) begin(true);
  });
  $("volume").addEventListener("input", () => {
    setGain(10 ** (Number($("volume").value) / 20) / strongest.peak);
    keep();
  });
  $("press").addEventListener("input", () => {
    pad.force = Number($("press").value);
    showForce();
    keep();
  });
  $("hover").addEventListener("change", () => {
    pad.hover = $("hover").checked;
    keep();
  });
  $("vibrate").addEventListener("change", () => {
    vibration.on = $("vibrate").checked;
    if (!vibration.on) vibration.stop();
    keep();
  });
  $("add").addEventListener("click", () => rows.add());
  $("arrangement").addEventListener("change", (event) => rows.arrange(event.target.value));
  $("measure").addEventListener("click", () => calibrate($("card"), scale));
  new ResizeObserver(scale).observe($("pad"));
  addEventListener("pagehide", () => vibration.stop());
}

function showForce() {
  $("press").value = String(pad.force);
  $("press-value").value = `${pad.force.toFixed(1)} N`;
}

function begun() {
  if (kept.force > 0) pad.force = Math.min(2, Math.max(0.1, kept.force));
  if (typeof kept.hover === "boolean") pad.hover = kept.hover;
  $("hover").checked = pad.hover;
  const able = typeof navigator.vibrate === "function";
  vibration.on = able && (kept.vibrate ?? matchMedia("(pointer: coarse)").matches);
  $("vibrate").checked = vibration.on;
  $("vibrate").disabled = !able;
  $("vibrate-why").textContent = able
    ? "Works on phones, not on desktop computers. The vibration switches on and off with the texture's strength, at the phone's one frequency."
    : "This browser cannot vibrate (nor can Safari or Firefox); Chrome on Android can.";
  showForce();
  listen();
  scale();
  draw();
  setInterval(() => {
    showNumbers();
    $("hand").setAttribute("aria-pressed", String(pad.hand));
  }, 100);
  arrange();
  rows.begin();
}

begun();
