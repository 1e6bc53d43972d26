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
export const SETTINGS = Object.freeze({
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
export class Finger {
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
export class Follower {
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
