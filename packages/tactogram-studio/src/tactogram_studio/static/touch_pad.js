/** The pad: turns pointer, keys or a simulated hand into motion in mm; draws surface, trail and probe. */

import { fitted } from "./touch_sound.js";

/** A resting finger sends no events; after this time its last position is sent again. */
const HELD_MS = 25;
const BEAT_MS = 8;
const LIFTED_MS = 400;
const TRAIL_S = 0.7;
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const KEY_MM_S = { slow: 80, fast: 250 };

/** A pad over an element; `tell` receives each batch of samples. */
export class Pad {
  /**
   * @param {HTMLElement} element
   * @param {(message: Record<string, any>) => void} tell
   */
  constructor(element, tell) {
    this.element = element;
    this.canvas = element.querySelector("canvas");
    this._tell = tell;
    this.pxPerMm = 96 / 25.4;
    /** Force of a finger or mouse, which report none, N. */
    this.force = 0.6;
    /** Force at full pressure of a pen, N. */
    this.fullForce = 2;
    /** Whether a mouse touches without a pressed button. */
    this.hover = true;
    /**
     * Stacked pictures of each field, from left to right: `{bitmap, mm_per_pixel, name, opacity, line}`; a photograph is
     * felt along its `line`, a share of its height.
     */
    this.fields = [];
    /** Recent samples, for tests and the trail: `{time, x, y, force}`. */
    this.track = [];
    this._pointer = null;
    this._last = null;
    this._trail = [];
    this._keys = new Set();
    this._keyPlace = null;
    this._hand = null;
    this._still = matchMedia("(prefers-reduced-motion: reduce)");
    this._listen();
    this._timer = setInterval(() => this._beat(performance.now()), BEAT_MS);
  }

  /** Send nothing any more. */
  close() {
    clearInterval(this._timer);
  }

  get size() {
    const { clientWidth, clientHeight } = this.element;
    return { width: clientWidth / this.pxPerMm, height: clientHeight / this.pxPerMm };
  }

  /**
   * Set the scale, and return whether it is that of a photograph: one alone fills the pad, in a shape like its own.
   * @param {number} pxPerMm Of the screen.
   */
  scale(pxPerMm) {
    const [first, ...others] = this.fields;
    const alone = others.length === 0 && first?.length === 1 && first[0].line && first[0].bitmap;
    const { width, height } = alone || { width: 0, height: 0 };
    const free = { aspectRatio: "", height: "", minHeight: "", maxHeight: "", width: "" };
    const shape = { aspectRatio: `${width} / ${height}`, height: "auto", minHeight: "0", maxHeight: "75vh", width: "100%" };
    Object.assign(this.element.style, alone ? shape : free);
    this.pxPerMm = alone ? this.element.clientWidth / (width * first[0].mm_per_pixel) : pxPerMm;
    return Boolean(alone);
  }

  /** Start or stop the simulated hand. */
  set hand(on) {
    if (on) this._hand = { began: performance.now() };
    else if (this._hand) {
      this._hand = null;
      this._lift(performance.now());
    }
  }

  get hand() {
    return this._hand !== null;
  }

