/** `<tactogram-pad src="corduroy.json">`: a texture to stroke, in any page. One file: its own worklet, too. */

import { decoded, readDocument } from "./touch_document.js";
import { Pad } from "./touch_pad.js";
import { SAFE_DB, Sound } from "./touch_sound.js";
import { Vibration } from "./touch_vibration.js";
import {} from "./touch_worklet.js";

const STYLES = `
:host { display: block; font: 15px/1.4 system-ui, sans-serif; }
:host([hidden]) { display: none; }
.pad { position: relative; box-sizing: border-box; height: var(--tactogram-pad-height, 18rem); overflow: hidden; border-radius: 10px;
  border: 1px solid #75818c; background: #e6e9ec; cursor: none; touch-action: none; user-select: none;
  -webkit-user-select: none; -webkit-touch-callout: none; }
.pad:focus-visible { outline: 3px solid #0b5d66; outline-offset: 2px; box-shadow: 0 0 0 2px #ffffff; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; }
button { position: absolute; right: 0.75rem; bottom: 0.75rem; padding: 0.5rem 0.9rem; border: 2px solid #ffffff; border-radius: 8px;
  background: #0b5d66; color: #ffffff; font: inherit; font-weight: 600; cursor: pointer; }
button:focus-visible { outline: 3px solid #0b5d66; outline-offset: 2px; }
p { margin: 0.35rem 0 0; font-size: 0.85em; }
.error { padding: 0.5rem 0.75rem; border: 2px solid #b3261e; border-radius: 8px; }
`;
const KEYS = "Stroke it with a mouse, finger or pen. Keys: arrows stroke, faster with Shift; Space taps.";

/** A pad with the texture of the document at `src`. */
export class TactogramPad extends (globalThis.HTMLElement ?? Object) {
  static observedAttributes = ["src", "gain", "label"];

  /** Latest values from the audio thread: state, speed (mm/s), force (N), rms and peak (in `unit`). */
  report = { state: "lost", speed: 0, force: 0, rms: 0, peak: 0 };
  _open = false;

  get src() {
    return this.getAttribute("src") ?? "";
  }

  set src(address) {
    this.setAttribute("src", address);
  }

  /** Parts of full scale per unit of the texture; by default its largest sample is at -20 dB. */
  get gain() {
    const gain = Number(this.getAttribute("gain"));
    return gain > 0 ? gain : 10 ** (SAFE_DB / 20) / this._table.head.peak;
  }

  connectedCallback() {
    this._load();
  }

  disconnectedCallback() {
    this._close();
  }

  attributeChangedCallback(name) {
    if (!this.isConnected) return;
    if (name === "src") this._load();
    else if (this._pad) this._apply();
  }

  /** Show the document at `src`, or why it cannot be shown. */
  async _load() {
    this._close();
    const loading = (this._loading = {});
    const src = this.src;
    try {
      const { table, picture } = readDocument(await fetched(new URL(src, this.ownerDocument.baseURI)));
      const bitmap = picture && (await createImageBitmap(new Blob([decoded(picture.webp)], { type: "image/webp" })));
      if (loading === this._loading) this._show(table, { ...picture, bitmap });
    } catch (error) {
      if (loading === this._loading) this._draw(made("p", { className: "error", role: "alert", textContent: `${src || "src"}: ${error.message}` }));
    }
  }

  _show(table, picture) {
    this._table = table;
    const { name, simulated, follows, notes } = table.head;
    const pad = made("div", { className: "pad", tabIndex: 0, role: "application" });
    pad.setAttribute("aria-roledescription", "touch pad");
    pad.setAttribute("aria-describedby", "keys");
    this._button = made("button", { type: "button", textContent: "Press to start" });
    this._button.addEventListener("click", () => this._switch(!this._open));
    pad.addEventListener("pointerdown", (event) => {
      if (!this._sound && event.target !== this._button) this._switch(true);
    });
    pad.append(made("canvas", { ariaHidden: "true" }), this._button);
    const said = [picture.words ?? name, `${simulated ? "simulated; " : ""}follows ${follows}`, ...notes]
      .map((text) => `${text[0].toUpperCase()}${text.slice(1)}.`)
      .join(" ");
    this._draw(pad, made("p", { id: "keys", textContent: `${said} ${KEYS}` }));
    this._pad = new Pad(pad, (message) => this._sound?.tellNow(message));
    this._pad.fields = [[{ ...picture, name, opacity: 1 }]];
    this._vibration = new Vibration((pattern) => navigator.vibrate?.(pattern) ?? false);
    this._vibration.tables = [table];
    this._vibration.on = matchMedia("(pointer: coarse)").matches;
    const screen = this._pad.pxPerMm;
    new ResizeObserver(() => this._pad?.scale(screen)).observe(pad);
    this._apply();
    const draw = () => {
      this._pad.draw(this.report);
      this._frame = requestAnimationFrame(draw);
    };
    draw();
  }

  /** Apply the attributes that may change. */
  _apply() {
    const { name } = this._table.head;
    this._pad.element.setAttribute("aria-label", this.getAttribute("label") ?? `Surface of ${name}`);
    this._sound?.tell({ kind: "output", gain: this.gain, open: this._open });
  }

  /** Turn the sound on, which browsers allow after a gesture, or off. */
  async _switch(on) {
    const { head, buffer } = this._table;
    if (!this._sound) {
      this._sound = new Sound((report) => this._follow(report), head.rate);
      this._sound.tell({ kind: "textures", tables: [{ head, buffer }], seed: 1, fields: [[1]] });
    }
    this._open = this._sound.wanted = on;
    this._button.textContent = on ? "Turn the sound off" : "Turn the sound on";
    this._apply();
    if (!on) return;
    this._pad.element.focus({ preventScroll: true, focusVisible: false });
    await this._sound.begin();
  }

  _follow(report) {
    this.report = report;
    this._vibration.follow(report, [1]);
  }

  _draw(...parts) {
    const root = this.shadowRoot ?? this.attachShadow({ mode: "open" });
    const sheet = new CSSStyleSheet(); // allowed by any Content-Security-Policy
    sheet.replaceSync(STYLES);
    root.adoptedStyleSheets = [sheet];
    root.replaceChildren(...parts);
  }

  _close() {
    cancelAnimationFrame(this._frame);
    this._vibration?.stop();
    this._pad?.close();
    this._sound?.close();
    this._loading = this._pad = this._sound = undefined;
    this._open = false;
  }
}

/** Return the text at an address. @param {URL} address */
async function fetched(address) {
  let answer;
  try {
    answer = await fetch(address);
  } catch {
    throw new Error("cannot be loaded; is the page served by a web server?");
  }
  if (!answer.ok) throw new Error(`cannot be loaded: ${answer.status} ${answer.statusText}`.trim());
  return answer.text();
}

const made = (name, values) => Object.assign(document.createElement(name), values);

if (globalThis.customElements && !customElements.get("tactogram-pad")) customElements.define("tactogram-pad", TactogramPad);
