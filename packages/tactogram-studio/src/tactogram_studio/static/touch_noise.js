/**
 * Modulated noise that follows speed and force: `tactogram.signal.modulated_noise_synthesis` and
 * `tactogram_playback.streaming.noise_texture`, for one axis, in the browser.
 */

import { around, Noise, Resampler } from "./touch_textures.js";
import { ending, Tones } from "./touch_tones.js";

const BANDS = 4;
const SUBFRAMES = 4;
const GAINS = BANDS + SUBFRAMES;
const SQUARE = GAINS * GAINS;
const TAPS = 512;
const FRAME_S = 0.01;
const SETTLING_S = 0.5;
const SILENT = 1e-30;

/** Noise in bands whose strength fluctuates, and tones, with parameters from a grid over speed and force. */
export class ModulatedNoiseTexture {
  /**
   * @param {import("./touch_textures.js").Table} table
   * @param {number} rate Of the engine, Hz.
   * @param {number} most
   * @param {number} seed
   */
  constructor(table, rate, most, seed) {
    const { head, arrays } = table;
    this.level = head.level;
    this._noise = new Noise(seed);
    this._resampler = new Resampler(table, rate, most);
    this._speeds = arrays.speeds;
    this._forces = arrays.forces;
    this._values = summed(arrays.values, arrays.steps, this._speeds.length);
    this._scoresOf = arrays.scores;
    this._sections = arrays.sections;
    this._rate = head.table_rate;
    this._length = FRAME_S * head.table_rate;
    this._factor = head.level_factor;
    this._lags = head.lags;
    // Places in a row of parameters: `NoiseParameters`.
    this._root = 3 * SQUARE * this._lags;
    this._offsetRoot = this._root + SQUARE;
    this._quantiles = this._offsetRoot + SQUARE;
    const size = arrays.steps.length;
    this._taps = this._quantiles + GAINS * this._scoresOf.length + BANDS + 1;
    this._tones = new Tones(this._taps + TAPS, size, this._rate, seed);
    this._parameters = new Float64Array(size);
    this._ends = [new Float64Array(size), new Float64Array(size)];
    this._begun = false;
    this._own = new Float64Array(GAINS);
    this._lattice = new Float64Array(GAINS * this._lags);
    this._x = new Float64Array(GAINS);
    this._new = new Float64Array(GAINS);
    this._scores = [new Float64Array(GAINS), new Float64Array(GAINS)];
    /** Logarithms of the gains: by the first and by the last parameters, at the frame's beginning and end. */
    this._gains = [0, 1].map(() => [new Float64Array(GAINS), new Float64Array(GAINS)]);
    this._delays = new Float64Array(2 * BANDS);
    this._power = 0;
    this._ring = new Float64Array(2 * TAPS);
    this._place = this._subframe = this._done = this._frame = 0;
    this._drawn = new Float64Array(0);
  }

  /**
   * Write the next samples.
   * @param {import("./touch_motion.js").Follower} motion
   * @param {Float32Array} out
   */
  render(motion, out) {
    const count = motion.count;
    this._interpolate(motion.speed[count - 1], motion.force[count - 1]);
    if (!this._begun) this._begin();
    const moving = this._parameters.some((value, p) => value !== this._ends[1][p]);
    if (moving) {
      this._ends.reverse();
      this._ends[1].set(this._parameters);
    }
    const fresh = this._resampler.fresh(count);
    const first = this._ends[moving ? 0 : 1];
    this._write(fresh, this._resampler.made, first, moving);
    this._tones.add(fresh, this._resampler.made, first, this._ends[1], moving);
    this._resampler.write(fresh, count, out);
  }

  _interpolate(speed, force) {
    const { _parameters: parameters, _values: v } = this;
    const [corners, [a, b, c, d]] = around(speed, force, this._speeds, this._forces);
    const [i, j, k, l] = corners.map((corner) => corner * parameters.length);
    for (let p = 0; p < parameters.length; p++) {
      parameters[p] = a * v[i + p] + b * v[j + p] + c * v[k + p] + d * v[l + p];
    }
  }

  _begin() {
    this._begun = true;
    this._ends[1].set(this._parameters);
    for (const array of [this._own, this._lattice]) this._draw(array, array.length);
    this._write(Math.round(SETTLING_S * this._rate) + TAPS, null, this._ends[1], false);
  }

  _draw(array, count) {
    for (let n = 0; n < count; n++) array[n] = this._noise.normal();
  }

