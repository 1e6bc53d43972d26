/** Pixels to millimetres: measured with a card held to the screen, or what CSS says, which is named as assumed. */

export const ASSUMED = 96 / 25.4;
/** ISO/IEC 7810, ID-1: the long side of a card. */
export const CARD_MM = 85.6;
/** As the participants' pages keep it: one measurement serves both. */
const KEY = "tactogram.screen";

function screenNow() {
  const sides = [screen.width, screen.height].sort((one, other) => one - other);
  return `${sides[0]}x${sides[1]}@${devicePixelRatio}`;
}

/** Return CSS pixels per mm as measured on this screen at this zoom, or null. */
export function measured() {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "null");
    return kept && kept.screen === screenNow() && kept.px_per_mm > 1.5 && kept.px_per_mm < 20 ? kept.px_per_mm : null;
  } catch {
    return null;
  }
}

/** @param {number} pxPerMm */
export function keep(pxPerMm) {
  localStorage.setItem(KEY, JSON.stringify({ px_per_mm: pxPerMm, screen: screenNow() }));
}

/**
 * Let a card be matched in a dialog; `done` is called when it was.
 * @param {HTMLDialogElement} dialog
 * @param {() => void} done
 */
export function calibrate(dialog, done) {
  const range = dialog.querySelector("input");
  const card = dialog.querySelector(".touch-card-shape");
  const draw = () => (card.style.width = `${range.value}px`);
  range.max = String(Math.min(900, innerWidth - 80));
  range.value = String(Math.round(CARD_MM * (measured() ?? ASSUMED)));
  range.oninput = draw;
  draw();
  dialog.querySelector("[value=keep]").onclick = () => {
    keep(Number(range.value) / CARD_MM);
    done();
  };
  dialog.showModal();
}
