/** A visual analogue scale: a plain line, without a mark until one is set by touch or keys. */

import { make } from "./dom.js";
import { fitting, pxPerMm } from "./millimetres.js";
import { say } from "./wording.js";

/** By how much a key moves the mark, as a share of the line: 1 mm and 10 mm of 100. */
const STEPS = { ArrowLeft: -0.01, ArrowDown: -0.01, ArrowRight: 0.01, ArrowUp: 0.01, PageDown: -0.1, PageUp: 0.1 };

/**
 * @param {object} options
 * @param {string} options.language
 * @param {number} options.mm wanted length
 * @param {number} options.room available CSS pixels
 * @param {number} options.low value at the left end
 * @param {number} options.high value at the right end
 * @param {string} options.name for screen readers
 * @param {string} options.value as stored, or ""
 * @param {(value: string) => void} options.changed
 * @returns {{element: HTMLElement, mm: number}} mm: actual length
 */
export function scaleLine({ language, mm, room, low, high, name, value, changed }) {
  const scale = pxPerMm();
  const drawn = fitting(mm, room, scale);
  const line = make("div", { class: "vas-line" });
  const hint = make("span", { class: "vas-hint", text: say(language, "scale_touch"), "aria-hidden": "true" });
  const mark = make("div", { class: "vas-mark", hidden: true });
  const element = make(
    "div",
    {
      class: "vas",
      role: "slider",
      tabindex: "0",
      "aria-label": name,
      "aria-description": say(language, "scale"),
      "aria-valuemin": low,
      "aria-valuemax": high,
    },
    line,
    mark,
    hint,
  );
  element.style.width = `${drawn * scale}px`;
  let share = value === "" ? null : (Number(value) - low) / (high - low);

  const draw = () => {
    mark.hidden = share === null;
    hint.hidden = share !== null;
    if (share !== null) mark.style.left = `${100 * share}%`;
    const now = share === null ? low : low + share * (high - low);
    element.setAttribute("aria-valuenow", now.toFixed(1));
    const percent = share === null ? 0 : Math.round(100 * share);
    element.setAttribute("aria-valuetext", share === null ? say(language, "not_marked") : say(language, "marked", { percent }));
  };
  const set = (to) => {
    share = Math.min(Math.max(to, 0), 1);
    draw();
    // To a tenth of a hundredth of the line: a tenth of a mm on 100 mm.
    changed(String(Number((low + (Math.round(1000 * share) / 1000) * (high - low)).toFixed(6))));
  };
  const touched = (event) => {
    const box = line.getBoundingClientRect();
    set((event.clientX - box.left) / box.width);
  };
  element.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    element.setPointerCapture(event.pointerId);
    element.focus();
    touched(event);
  });
  element.addEventListener("pointermove", (event) => element.hasPointerCapture(event.pointerId) && touched(event));
  element.addEventListener("keydown", (event) => {
    const ends = { Home: 0, End: 1 };
    if (event.key in ends) set(ends[event.key]);
    else if (event.key in STEPS) set(share === null ? 0.5 : share + STEPS[event.key]);
    else return;
    event.preventDefault();
  });
  draw();
  return { element, mm: drawn };
}
