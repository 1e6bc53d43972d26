/** Pixels per millimetre, measured with a card; shared with participants' pages. */

import { ASSUMED, CARD_MM, keepMeasured, measured } from "/participants/static/millimetres.js";

export { ASSUMED, measured };

/** Open the dialog for the card; `done` is called after a measurement. */
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
