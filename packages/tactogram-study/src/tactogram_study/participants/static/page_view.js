/** One page of a study as a form: stimuli, questions, and the reason why it cannot be left yet. */

import { areas, smallNote } from "./areas.js";
import { button, make } from "./dom.js";
import { endsOf, questionOf } from "./questions.js";
import { intervals, players } from "./stimuli.js";
import { say } from "./wording.js";

/** The second click of a double click on the previous page does not count on this one. */
export const FIRST_MS = 300;
/** From this many questions of one kind on, they are shown in rows. */
const ROWS = 4;
/** Widest page (`.page`: 64rem), and the approximate height around stimuli and of a question below them. */
const WIDEST_PX = 1152;
const SIDES_PX = 36;
const AROUND_PX = 210;
const QUESTION_PX = 110;
const IN_ROWS = ["steps", "choice"];

/**
 * @param {object} options
 * @param {any} options.page as `Page.shown` gives it
 * @param {string} options.language
 * @param {any} options.sounds
 * @param {Map<string, string>} options.images
 * @param {HTMLElement} options.stage
 * @param {{kept: Object<string, string>, keep: (answers: Object<string, string>) => void}} options.draft
 * @param {(sent: {answers: Object<string, string>, rt_ms: Object<string, number>, facts: Object<string, any>}) => void} options.send
 * @returns {{stop: () => void, hush: () => void}}
 */
export function showPage({ page, language, sounds, images, stage, draft, send }) {
  const began = performance.now();
  const answers = Object.fromEntries(page.questions.map((one) => [one.key, draft.kept[one.key] ?? ""]));
  const times = {};
  let sent = false;

  const next = make("button", { type: "submit", class: "large primary", text: say(language, "next") });
  const reason = make("p", { class: "reason", role: "status" });
  const changed = () => {
    const why = missing();
    next.disabled = why !== null;
    if (reason.textContent !== (why ?? "")) reason.textContent = why ?? "";
  };
  const room = [Math.min(stage.clientWidth, WIDEST_PX) - SIDES_PX, stage.clientHeight];
  const scene = { page, language, sounds, images, changed, room: [room[0], room[1] - AROUND_PX - QUESTION_PX * page.questions.length] };
  const way = page.slots.length ? presentationOf(page, sounds) : "";
  const shown = way ? PRESENTATIONS[way](scene) : null;
  const matrix = page.questions.length >= ROWS && page.questions.every((one) => IN_ROWS.includes(one.kind) && one.kind === page.questions[0].kind);
  const asked = page.questions.map((question) =>
    questionOf(question, {
      language,
      layout: page.layout,
      room: room[0] - 32,
      matrix,
      value: answers[question.key],
      changed: (value) => {
        answers[question.key] = value;
        times[question.key] = Math.round(performance.now() - began);
        draft.keep(answers);
        changed();
      },
    }),
  );

  function missing() {
    const before = shown?.missing() ?? null;
    if (before !== null) return before;
    const reasons = asked.map((one, i) => one.missing(answers[page.questions[i].key])).filter((one) => one !== null);
    if (!reasons.length) return null;
    const own = reasons.find((one) => one.startsWith("="));
    if (own) return own.slice(1);
    if (reasons.length > 1 && reasons.every((one) => one === "answer")) return say(language, "need_answers", { count: reasons.length });
    return say(language, `need_${reasons[0]}`);
  }

  const form = make("form", { class: classesOf(page, way, matrix), "data-token": page.token, novalidate: true, autocomplete: "off" });
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (sent || performance.now() - began < FIRST_MS || missing() !== null) return;
    sent = true;
    next.disabled = true;
    const facts = Object.assign({}, ...asked.map((one) => one.facts), shown?.facts() ?? {}, sounds.facts());
    shown?.stop();
    const rt_ms = { "": Math.round(performance.now() - began), ...times };
    send({ answers: { ...answers }, rt_ms, facts });
  });
  const questions = make("section", { class: "asked" }, ...(matrix ? [rowHead(page.questions[0])] : []).filter(Boolean), ...asked.map((one) => one.element));
  const small = asked.find((one) => one.facts.vas_mm < one.facts.vas_asked_mm - 0.05);
  if (small) questions.append(smallNote(language, small.facts.vas_asked_mm, small.facts.vas_mm));
  form.append(
    make("section", { class: "lead-in" }, ...leadIn(page, language)),
    ...(shown ? [make("section", { class: "stimuli" }, shown.element)] : []),
    questions,
    make("div", { class: "foot" }, reason, next),
  );
  stage.replaceChildren(form);
  form.querySelector("[tabindex='-1']")?.focus();
  changed();
  return { stop: () => shown?.stop(), hush: () => (shown?.hush ?? shown?.stop)?.() };
}

const PRESENTATIONS = { areas, intervals, players };

/** Return how stimuli are presented: areas to stroke, two intervals in sequence, or a button each. */
function presentationOf(page, sounds) {
  const played = page.slots.every((slot) => slot.played);
  if (sounds.streamed && page.slots.some((slot) => slot.played)) return "areas";
  if (page.layout.area_mm && page.slots.length === 2 && played) return "areas";
  return page.layout.presentation === "intervals" ? "intervals" : "players";
}

/** Whether a page shows areas, pictures or lines of a size in millimetres. */
export function inMillimetres(page, sounds) {
  const line = page.questions.some((question) => question.kind === "vas");
  return line || page.slots.some((slot) => slot.picture) || (page.slots.length > 0 && presentationOf(page, sounds) === "areas");
}

function classesOf(page, way, matrix) {
  const questions = matrix ? ["with-matrix"] : way ? ["with-few"] : [];
  return ["page", `kind-${page.kind}`, ...(way ? [`presents-${way}`] : []), ...questions].join(" ");
}

function leadIn(page, language) {
  const parts = [];
  const { feedback, practice } = page.layout;
  if (feedback) parts.push(make("p", { class: feedback.correct ? "feedback right" : "feedback wrong", role: "status", text: feedback.text }));
  if (practice) parts.push(make("p", { class: "practice" }, make("strong", { text: say(language, "practice") }), " ", practice.text ?? ""));
  if (page.kind === "consent" || page.kind === "questions") {
    parts.push(make("h1", { tabindex: "-1", text: say(language, page.kind) }));
    if (page.text) parts.push(make("div", { class: "long-text", text: page.text.trim() }));
  } else {
    parts.push(make("h1", { tabindex: "-1", class: "instruction", text: page.text }));
  }
  return parts;
}

/** Return the labels of the scale's ends, above all rows. */
function rowHead(question) {
  const ends = endsOf(question);
  ends?.classList.add("row-head");
  return ends;
}

/** Show a screen between pages: a title, a text and a button to continue. */
export function showMoment(stage, { title, text, go, press, more = [] }) {
  const began = performance.now();
  const on = go ? [button(go, () => performance.now() - began >= FIRST_MS && press(), { class: "large primary" })] : [];
  stage.replaceChildren(make("div", { class: "moment" }, make("h1", { tabindex: "-1", text: title }), make("p", { class: "lead", text }), ...more, ...on));
  stage.querySelector("h1").focus();
}
