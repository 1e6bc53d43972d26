/** A target that moves back and forth, and a finger that follows it. Pure: times are arguments, in ms. */

/** A finger counts as stroking this long after its last movement, ms: about five reports of a screen at 60 Hz. */
export const STILL_MS = 80;
/** Below this a finger rests, mm/s. */
export const SLOWEST = 5;

/**
 * Return where the target is: a triangle between two ends, at one speed.
 * @param {number} ms since it started at the left end
 * @param {number} speed mm/s
 * @param {number} way mm from end to end
 */
export function targetAt(ms, speed, way) {
  if (!(way > 0)) return 0;
  const gone = ((speed * ms) / 1000) % (2 * way);
  return gone <= way ? gone : 2 * way - gone;
}

/** Stroke of a finger on an area: whether it moves, its speed, its distance from the target. */
export class Stroke {
  constructor() {
    this.last = null;
    this.stroking = false;
    this.path = 0;
    this.ms = 0;
    this.apart = 0;
    this.samples = 0;
  }

  /** A finger comes down. */
  down(ms, x, y) {
    this.last = { ms, x, y, moved: -Infinity };
    this.stroking = false;
  }

  /**
   * A finger is somewhere. Reports of the same instant count as one.
   * @param {number} ms
   * @param {number} x mm
   * @param {number} y mm
   * @param {number} target mm, its x
   */
  moved(ms, x, y, target) {
    if (this.last === null) return this.down(ms, x, y);
    const passed = ms - this.last.ms;
    const way = Math.hypot(x - this.last.x, y - this.last.y);
    if (passed <= 0) return undefined;
    const fast = (way / passed) * 1000 >= SLOWEST;
    if (fast && passed <= STILL_MS) {
      this.path += way;
      this.ms += passed;
      this.apart += Math.abs(x - target);
      this.samples += 1;
    }
    this.stroking = fast;
    this.last = { ms, x, y, moved: fast ? ms : this.last.moved };
    return undefined;
  }

  /** A finger goes up or leaves the area. */
  up() {
    this.last = null;
    this.stroking = false;
  }

  /** Return whether it strokes at an instant: it moved a moment ago. */
  strokes(ms) {
    return this.last !== null && ms - this.last.moved <= STILL_MS;
  }

  /** Return mean speed, mm/s; null if it never stroked. */
  get speed() {
    return this.ms > 0 ? (1000 * this.path) / this.ms : null;
  }

  /** Return mean distance from the target along its way, mm. */
  get distance() {
    return this.samples ? this.apart / this.samples : null;
  }
}

/** What was drawn of the target: its way over its time, by the page's own clock. */
export class Drawn {
  constructor() {
    this.last = null;
    this.path = 0;
    this.ms = 0;
    this.frames = 0;
  }

  /** A frame was drawn. Frames in which it turned say less than the way, and are left out. */
  frame(ms, x, turned) {
    if (this.last && !turned && ms > this.last.ms) {
      this.path += Math.abs(x - this.last.x);
      this.ms += ms - this.last.ms;
      this.frames += 1;
    }
    this.last = { ms, x };
  }

  get speed() {
    return this.ms > 0 ? (1000 * this.path) / this.ms : null;
  }

  get refresh() {
    return this.ms > 0 ? (1000 * this.frames) / this.ms : null;
  }
}
