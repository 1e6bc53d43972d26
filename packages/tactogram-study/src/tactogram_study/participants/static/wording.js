/** Texts of the pages, from the language files. Texts of a study come from the server. */

import TEXTS from "/participants/languages.js";

const primary = (language) => language.toLowerCase().split("-")[0];
const textsIn = (language) => TEXTS[language] ?? TEXTS[primary(language)] ?? TEXTS.en;

/** Return a text, with each `{name}` replaced by its value. */
export function say(language, key, values = {}) {
  return textsIn(language)[key].replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}

const REMEDIES = { 0: "waiting", 404: "no_ticket", 423: "display_busy", 429: "too_many" };

/** Return what a participant can do about a refusal with a status; the server's own sentence is for its log. */
export const remedy = (language, status) => say(language, REMEDIES[status] ?? (status >= 500 ? "problem" : "refused"));

/** Return the name of a language in itself. */
export const nameOf = (language) => (TEXTS[language] ?? TEXTS[primary(language)])?.name ?? language;

/** Return the language among those given that the browser prefers, or the first. */
export function preferred(languages) {
  for (const wanted of navigator.languages ?? [navigator.language]) {
    const found = languages.find((one) => one.toLowerCase() === wanted.toLowerCase()) ?? languages.find((one) => primary(one) === primary(wanted));
    if (found) return found;
  }
  return languages[0];
}

/** The language before the study's are known. */
export const guessed = preferred(["en", ...Object.keys(TEXTS)]);

/** Return names as a list in the language. */
export function joined(language, names) {
  if (names.length < 2) return names.join("");
  return names.slice(0, -1).join(say(language, "comma")) + say(language, "and") + names[names.length - 1];
}
