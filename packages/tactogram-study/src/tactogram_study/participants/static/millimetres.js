/** Millimetres on this screen, measured with a card, and sizes that fit. Lengths are CSS pixels unless they say mm. */

/** ISO/IEC 7810:2019, ID-1. */
export const CARD_MM = { long: 85.6, short: 53.98 };
/** Assumed for a screen that was not measured: 96 CSS pixels to the inch (CSS Values and Units, 6.2). */
export const ASSUMED = 96 / 25.4;
const KEY = "tactogram.screen";
/** Measured since the page was loaded, for browsers without storage. */
let held = null;
const POSSIBLE = { least: 1.5, most: 20 };

/** Return an id of the screen at its zoom. */
function screenNow(view = window) {
  const sides = [view.screen.width, view.screen.height].sort((one, other) => one - other);
  return `${sides[0]}x${sides[1]}@${view.devicePixelRatio}`;
}

/** Return the pixels per mm measured on this screen at this zoom, or null. */
export function measured(view = window) {
  try {
    return valid(JSON.parse(view.localStorage.getItem(KEY) ?? "null") ?? held, view);
  } catch {
    return valid(held, view);
  }
}

function valid(kept, view) {
  const known = kept && kept.screen === screenNow(view) ? kept.px_per_mm : null;
  return known >= POSSIBLE.least && known <= POSSIBLE.most ? known : null;
}

export function keepMeasured(pxPerMm, view = window) {
  held = { px_per_mm: pxPerMm, screen: screenNow(view) };
  try {
    view.localStorage.setItem(KEY, JSON.stringify(held));
  } catch {
    // A browser without storage measures again after a reload.
  }
}

/** Return the pixels per mm: measured, else assumed. */
export const pxPerMm = () => measured() ?? ASSUMED;

/** Return `asked` mm, or less where `room` (pixels) is smaller; `scale` is pixels per mm. */
export function fitting(asked, room, scale) {
  return Math.min(asked, Math.max(1, room / scale));
}

/** Least height of an area, mm: the target and a fingertip on it; with less room the page scrolls. */
const LOWEST_MM = 14;

/**
 * Return the layout of areas, two by default: one above the other if they fit, else side by side, else smaller.
 * @param {[number, number]} area width and height, mm
 * @param {[number, number]} room width and height, CSS pixels
 * @param {number} scale CSS pixels for each mm
 * @param {number} gap CSS pixels between them, also for a label above each
 * @param {number} count
 * @returns {{beside: boolean, width: number, height: number, whole: boolean}} sizes in mm
 */
export function areasIn(area, room, scale, gap, count = 2) {
  const above = sized(area, [room[0], room[1] / count - gap], scale, false);
  const beside = sized(area, [(room[0] - (count - 1) * gap) / count, room[1] - gap], scale, true);
  if (above.whole || above.width * above.height >= beside.width * beside.height) return above;
  return beside;
}

function sized(area, room, scale, beside) {
  const width = fitting(area[0], room[0], scale);
  const height = fitting(area[1], Math.max(room[1], LOWEST_MM * scale), scale);
  return { beside, width, height, whole: width >= area[0] && height >= area[1] };
}
