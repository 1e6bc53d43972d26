/** Areas under the finger, a target that moves in each, and stimuli only while a finger strokes. */

import { make } from "./dom.js";
import { sampleOf } from "./finger.js";
import { areasIn, pxPerMm } from "./millimetres.js";
import { Drawn, Stroke, targetAt } from "./stroking.js";
import { joined, say } from "./wording.js";

/** Radius of the target, mm: about a fingertip. */
const TARGET_MM = 6;
/** Speed at which keys stroke where the study sets no target, mm/s. */
const KEYS_MM_S = 100;
/** How long each area is to be stroked before the page goes on, ms. */
export const ENOUGH_MS = 1000;
const GAP_PX = 34;
/** Width and height of an area where the study sets none, mm. */
const AREA_MM = [120, 25];

/**
 * Return the areas of a page.
 * @param {import("./stimuli.js").Scene} scene
 */
export function areas(scene) {
  const { page, language, room } = scene;
  const scale = pxPerMm();
  const { image_mm: image, area_mm: asked = image ? [image, image] : AREA_MM } = page.layout;
  const placed = areasIn(asked, room, scale, GAP_PX, page.slots.length);
  const size = { width: placed.width, height: placed.height, way: placed.width - 2 * TARGET_MM };
  const speed = page.layout.target_speed_mm_s ?? KEYS_MM_S;
  const clock = { start: performance.now(), now: () => performance.now() };
  const pads = page.slots.map((slot) => padOf(slot, scene, { ...size, scale, speed, clock }));
  const drawn = new Drawn();
  let frame = 0;
  const draw = (ms) => {
    // The frame's own time, not the time at which its callback ran.
    const passed = ms - clock.start;
    const x = targetAt(passed, speed, size.way);
    const sweep = Math.floor((speed * passed) / 1000 / size.way);
    drawn.frame(passed, x, sweep !== draw.sweep);
    draw.sweep = sweep;
    for (const pad of pads) pad.draw(x, clock.now());
    frame = requestAnimationFrame(draw);
  };
  frame = requestAnimationFrame(draw);
  const element = make("div", { class: placed.beside ? "areas beside" : "areas" }, ...pads.map((pad) => pad.element));
  if (!placed.whole) element.append(areaNote(language, asked, placed));
  return {
    element,
    missing: () => {
      const names = pads.filter((pad) => pad.needed()).map((pad) => pad.name);
      if (names.length === 1 && names[0] === "") return say(language, "need_stroke_one");
      return names.length ? say(language, "need_stroke", { names: joined(language, names) }) : null;
    },
    facts: () => measuredBy(pads, drawn, size, placed),
    stop: () => {
      cancelAnimationFrame(frame);
      for (const pad of pads) pad.stop();
    },
    hush: () => pads.forEach((pad) => pad.stop()),
  };
}

/** Return a note that a line is shorter than the study sets it. */
export function smallNote(language, asked, drawn) {
  return noteOf(language, String(Math.round(asked)), String(Math.round(drawn)), asked);
}

function areaNote(language, [width, height], drawn) {
  const size = (one, other) => `${Math.round(one)} × ${Math.round(other)}`;
  return noteOf(language, size(width, height), size(drawn.width, drawn.height), width);
}

function noteOf(language, asked, drawn, widest) {
  const turn = innerHeight > innerWidth && innerHeight / pxPerMm() > widest + 10 ? ` ${say(language, "turn")}` : "";
  return make("p", { class: "note", role: "note", text: say(language, "too_small", { asked, drawn }) + turn });
}