  /**
   * Draw the surface, where the finger was, and where it is.
   * @param {Record<string, any>} report
   */
  draw(report) {
    const { width, height } = fitted(this.canvas);
    const pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, width, height);
    this._drawFields(pen, width, height);
    if (!this._still.matches) this._drawTrail(pen, performance.now() / 1e3);
    if (this._last) this._drawProbe(pen, report);
  }

  _listen() {
    const { element } = this;
    // Unlike pointermove, it does not wait for the next frame.
    const moved = "onpointerrawupdate" in element ? "pointerrawupdate" : "pointermove";
    element.addEventListener(moved, (event) => this._moved(event));
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || this._pointer !== null || event.target.closest("button")) return;
      event.preventDefault();
      element.focus({ preventScroll: true, focusVisible: false });
      this.hand = false;
      this._pointer = event.pointerId;
      try {
        element.setPointerCapture(event.pointerId);
      } catch {
        // The pointer is gone, or was made by a test.
      }
      const tapped = this.hover && event.pointerType === "mouse" && this._last?.force > 0;
      this._send([this._sample(event)]);
      if (tapped) this._tell({ kind: "tap", strength: this._forceOf(event) });
    });
    for (const name of ["pointerup", "pointercancel"]) {
      element.addEventListener(name, (event) => {
        if (event.pointerId !== this._pointer) return;
        this._pointer = null;
        if (!(this.hover && event.pointerType === "mouse" && name === "pointerup")) this._lift(event.timeStamp);
      });
    }
    element.addEventListener("pointerleave", (event) => {
      if (this._pointer === null && !this.hand && !this._keyPlace) this._lift(event.timeStamp);
    });
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("keydown", (event) => this._keyDown(event));
    element.addEventListener("keyup", (event) => this._keys.delete(event.key));
    element.addEventListener("blur", () => this._keys.clear());
  }

  _moved(event) {
    if (this._pointer === null ? !this._hovers(event) : event.pointerId !== this._pointer) return;
    if (this._hand) this.hand = false;
    this._keyPlace = null;
    const events = event.getCoalescedEvents?.() ?? [];
    this._send((events.length ? events : [event]).map((one) => this._sample(one)));
  }

  _hovers(event) {
    return this.hover && event.pointerType === "mouse" && event.buttons === 0;
  }

  _sample(event) {
    const box = this.element.getBoundingClientRect();
    const [left, top] = [event.clientX - box.left - this.element.clientLeft, event.clientY - box.top - this.element.clientTop];
    const inside = left >= 0 && top >= 0 && left < this.element.clientWidth && top < this.element.clientHeight;
    return {
      time: event.timeStamp / 1e3,
      x: left / this.pxPerMm,
      y: top / this.pxPerMm,
      force: inside ? this._forceOf(event) : 0,
      quiet: this._pointer === null,
    };
  }

  _forceOf(event) {
    // Only pens measure pressure: a mouse reports 0.5, most screens nothing for a finger.
    return event.pointerType === "pen" && event.pressure > 0 ? event.pressure * this.fullForce : this.force;
  }

  _send(samples, made = false) {
    const last = samples[samples.length - 1];
    this._last = { ...last, made };
    for (const { time, x, y, force } of samples) {
      this.track.push({ time, x, y, force });
      if (force > 0) this._trail.push({ time, x, y });
    }
    if (this.track.length > 20_000) this.track.splice(0, 10_000);
    this._tell({ kind: "motion", samples: made ? samples.map((sample) => ({ ...sample, made })) : samples });
  }

  _lift(ms) {
    if (!this._last || this._last.force === 0) return;
    // An older event may follow the repeated position of a resting finger; the lift must not be dropped for it.
    const time = Math.max(ms / 1e3, this._last.time + 1e-4);
    this._send([{ ...this._last, time, force: 0 }], true);
  }

  /** Repeat the position of a resting finger; advance keys and the simulated hand. */
  _beat(now) {
    if (this._hand) this._stroke(now);
    else if (this._keys.size || this._keyPlace) this._keyed(now);
    else if (this._last && this._last.force > 0 && now / 1e3 - this._last.time > HELD_MS / 1e3) {
      const { x, y, force } = this._last;
      this._send([{ time: now / 1e3, x, y, force, quiet: true }], true);
    }
  }

  _keyDown(event) {
    if (event.target !== this.element) return; // a button's keys are its own
    if (event.key === " ") {
      event.preventDefault();
      if (!event.repeat) this._tell({ kind: "tap", strength: this.force });
    }
    if (!(event.key in KEYS)) return;
    event.preventDefault();
    this.hand = false;
    const { width, height } = this.size;
    const from = this._last ?? { x: width / 2, y: height / 2 };
    this._keyPlace ??= { x: from.x, y: from.y, time: performance.now(), idle: 0 };
    this._keys.add(event.key);
    this._fast = event.shiftKey;
  }

  _keyed(now) {
    const place = this._keyPlace;
    if (!place) return;
    const step = (now - place.time) / 1e3;
    place.time = now;
    place.idle = this._keys.size ? 0 : place.idle + step;
    const { width, height } = this.size;
    const way = (this._fast ? KEY_MM_S.fast : KEY_MM_S.slow) * step;
    for (const key of this._keys) {
      place.x = Math.min(width, Math.max(0, place.x + KEYS[key][0] * way));
      place.y = Math.min(height, Math.max(0, place.y + KEYS[key][1] * way));
    }
    const lifted = place.idle * 1e3 > LIFTED_MS;
    this._send([{ time: now / 1e3, x: place.x, y: place.y, force: lifted ? 0 : this.force, quiet: true }], true);
    if (lifted) this._keyPlace = null;
  }

  /** Minimum-jerk strokes back and forth (Flash and Hogan 1985), a little lower each time. */
  _stroke(now) {
    const { width, height } = this.size;
    const seconds = (now - this._hand.began) / 1e3;
    const lasting = 1.1;
    const number = Math.floor(seconds / lasting);
    const share = Math.min(1, (seconds / lasting - number) / 0.85);
    const gone = share ** 3 * (10 - 15 * share + 6 * share ** 2);
    const x = width * (0.12 + 0.76 * (number % 2 ? 1 - gone : gone));
    const y = height * (0.5 + 0.28 * Math.sin(0.6 * seconds));
    this._send([{ time: now / 1e3, x, y, force: this.force, quiet: true }], true);
  }

  _drawFields(pen, width, height) {
    const across = width / Math.max(1, this.fields.length);
    this.fields.forEach((layers, n) => {
      const left = n * across;
      pen.save();
      pen.beginPath();
      pen.rect(left, 0, across, height);
      pen.clip();
      for (const { bitmap, mm_per_pixel: scale, opacity, line } of layers) {
        if (!bitmap) continue;
        // Tiled at its true size; if that is unknown, the picture fills the field.
        const zoom = scale ? scale * this.pxPerMm : Math.max(across / bitmap.width, height / bitmap.height);
        // The line of a photograph lies in the middle.
        const pattern = pen.createPattern(bitmap, line ? "repeat-x" : "repeat");
        const top = line ? height / 2 - line * bitmap.height * zoom : 0;
        pattern.setTransform(new DOMMatrix([zoom, 0, 0, zoom, left, top]));
        pen.globalAlpha = opacity;
        pen.fillStyle = pattern;
        pen.fillRect(left, 0, across, height);
      }
      pen.globalAlpha = 1;
      if (layers.some(({ line }) => line)) drawLine(pen, left, left + across, height / 2);
      if (this.fields.length > 1) label(pen, `${"ABCD"[n]}  ${layers[0].name}`, left + 12, 12);
      pen.restore();
      if (n > 0) {
        pen.fillStyle = "#ffffff";
        pen.fillRect(left - 2, 0, 4, height);
      }
    });
  }

  _drawTrail(pen, now) {
    this._trail = this._trail.filter(({ time }) => now - time < TRAIL_S).slice(-600);
    pen.lineCap = "round";
    for (const [colour, width] of [["255,255,255", 8], ["11,93,102", 4]]) {
      pen.lineWidth = width;
      for (let i = 1; i < this._trail.length; i++) {
        const [a, b] = [this._trail[i - 1], this._trail[i]];
        if (b.time - a.time > 0.1) continue;
        pen.strokeStyle = `rgba(${colour},${Math.max(0, 1 - (now - b.time) / TRAIL_S)})`;
        pen.beginPath();
        pen.moveTo(a.x * this.pxPerMm, a.y * this.pxPerMm);
        pen.lineTo(b.x * this.pxPerMm, b.y * this.pxPerMm);
        pen.stroke();
      }
    }
  }

  _drawProbe(pen, report) {
    const { x, y, force } = this._last;
    if (this.fields.some((layers) => layers.some(({ line }) => line))) {
      pen.fillStyle = "#0b5d66"; // the point of the line that is felt
      pen.fillRect(x * this.pxPerMm - 3, this.element.clientHeight / 2 - 12, 6, 24);
    }
    pen.beginPath();
    pen.arc(x * this.pxPerMm, y * this.pxPerMm, force > 0 ? 13 : 9, 0, 2 * Math.PI);
    pen.fillStyle = report.state === "slide" ? "#0b5d66" : force > 0 ? "rgba(255,255,255,0.9)" : "rgba(255,255,255,0.4)";
    pen.fill();
    pen.lineWidth = 3;
    pen.strokeStyle = report.state === "slide" ? "#ffffff" : "#0b5d66";
    pen.stroke();
  }
}

/** Mark the line that is felt. */
function drawLine(pen, left, right, y) {
  for (const [colour, width] of [["#ffffff", 5], ["#0b5d66", 2]]) {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    pen.moveTo(left, y);
    pen.lineTo(right, y);
    pen.stroke();
  }
}

function label(pen, text, left, top) {
  pen.font = "600 15px system-ui, sans-serif";
  pen.fillStyle = "rgba(255,255,255,0.92)";
  pen.fillRect(left, top, pen.measureText(text).width + 20, 28);
  pen.fillStyle = "#17202a";
  pen.textBaseline = "middle";
  pen.fillText(text, left + 10, top + 15);
  pen.textBaseline = "alphabetic";
}
