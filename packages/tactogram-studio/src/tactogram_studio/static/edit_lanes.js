/** Lanes of the timeline: a track's amplitude with its transients, and its frequency. */

const HEIGHTS = { amplitude: 112, frequency: 64 };
const EDGE_PX = 9;
/** Room left of 0 s. */
export const LEFT_PX = 12;
const HIT_PX = 12;
const LEAST_S = 0.001;
/** Steps of the arrow keys, and with Shift. */
const STEPS = { amplitude: [0.05, 0.01], frequency: [10, 1] };

/** @param {string} name @param {Record<string, any>} values @returns {SVGElement} */
export function svg(name, values) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(values)) made.setAttribute(key, String(value));
  return made;
}

/** @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2 @param {string} kind */
export const line = (x1, y1, x2, y2, kind) => svg("line", { x1, y1, x2, y2, class: kind });

/** Return the items of a line as times and values. @param {any} track @param {string} name @returns {{time: number, value: number}[]} */
export function itemsOf(track, name) {
  if (name === "transients") return track.transients.map((/** @type {any} */ one) => ({ time: one.time, value: one.amplitude }));
  if (name === "tones") return track.transients.map((/** @type {any} */ one) => ({ time: one.time, value: one.frequency }));
  return track[name];
}

/** Stretch a selection. @param {SVGElement} rect @param {number} from @param {number} to @param {number} scale */
export function sweep(rect, from, to, scale) {
  rect.setAttribute("x", String(LEFT_PX + Math.min(from, to) * scale));
  rect.setAttribute("width", String(Math.abs(to - from) * scale));
}

export class Lane {
  /** @param {any} track @param {number} number @param {string} name @param {any} view */
  constructor(track, number, name, view) {
    Object.assign(this, { track, number, name, view });
    this.height = HEIGHTS[name];
    this.top = name === "amplitude" ? 1 : Math.max(400, ...itemsOf(track, "frequency").map((p) => p.value), ...itemsOf(track, "tones").map((p) => p.value));
    this.least = name === "amplitude" ? 0 : 20;
    this.drawn = svg("svg", { class: "lane", width: view.width, height: this.height, "data-line": name, "data-lane": `${number} ${name}`, role: "group",
      "aria-label": name === "amplitude" ? "Amplitude and transients, 0 to 1" : `Frequency, 0 to ${this.top} Hz` });
    this.frame();
    this.curve();
    this.items(name === "amplitude" ? "amplitude" : "frequency");
    this.items(name === "amplitude" ? "transients" : "tones");
    this.listen();
  }

  /** @param {number} value */
  y(value) {
    return this.height - EDGE_PX - (value / this.top) * (this.height - 2 * EDGE_PX);
  }

  /** @param {{clientX: number, clientY: number}} event @returns {[number, number]} */
  place(event) {
    // While an item is dragged, the lane is drawn anew.
    const drawn = this.drawn.isConnected ? this.drawn : document.querySelector(`#timeline [data-lane="${this.number} ${this.name}"]`);
    const box = (drawn ?? this.drawn).getBoundingClientRect();
    const share = (this.height - EDGE_PX - (event.clientY - box.top)) / (this.height - 2 * EDGE_PX);
    const value = Math.min(this.top, Math.max(this.least, share * this.top));
    const digits = this.name === "amplitude" ? 1e3 : 1;
    return [Math.max(0, (event.clientX - box.left - LEFT_PX) / this.view.scale), Math.round(value * digits) / digits];
  }

  frame() {
    const marks = this.name === "amplitude" ? [0, 0.5, 1] : [0, this.top / 2, this.top];
    for (const value of marks) this.drawn.append(line(LEFT_PX, this.y(value), this.view.width, this.y(value), "grid"));
    const text = svg("text", { x: this.view.width - 4, y: this.y(this.top) + 12, "text-anchor": "end" });
    text.textContent = this.name === "amplitude" ? "amplitude, 0 to 1" : `frequency, 0 to ${this.top} Hz`;
    this.drawn.append(text);
  }

