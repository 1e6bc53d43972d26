/**
 * Motion to samples: `tactogram_playback.streaming.engine` and `.contact` in the browser, and the output stage after
 * them. Independent of pages and audio contexts.
 */

import { Finger, Follower } from "./touch_motion.js";
import { ModulatedNoiseTexture } from "./touch_noise.js";
import { AutoregressiveTexture, SurfaceTexture } from "./touch_textures.js";

const GLIDE_S = 0.05;
const KINDS = { autoregressive: AutoregressiveTexture, noise: ModulatedNoiseTexture, surface: SurfaceTexture };

/** Transient of a landing; see `ContactSettings`. */
const CONTACT = { frequency_hz: 160, decay_s: 0.012, gain: 4, hardest_n: 3 };
const AT_ONCE = 8;
const OVER = 1e-4;

/** Decaying sines that start when a finger lands. */
export class Transients {
  /** @param {number} rate */
  constructor(rate, settings = CONTACT) {
    this.settings = settings;
    this.started = 0;
    this._turn = (2 * Math.PI * settings.frequency_hz) / rate;
    this._keep = Math.exp(-1 / (settings.decay_s * rate));
    this._peak = Math.exp(-0.25 / (settings.frequency_hz * settings.decay_s));
    this._amplitude = new Float64Array(AT_ONCE);
    this._phase = new Float64Array(AT_ONCE);
    this._end = new Float64Array(AT_ONCE);
  }

  /**
   * Begin one with the next sample.
   * @param {number} strength Force of the landing, N.
   * @param {number} level Of the texture, in its unit.
   */
  start(strength, level) {
    const amplitude = this.settings.gain * level * Math.min(Math.max(strength, 0), this.settings.hardest_n);
    if (amplitude === 0) return;
    const quietest = this._amplitude.indexOf(Math.min(...this._amplitude));
    this._amplitude[quietest] = amplitude / this._peak;
    this._end[quietest] = OVER * amplitude;
    this._phase[quietest] = 0;
    this.started += 1;
  }

  /**
   * Add the next samples.
   * @param {Float32Array} out
   * @param {number} count
   */
  add(out, count) {
    for (let voice = 0; voice < AT_ONCE; voice++) {
      if (this._amplitude[voice] === 0) continue;
      for (let i = 0; i < count; i++) {
        out[i] += this._amplitude[voice] * Math.sin(this._phase[voice]);
        this._phase[voice] += this._turn;
        this._amplitude[voice] *= this._keep;
      }
      if (this._amplitude[voice] < this._end[voice]) this._amplitude[voice] = 0;
    }
  }
}

/** Textures under a finger; the pad may have several fields side by side, each with its own mix. */
export class Engine {
  /**
   * @param {import("./touch_textures.js").Table[]} tables
   * @param {object} options
   * @param {number} options.rate
   * @param {number} options.most
   * @param {number} [options.seed] Texture number n has seed + n.
   * @param {number[][]} [options.fields] Weights of the textures in each field, from left to right.
   * @param {number} [options.width_mm] Width of a field.
   * @param {Finger} [options.finger]
   * @param {number} [options.tap_gain]
   */
  constructor(tables, { rate, most, seed = 0, fields, width_mm = Infinity, finger, tap_gain = CONTACT.gain }) {
    this.rate = rate;
    this.most = most;
    this.finger = finger ?? new Finger();
    this.follower = new Follower(rate, most);
    this.transients = new Transients(rate, { ...CONTACT, gain: tap_gain });
    this.textures = tables.map(
      (table, number) => new KINDS[table.head.kind](table, rate, most, seed + number),
    );
    const even = this.textures.map(() => 1 / this.textures.length);
    this.fields = fields ?? [even];
    this.width_mm = width_mm;
    this._weights = Float64Array.from(this.fields[0]);
    this._gains = this._weights.map(Math.sqrt);
    this._one = new Float32Array(most);
  }

  /**
   * Write the next `count` samples, in the textures' unit.
   * @param {number} now On the engine's clock.
   * @param {number} count
   * @param {Float32Array} out
   */
  render(now, count, out) {
    const { follower, finger, textures } = this;
    follower.follow(finger, now, count);
    const target = this._target(count);
    if (finger.landed_n > 0) {
      this.tap(finger.landed_n);
      finger.landed_n = 0;
    }
    out.fill(0, 0, count);
    const step = Math.min(1, count / (GLIDE_S * this.rate));
    for (let n = 0; n < textures.length; n++) {
      const before = this._gains[n];
      this._weights[n] += Math.max(-step, Math.min(step, target[n] - this._weights[n]));
      const after = Math.sqrt(this._weights[n]);
      this._gains[n] = after;
      if (before === 0 && after === 0) continue;
      const one = this._one;
      textures[n].render(follower, one);
      for (let i = 0; i < count; i++) {
        const gain = (before + ((after - before) * (i + 1)) / count) * follower.contact[i] * follower.movement[i];
        out[i] += gain * one[i];
      }
    }
    this.transients.add(out, count);
  }

  /**
   * Begin a transient of so much force on what is under the finger.
   * @param {number} strength N.
   */
  tap(strength) {
    let power = 0;
    this.textures.forEach((texture, n) => (power += this._weights[n] * texture.level * texture.level));
    this.transients.start(strength, Math.sqrt(power));
  }

  /** Return the number of the field under the finger. */
  field() {
    const x = this.follower.x[Math.max(0, this.follower.count - 1)];
    return Math.min(this.fields.length - 1, Math.max(0, Math.floor(x / this.width_mm)));
  }

  _target(count) {
    return this.fields.length === 1 ? this.fields[0] : this.fields[this.field(count)];
  }
}

const MUTING_S = 0.02;
const RELEASE_S = 0.1;
/** Largest output: a little below full scale. */
export const CEILING = 0.89;

/** Output stage from the textures' unit to parts of full scale: gain, mute and limiter. */
export class Output {
  /** @param {number} rate */
  constructor(rate) {
    /** Parts of full scale per unit. */
    this.gain = 0;
    this.open = false;
    /** Samples that were limited. */
    this.limited = 0;
    this._gain = 0;
    this._share = 0;
    this._limit = 1;
    this._step = 1 / (MUTING_S * rate);
    this._glide = 1 - Math.exp(-1 / (MUTING_S * rate));
    this._release = 1 - Math.exp(-1 / (RELEASE_S * rate));
  }

  /** Whether the output is silent for any input. */
  get silent() {
    return this._share === 0;
  }

  /**
   * Change `count` samples in place.
   * @param {Float32Array} out
   * @param {number} count
   */
  process(out, count) {
    for (let i = 0; i < count; i++) {
      this._share = Math.min(1, Math.max(0, this._share + (this.open ? this._step : -this._step)));
      this._gain += this._glide * (this.gain - this._gain);
      let x = out[i] * this._gain * this._share;
      if (!(x > -Infinity && x < Infinity)) x = 0;
      const size = Math.abs(x);
      if (size * this._limit > CEILING) {
        this._limit = CEILING / size; // immediately: no sample exceeds it
        this.limited += 1;
      }
      out[i] = x * this._limit;
      this._limit += this._release * (1 - this._limit);
    }
  }

  /** Apply the gain immediately, for a rendering that starts with it. */
  settle() {
    this._gain = this.gain;
    this._share = this.open ? 1 : 0;
  }
}
