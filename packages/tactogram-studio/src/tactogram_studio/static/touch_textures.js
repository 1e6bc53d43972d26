/**
 * Textures that follow a finger: `tactogram_playback.streaming.textures`, for one axis, in the browser.
 *
 * Everything computed in advance (models on a grid over speed and force, copies of a surface with decreasing detail, the
 * kernel between two rates) is in the table from `tactogram_studio.pages.touch.tables`.
 */

const PHASES = 128;
const MAGIC = "TGTT";

/**
 * @typedef {object} Table
 * @property {Record<string, any>} head
 * @property {ArrayBuffer} buffer
 * @property {Record<string, Float32Array | Float64Array | Int16Array>} arrays Views of the buffer.
 */

/**
 * Read a response of `/touch/table`: "TGTT", the length of a JSON text, the text, and little-endian arrays.
 * @param {ArrayBuffer} buffer
 * @returns {Table}
 */
export function readTable(buffer) {
  const bytes = new Uint8Array(buffer);
  if (String.fromCharCode(...bytes.subarray(0, 4)) !== MAGIC) throw new Error("not a texture table");
  const length = new DataView(buffer).getUint32(4, true);
  return tableOf(JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + length))), buffer);
}

/**
 * Return a table whose text is parsed already: the audio thread has no text decoder.
 * @param {Record<string, any>} head
 * @param {ArrayBuffer} buffer
 * @returns {Table}
 */
export function tableOf(head, buffer) {
  const arrays = {};
  for (const [name, { type, offset, length }] of Object.entries(head.arrays)) {
    const kind = { float64: Float64Array, float32: Float32Array, int16: Int16Array }[type];
    arrays[name] = new kind(buffer, offset, length);
  }
  return { head, buffer, arrays };
}

/** Normal noise from a seed: the small fast counter generator sfc32 (C. Doty-Humphrey), and the Box-Muller transform. */
export class Noise {
  /** @param {number} seed */
  constructor(seed) {
    this._a = 0x9e3779b9;
    this._b = 0x243f6a88;
    this._c = seed >>> 0;
    this._count = 1;
    this._kept = NaN;
    for (let i = 0; i < 15; i++) this.whole();
  }

  /** Return a whole number of 32 bits. */
  whole() {
    const sum = (this._a + this._b + this._count) >>> 0;
    this._count = (this._count + 1) >>> 0;
    this._a = this._b ^ (this._b >>> 9);
    this._b = (this._c + (this._c << 3)) >>> 0;
    this._c = (((this._c << 21) | (this._c >>> 11)) + sum) >>> 0;
    return sum;
  }

  /** Return a number of mean 0 and variance 1. */
  normal() {
    if (this._kept === this._kept) {
      const kept = this._kept;
      this._kept = NaN;
      return kept;
    }
    const radius = Math.sqrt(-2 * Math.log((this.whole() + 1) / 4294967296));
    const angle = (2 * Math.PI * this.whole()) / 4294967296;
    this._kept = radius * Math.sin(angle);
    return radius * Math.cos(angle);
  }
}

/** Samples at a texture's rate, interpolated at the engine's. */
export class Resampler {
  /**
   * @param {Table} table
   * @param {number} rate Of the engine, Hz.
   * @param {number} most
   */
  constructor({ head, arrays }, rate, most) {
    this._kernel = arrays.kernel;
    this._ratio = head.table_rate / rate;
    this._half = head.half;
    const room = 2 * this._half + Math.ceil(most * this._ratio) + 2;
    /** Where to write fresh samples. */
    this.made = new Float64Array(room);
    this._history = new Float64Array(room);
    this._have = 0;
    this._place = Math.max(this._half - 1, 0);
  }

  /**
   * Return the number of samples at the texture's rate that the next `count` need.
   * @param {number} count
   */
  fresh(count) {
    if (!this._half) return count;
    const last = Math.floor(this._place + (count - 1) * this._ratio) + this._half;
    return Math.max(0, last + 1 - this._have);
  }