function padOf(slot, scene, { width, height, way, scale, speed, clock }) {
  const { language, sounds } = scene;
  const name = slot.slot;
  // Without a speed nothing is to be followed; keys still stroke as the target would.
  const target = make("div", { class: "target", hidden: !scene.page.layout.target_speed_mm_s });
  const pad = make("div", { class: "pad", role: "button", tabindex: "0", "aria-label": say(language, "area_label", { name }), "data-area": name }, target);
  if (slot.picture) pad.style.background = `center / 100% 100% url("${scene.images.get(name)}")`;
  pad.style.width = `${width * scale}px`;
  pad.style.height = `${height * scale}px`;
  target.style.width = target.style.height = `${2 * TARGET_MM * scale}px`;
  target.style.marginLeft = target.style.marginTop = `${-TARGET_MM * scale}px`;
  const label = make("div", { class: "area-name" }, name ? say(language, "area", { name }) : "", make("span", { class: "state" }));
  const todo = slot.text ? [make("p", { class: "to-do", text: slot.text })] : [];
  const element = make("div", { class: "area" }, label, ...todo, pad);
  const stroke = new Stroke();
  let voice = null;
  let pointer = null;
  let kind = null;
  let sounded = 0;
  let since = null;

  const sound = (stroked, ms) => {
    // Only sound that the device is playing can be felt.
    const on = stroked && voice.audible();
    if (on === (since !== null)) return;
    if (on) since = ms;
    else {
      sounded += ms - since;
      since = null;
    }
    voice?.let(on);
    pad.classList.toggle("sounding", on);
    if (!on && sounded >= ENOUGH_MS && label.lastChild.textContent === "") label.lastChild.textContent = ` · ${say(language, "area_done")}`;
    scene.changed();
  };
  const begin = () => {
    voice?.stop();
    voice = sounds.play(name, { loop: true });
  };
  const end = () => {
    sound(false, clock.now());
    stroke.up();
    voice?.stop();
    voice = null;
    pointer = null;
  };
  const at = (event) => {
    const box = pad.getBoundingClientRect();
    const x = (event.clientX - box.left - pad.clientLeft) / scale;
    const y = (event.clientY - box.top - pad.clientTop) / scale;
    return { x, y, inside: x >= 0 && y >= 0 && x <= width && y <= height };
  };
  const strokedByKey = (x, ms) => {
    const box = pad.getBoundingClientRect();
    const clientX = box.left + (TARGET_MM + x) * scale;
    return sampleOf({ clientX, clientY: box.top + box.height / 2, timeStamp: ms }, true);
  };
  const goal = (ms) => TARGET_MM + targetAt(ms - clock.start, speed, way);

  pad.addEventListener("pointerdown", (event) => {
    if (pointer !== null || event.button || !slot.played) return;
    event.preventDefault();
    pad.setPointerCapture(event.pointerId);
    pointer = event.pointerId;
    kind = event.pointerType;
    begin();
    const place = at(event);
    stroke.down(event.timeStamp, place.x, place.y);
    voice.moved?.([sampleOf(event, place.inside)]);
  });
  pad.addEventListener("pointermove", (event) => {
    if (event.pointerId !== pointer) return;
    const all = event.getCoalescedEvents?.() ?? [];
    const reports = all.length ? all : [event];
    for (const one of reports) {
      const place = at(one);
      if (place.inside) stroke.moved(one.timeStamp, place.x, place.y, goal(one.timeStamp));
      else stroke.up();
    }
    voice.moved?.(reports.map((one) => sampleOf(one, at(one).inside)));
    sound(stroke.stroking, event.timeStamp);
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
    pad.addEventListener(name, (event) => event.pointerId === pointer && end());
  }
  pad.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (event.repeat || pointer !== null || !slot.played) return;
    pointer = "key";
    kind = "keyboard";
    begin();
    sound(true, clock.now());
  });
  for (const name of ["keyup", "blur"]) pad.addEventListener(name, () => pointer === "key" && end());

  return {
    element,
    name,
    stroke,
    kind: () => kind,
    needed: () => slot.played && sounded + (since === null ? 0 : clock.now() - since) < ENOUGH_MS,
    sounded: () => sounded,
    stop: end,
    /** @param {number} x mm, of the target */
    draw: (x, ms) => {
      target.style.transform = `translateX(${(TARGET_MM + x) * scale}px)`;
      if (pointer === "key") {
        voice.moved?.([strokedByKey(x, ms)]);
        sound(true, ms);
        scene.changed();
        return;
      }
      voice?.beat?.(ms);
      if (since !== null && !stroke.strokes(ms)) sound(false, ms);
    },
  };
}

function measuredBy(pads, drawn, size, placed) {
  const facts = {
    target_speed_mm_s: drawn.speed,
    refresh_hz: drawn.refresh,
    area_width_mm: size.width,
    area_height_mm: size.height,
    areas: placed.beside ? "beside each other" : "above each other",
    pointer: pads.map((pad) => pad.kind()).find(Boolean),
  };
  const stroked = pads.filter((pad) => pad.stroke.ms > 0);
  const ms = stroked.reduce((sum, pad) => sum + pad.stroke.ms, 0);
  if (ms > 0) {
    facts.finger_speed_mm_s = (1000 * stroked.reduce((sum, pad) => sum + pad.stroke.path, 0)) / ms;
    const samples = stroked.reduce((sum, pad) => sum + pad.stroke.samples, 0);
    facts.followed_mm = stroked.reduce((sum, pad) => sum + pad.stroke.apart, 0) / samples;
  }
  for (const pad of pads) {
    facts[`finger_speed_mm_s_${pad.name.toLowerCase()}`] = pad.stroke.speed;
    facts[`sounded_ms_${pad.name.toLowerCase()}`] = Math.round(pad.sounded());
  }
  return facts;
}
