/**
 * The timeline of the page Edit: draws an effect's tracks and reports what a hand or a key does to them.
 *
 * The server edits (`tactogram.rendering.effects`): each action is an event `edit`, and the effect that it leads to comes
 * back through `draw`. Only what a drag or a held key moves is moved here first, so that it follows at once.
 */

import { LEFT_PX, Lane, itemsOf, line, svg, sweep } from "./edit_lanes.js";

const RULER_PX = 26;
const state = {
  /** @type {any} */ effect: { tracks: [] },
  track: 0,
  /** @type {[string, number] | null} */ item: null,
  /** @type {[number, number] | null} */ range: null,
  cursor: 0,
  zoom: 1,
  snap: 0.01,
  tool: "select",
  sent: 0,
};
const root = await drawnPage();

/** Return the timeline once the page is drawn and connected: what is sent earlier may be lost. @returns {Promise<HTMLElement>} */
async function drawnPage() {
  for (;;) {
    const found = document.getElementById("timeline");
    if (found && window.did_handshake) return found;
    await new Promise(requestAnimationFrame);
  }
}

/** @param {Record<string, any>} event */
function send(event) {
  state.sent += 1;
  window.emitEvent("edit", { ...event, number: state.sent });
}

/** Seconds shown. */
const shownSeconds = () => {
  const end = Math.max(0, state.cursor, ...state.effect.tracks.map((/** @type {any} */ t) => t.end));
  return Math.max(1, Math.ceil(end * 1.15 * 10) / 10);
};

/** @param {number} seconds */
const snapped = (seconds) => {
  const step = state.snap || 0.001;
  return Math.max(0, Math.round(Math.round(seconds / step) * step * 1e6) / 1e6);
};

/** Draw the effect that the server sends, unless a later action is on its way. @param {any} now */
function draw(now) {
  if (now.number && now.number < state.sent) return;
  Object.assign(state, { effect: now.effect, track: now.track, item: now.item, range: now.range, cursor: now.cursor });
  root.dataset.sound = now.sound;
  redraw();
}

function redraw() {
  const focused = document.activeElement instanceof Element ? document.activeElement.closest("#timeline [data-focus]")?.getAttribute("data-focus") : null;
  const scroll = root.scrollLeft;
  const seen = root.clientWidth || 600;
  const seconds = shownSeconds();
  const width = Math.max(seen, Math.round(seen * state.zoom));
  const scale = (width - 2 * LEFT_PX) / seconds;
  const wide = document.createElement("div");
  wide.className = "edit-wide";
  wide.style.width = `${width}px`;
  root.style.setProperty("--seen", `${seen}px`);
  wide.append(ruler(width, seconds, scale));
  state.effect.tracks.forEach((/** @type {any} */ track, /** @type {number} */ number) => wide.append(trackOf(track, number, width, scale)));
  if (!state.effect.tracks.length) {
    const empty = document.createElement("p");
    empty.className = "edit-empty";
    empty.textContent = "Empty. Choose a ready effect, open a file, or add a track to draw on.";
    wide.append(empty);
  }
  const head = document.createElement("div");
  head.className = "edit-head";
  head.style.setProperty("--sounding", `${state.effect.seconds * scale}px`);
  head.setAttribute("data-player-head", root.dataset.sound ?? "");
  head.setAttribute("aria-hidden", "true");
  wide.append(head);
  root.replaceChildren(wide);
  root.scrollLeft = scroll;
  root.dataset.drawn = String(Number(root.dataset.drawn ?? 0) + 1);
  if (focused) {
    const item = state.item ? `item ${state.track} ${state.item[0]} ${state.item[1]}` : "";
    const at = focused.startsWith("item") && item ? item : focused;
    const again = root.querySelector(`[data-focus="${at}"]`) ?? root.querySelector('[data-focus="ruler"]');
    if (again instanceof HTMLElement || again instanceof SVGElement) again.focus({ preventScroll: true });
  }
}

