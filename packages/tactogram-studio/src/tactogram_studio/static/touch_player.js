/**
 * Messages from the page to the engine and its output, and reports back.
 *
 * Runs in an AudioWorklet (`touch_worklet.js`) or, if there is none, in the page (`touch_sound.js`).
 */

import { Engine, Output } from "./touch_dsp.js";
import { Finger } from "./touch_motion.js";
import { tableOf } from "./touch_textures.js";

const REPORT_S = 0.03;
export const QUANTUM = 128;

/** An engine controlled by messages. */
export class Player {
  /**
   * @param {number} rate
   * @param {(report: Record<string, any>) => void} report
   */
  constructor(rate, report) {
    this.rate = rate;
    this._report = report;
    this._finger = new Finger();
    this._output = new Output(rate);
    /** @type {Engine | null} */
    this._engine = null;
    /** @type {Engine | null} */
    this._next = null;
    this._changing = false;
    this._waiting = [];
    /** Motion with fixed times, for rendering without a hand. */
    this._script = [];
    this._reported = -Infinity;
    this._square = this._peak = this._samples = 0;
    /** The newest motion, on the page's clock, and the block that first contains it. */
    this._newest = this._newestBlock = NaN;
    this._wanted = false;
  }

  /**
   * Take a message.
   * @param {Record<string, any>} message
   * @param {number} now
   */
  hear(message, now) {
    switch (message.kind) {
      case "motion":
        for (const sample of message.samples) this._waiting.push({ ...sample, arrival: now });
        break;
      case "script":
        this._script = message.samples.map((sample) => ({ ...sample, arrival: sample.time }));
        break;
      case "tap":
        this._engine?.tap(message.strength);
        break;
      case "textures":
        this._change(message);
        break;
      case "fields":
        for (const engine of [this._engine, this._next]) {
          if (engine && engine.textures.length === message.fields[0].length) {
            engine.fields = message.fields;
            engine.width_mm = message.width_mm ?? engine.width_mm;
          }
        }
        break;
      case "output":
        if (message.gain !== undefined) this._output.gain = message.gain;
        if (message.open !== undefined) this._wanted = message.open;
        if (message.settled) {
          this._output.open = this._wanted;
          this._output.settle();
        }
        break;
    }
  }

  /**
   * Write the next samples, at most `QUANTUM` at a time.
   * @param {number} now On the audio context's clock.
   * @param {Float32Array} out
   */
  render(now, out) {
    const output = this._output;
    if (this._changing && output.silent) {
      this._engine = this._next;
      this._next = null;
      this._changing = false;
    }
    output.open = this._wanted && !this._changing;
    this._listen(now);
    if (this._engine === null) out.fill(0);
    else this._engine.render(now, out.length, out);
    this._measure(out);
    output.process(out, out.length);
    if (now >= this._reported + REPORT_S) this._tell(now);
  }

  _change({ tables, seed, fields, width_mm, tap_gain }) {
    const options = { rate: this.rate, most: QUANTUM, finger: this._finger, seed, fields, width_mm, tap_gain };
    const engine = tables.length ? new Engine(tables.map(({ head, buffer }) => tableOf(head, buffer)), options) : null;
    if (this._engine === null || this._output.silent) {
      this._engine = engine;
      this._changing = false;
    } else {
      this._next = engine;
      this._changing = true;
    }
  }

  _listen(now) {
    const finger = this._finger;
    while (this._script.length && this._script[0].time <= now) finger.hear(this._script.shift(), now);
    for (const sample of this._waiting) {
      if (finger.hear(sample, now) && !sample.made) {
        this._newest = sample.time;
        this._newestBlock = now;
      }
    }
    this._waiting.length = 0;
  }

  _measure(out) {
    for (let i = 0; i < out.length; i++) {
      this._square += out[i] * out[i];
      const size = Math.abs(out[i]);
      if (size > this._peak) this._peak = size;
    }
    this._samples += out.length;
  }

  _tell(now) {
    const follower = this._engine?.follower;
    const last = Math.max(0, (follower?.count ?? 0) - 1);
    this._report({
      time: now,
      motion: this._newest,
      motion_block: this._newestBlock,
      state: follower?.state ?? "lost",
      x: follower?.x[last] ?? 0,
      y: follower?.y[last] ?? 0,
      path: follower?.path[last] ?? 0,
      speed: follower?.speed[last] ?? 0,
      force: follower?.force[last] ?? 0,
      field: this._engine?.field() ?? 0,
      rms: Math.sqrt(this._square / Math.max(1, this._samples)),
      peak: this._peak,
      gain: this._output.gain,
      limited: this._output.limited,
      counts: { ...this._finger.counts },
    });
    this._newest = this._newestBlock = NaN;
    this._reported = now;
    this._square = this._peak = this._samples = 0;
  }
}