  /**
   * Write `count` samples, with the fresh ones in `made`.
   * @param {number} fresh
   * @param {number} count
   * @param {Float32Array} out
   */
  write(fresh, count, out) {
    const { _half: half, _kernel: kernel, _history: history, made } = this;
    if (half === 0) {
      for (let i = 0; i < count; i++) out[i] = made[i];
      return;
    }
    for (let i = 0; i < fresh; i++) history[this._have + i] = made[i];
    this._have += fresh;
    const taps = 2 * half;
    for (let i = 0; i < count; i++) {
      const at = this._place + i * this._ratio;
      const whole = Math.floor(at);
      const phase = (at - whole) * PHASES;
      const row = Math.floor(phase);
      const share = phase - row;
      const first = row * taps;
      const from = whole - half + 1;
      let total = 0;
      for (let k = 0; k < taps; k++) {
        total += ((1 - share) * kernel[first + k] + share * kernel[first + taps + k]) * history[from + k];
      }
      out[i] = total;
    }
    this._place += count * this._ratio;
    const done = Math.min(Math.floor(this._place) - half + 1, this._have);
    if (done > 0) {
      history.copyWithin(0, done, this._have);
      this._have -= done;
      this._place -= done;
    }
  }
}

/** Noise through a ladder filter whose coefficients follow speed and force. */
export class AutoregressiveTexture {
  /**
   * @param {Table} table
   * @param {number} rate Of the engine, Hz.
   * @param {number} most
   * @param {number} seed
   */
  constructor(table, rate, most, seed) {
    const { head, arrays } = table;
    this.level = head.level;
    this._noise = new Noise(seed);
    this._order = head.order;
    this._speeds = arrays.speeds;
    this._forces = arrays.forces;
    this._reflections = arrays.reflection;
    this._deviations = arrays.deviation;
    this._state = Float64Array.from({ length: this._order }, () => this._noise.normal());
    this._resampler = new Resampler(table, rate, most);
    // Parameters at the start and end of a block.
    this._before = new Float64Array(this._order);
    this._after = new Float64Array(this._order);
    this._deviation = [0, 0];
    this._begun = false;
  }

  /**
   * Write the next samples.
   * @param {import("./touch_motion.js").Follower} motion
   * @param {Float32Array} out
   */
  render(motion, out) {
    const count = motion.count;
    const fresh = this._resampler.fresh(count);
    this._turnTo(motion.speed[count - 1], motion.force[count - 1]);
    this._ladder(fresh, this._resampler.made);
    this._resampler.write(fresh, count, out);
  }

  _turnTo(speed, force) {
    [this._before, this._after] = [this._after, this._before];
    this._deviation[0] = this._deviation[1];
    const [corners, shares] = around(speed, force, this._speeds, this._forces);
    const order = this._order;
    const [a, b, c, d] = shares;
    const [p, q, r, s] = corners.map((corner) => corner * order);
    const k = this._reflections;
    for (let m = 0; m < order; m++) {
      this._after[m] = a * k[p + m] + b * k[q + m] + c * k[r + m] + d * k[s + m];
    }
    const g = this._deviations;
    this._deviation[1] = Math.exp(
      a * g[corners[0]] + b * g[corners[1]] + c * g[corners[2]] + d * g[corners[3]],
    );
    if (!this._begun) {
      this._before.set(this._after);
      this._deviation[0] = this._deviation[1];
      this._begun = true;
    }
  }

  /** The normalised ladder of Gray and Markel (1975), interpolated from the block's first parameters to its last. */
  _ladder(count, made) {
    const { _before: before, _after: after, _state: state, _order: order } = this;
    const glide = Math.max(1, count);
    for (let t = 0; t < count; t++) {
      const r = t / glide;
      let x = this._noise.normal();
      for (let m = order - 1; m >= 0; m--) {
        const k = (1 - r) * before[m] + r * after[m];
        const c = Math.sqrt((1 - k) * (1 + k));
        const b = state[m];
        if (m + 1 < order) state[m + 1] = k * x + c * b;
        x = c * x - k * b;
      }
      if (order) state[0] = x;
      made[t] = ((1 - r) * this._deviation[0] + r * this._deviation[1]) * x;
    }
  }
}