/** @param {number} width @param {number} seconds @param {number} scale */
function ruler(width, seconds, scale) {
  const drawn = svg("svg", { class: "ruler", width, height: RULER_PX, tabindex: 0, role: "slider", "data-focus": "ruler",
    "aria-label": "Cursor", "aria-valuemin": 0, "aria-valuemax": 60, "aria-valuenow": state.cursor, "aria-valuetext": cursorText() });
  const step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10].find((s) => s * scale > 56) ?? 20;
  for (let n = 0; n * step <= seconds + 1e-9; n++) {
    const x = LEFT_PX + n * step * scale;
    drawn.append(line(x, RULER_PX - 7, x, RULER_PX, "grid"));
    const text = svg("text", { x: x + 3, y: 13 });
    text.textContent = n === 0 ? "0 s" : String(Math.round(n * step * 100) / 100);
    drawn.append(text);
  }
  selection(drawn, RULER_PX, scale);
  const x = LEFT_PX + state.cursor * scale;
  drawn.append(svg("path", { class: "handle", d: `M${x - 6},${RULER_PX - 9} h12 l-6,9 z` }));
  /** @type {number | null} */
  let begun = null;
  const at = (/** @type {PointerEvent} */ event) => snapped((event.clientX - drawn.getBoundingClientRect().left - LEFT_PX) / scale);
  const swept = svg("rect", { class: "selected", y: 0, height: RULER_PX, width: 0 });
  drawn.append(swept);
  drawn.addEventListener("pointerdown", (event) => { begun = at(event); drawn.setPointerCapture(event.pointerId); });
  drawn.addEventListener("pointermove", (event) => { if (begun !== null) sweep(swept, begun, at(event), scale); });
  drawn.addEventListener("pointerup", (event) => {
    if (begun !== null) send({ do: "range", start: begun, end: at(event) });
    begun = null;
  });
  drawn.addEventListener("keydown", rulerKey);
  return drawn;
}

const cursorText = () => (state.range ? `${state.range[0]} to ${state.range[1]} s selected` : `${state.cursor} s`);

/** @param {KeyboardEvent} event */
function rulerKey(event) {
  const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (event.key === "Home") {
    Object.assign(state, { cursor: 0, range: null }); // before the server does: the next key goes on from here
    send({ do: "range", start: 0, end: 0 });
    redraw();
  } else if (way === undefined) return;
  else {
    const [start, end] = state.range ?? [state.cursor, state.cursor];
    const moved = snapped((event.shiftKey ? end : start) + way * (state.snap || 0.001));
    if (event.shiftKey) Object.assign(state, { range: [start, Math.max(start, moved)] });
    else Object.assign(state, { cursor: moved, range: null });
    send({ do: "range", start: event.shiftKey ? start : moved, end: event.shiftKey ? Math.max(start, moved) : moved });
    redraw();
  }
  event.preventDefault();
}

/** Draw the selected range and the cursor into a lane. @param {SVGElement} drawn @param {number} height @param {number} scale */
function selection(drawn, height, scale) {
  if (state.range) {
    const [start, end] = state.range;
    drawn.append(svg("rect", { class: "selected", x: LEFT_PX + start * scale, y: 0, width: (end - start) * scale, height }));
  }
  const x = LEFT_PX + state.cursor * scale;
  drawn.append(line(x, 0, x, height, "cursor"));
}

/** @param {any} track @param {number} number @param {number} width @param {number} scale */
function trackOf(track, number, width, scale) {
  const section = document.createElement("div");
  section.className = "track";
  section.dataset.muted = String(track.muted);
  section.setAttribute("role", "group");
  section.setAttribute("aria-label", `Track ${number + 1}: ${track.title}`);
  section.append(bar(track, number));
  for (const name of ["amplitude", "frequency"]) {
    const lane = new Lane(track, number, name, { width, scale, tool: state.tool, snapped, snap: state.snap || 0.001,
      item: state.track === number ? state.item : null, send, local });
    selection(lane.drawn, lane.height, scale);
    section.append(lane.drawn);
  }
  return section;
}

