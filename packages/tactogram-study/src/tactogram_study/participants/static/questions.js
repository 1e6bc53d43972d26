/** Questions of each kind, without a preselected answer. */

import { make } from "./dom.js";
import { scaleLine } from "./scale_line.js";
import { say } from "./wording.js";

/** A visual analogue scale of a questionnaire, mm. */
const VAS_MM = 100;
/** Scales with more steps than fit in a line become a number field. */
const MOST_STEPS = 11;
const SMALLEST_SHOWN = 1e-6;

/**
 * Page data that a question needs.
 * @typedef {object} Place
 * @property {string} language
 * @property {Object<string, any>} layout
 * @property {number} room width for a line, CSS pixels
 * @property {boolean} matrix whether questions of one kind are shown in rows
 * @property {string} value the answer so far
 * @property {(value: string) => void} changed
 */

/**
 * Return a question's form element.
 * @param {any} question one of `Page.shown`
 * @param {Place} place
 * @returns {{element: HTMLElement, missing: (value: string) => string|null, facts: Object<string, any>}}
 *   missing: why an answer is not acceptable, as the key of a text or as `=` and the text itself; else null
 */
export function questionOf(question, place) {
  const kind = question.kind === "steps" && question.high - question.low >= MOST_STEPS ? "number" : question.kind;
  const shown = { choice, steps, vas, number, text }[kind](question, place);
  const legend = make("legend", {}, ...legendOf(question, place.language));
  const set = make("fieldset", { class: `question asks-${kind}${place.matrix ? " matrix" : ""}`, "data-key": question.key }, legend, shown.element);
  if (shown.ends) set.append(shown.ends);
  return { element: set, missing: shown.missing ?? ((value) => required(question, value)), facts: shown.facts ?? {} };
}

function legendOf(question, language) {
  const parts = question.slot ? [make("span", { class: "slot", text: question.slot }), " "] : [];
  parts.push(question.text);
  if (!question.required) parts.push(" ", make("span", { class: "quiet", text: say(language, "optional") }));
  return parts;
}

const required = (question, value) => (question.required && value === "" ? "answer" : null);

function radio(question, place, value, text) {
  const input = make("input", { type: "radio", name: question.key, value, onchange: () => place.changed(value) });
  input.checked = place.value === value;
  return make("label", { class: "option" }, input, make("span", { text }));
}

function choice(question, place) {
  const options = question.options.map((option) => radio(question, place, option.value, option.text));
  return { element: make("div", { class: "options" }, ...options) };
}

function steps(question, place) {
  const count = question.high - question.low + 1;
  const numbers = Array.from({ length: count }, (_, i) => String(question.low + i));
  const element = make("div", { class: "options steps" }, ...numbers.map((one) => radio(question, place, one, one)));
  element.style.setProperty("--count", String(count));
  return { element, ends: place.matrix ? null : endsOf(question) };
}

/** Return the labels of a scale's two ends. */
export function endsOf(question) {
  if (!question.low_text && !question.high_text) return null;
  return make("div", { class: "ends" }, make("span", { text: question.low_text }), make("span", { text: question.high_text }));
}

function vas(question, place) {
  const asked = place.layout.vas_mm ?? VAS_MM;
  const name = [question.slot, question.text, `${question.low_text} – ${question.high_text}`].filter(Boolean).join(", ");
  const line = scaleLine({ ...place, mm: asked, low: question.low, high: question.high, name });
  const ends = endsOf(question);
  const block = make("div", { class: "vas-block" }, line.element);
  block.style.width = line.element.style.width;
  if (ends) block.append(ends);
  return {
    element: block,
    missing: (value) => (question.required && value === "" ? "mark" : null),
    facts: { vas_mm: line.mm, vas_asked_mm: asked },
  };
}

function number(question, place) {
  const input = make("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    enterkeyhint: "next",
    maxlength: 24,
    class: "number",
    "aria-label": question.text || say(place.language, "number"),
    oninput: (event) => place.changed(plainNumber(event.target.value)),
  });
  input.value = place.value;
  const missing = (value) => {
    if (value === "") return question.required ? "number" : null;
    const given = Number(value);
    const low = question.low ?? -Infinity;
    const high = question.high ?? Infinity;
    const whole = question.kind !== "steps" || Number.isInteger(given);
    if (Number.isFinite(given) && given >= low && given <= high && whole) return null;
    return numberReason(place.language, low, high);
  };
  return { element: input, missing };
}

/** Return a number as programs write it; full-width digits and a decimal comma are accepted. */
export function plainNumber(text) {
  return text.normalize("NFKC").trim().replace(/^([+-]?\d+),(\d+)$/, "$1.$2").replace(/[−ー]/g, "-");
}

function numberReason(language, low, high) {
  if (Number.isFinite(low) && Number.isFinite(high)) return `=${say(language, "bad_between", { low, high })}`;
  if (low > 0 && low < SMALLEST_SHOWN) return `=${say(language, "bad_positive")}`;
  return Number.isFinite(low) ? `=${say(language, "bad_number", { low })}` : "number";
}

function text(question, place) {
  const area = make("textarea", {
    rows: 4,
    maxlength: 2000,
    autocomplete: "off",
    "aria-label": question.text,
    oninput: (event) => place.changed(event.target.value.trim()),
  });
  area.value = place.value;
  return { element: area };
}
