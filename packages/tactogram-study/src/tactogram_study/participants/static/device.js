/** Facts about this device, sent with each answer: sizes and speeds can be checked later. */

import { measured, pxPerMm } from "./millimetres.js";

const rounded = (value, digits = 3) => (Number.isFinite(value) ? Number(value.toFixed(digits)) : null);

/** Return facts by name, with units in the names. */
export function deviceFacts(more = {}) {
  const facts = {
    px_per_mm: rounded(pxPerMm(), 4),
    calibrated: measured() !== null,
    pixel_ratio: rounded(devicePixelRatio),
    zoom: rounded(window.visualViewport?.scale ?? 1),
    dark: matchMedia("(prefers-color-scheme: dark)").matches,
    width_px: innerWidth,
    height_px: innerHeight,
    touch: navigator.maxTouchPoints > 0,
    // Undefined in browsers without full screen.
    full_screen: Boolean(document.fullscreenElement),
  };
  for (const [name, value] of Object.entries(more)) {
    const kept = typeof value === "number" ? rounded(value) : value;
    if (kept !== null && kept !== undefined) facts[name] = kept;
  }
  return facts;
}
