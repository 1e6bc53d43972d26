/** Pixels to millimetres by a card, in a dialog; one measurement serves this page and the participants'. */

import { ASSUMED, CARD_MM, keepMeasured, measured } from "/participants/static/millimetres.js";

export { ASSUMED, measured };

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
  range.value = String(Math.round(CARD_MM.long * (measured() ?? ASSUMED)));
  range.oninput = draw;
  draw();
  dialog.querySelector("[value=keep]").onclick = () => {
    keepMeasured(Number(range.value) / CARD_MM.long);
    done();
  };
  dialog.showModal();
}
