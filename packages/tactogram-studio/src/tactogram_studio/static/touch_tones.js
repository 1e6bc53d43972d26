/** Tones that follow speed and force: `tactogram.signal.tone_synthesis`, for one axis, in the browser. */

import { Noise } from "./touch_textures.js";

const START_S = 0.1;
const STEP_S = 0.01;
/** Of unsteadiness: a stroke's speed, and speed and gain within it with their autocorrelations. */
const NUMBERS = 5;
/** Keeps its noise apart from that of the texture. */
const APART = 0x746f6e65;

/** Lines of which each row of parameters has `NUMBERS`, then frequencies, cosine and sine parts. */
export class Tones {
  /**
   * @param {number} place Of the first parameter in a row.
   * @param {number} size Of a row.
   * @param {number} rate Of the texture, Hz.
   * @param {number} seed
   */
  constructor(place, size, rate, seed) {
    this._unsteadiness = place;
    this._lines = (size - place - NUMBERS) / 3;
    this._frequency = place + NUMBERS;
    this._cosine = this._frequency + this._lines;
    this._sine = this._cosine + this._lines;
    this._rate = rate;
    this._length = STEP_S * rate;
    this._noise = new Noise((seed ^ APART) >>> 0);
    /** Of the stroke's speed; of speed and gain at the beginning and at the end of the frame. */
    this._scores = new Float64Array(NUMBERS);
    this._phase = new Float64Array(this._lines);
    this._begun = false;
    this._done = this._frame = 0;
  }

  /**
   * Add the next samples.
   * @param {number} samples
   * @param {Float64Array} out
   * @param {Float64Array} first Parameters at the beginning.
   * @param {Float64Array} last Parameters at the end.
   * @param {boolean} moving Whether they differ.
   */
  add(samples, out, first, last, moving) {
    if (!this._lines) return;
    const { _scores: scores, _phase: phase, _unsteadiness: u } = this;
    if (!this._begun) this._begin(first);
    for (let t = 0; t < samples; t++) {
      const now = this._done + t;
      if (now === ending(this._frame, this._length)) {
        for (const which of [0, 1]) {
          const kept = last[u + 2 + 2 * which];
          const drawn = Math.sqrt(Math.max(0, 1 - kept * kept)) * this._noise.normal();
          scores[1 + which] = scores[3 + which];
          scores[3 + which] = kept * scores[3 + which] + drawn;
        }
        this._frame += 1;
      }
      const begin = ending(this._frame - 1, this._length);
      const ofFrame = (now + 1 - begin) / (ending(this._frame, this._length) - begin);
      const r = moving ? (t + 1) / samples : 0;
      const at = (p) => (1 - r) * first[p] + r * last[p];
      const speed = (1 - ofFrame) * scores[1] + ofFrame * scores[3];
      const level = (1 - ofFrame) * scores[2] + ofFrame * scores[4];
      const step = ((2 * Math.PI) / this._rate) * Math.exp(at(u) * scores[0] + at(u + 1) * speed);
      const gain = Math.exp(at(u + 3) * level);
      for (let k = 0; k < this._lines; k++) {
        phase[k] = (phase[k] + step * at(this._frequency + k)) % (2 * Math.PI);
        const line = at(this._cosine + k) * Math.cos(phase[k]) - at(this._sine + k) * Math.sin(phase[k]);
        out[t] += gain * line;
      }
    }
    this._done += samples;
  }

  _begin(parameters) {
    this._begun = true;
    for (let n = 0; n < NUMBERS; n++) this._scores[n] = this._noise.normal();
    const start = 2 * Math.PI * START_S * this._noise.normal();
    for (let k = 0; k < this._lines; k++) this._phase[k] = start * parameters[this._frequency + k];
  }
}

/** Return the sample after the end of `count` frames or subframes of `length` samples. */
export function ending(count, length) {
  return Math.floor(count * length + 0.5);
}
