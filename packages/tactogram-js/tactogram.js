/* tactogram.js 0.1.0, Apache-2.0. Made from tactogram-studio: change its modules. */
const $touch_textures = (() => {
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
function readTable(buffer) {
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
function tableOf(head, buffer) {
  const arrays = {};
  for (const [name, { type, offset, length }] of Object.entries(head.arrays)) {
    const kind = { float64: Float64Array, float32: Float32Array, int16: Int16Array }[type];
    arrays[name] = new kind(buffer, offset, length);
  }
  return { head, buffer, arrays };
}

/** Normal noise from a seed: the small fast counter generator sfc32 (C. Doty-Humphrey), and the Box-Muller transform. */
class Noise {
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
class Resampler {
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
class AutoregressiveTexture {
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
class SurfaceTexture {
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
function node(value, nodes) {
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
function around(speed, force, speeds, forces) {
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

return { readTable, tableOf, Noise, Resampler, AutoregressiveTexture, SurfaceTexture, node, around };
})();
const $touch_document = (() => {
/** A texture from its JSON document: `tactogram_studio.touch.document`. */

const { tableOf } = $touch_textures;

const FORMAT = "tactogram-texture";
const VERSION = 1;
const KINDS = { float64: Float64Array, float32: Float32Array, int16: Int16Array };

/**
 * Return the table and the picture in a document.
 * @param {string} text JSON.
 * @returns {{table: import("./touch_textures.js").Table, picture: Record<string, any> | null}}
 */
function readDocument(text) {
  const { format, version, arrays, picture, ...facts } = parsed(text);
  if (format !== FORMAT || version !== VERSION) {
    const got = format === FORMAT ? `version ${version}` : (format ?? "another JSON");
    throw new Error(`expected a ${FORMAT}, version ${VERSION}, got ${got}; write one with: tactogram touch`);
  }
  try {
    return { table: tableIn(facts, arrays), picture: picture ?? null };
  } catch {
    throw new Error("its arrays are damaged; write it again with: tactogram touch");
  }
}

function tableIn(facts, arrays) {
  const places = {};
  let end = 0;
  for (const [name, { type, values }] of Object.entries(arrays)) {
    places[name] = { type, offset: end, length: values.length };
    end += 8 * Math.ceil((values.length * KINDS[type].BYTES_PER_ELEMENT) / 8);
  }
  const table = tableOf({ ...facts, arrays: places }, new ArrayBuffer(end));
  for (const [name, { values }] of Object.entries(arrays)) table.arrays[name].set(values);
  return table;
}

function parsed(text) {
  try {
    return JSON.parse(text) ?? {};
  } catch {
    throw new Error(`expected a ${FORMAT}, got no JSON; write one with: tactogram touch`);
  }
}

/** Return the bytes of base64. @param {string} text */
function decoded(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

return { FORMAT, VERSION, readDocument, decoded };
})();
const $awake = (() => {
/** Audio contexts that start with a user's gesture and resume after a call, a lock screen or a silent switch. */

/** Events in which browsers allow sound to start; for a touch that is the one that ends it. */
const GESTURES = ["pointerdown", "pointerup", "touchend", "click", "keydown"];
/** Longest start of a sound device, ms; wireless ones take about one second. */
const BEGINS_MS = 3000;

/** Resume a context at each gesture, while `wanted` returns true: it has not been allowed to start, or the system stopped it. */
function keepAwake(context, wanted = () => true) {
  // A tablet's silent switch mutes "ambient" sound.
  if (navigator.audioSession) navigator.audioSession.type = "playback";
  const wake = () => {
    if (wanted() && context.state !== "running" && context.state !== "closed") context.resume().catch(() => null);
  };
  for (const name of GESTURES) document.addEventListener(name, wake, { capture: true, passive: true });
}

return { BEGINS_MS, keepAwake };
})();
const $touch_motion = (() => {
/**
 * Motion of the finger: `tactogram.rendering.motion`, its state and its path, in the browser.
 *
 * The same operations in the same order, so that both make the same samples from the same motion; reasons are given
 * there. Lengths in mm, speeds in mm/s, forces in N, times in s.
 */

/**
 * One message about the finger; unknown values are NaN.
 * @typedef {object} Sample
 * @property {number} time On the sender's clock.
 * @property {number} arrival On the engine's clock.
 * @property {number} x
 * @property {number} y
 * @property {number} force 0 is a lifted finger.
 * @property {boolean} [quiet] A landing without a transient: a mouse that enters the pad.
 * @property {boolean} [made] Not from a pointer: keys, a simulated hand, a resting finger.
 */

const DRIFT = 2e-4;
const RESTART_S = 1.0;
const FARTHEST_MM = 1e6;

/** Python drops samples after 30 ms; a browser may delay pointer events for two frames of 60 Hz. */
const SETTINGS = Object.freeze({
  smoothing_s: 0.01,
  late_s: 0.06,
  lost_s: 0.1,
  contact_on_n: 0.05,
  contact_off_n: 0.02,
  rest_mm_s: 1.0,
  moving_mm_s: 6.0,
  jump_mm: 20.0,
});

/** Present state of the finger: `hear` each sample, read at the start of each block. */
class Finger {
  /** @param {typeof SETTINGS} [settings] */
  constructor(settings = SETTINGS) {
    this.settings = settings;
    this.counts = { used: 0, late: 0, out_of_order: 0, invalid: 0, lost_connections: 0 };
    this.x = this.y = this.vx = this.vy = 0;
    this.position_s = -Infinity;
    this.force = NaN;
    this.heard_s = -Infinity;
    this.touching = false;
    /** Force of a landing that no block contains yet. */
    this.landed_n = 0;
    /** Whether the newest position is a jump, not a stroke. */
    this.jumped = false;
    this.interval_s = 0;
    this._positions = 0;
    this._offset = this._lateFrom = this._lateLeast = Infinity;
    this._offset_s = 0;
    this._last = -Infinity;
    this._connected = false;
  }

  /**
   * Take up a sample; return whether it was used.
   * @param {Sample} sample
   * @param {number} now
   */
  hear(sample, now) {
    if (!isValid(sample)) {
      this.counts.invalid += 1;
      return false;
    }
    if (sample.time <= this._last) {
      if (sample.time > this._last - RESTART_S) {
        this.counts.out_of_order += 1;
        return false;
      }
      this._setClock(Infinity);
    }
    this._last = sample.time;
    const seen = sample.arrival - sample.time;
    const allowed = this._offset + DRIFT * Math.max(0, sample.arrival - this._offset_s);
    if (seen < allowed) this._offset = seen;
    else if (this._offset < Infinity) this._offset = allowed;
    this._offset_s = sample.arrival;
    if (now - (sample.time + this._offset) > this.settings.late_s && this._isLate(sample, now)) {
      this.counts.late += 1;
      return false;
    }
    const at = sample.time + this._offset;
    this._lateFrom = this._lateLeast = Infinity;
    this.counts.used += 1;
    this.heard_s = Math.max(this.heard_s, at);
    this._connected = true;
    if (sample.x === sample.x) this._hearPosition(sample.x, sample.y, at);
    if (sample.force === sample.force) this.force = sample.force;
    this._touch(sample.quiet === true);
    return true;
  }

  /**
   * Tell whether nothing has come for too long.
   * @param {number} now
   */
  lost(now) {
    if (now - this.heard_s <= this.settings.lost_s) return false;
    if (this._connected) {
      this._connected = false;
      this.counts.lost_connections += 1;
      this.touching = false;
      this.vx = this.vy = 0;
      this.jumped = true;
    }
    return true;
  }

  /**
   * Return the velocity.
   * @param {number} now
   * @returns {[number, number]}
   */
  velocity(now) {
    return now - this.position_s <= this.settings.lost_s ? [this.vx, this.vy] : [0, 0];
  }

  /**
   * Return where the finger is now if it goes on as it went, or null if no position comes.
   * @param {number} now
   * @returns {[number, number] | null}
   */
  place(now) {
    const age = now - this.position_s;
    if (age > this.settings.lost_s) return null;
    const ahead = Math.min(Math.max(age, 0), this.settings.late_s + this.interval_s);
    return [this.x + this.vx * ahead, this.y + this.vy * ahead];
  }

  _isLate(sample, now) {
    this._lateFrom = Math.min(this._lateFrom, sample.arrival);
    this._lateLeast = Math.min(this._lateLeast, sample.arrival - sample.time);
    if (sample.arrival - this._lateFrom < RESTART_S || this._lateLeast <= this._offset) return true;
    this._setClock(this._lateLeast);
    return now - (sample.time + this._offset) > this.settings.late_s;
  }

  _setClock(offset) {
    this._offset = offset;
    this._lateFrom = this._lateLeast = Infinity;
  }

  _hearPosition(x, y, at) {
    const step = at - this.position_s;
    if (step <= 0) return;
    this.position_s = at;
    if (!(step < this.settings.lost_s)) {
      const far = Math.hypot(x - this.x, y - this.y) > this.settings.jump_mm;
      this.jumped = this.jumped || far || step === Infinity;
      this._beginAt(x, y);
      return;
    }
    this.interval_s = this.interval_s === 0 ? step : 0.9 * this.interval_s + 0.1 * step;
    const keep = Math.exp(-step / Math.max(this.settings.smoothing_s, 1.5 * this.interval_s));
    const missedX = x - this.x - this.vx * step;
    const missedY = y - this.y - this.vy * step;
    if (Math.hypot(missedX, missedY) > this.settings.jump_mm) {
      this.jumped = true;
      this._beginAt(x, y);
      return;
    }
    const n = this._positions;
    this._positions += 1;
    const gain = Math.max(1 - keep * keep, (2 * (2 * n + 1)) / ((n + 1) * (n + 2)));
    const slope = Math.max((1 - keep) * (1 - keep), 6 / ((n + 1) * (n + 2))) / step;
    this.x += this.vx * step + gain * missedX;
    this.y += this.vy * step + gain * missedY;
    this.vx += slope * missedX;
    this.vy += slope * missedY;
  }

  _beginAt(x, y) {
    this.x = x;
    this.y = y;
    this.vx = this.vy = 0;
    this._positions = 1;
  }

  _touch(quiet) {
    if (this.force !== this.force) this.touching = true;
    else if (this.touching) this.touching = this.force >= this.settings.contact_off_n;
    else if (this.force > this.settings.contact_on_n) {
      this.touching = true;
      this.landed_n = quiet ? 0 : this.force;
    }
  }
}

/** @param {Sample} sample */
function isValid(sample) {
  if (!Number.isFinite(sample.time) || !Number.isFinite(sample.arrival)) return false;
  if (Number.isNaN(sample.x) !== Number.isNaN(sample.y)) return false;
  if (Number.isNaN(sample.x) && Number.isNaN(sample.force)) return false;
  if (Math.abs(sample.x) > FARTHEST_MM || Math.abs(sample.y) > FARTHEST_MM) return false;
  return !(sample.force < 0 || sample.force === Infinity);
}

const FOLLOWING_S = 0.005;
const FORCE_S = 0.005;
const LANDING_S = 0.003;
const LIFTING_S = 0.012;

/** The finger at each sample of a block, interpolated without jumps. */
class Follower {
  /**
   * @param {number} rate Hz.
   * @param {number} most Most samples in a block.
   */
  constructor(rate, most) {
    this.step = 1 / rate;
    this.count = 0;
    this.x = new Float64Array(most);
    this.y = new Float64Array(most);
    this.path = new Float64Array(most);
    this.speed = new Float64Array(most);
    this.force = new Float64Array(most);
    this.contact = new Float32Array(most);
    this.movement = new Float32Array(most);
    /** @type {"lost" | "air" | "rest" | "slide"} */
    this.state = "lost";
    this._x = this._y = this._vx = this._vy = this._force = this._contact = this._path = this._movement = 0;
  }

  /**
   * Go after the finger for the next `count` samples.
   * @param {Finger} finger
   * @param {number} now
   * @param {number} count
   */
  follow(finger, now, count) {
    const settings = finger.settings;
    const lost = finger.lost(now);
    let place = lost ? null : finger.place(now);
    let [vx, vy] = lost ? [0, 0] : finger.velocity(now);
    const silent = this._contact === 0;
    if (finger.jumped && place !== null && silent) {
      [this._x, this._y] = place;
      this._vx = vx;
      this._vy = vy;
      finger.jumped = false;
    }
    const elsewhere = finger.jumped && place !== null;
    if (elsewhere) {
      // Fade out here, and move there silently.
      place = null;
      vx = vy = 0;
    }
    const touching = finger.touching && !lost && !elsewhere;
    const force = finger.force === finger.force ? finger.force : 0;
    if (silent && touching) this._force = force;
    this._follow(place, vx, vy, force, touching, Math.max(FOLLOWING_S, finger.interval_s), settings, count);
    this.count = count;
    const moving = this.speed[count - 1] > (settings.rest_mm_s + settings.moving_mm_s) / 2;
    this.state = lost ? "lost" : !finger.touching ? "air" : moving ? "slide" : "rest";
  }

  _follow(place, vx, vy, force, touching, following, settings, count) {
    const step = this.step;
    const pull = 1 / (following * following);
    const damp = 2 / following;
    const keep = Math.exp(-step / FORCE_S);
    const rise = step / LANDING_S;
    const fall = step / LIFTING_S;
    const rest = settings.rest_mm_s;
    const moving = settings.moving_mm_s;
    const [x, y] = place ?? [0, 0];
    let [px, py, ux, uy] = [this._x, this._y, this._vx, this._vy];
    let [held, contact, path, share] = [this._force, this._contact, this._path, this._movement];
    for (let i = 0; i < count; i++) {
      const t = i * step;
      let ax = damp * (vx - ux);
      let ay = damp * (vy - uy);
      if (place !== null) {
        ax += pull * (x + vx * t - px);
        ay += pull * (y + vy * t - py);
      }
      ux += ax * step;
      uy += ay * step;
      px += ux * step;
      py += uy * step;
      const speed = Math.sqrt(ux * ux + uy * uy);
      path += speed * step;
      held = force + keep * (held - force);
      contact = touching ? Math.min(1, contact + rise) : Math.max(0, contact - fall);
      const wanted = Math.min(1, Math.max(0, (speed - rest) / (moving - rest)));
      share += Math.min(rise, Math.max(-fall, wanted - share));
      this.x[i] = px;
      this.y[i] = py;
      this.path[i] = path;
      this.speed[i] = speed;
      this.force[i] = held;
      this.contact[i] = contact * contact * (3 - 2 * contact);
      this.movement[i] = share * share * (3 - 2 * share);
    }
    this._x = px;
    this._y = py;
    this._vx = ux;
    this._vy = uy;
    this._force = held;
    this._contact = contact;
    this._path = path;
    this._movement = share;
  }
}

return { SETTINGS, Finger, Follower };
})();
const $touch_tones = (() => {
/** Tones that follow speed and force: `tactogram.signal.tone_synthesis`, for one axis, in the browser. */

const { Noise } = $touch_textures;

const START_S = 0.1;
const STEP_S = 0.01;
/** Of unsteadiness: a stroke's speed, and speed and gain within it with their autocorrelations. */
const NUMBERS = 5;
/** Keeps its noise apart from that of the texture. */
const APART = 0x746f6e65;

/** Lines of which each row of parameters has `NUMBERS`, then frequencies, cosine and sine parts. */
class Tones {
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
function ending(count, length) {
  return Math.floor(count * length + 0.5);
}

return { Tones, ending };
})();
const $touch_noise = (() => {
/**
 * Modulated noise that follows speed and force: `tactogram.signal.modulated_noise_synthesis` and
 * `tactogram_playback.streaming.noise_texture`, for one axis, in the browser.
 */

const { around, Noise, Resampler } = $touch_textures;
const { ending, Tones } = $touch_tones;

const BANDS = 4;
const SUBFRAMES = 4;
const GAINS = BANDS + SUBFRAMES;
const SQUARE = GAINS * GAINS;
const TAPS = 512;
const FRAME_S = 0.01;
const SETTLING_S = 0.5;
const SILENT = 1e-30;

/** Noise in bands whose strength fluctuates, and tones, with parameters from a grid over speed and force. */
class ModulatedNoiseTexture {
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

return { ModulatedNoiseTexture };
})();
const $touch_dsp = (() => {
/**
 * Motion to samples: `tactogram_playback.streaming.engine` and `.contact` in the browser, and the output stage after
 * them. Independent of pages and audio contexts.
 */

const { Finger, Follower } = $touch_motion;
const { ModulatedNoiseTexture } = $touch_noise;
const { AutoregressiveTexture, SurfaceTexture } = $touch_textures;

const GLIDE_S = 0.05;
const KINDS = { autoregressive: AutoregressiveTexture, noise: ModulatedNoiseTexture, surface: SurfaceTexture };

/** Transient of a landing; see `ContactSettings`. */
const CONTACT = { frequency_hz: 160, decay_s: 0.012, gain: 4, hardest_n: 3 };
const AT_ONCE = 8;
const OVER = 1e-4;

/** Decaying sines that start when a finger lands. */
class Transients {
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
class Engine {
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
const CEILING = 0.89;

/** Output stage from the textures' unit to parts of full scale: gain, mute and limiter. */
class Output {
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

return { Transients, Engine, CEILING, Output };
})();
const $touch_player = (() => {
/**
 * Messages from the page to the engine and its output, and reports back.
 *
 * Runs in an AudioWorklet (`touch_worklet.js`) or, if there is none, in the page (`touch_sound.js`).
 */

const { Engine, Output } = $touch_dsp;
const { Finger } = $touch_motion;
const { tableOf } = $touch_textures;

const REPORT_S = 0.03;
const QUANTUM = 128;

/** An engine controlled by messages. */
class Player {
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

return { QUANTUM, Player };
})();
const $touch_sound = (() => {
/** Audio of the page Touch: context, worklet, spectrum and latency. */

const { keepAwake } = $awake;

const { Player, QUANTUM } = $touch_player;

/** Peak of the first textures, in dB of full scale: audible, and harmless on headphones. */
const SAFE_DB = -20;
const KEPT = 400;
/** A block must last at most 5 ms; headsets with a microphone use 16 or 24 kHz. */
const LEAST_HZ = QUANTUM / 0.005;
const USUAL_HZ = 48_000;

/** Sound controlled by messages (see `touch_player.js`) that reports back. */
class Sound {
  /**
   * @param {(report: Record<string, any>) => void} report
   * @param {number} [rate] Hz, where the textures need one; by default the device's.
   */
  constructor(report, rate) {
    this._report = report;
    this.context = rate ? new AudioContext({ latencyHint: "interactive", sampleRate: rate }) : contextOf();
    /** Whether the sound is switched on. */
    this.wanted = false;
    keepAwake(this.context, () => this.wanted);
    this.analyser = new AnalyserNode(this.context, { fftSize: 8192, smoothingTimeConstant: 0.6 });
    this.analyser.connect(this.context.destination);
    /** Whether the samples are made in the audio thread; without a worklet, in the page's. */
    this.threaded = this.context.audioWorklet !== undefined;
    /** Seconds from a pointer event to the output of the first block that follows it, newest last. */
    this.latencies = [];
    this._ready = this.threaded ? this._withWorklet().catch(() => this._withoutWorklet()) : this._withoutWorklet();
  }

  get rate() {
    return this.context.sampleRate;
  }

  /**
   * Tell the player something.
   * @param {Record<string, any>} message
   */
  async tell(message) {
    await this._ready;
    this._send(message);
  }

  /** Send a message immediately if the sound plays: motion is useless later. */
  tellNow(message) {
    if (this.context.state === "running") this._send?.(message);
  }

  /** Start; browsers allow it only just after a user's gesture. */
  async begin() {
    this.wanted = true;
    const resumed = this.context.resume();
    await this._ready;
    await resumed;
  }

  /** Give the sound output back. */
  close() {
    this.wanted = false;
    this.context.close();
  }

  /** Return the delays that the browser reports, s; null if it does not. */
  delays() {
    const { baseLatency, outputLatency } = this.context;
    return { base: baseLatency ?? null, output: outputLatency > 0 ? outputLatency : null };
  }

  _heard(report) {
    if (report.error) {
      console.error(report.error);
      return;
    }
    if (report.motion === report.motion) {
      const late = this._lateness(report);
      if (late !== null) {
        this.latencies.push(late);
        if (this.latencies.length > KEPT) this.latencies.shift();
      }
    }
    this._report(report);
  }

  /** Time from a pointer event to the output of the first block that it changed, s. */
  _lateness({ motion, motion_block: block }) {
    const stamp = this.context.getOutputTimestamp?.();
    if (!stamp || !(stamp.performanceTime > 0)) return null;
    const { currentTime, outputLatency = 0 } = this.context;
    const late = leaves(block, { ...clocks(stamp), now: performance.now() / 1e3, currentTime, outputLatency }) - motion;
    return late > 0 && late < 2 ? late : null;
  }

  async _withWorklet() {
    await this.context.audioWorklet.addModule(import.meta.url);
    const worklet = new AudioWorkletNode(this.context, "tactogram-touch", {
      numberOfInputs: 0,
      outputChannelCount: [2],
    });
    worklet.port.onmessage = (event) => this._heard(event.data);
    worklet.connect(this.analyser);
    this._send = (message) => worklet.port.postMessage(message);
  }

  /** Browsers have no worklet over plain HTTP beyond this machine: then the page's thread makes the samples. */
  async _withoutWorklet() {
    this.threaded = false;
    const player = new Player(this.context.sampleRate, (report) => this._heard(report));
    const script = this.context.createScriptProcessor(1024, 0, 2);
    script.onaudioprocess = ({ outputBuffer, playbackTime }) => {
      const [left, right] = [outputBuffer.getChannelData(0), outputBuffer.getChannelData(1)];
      for (let i = 0; i < left.length; i += QUANTUM) {
        player.render(playbackTime + i / this.rate, left.subarray(i, i + QUANTUM));
      }
      right.set(left);
    };
    script.connect(this.analyser);
    this._send = (message) => player.hear(message, this.context.currentTime);
  }
}

/** Return a context at the device's rate, or at one that suits the textures. */
function contextOf() {
  const own = new AudioContext({ latencyHint: "interactive" });
  if (own.sampleRate >= LEAST_HZ) return own;
  own.close();
  return new AudioContext({ latencyHint: "interactive", sampleRate: USUAL_HZ });
}

const clocks = ({ contextTime, performanceTime }) => ({ heard: contextTime, at: performanceTime / 1e3 });

/**
 * Return when a block leaves the browser, on the page's clock, s.
 *
 * A browser reports what is `heard`, and `at` which time. Some (Firefox) shift both by the output's latency, as if a
 * block were heard as soon as it is made; then the latency is added.
 * @param {number} block On the context's clock, s.
 * @param {{heard: number, at: number, now: number, currentTime: number, outputLatency: number}} said
 */
function leaves(block, { heard, at, now, currentTime, outputLatency }) {
  const behind = currentTime - heard - (now - at);
  return at + block - heard + (behind < outputLatency / 2 ? outputLatency : 0);
}

/** Return a quantile of values. */
function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

/**
 * Draw a spectrum from 0 to 1000 Hz.
 * @param {HTMLCanvasElement} canvas
 * @param {AnalyserNode} analyser
 * @param {Float32Array} bins
 * @param {number} high dB of full scale at the top; the bottom is 80 dB below.
 */
function drawSpectrum(canvas, analyser, bins, high) {
  const { width, height } = fitted(canvas);
  const pen = canvas.getContext("2d");
  const style = getComputedStyle(canvas);
  const [most, foot, low] = [1000, 18, high - 80];
  analyser.getFloatFrequencyData(bins);
  const perBin = analyser.context.sampleRate / analyser.fftSize;
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = style.getPropertyValue("--quiet") || "#51606e";
  pen.strokeStyle = style.getPropertyValue("--line") || "#d5dce2";
  for (let hz = 0; hz <= most; hz += 200) {
    const x = (hz / most) * (width - 1) + 0.5;
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x, height - foot);
    pen.stroke();
    pen.textAlign = hz === 0 ? "left" : hz === most ? "right" : "center";
    pen.fillText(hz === most ? `${hz} Hz` : String(hz), x, height - 4);
  }
  pen.fillStyle = style.getPropertyValue("--accent") || "#0b5d66";
  pen.beginPath();
  pen.moveTo(0, height - foot);
  for (let n = 1; n * perBin <= most && n < bins.length; n++) {
    const share = Math.min(1, Math.max(0, (bins[n] - low) / (high - low)));
    pen.lineTo(((n * perBin) / most) * width, (1 - share) * (height - foot));
  }
  pen.lineTo(width, height - foot);
  pen.fill();
}

/**
 * Set a canvas to the screen's resolution; return its size in CSS pixels.
 * @param {HTMLCanvasElement} canvas
 */
function fitted(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const ratio = devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
  return { width, height };
}

return { SAFE_DB, Sound, contextOf, leaves, quantile, drawSpectrum, fitted };
})();
const $touch_pad = (() => {
/** The pad: turns pointer, keys or a simulated hand into motion in mm; draws surface, trail and probe. */

const { fitted } = $touch_sound;

/** A resting finger sends no events; after this time its last position is sent again. */
const HELD_MS = 25;
const BEAT_MS = 8;
const LIFTED_MS = 400;
const TRAIL_S = 0.7;
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const KEY_MM_S = { slow: 80, fast: 250 };

/** A pad over an element; `tell` receives each batch of samples. */
class Pad {
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

return { Pad };
})();
const $touch_vibration = (() => {
/**
 * Phone vibration: on and off, with a share of time on that follows the texture's strength.
 *
 * The rules are those of the display `phone-on-off` (`tactogram.rendering.families.pattern`): steps of 20 ms, error diffusion,
 * no pulse or pause shorter than two steps. The strength is known in advance, by speed, force and position, so that
 * patterns are made for the next moments.
 */

const { node } = $touch_textures;

/** Steps per pattern, and steps until the next pattern is sent. */
const AHEAD = 10;
const EVERY = 5;

/**
 * Return the amplitude of the sine with a texture's power in the felt band, in its unit.
 * @param {import("./touch_textures.js").Table} table
 * @param {{speed: number, force: number, path: number, x: number, y: number}} at
 */
function amplitudeAt({ head, arrays }, at) {
  const values = arrays.vibration;
  if (head.kind === "surface") {
    const step = head.vibration_step_mm;
    const place = ((((at[head.along] / step) % values.length) + values.length) % values.length);
    const i = Math.floor(place);
    return values[i] + (place - i) * (values[(i + 1) % values.length] - values[i]);
  }
  const across = arrays.forces.length;
  const [i0, i1, u] = node(at.speed, arrays.speeds);
  const [j0, j1, w] = node(at.force, arrays.forces);
  const upper = (1 - u) * values[i0 * across + j0] + u * values[i1 * across + j0];
  const lower = (1 - u) * values[i0 * across + j1] + u * values[i1 * across + j1];
  return (1 - w) * upper + w * lower;
}

/** On-off pattern whose running mean follows a share, in runs of at least `shortest` steps; silence is immediate. */
class OnOff {
  /** @param {number} shortest Steps. */
  constructor(shortest) {
    this.shortest = shortest;
    this.owed = 0;
    this.state = 0;
    this.lasted = shortest;
  }

  /** Return a copy of the state, to look ahead. */
  copy() {
    return Object.assign(new OnOff(this.shortest), this);
  }

  /**
   * Return 0 or 1 for the next step.
   * @param {number} share 0 to 1.
   */
  next(share) {
    this.owed += share;
    let wished = Number(this.state === 0 ? this.owed >= this.shortest / 2 : this.owed > 0);
    if (share === 0) {
      this.owed = wished = 0;
      this.lasted = this.shortest;
    }
    if (wished !== this.state && this.lasted >= this.shortest) {
      this.state = wished;
      this.lasted = 0;
    }
    this.owed -= this.state;
    this.lasted += 1;
    return this.state;
  }
}

/**
 * Return durations on, off, on … in ms for `navigator.vibrate`; empty without vibration.
 * @param {number[]} values 0 or 1.
 * @param {number} stepMs
 */
function patternOf(values, stepMs) {
  const pattern = values[0] ? [] : [0];
  values.forEach((value, n) => {
    if (n > 0 && value === values[n - 1]) pattern[pattern.length - 1] += stepMs;
    else pattern.push(stepMs);
  });
  if (pattern.length % 2 === 0) pattern.pop(); // a pause at the end has no effect
  return pattern.some((ms, n) => n % 2 === 0 && ms > 0) ? pattern : [];
}

/** Sends patterns to a phone while the finger slides. */
class Vibration {
  /** @param {(pattern: number | number[]) => boolean} vibrate */
  constructor(vibrate) {
    this._vibrate = vibrate;
    this._tables = [];
    this._strongest = 1;
    this._onOff = new OnOff(2);
    this._sent = false;
    this._last = null;
    this.on = false;
  }

  /** @param {import("./touch_textures.js").Table[]} tables */
  set tables(tables) {
    this._tables = tables;
    this._strongest = Math.max(1e-9, ...tables.flatMap((table) => table.arrays.vibration.reduce((a, b) => Math.max(a, b), 0)));
  }

  /**
   * Send what comes next, if it is time; `report` is the player's.
   * @param {Record<string, any>} report
   * @param {number[]} weights Of the textures under the finger.
   */
  follow(report, weights) {
    if (!this.on || report.state !== "slide" || !this._tables.length) {
      this.stop();
      return;
    }
    const { step_ms: stepMs, shortest_steps: shortest } = this._tables[0].head.phone;
    const due = (EVERY * stepMs) / 1e3;
    if (this._last !== null && report.time - this._last.time < due) return;
    const [vx, vy] = this._velocity(report);
    this._onOff.shortest = shortest;
    const values = [];
    let later = this._onOff;
    for (let n = 0; n < AHEAD; n++) {
      if (n === EVERY) later = this._onOff.copy(); // beyond this only if the page is delayed
      const t = (n * stepMs) / 1e3;
      const at = { ...report, path: report.path + report.speed * t, x: report.x + vx * t, y: report.y + vy * t };
      values.push(later.next(this.share(at, weights)));
    }
    this._last = report;
    const pattern = patternOf(values, stepMs);
    if (pattern.length) {
      this._vibrate(pattern);
      this._sent = true;
    } else if (this._sent) {
      this._vibrate(0);
      this._sent = false;
    }
  }

  /**
   * Return how strong it shall be, of the strongest moment of all textures.
   * @param {Record<string, any>} at
   * @param {number[]} weights
   */
  share(at, weights) {
    let power = 0;
    this._tables.forEach((table, n) => (power += (weights[n] ?? 0) * amplitudeAt(table, at) ** 2));
    return Math.min(1, Math.sqrt(power) / this._strongest);
  }

  /** Stop the vibration. */
  stop() {
    if (this._sent) this._vibrate(0);
    this._sent = false;
    this._last = null;
    this._onOff = new OnOff(this._onOff.shortest);
  }

  _velocity(report) {
    const last = this._last;
    if (last === null || report.time <= last.time) return [0, 0];
    return [report.x - last.x, report.y - last.y].map((way) => way / (report.time - last.time));
  }
}

return { amplitudeAt, OnOff, patternOf, Vibration };
})();
const $touch_worklet = (() => {
/** The sound of the page Touch, in the audio thread; elsewhere this module does nothing. */

const { Player } = $touch_player;

const Processor = globalThis.AudioWorkletProcessor ?? Object;

class TouchProcessor extends Processor {
  constructor(options) {
    super();
    this._player = new Player(sampleRate, (report) => this.port.postMessage(report));
    this.port.onmessage = (event) => this._hear(event.data);
    for (const message of options.processorOptions?.messages ?? []) this._hear(message);
  }

  _hear(message) {
    try {
      this._player.hear(message, currentTime);
    } catch (error) {
      this.port.postMessage({ error: String(error) });
    }
  }

  process(_inputs, outputs) {
    const [first, ...others] = outputs[0];
    this._player.render(currentTime, first);
    for (const other of others) other.set(first);
    return true;
  }
}

globalThis.registerProcessor?.("tactogram-touch", TouchProcessor);

return {  };
})();
/** `<tactogram-pad src="corduroy.json">`: a texture to stroke, in any page. One file: its own worklet, too. */

const { decoded, readDocument } = $touch_document;
const { Pad } = $touch_pad;
const { SAFE_DB, Sound } = $touch_sound;
const { Vibration } = $touch_vibration;
const {} = $touch_worklet;

const STYLES = `
:host { display: block; font: 15px/1.4 system-ui, sans-serif; }
:host([hidden]) { display: none; }
.pad { position: relative; box-sizing: border-box; height: var(--tactogram-pad-height, 18rem); overflow: hidden; border-radius: 10px;
  border: 1px solid #75818c; background: #e6e9ec; cursor: none; touch-action: none; user-select: none;
  -webkit-user-select: none; -webkit-touch-callout: none; }
.pad:focus-visible { outline: 3px solid #0b5d66; outline-offset: 2px; box-shadow: 0 0 0 2px #ffffff; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; }
button { position: absolute; right: 0.75rem; bottom: 0.75rem; padding: 0.5rem 0.9rem; border: 2px solid #ffffff; border-radius: 8px;
  background: #0b5d66; color: #ffffff; font: inherit; font-weight: 600; cursor: pointer; }
button:focus-visible { outline: 3px solid #0b5d66; outline-offset: 2px; }
p { margin: 0.35rem 0 0; font-size: 0.85em; }
.error { padding: 0.5rem 0.75rem; border: 2px solid #b3261e; border-radius: 8px; }
`;
const KEYS = "Stroke it with a mouse, finger or pen. Keys: arrows stroke, faster with Shift; Space taps.";

/** A pad with the texture of the document at `src`. */
class TactogramPad extends (globalThis.HTMLElement ?? Object) {
  static observedAttributes = ["src", "gain", "label"];

  /** Latest values from the audio thread: state, speed (mm/s), force (N), rms and peak (in `unit`). */
  report = { state: "lost", speed: 0, force: 0, rms: 0, peak: 0 };
  _open = false;

  get src() {
    return this.getAttribute("src") ?? "";
  }

  set src(address) {
    this.setAttribute("src", address);
  }

  /** Parts of full scale per unit of the texture; by default its largest sample is at -20 dB. */
  get gain() {
    const gain = Number(this.getAttribute("gain"));
    return gain > 0 ? gain : 10 ** (SAFE_DB / 20) / this._table.head.peak;
  }

  connectedCallback() {
    this._load();
  }

  disconnectedCallback() {
    this._close();
  }

  attributeChangedCallback(name) {
    if (!this.isConnected) return;
    if (name === "src") this._load();
    else if (this._pad) this._apply();
  }

  /** Show the document at `src`, or why it cannot be shown. */
  async _load() {
    this._close();
    const loading = (this._loading = {});
    const src = this.src;
    try {
      const { table, picture } = readDocument(await fetched(new URL(src, this.ownerDocument.baseURI)));
      const bitmap = picture && (await createImageBitmap(new Blob([decoded(picture.webp)], { type: "image/webp" })));
      if (loading === this._loading) this._show(table, { ...picture, bitmap });
    } catch (error) {
      if (loading === this._loading) this._draw(made("p", { className: "error", role: "alert", textContent: `${src || "src"}: ${error.message}` }));
    }
  }

  _show(table, picture) {
    this._table = table;
    const { name, simulated, follows, notes } = table.head;
    const pad = made("div", { className: "pad", tabIndex: 0, role: "application" });
    pad.setAttribute("aria-roledescription", "touch pad");
    pad.setAttribute("aria-describedby", "keys");
    this._button = made("button", { type: "button", textContent: "Press to start" });
    this._button.addEventListener("click", () => this._switch(!this._open));
    pad.addEventListener("pointerdown", (event) => {
      if (!this._sound && event.target !== this._button) this._switch(true);
    });
    pad.append(made("canvas", { ariaHidden: "true" }), this._button);
    const said = [picture.words ?? name, `${simulated ? "simulated; " : ""}follows ${follows}`, ...notes]
      .map((text) => `${text[0].toUpperCase()}${text.slice(1)}.`)
      .join(" ");
    this._draw(pad, made("p", { id: "keys", textContent: `${said} ${KEYS}` }));
    this._pad = new Pad(pad, (message) => this._sound?.tellNow(message));
    this._pad.fields = [[{ ...picture, name, opacity: 1 }]];
    this._vibration = new Vibration((pattern) => navigator.vibrate?.(pattern) ?? false);
    this._vibration.tables = [table];
    this._vibration.on = matchMedia("(pointer: coarse)").matches;
    const screen = this._pad.pxPerMm;
    new ResizeObserver(() => this._pad?.scale(screen)).observe(pad);
    this._apply();
    const draw = () => {
      this._pad.draw(this.report);
      this._frame = requestAnimationFrame(draw);
    };
    draw();
  }

  /** Apply the attributes that may change. */
  _apply() {
    const { name } = this._table.head;
    this._pad.element.setAttribute("aria-label", this.getAttribute("label") ?? `Surface of ${name}`);
    this._sound?.tell({ kind: "output", gain: this.gain, open: this._open });
  }

  /** Turn the sound on, which browsers allow after a gesture, or off. */
  async _switch(on) {
    const { head, buffer } = this._table;
    if (!this._sound) {
      this._sound = new Sound((report) => this._follow(report), head.rate);
      this._sound.tell({ kind: "textures", tables: [{ head, buffer }], seed: 1, fields: [[1]] });
    }
    this._open = this._sound.wanted = on;
    this._button.textContent = on ? "Turn the sound off" : "Turn the sound on";
    this._apply();
    if (!on) return;
    this._pad.element.focus({ preventScroll: true, focusVisible: false });
    await this._sound.begin();
  }

  _follow(report) {
    this.report = report;
    this._vibration.follow(report, [1]);
  }

  _draw(...parts) {
    const root = this.shadowRoot ?? this.attachShadow({ mode: "open" });
    const sheet = new CSSStyleSheet(); // allowed by any Content-Security-Policy
    sheet.replaceSync(STYLES);
    root.adoptedStyleSheets = [sheet];
    root.replaceChildren(...parts);
  }

  _close() {
    cancelAnimationFrame(this._frame);
    this._vibration?.stop();
    this._pad?.close();
    this._sound?.close();
    this._loading = this._pad = this._sound = undefined;
    this._open = false;
  }
}

/** Return the text at an address. @param {URL} address */
async function fetched(address) {
  let answer;
  try {
    answer = await fetch(address);
  } catch {
    throw new Error("cannot be loaded; is the page served by a web server?");
  }
  if (!answer.ok) throw new Error(`cannot be loaded: ${answer.status} ${answer.statusText}`.trim());
  return answer.text();
}

const made = (name, values) => Object.assign(document.createElement(name), values);

if (globalThis.customElements && !customElements.get("tactogram-pad")) customElements.define("tactogram-pad", TactogramPad);

export { TactogramPad };
