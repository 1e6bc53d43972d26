/** Screen calibration: matching a card of known size gives the pixels per millimetre. */

import { button, make } from "./dom.js";
import { ASSUMED, CARD_MM, keepMeasured } from "./millimetres.js";
import { say } from "./wording.js";

/** The frame starts smaller than any card, so that pressing on without moving it is not accepted. */
const FIRST = 0.75;
const STEP_PX = 1;
const LARGE_STEP_PX = 10;
/** From this width on, a card fits lengthwise on any screen: 90 mm on the densest tablets. */
const LYING_PX = 640;

/** Show the calibration page and return once the card fits: by its long side on a wide screen, else by its short one. */
export function calibrate(stage, language) {
  const lies = stage.clientWidth >= LYING_PX;
  const side = lies ? CARD_MM.long : CARD_MM.short;
  const other = lies ? CARD_MM.short : CARD_MM.long;
  const frame = make("div", { class: "card-frame" }, make("span", { class: "card-text", text: say(language, "card_here") }));
  const handle = make("div", { class: "card-handle", role: "slider", tabindex: "0", "aria-label": say(language, "card_slider") });
  frame.append(handle);
  const ground = make("div", { class: "card-ground" }, frame);
  const reason = make("p", { class: "reason", role: "status", text: say(language, "card_move_first") });
  const fits = button(say(language, "card_fits"), () => {}, { class: "large primary", disabled: true });
  const less = button("−", () => move(-STEP_PX), { "aria-label": say(language, "card_shorter"), class: "large step" });
  const more = button("+", () => move(STEP_PX), { "aria-label": say(language, "card_longer"), class: "large step" });
  stage.replaceChildren(
    make(
      "div",
      { class: "card-page" },
      make("h1", { text: say(language, "card_title") }),
      make("p", { text: `${say(language, lies ? "card_lying" : "card_standing")} ${say(language, "card_text")}` }),
      ground,
      make("div", { class: "row" }, less, fits, more),
      reason,
    ),
  );

  const limits = { least: 80, most: ground.clientWidth - 6 };
  let length = Math.min(side * ASSUMED * FIRST, limits.most);
  const draw = () => {
    frame.style.width = `${length}px`;
    frame.style.height = `${(length * other) / side}px`;
    const values = { min: limits.least, max: Math.round(limits.most), now: Math.round(length), text: `${Math.round(length)} px` };
    for (const [name, value] of Object.entries(values)) handle.setAttribute(`aria-value${name}`, String(value));
  };
  const set = (value) => {
    length = Math.min(Math.max(value, limits.least), limits.most);
    fits.disabled = false;
    reason.textContent = "";
    draw();
  };
  const move = (by) => set(length + by);
  // A drag moves the line by its own distance, wherever it starts: the finger does not hide the line, and it does not jump.
  let held = null;
  ground.addEventListener("pointerdown", (event) => {
    ground.setPointerCapture(event.pointerId);
    held = event.clientX - length;
  });
  ground.addEventListener("pointermove", (event) => held !== null && ground.hasPointerCapture(event.pointerId) && set(event.clientX - held));
  for (const name of ["pointerup", "pointercancel"]) ground.addEventListener(name, () => (held = null));
  handle.addEventListener("keydown", (event) => {
    const size = event.shiftKey ? LARGE_STEP_PX : STEP_PX;
    const by = { ArrowRight: size, ArrowUp: size, ArrowLeft: -size, ArrowDown: -size, PageUp: LARGE_STEP_PX, PageDown: -LARGE_STEP_PX }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    move(by);
  });
  draw();
  handle.focus({ focusVisible: false });
  return new Promise((resolve) => {
    fits.addEventListener("click", () => {
      keepMeasured(length / side);
      resolve();
    });
  });
}