  curve() {
    const points = itemsOf(this.track, this.name);
    if (!points.length) return;
    const at = points.map((p) => [LEFT_PX + p.time * this.view.scale, this.y(p.value)]);
    if (this.name === "frequency") {
      at.unshift([LEFT_PX, at[0][1]]);
      at.push([this.view.width, at[at.length - 1][1]]);
    }
    const path = at.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join(" ");
    if (this.name === "amplitude") {
      const foot = this.y(0);
      this.drawn.append(svg("polygon", { class: "area", points: `${at[0][0]},${foot} ${path} ${at[at.length - 1][0]},${foot}` }));
    }
    this.drawn.append(svg("polyline", { class: "line", points: path }));
  }

  /** @param {string} name */
  items(name) {
    const gem = name === "transients" || name === "tones";
    const all = itemsOf(this.track, name);
    const current = this.view.item?.[0] === name ? this.view.item[1] : -1;
    all.forEach(({ time, value }, index) => {
      const x = LEFT_PX + time * this.view.scale, y = this.y(value);
      if (name === "transients") this.drawn.append(line(x, this.y(0), x, y, "stem"));
      const noun = { amplitude: "Amplitude point", frequency: "Frequency point", transients: "Transient", tones: "Frequency of transient" }[name];
      const amplitude = this.name === "amplitude";
      const made = svg("g", { class: "item", role: "slider", tabindex: index === Math.max(0, current) ? 0 : -1, "data-focus": `item ${this.number} ${name} ${index}`,
        "data-item": name, "aria-label": `${noun} ${index + 1} of ${all.length}`, "aria-orientation": "vertical", "aria-valuemin": this.least, "aria-valuemax": this.top,
        "aria-valuenow": value, "aria-valuetext": `${time} s, ${amplitude ? value : `${Math.round(value)} Hz`}`, "aria-current": index === current });
      made.append(svg("circle", { class: "hit", cx: x, cy: y, r: HIT_PX }));
      made.append(gem ? svg("path", { class: "gem", d: `M${x},${y - 6} l6,6 l-6,6 l-6,-6 z` }) : svg("circle", { class: "dot", cx: x, cy: y, r: 4.5 }));
      made.addEventListener("pointerdown", (event) => this.drag(event, name, index));
      made.addEventListener("keydown", (event) => this.key(event, name, index));
      this.drawn.append(made);
    });
  }

  /** Return a place that an item can have. @param {string} name @param {number} index @param {number} time @returns {number} */
  free(name, index, time) {
    const all = itemsOf(this.track, name);
    if (name === "transients" || name === "tones") return Math.max(0, time);
    const before = index > 0 ? all[index - 1].time + LEAST_S : 0;
    const after = index + 1 < all.length ? all[index + 1].time - LEAST_S : 60;
    return Math.min(after, Math.max(before, time));
  }

  /** @param {PointerEvent} event @param {string} name @param {number} index */
  drag(event, name, index) {
    event.stopPropagation();
    event.preventDefault();
    const begun = this.place(event);
    const old = itemsOf(this.track, name)[index];
    let moved = false, last = [old.time, old.value];
    const move = (/** @type {PointerEvent} */ at) => {
      const [time, value] = this.place(at);
      if (!moved && Math.hypot((time - begun[0]) * this.view.scale, at.clientY - event.clientY) < 3) return;
      moved = true;
      last = [this.free(name, index, this.view.snapped(old.time + time - begun[0])), value];
      this.view.local(this.number, [name, index], last[0], last[1]);
    };
    const up = () => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", up);
      removeEventListener("pointercancel", up);
      if (moved) this.view.send({ do: "move", track: this.number, line: name, index, time: last[0], value: last[1] });
      else this.view.send({ do: "select", track: this.number, line: name, index });
      const focus = document.querySelector(`#timeline [data-focus="item ${this.number} ${name} ${index}"]`);
      if (focus instanceof SVGElement) focus.focus({ preventScroll: true });
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", up);
    addEventListener("pointercancel", up);
  }

