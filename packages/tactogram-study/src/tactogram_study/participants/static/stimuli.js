/** Stimuli of a page: buttons that play them, two intervals in sequence, and images. */

import { button, make } from "./dom.js";
import { fitting, pxPerMm } from "./millimetres.js";
import { joined, say } from "./wording.js";

/** Silence between two intervals, ms. */
export const BETWEEN_MS = 500;
/** Size of an image where the study sets none, mm. */
const IMAGE_MM = 60;
/** Largest share of the screen's width and height for an image. */
const IMAGE_SHARE = { width: 0.8, height: 0.3 };

/**
 * Page data that a stimulus view needs.
 * @typedef {object} Scene
 * @property {string} language
 * @property {any} page as `Page.shown` gives it
 * @property {any} sounds `BrowserSounds` or `ServerSounds`
 * @property {Map<string, string>} images addresses by slot
 * @property {() => void} changed
 * @property {(key: string) => void} failed
 * @property {[number, number]} room width and height, CSS pixels
 */

/** Return the slots of a page, each with its picture, its text and a button to play it. */
export function players(scene) {
  const { page, language } = scene;
  const views = page.slots.map((slot) => playerOf(slot, scene));
  const element = make("div", { class: `players count-${views.length}` }, ...views.map((view) => view.element));
  const missing = () => {
    const names = views.filter((view) => view.needed()).map((view) => view.name);
    if (!names.length) return null;
    if (names.length === 1 && names[0] === "") return say(language, "need_play_one");
    return say(language, "need_play", { names: joined(language, names) });
  };
  const facts = () => Object.assign({}, ...views.map((view) => view.facts()));
  return { element, missing, facts, stop: () => scene.sounds.hush() };
}

function playerOf(slot, scene) {
  const { language, sounds } = scene;
  const name = slot.slot;
  const card = make("div", { class: "player" });
  let plays = 0;
  if (name) card.append(make("div", { class: "slot-name", text: name }));
  const picture = slot.picture ? imageOf(slot, scene) : null;
  if (picture) card.append(picture.element);
  if (slot.text) card.append(make("p", { class: "to-do", text: slot.text }));
  if (slot.played) {
    const label = name ? say(language, "play", { name }) : say(language, "play_one");
    const press = button(label, play, { class: "large play", "data-play": name });
    const state = make("span", { class: "state", role: "status" });
    card.append(press, state);
    async function play() {
      sounds.hush();
      for (const other of document.querySelectorAll(".playing")) other.classList.remove("playing");
      card.classList.add("playing");
      state.textContent = say(language, "playing");
      const whole = await sounds.play(name).ended.catch(() => false);
      card.classList.remove("playing");
      if (whole) plays += 1;
      state.textContent = plays ? say(language, "played") : "";
      card.classList.toggle("was-played", plays > 0);
      scene.changed();
    }
  }
  return {
    element: card,
    name,
    needed: () => slot.played && plays === 0,
    facts: () => ({ ...(slot.played ? { [`plays${suffix(name)}`]: plays } : {}), ...(picture?.facts ?? {}) }),
  };
}

const suffix = (name) => (name ? `_${name.toLowerCase()}` : "");

function imageOf(slot, scene) {
  const { page, language, room } = scene;
  const scale = pxPerMm();
  const asked = page.layout.image_mm ?? IMAGE_MM;
  const share = page.layout.image_mm ? 1 : IMAGE_SHARE.height;
  const mm = fitting(asked, Math.min(IMAGE_SHARE.width * room[0], share * innerHeight), scale);
  const alt = slot.slot ? say(language, "image_of", { name: slot.slot }) : say(language, "image");
  const element = make("img", { class: "picture", src: scene.images.get(slot.slot), alt, draggable: "false" });
  element.style.width = `${mm * scale}px`;
  element.style.height = `${mm * scale}px`;
  return { element, facts: { image_mm: mm, ...(page.layout.image_mm && mm < asked ? { image_asked_mm: asked } : {}) } };
}

/** Return two intervals that play in sequence, each marked while it plays. */
export function intervals(scene) {
  const { page, language, sounds } = scene;
  let plays = 0;
  const boxes = page.slots.map((slot) => make("div", { class: "interval", text: slot.slot }));
  const state = make("p", { class: "state", role: "status" });
  let round = 0;
  const play = async () => {
    const own = (round += 1);
    sounds.hush();
    for (const box of boxes) box.classList.remove("playing");
    press.disabled = true;
    let whole = true;
    const seconds = Math.max(...page.slots.map((slot) => sounds.seconds(slot.slot) ?? 0));
    for (const [place, slot] of page.slots.entries()) {
      if (place) await new Promise((resolve) => setTimeout(resolve, BETWEEN_MS));
      if (own !== round) return;
      boxes[place].classList.add("playing");
      state.textContent = `${slot.slot} · ${say(language, "playing")}`;
      whole = (await sounds.play(slot.slot, { seconds }).ended.catch(() => false)) && whole;
      boxes[place].classList.remove("playing");
    }
    press.disabled = false;
    state.textContent = "";
    if (whole) plays += 1;
    for (const box of boxes) box.classList.toggle("was-played", plays > 0);
    scene.changed();
  };
  const press = button(say(language, "play_both"), play, { class: "large play", "data-play": "both" });
  const element = make("div", { class: "intervals" }, make("div", { class: "row" }, ...boxes), press, state);
  return {
    element,
    missing: () => (plays ? null : say(language, "need_play", { names: joined(language, page.slots.map((slot) => slot.slot)) })),
    facts: () => ({ plays }),
    stop: () => {
      round += 1;
      sounds.hush();
      press.disabled = false;
    },
  };
}