  /**
   * Write samples at the texture's rate; without an array only the state changes.
   * @param {number} samples
   * @param {Float64Array | null} out
   * @param {Float64Array} first Parameters at the beginning.
   * @param {boolean} moving Whether those at the end are others.
   */
  _write(samples, out, first, moving) {
    const { _length: length, _gains: gains, _sections: s, _delays: d, _ring: ring } = this;
    const last = this._ends[1];
    let begun = 0;
    while (ending(this._frame + begun, length) < this._done + samples) begun += 1;
    const drawn = GAINS * begun + BANDS * samples;
    if (this._drawn.length < drawn) this._drawn = new Float64Array(drawn);
    this._draw(this._drawn, drawn);
    let innovation = 0;
    let noise = GAINS * begun;
    this._transform(first, gains[0]);
    this._transform(last, gains[1]);
    for (let t = 0; t < samples; t++) {
      const now = this._done + t;
      if (now === ending(this._frame, length)) {
        this._advance(innovation, last);
        innovation += GAINS;
        this._transform(first, gains[0]);
        this._transform(last, gains[1]);
        this._subframe = SUBFRAMES * this._frame;
        this._frame += 1;
      } else if (now === ending(this._subframe + 1, length / SUBFRAMES)) this._subframe += 1;
      const r = moving ? (t + 1) / samples : 0;
      const frame = this._frame;
      const subframe = this._subframe;
      const begin = ending(frame - 1, length);
      const ofFrame = (now + 1 - begin) / (ending(frame, length) - begin);
      const from = ending(subframe, length / SUBFRAMES);
      const ofSubframe = (now + 1 - from) / (ending(subframe + 1, length / SUBFRAMES) - from);
      let total = 0;
      for (let b = 0; b < BANDS; b++) {
        const x = this._drawn[noise + b];
        const y = s[6 * b] * x + d[2 * b];
        d[2 * b] = s[6 * b + 1] * x - s[6 * b + 4] * y + d[2 * b + 1];
        d[2 * b + 1] = s[6 * b + 2] * x - s[6 * b + 5] * y;
        total += Math.exp(between(gains, 0, b, 1, b, ofFrame, r)) * y;
      }
      noise += BANDS;
      this._power += this._factor * (total * total - this._power);
      const at = BANDS + subframe - SUBFRAMES * (frame - 1);
      const level =
        at === BANDS
          ? between(gains, 0, GAINS - 1, 1, at, ofSubframe, r)
          : between(gains, 1, at - 1, 1, at, ofSubframe, r);
      this._place = (this._place + 1) % TAPS;
      const newest = this._place + TAPS;
      ring[this._place] = ring[newest] = (total * Math.exp(level)) / Math.sqrt(Math.max(this._power, SILENT));
      if (out === null) continue;
      out[t] = filtered(first, this._taps, ring, newest);
      if (moving) out[t] += r * (filtered(last, this._taps, ring, newest) - out[t]);
    }
    this._done += samples;
  }

  /** Draw the scores at the end of the next frame: the normalised lattice. */
  _advance(innovation, parameters) {
    const { _lattice: lattice, _lags: lags, _scores: scores } = this;
    let x = this._x;
    let next = this._new;
    for (let g = 0; g < GAINS; g++) x[g] = this._drawn[innovation + g];
    for (let m = lags - 1; m >= 0; m--) {
      const s = 3 * SQUARE * m;
      const k = s + SQUARE;
      const w = k + SQUARE;
      const row = GAINS * m;
      for (let g = 0; g < GAINS; g++) {
        let ahead = 0;
        let back = 0;
        for (let h = 0; h < GAINS; h++) {
          const along = GAINS * g + h;
          ahead += parameters[s + along] * x[h] + parameters[k + along] * lattice[row + h];
          back += parameters[w + along] * lattice[row + h] - parameters[k + GAINS * h + g] * x[h];
        }
        next[g] = ahead;
        if (m + 1 < lags) lattice[row + GAINS + g] = back;
      }
      [x, next] = [next, x];
    }
    lattice.set(x);
    scores.reverse();
    for (let g = 0; g < GAINS; g++) {
      scores[1][g] = 0;
      for (let h = 0; h < GAINS; h++) scores[1][g] += parameters[this._root + GAINS * g + h] * x[h];
    }
  }

  _transform(parameters, gains) {
    const { _scoresOf: known, _own: own } = this;
    const last = known.length - 1;
    for (let g = 0; g < GAINS; g++) {
      let offset = 0;
      for (let h = 0; h < GAINS; h++) offset += parameters[this._offsetRoot + GAINS * g + h] * own[h];
      const row = this._quantiles + known.length * g;
      for (let end = 0; end < 2; end++) {
        const z = this._scores[end][g] + offset;
        let i = 1;
        while (i < last && known[i] < z) i += 1;
        const share = Math.min(Math.max((z - known[i - 1]) / (known[i] - known[i - 1]), 0), 1);
        gains[end][g] = (1 - share) * parameters[row + i - 1] + share * parameters[row + i];
      }
    }
  }
}

/**
 * Return the parameters of each node, (speed, force, parameter), from their second differences along the speed.
 * @param {Int16Array} differences (parameter, force, speed), in steps.
 * @param {Float32Array} steps
 * @param {number} speeds
 */
function summed(differences, steps, speeds) {
  const values = new Float32Array(differences.length);
  const forces = differences.length / speeds / steps.length;
  let at = 0;
  for (let p = 0; p < steps.length; p++) {
    for (let force = 0; force < forces; force++) {
      let slope = 0;
      let value = 0;
      for (let speed = 0; speed < speeds; speed++) {
        slope += differences[at++];
        value += slope;
        const whole = (value << 16) >> 16; // differences beyond int16 were sent modulo 2**16
        values[(speed * forces + force) * steps.length + p] = whole * steps[p];
      }
    }
  }
  return values;
}

function between(gains, one, i, two, j, share, r) {
  const before = (1 - share) * gains[0][one][i] + share * gains[0][two][j];
  const after = (1 - share) * gains[1][one][i] + share * gains[1][two][j];
  return (1 - r) * before + r * after;
}

function filtered(parameters, taps, ring, newest) {
  let total = 0;
  for (let k = 0; k < TAPS; k++) total += parameters[taps + k] * ring[newest - k];
  return total;
}