/** Move an item here before the server does. @param {number} number @param {[string, number]} item @param {number} time @param {number} value */
function local(number, item, time, value) {
  const [name, index] = item;
  const track = state.effect.tracks[number];
  const moved = itemsOf(track, name).map((one, n) => (n === index ? { ...one, time, value } : one));
  if (name === "amplitude" || name === "frequency") track[name] = moved;
  else {
    const key = name === "transients" ? "amplitude" : "frequency";
    track.transients = track.transients.map((/** @type {any} */ one, /** @type {number} */ n) => (n === index ? { ...one, time, [key]: value } : one));
  }
  Object.assign(state, { track: number, item });
  redraw();
}

/** @param {any} track @param {number} number */
function bar(track, number) {
  const made = document.createElement("div");
  made.className = "track-bar";
  const named = `of ${track.title}, track ${number + 1}`;
  const button = (/** @type {string} */ text, /** @type {string} */ label, /** @type {() => void} */ act, /** @type {boolean | null} */ pressed) => {
    const one = document.createElement("button");
    one.type = "button";
    one.textContent = text;
    if (label) one.setAttribute("aria-label", label);
    if (pressed !== null) one.setAttribute("aria-pressed", String(pressed));
    one.setAttribute("data-focus", `${text} ${number}`);
    one.addEventListener("click", act);
    return one;
  };
  const field = (/** @type {string} */ text, /** @type {string} */ what, /** @type {number} */ value, /** @type {number} */ most, /** @type {number} */ step) => {
    const label = document.createElement("label");
    const input = document.createElement("input");
    Object.assign(input, { type: "number", min: "0", max: String(most), step: String(step), value: String(value) });
    input.setAttribute("aria-label", `${text} ${named}`);
    input.setAttribute("data-focus", `${what} ${number}`);
    input.addEventListener("change", () => { if (input.value !== "") send({ do: what, track: number, value: Number(input.value) }); });
    label.append(`${text} `, input);
    return label;
  };
  const name = button(track.title, `Select ${track.title}, track ${number + 1}`, () => send({ do: "select", track: number }), number === state.track);
  name.classList.add("track-name");
  made.append(
    name,
    field("Start, s", "start", Math.round(track.start * 1e4) / 1e4, 60, state.snap || 0.001),
    field("Gain", "gain", track.gain, 2, 0.1),
    button("Mute", `Mute ${track.title}, track ${number + 1}`, () => send({ do: "mute", track: number }), track.muted),
    button("Remove", `Remove ${track.title}, track ${number + 1}`, () => send({ do: "drop", track: number }), null),
  );
  return made;
}

document.addEventListener("keydown", (event) => {
  if (event.target instanceof HTMLElement && event.target.closest("input, textarea, .q-dialog")) return;
  if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
  const key = event.key.toLowerCase();
  if (key !== "z" && key !== "y") return;
  event.preventDefault();
  send({ do: key === "y" || event.shiftKey ? "redo" : "undo" });
});
new ResizeObserver(() => redraw()).observe(root);
addEventListener("focus", () => send({ do: "ready" })); // another tab may have changed the effect

window.tactogramEdit = {
  draw,
  /** @param {number} by */
  zoom(by) { state.zoom = Math.min(32, Math.max(1, by ? state.zoom * by : 1)); redraw(); },
  /** @param {string} tool */
  tool(tool) { state.tool = tool; root.dataset.tool = tool; redraw(); },
  /** @param {number} seconds */
  snap(seconds) { state.snap = seconds; redraw(); },
  /** Add at the cursor, on the selected track. @param {string} name */
  add(name) {
    const track = state.effect.tracks[state.track];
    if (!track) return;
    const points = itemsOf(track, "amplitude");
    send({ do: "add", track: state.track, line: name, time: state.cursor, value: name === "transients" ? 0.8 : points.length ? 0.5 : 0.8 });
  },
};
send({ do: "ready" });