  /** @param {KeyboardEvent} event @param {string} name @param {number} index */
  key(event, name, index) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const all = itemsOf(this.track, name);
    const { time, value } = all[index];
    const step = STEPS[this.name][event.shiftKey ? 1 : 0];
    const seconds = event.shiftKey ? LEAST_S : this.view.snap;
    const moves = { ArrowLeft: [-seconds, 0], ArrowRight: [seconds, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    const others = { PageDown: index + 1, PageUp: index - 1, Home: 0, End: all.length - 1 };
    if (event.key in moves) {
      const [dt, dv] = moves[event.key];
      const to = this.free(name, index, Math.round((time + dt) * 1e6) / 1e6);
      const level = Math.min(this.name === "amplitude" ? 1 : 1000, Math.max(this.least, Math.round((value + dv) * 1e3) / 1e3));
      this.view.local(this.number, [name, index], to, level);
      this.view.send({ do: "move", track: this.number, line: name, index, time: to, value: level, nudge: true });
    } else if (event.key in others) {
      const at = Math.min(all.length - 1, Math.max(0, others[event.key]));
      this.view.send({ do: "select", track: this.number, line: name, index: at });
    } else if (event.key === "Delete" || event.key === "Backspace") {
      this.view.send({ do: "remove", track: this.number, line: name, index });
    } else if (event.key === "Enter" && index + 1 < all.length && name === this.name) {
      const next = all[index + 1];
      this.view.send({ do: "add", track: this.number, line: name, time: (time + next.time) / 2, value: (value + next.value) / 2 });
    } else return;
    event.preventDefault();
  }

  /** Listen on the empty lane: a double click adds a point, a drag selects or draws. */
  listen() {
    const { view } = this;
    this.drawn.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      const points = [this.place(event)];
      const begun = view.snapped(points[0][0]);
      const trace = svg("polyline", { class: "line", points: "" });
      const swept = svg("rect", { class: "selected", y: 0, height: this.height, width: 0 });
      if (view.tool === "draw") this.drawn.append(trace);
      if (view.tool === "select") this.drawn.append(swept);
      const move = (/** @type {PointerEvent} */ at) => {
        points.push(this.place(at));
        trace.setAttribute("points", points.map(([t, v]) => `${LEFT_PX + t * view.scale},${this.y(v)}`).join(" "));
        sweep(swept, begun, view.snapped(this.place(at)[0]), view.scale);
      };
      const up = (/** @type {PointerEvent} */ at) => {
        removeEventListener("pointermove", move);
        removeEventListener("pointerup", up);
        removeEventListener("pointercancel", up);
        const [time, value] = this.place(at);
        const click = Math.abs(at.clientX - event.clientX) < 3 && Math.abs(at.clientY - event.clientY) < 3;
        if (view.tool === "transient") {
          if (this.name === "amplitude") view.send({ do: "add", track: this.number, line: "transients", time: view.snapped(time), value });
        } else if (view.tool === "draw") {
          if (click) view.send({ do: "add", track: this.number, line: this.name, time: view.snapped(time), value });
          else view.send({ do: "draw", track: this.number, line: this.name, points: points.slice(0, 5000).map(([t, v]) => ({ time: t, value: v })) });
        } else {
          view.send({ do: "select", track: this.number });
          view.send({ do: "range", start: begun, end: click ? begun : view.snapped(time) });
        }
      };
      addEventListener("pointermove", move);
      addEventListener("pointerup", up);
      addEventListener("pointercancel", up);
    });
    this.drawn.addEventListener("dblclick", (event) => {
      if (view.tool !== "select" || (event.target instanceof Element && event.target.closest(".item"))) return;
      const [time, value] = this.place(event);
      view.send({ do: "add", track: this.number, line: this.name, time: view.snapped(time), value });
    });
  }
}
