/**
 * Phone vibration: on and off, with a share of time on that follows the texture's strength.
 *
 * The rules are those of the display `phone-on-off` (`tactogram.rendering.families.pattern`): steps of 20 ms, error diffusion,
 * no pulse or pause shorter than two steps. The strength is known in advance, by speed, force and position, so that
 * patterns are made for the next moments.
 */

import { node } from "./touch_textures.js";

/** Steps per pattern, and steps until the next pattern is sent. */
const AHEAD = 10;
const EVERY = 5;

/**
 * Return the amplitude of the sine with a texture's power in the felt band, in its unit.
 * @param {import("./touch_textures.js").Table} table
 * @param {{speed: number, force: number, path: number, x: number, y: number}} at
 */
export function amplitudeAt({ head, arrays }, at) {
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
export class OnOff {
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
export function patternOf(values, stepMs) {
  const pattern = values[0] ? [] : [0];
  values.forEach((value, n) => {
    if (n > 0 && value === values[n - 1]) pattern[pattern.length - 1] += stepMs;
    else pattern.push(stepMs);
  });
  if (pattern.length % 2 === 0) pattern.pop(); // a pause at the end has no effect
  return pattern.some((ms, n) => n % 2 === 0 && ms > 0) ? pattern : [];
}

/** Sends patterns to a phone while the finger slides. */
export class Vibration {
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
