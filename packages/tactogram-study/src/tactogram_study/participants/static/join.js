/** The first page: choose a language, begin as a new participant, or continue with a code. */

import { deviceFacts } from "./device.js";
import { button, holdStill, make, tell } from "./dom.js";
import { ask, insist, statusOf } from "./server.js";
import { guessed, nameOf, preferred, remedy, say } from "./wording.js";

const base = location.pathname.replace(/\/+$/, "");
const stage = document.getElementById("stage");
const head = document.getElementById("head");
const ATTEMPT = "tactogram.attempt";
const UNFINISHED = "tactogram.unfinished";
let study = null;
let language = guessed;
let busy = false;

/** Return the id of this person's attempt to begin: sent twice, it makes one participant. */
function attempt() {
  try {
    const kept = sessionStorage.getItem(ATTEMPT) ?? drawn();
    sessionStorage.setItem(ATTEMPT, kept);
    return kept;
  } catch {
    return drawn();
  }
}

const drawn = () => Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");

/** Return the participant who began on this device and has not finished. */
function unfinished() {
  try {
    const found = JSON.parse(localStorage.getItem(UNFINISHED) ?? "null");
    return found && found.join === base ? found : null;
  } catch {
    return null;
  }
}

async function join(code) {
  if (busy) return;
  busy = true;
  tell("");
  try {
    const body = { code, language, device: deviceFacts(), ...(code ? {} : { attempt: attempt() }) };
    const made = await ask(base, body);
    try {
      sessionStorage.removeItem(ATTEMPT);
      localStorage.setItem(UNFINISHED, JSON.stringify({ join: base, ticket: made.ticket, code: made.code }));
    } catch {
      // Without storage the code leads back.
    }
    location.href = `/take/${made.ticket}`;
  } catch (error) {
    const status = statusOf(error);
    tell(code && status === 404 ? say(language, "unknown_code") : remedy(language, status));
    busy = false;
  }
}

function show() {
  document.documentElement.lang = language;
  const title = typeof study.title === "string" ? study.title : (study.title[language] ?? "");
  document.title = title;
  head.replaceChildren(make("span", { class: "title", text: title }));
  const languages = study.languages.map((one) =>
    make("button", { type: "button", class: "large", lang: one, "aria-pressed": String(one === language), text: nameOf(one), onclick: () => choose(one) }),
  );
  const code = make("input", { type: "text", id: "code", class: "number", autocomplete: "off", autocapitalize: "characters", spellcheck: "false", maxlength: 16, "aria-describedby": "code-hint", oninput: () => (go.disabled = code.value.trim() === "") });
  const go = make("button", { type: "submit", class: "large", text: say(language, "go_on"), disabled: true });
  const form = make("form", { class: "by-code", autocomplete: "off" }, make("label", { for: "code", text: say(language, "go_on_by_code") }), make("p", { class: "quiet", id: "code-hint", text: say(language, "code_asked") }), make("div", { class: "row" }, code, go));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const given = code.value.normalize("NFKC").trim();
    if (given) join(given);
  });
  const known = unfinished();
  const back = known
    ? [make("p", { class: "lead", text: say(language, "was_here") }), button(say(language, "go_on_as", { code: known.code }), () => (location.href = `/take/${known.ticket}`), { class: "large primary" })]
    : [];
  const begin = button(say(language, "begin"), () => join(""), { class: known ? "large" : "large primary" });
  const parts = [make("h1", { tabindex: "-1", text: title })];
  if (study.languages.length > 1) parts.push(make("p", { class: "lead", text: say(language, "language") }), make("div", { class: "row" }, ...languages));
  parts.push(...back, begin, make("p", { class: "divider", text: say(language, "or") }), form);
  stage.replaceChildren(make("div", { class: "moment join" }, ...parts));
}

function choose(chosen) {
  language = chosen;
  show();
}

async function start() {
  holdStill();
  try {
    study = await insist(() => ask(`${base}/study`), (away, status) => tell(away ? remedy(language, status) : ""));
  } catch {
    stage.replaceChildren(make("div", { class: "moment" }, make("h1", { text: say(language, "no_ticket") })));
    return;
  }
  language = preferred(study.languages);
  show();
}

start();