/** A signal over displacement, played at the finger's position: f = v k. */
export class SurfaceTexture {
  /**
   * @param {Table} table
   */
  constructor(table) {
    const { head, arrays } = table;
    this.level = head.level;
    this._along = head.along;
    this._copies = head.copies;
    this._nodes = arrays.nodes.length / head.copies;
    this._table = arrays.nodes;
    this._nodesPerMm = head.nodes_per_mm;
    this._samplesPerSpeed = head.samples_per_speed;
  }

  /**
   * Write the next samples.
   * @param {import("./touch_motion.js").Follower} motion
   * @param {Float32Array} out
   */
  render(motion, out) {
    const place = motion[this._along];
    const { _table: table, _nodes: nodes, _copies: copies } = this;
    for (let i = 0; i < motion.count; i++) {
      let at = (place[i] * this._nodesPerMm) % nodes;
      if (at < 0) at += nodes;
      let i1 = Math.floor(at);
      if (i1 >= nodes) i1 = 0;
      const r = at - i1;
      const i0 = i1 > 0 ? i1 - 1 : nodes - 1;
      const i2 = i1 + 1 < nodes ? i1 + 1 : 0;
      const i3 = i2 + 1 < nodes ? i2 + 1 : 0;
      // Samples of the surface per sample of the engine; above 1 the finest detail would alias.
      const ratio = motion.speed[i] * this._samplesPerSpeed;
      const copy = ratio > 0 ? 2 * Math.log2(ratio) : -4;
      let lower = 0;
      let share = 0;
      if (copy > -1) {
        const whole = Math.floor(copy);
        share = copy - whole;
        lower = whole + 1;
      }
      if (lower >= copies - 1) {
        lower = copies - 1;
        share = 0;
      }
      const upper = Math.min(lower + 1, copies - 1);
      out[i] =
        (1 - share) * cubic(table, lower * nodes, i0, i1, i2, i3, r) +
        share * cubic(table, upper * nodes, i0, i1, i2, i3, r);
    }
  }
}

/**
 * Return the nodes on both sides of a value, and its relative position between them.
 * @param {number} value
 * @param {Float64Array | Float32Array} nodes Ascending.
 * @returns {[number, number, number]}
 */
export function node(value, nodes) {
  const last = nodes.length - 1;
  if (last === 0 || !(value > nodes[0])) return [0, 0, 0];
  if (value >= nodes[last]) return [last, last, 0];
  let i = 0;
  while (nodes[i + 1] <= value) i++;
  return [i, i + 1, (value - nodes[i]) / (nodes[i + 1] - nodes[i])];
}

/**
 * Return the four nodes of a grid around a condition, and their shares.
 * @param {number} speed
 * @param {number} force
 * @param {Float64Array} speeds
 * @param {Float64Array} forces
 * @returns {[number[], number[]]}
 */
export function around(speed, force, speeds, forces) {
  const [i0, i1, u] = node(speed, speeds);
  const [j0, j1, w] = node(force, forces);
  const across = forces.length;
  return [
    [i0 * across + j0, i1 * across + j0, i0 * across + j1, i1 * across + j1],
    [(1 - u) * (1 - w), u * (1 - w), (1 - u) * w, u * w],
  ];
}

function cubic(table, row, i0, i1, i2, i3, r) {
  const y0 = table[row + i0];
  const y1 = table[row + i1];
  const y2 = table[row + i2];
  const y3 = table[row + i3];
  const slope1 = 0.5 * (y2 - y0);
  const slope2 = 0.5 * (y3 - y1);
  return y1 + r * (slope1 + r * (3 * (y2 - y1) - 2 * slope1 - slope2 + r * (2 * (y1 - y2) + slope1 + slope2)));
}
