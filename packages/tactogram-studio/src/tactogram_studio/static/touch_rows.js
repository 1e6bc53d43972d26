/** Textures to feel, side by side or mixed: a row for each, with what it follows and its weight. */

import { readTable } from "./touch_textures.js";

const MOST = 4;
const LAYOUTS = {
  auto: "automatic",
  table: "speed and force (models)",
  path: "the finger's path",
  x: "the position from left to right",
  y: "the position from top to bottom",
};

/**
 * @typedef {object} Row
 * @property {string} key JSON of where, of and material.
 * @property {string} lay
 * @property {number | null} speed
 * @property {number} weight
 * @property {any} [table]
 * @property {any} [picture]
 * @property {string} [error]
 * @property {URLSearchParams} [loading] The last request.
 */

/** The rows of the page. */
export class Rows {
  /**
   * @param {{list: HTMLElement, waiting: HTMLElement, rate: number, kept?: any}} parts
   * @param {(what: {changed: boolean}) => void} loaded
   */
  constructor({ list, waiting, rate, kept }, loaded) {
    this._list = list;
    this._waiting = waiting;
    this._rate = rate;
    this._loaded = loaded;
    this._offers = [];
    /** @type {Row[]} */
    this._rows = (kept?.rows ?? []).slice(0, MOST).map(({ key, lay, speed, weight }) => ({ key, lay, speed, weight }));
    this.arrangement = kept?.arrangement === "mixed" ? "mixed" : "beside";
    this.ready = false;
    const asked = new URLSearchParams(location.search);
    this._of = asked.get("of");
    if (this._of) {
      history.replaceState(null, "", location.pathname); // a reload must not undo what is chosen then
      const key = keyOf({ where: asked.get("where") ?? "run", of: this._of, material: asked.get("material") ?? "" });
      this._rows = [{ key, lay: "auto", speed: null, weight: 1 }];
    }
  }

  get count() {
    return this._rows.length;
  }

  /** Wait until there are textures, and load the chosen ones. */
  async begin() {
    for (;;) {
      const found = await offersNow();
      this._offers = found.offers;
      this._waiting.textContent = this._offers.length ? "" : found.waiting;
      if (this._offers.length) break;
      await new Promise((resolve) => setTimeout(resolve, 1500));
    }
    const known = new Set(this._offers.map(keyOf));
    this._rows = this._rows.filter((row) => known.has(row.key) || this._asked(row.key));
    if (!this._rows.length) this._rows = [this._fresh(0)];
    this._show();
    await Promise.all(this._rows.map((row) => this._load(row)));
    this._show();
    this._tell(true);
  }

  /** Update the list, and choose the file, kept result, or material of a run with this name. */
  async choose(where, of, material = "") {
    this._offers = (await offersNow()).offers;
    if (!this._rows.length) this._rows = [this._fresh(0)]; // before the example surfaces are ready
    await this._change(this._rows[0], { key: keyOf({ where, of, material }), lay: "auto", speed: null });
  }

  async add() {
    if (this._rows.length >= MOST) return;
    const row = this._fresh(this._rows.length);
    this._rows.push(row);
    await this._load(row);
    this._show();
    this._tell(true);
    this._list.lastElementChild.querySelector("select").focus();
  }

  /** @param {"beside" | "mixed"} how */
  arrange(how) {
    this.arrangement = how;
    this._show();
    this._tell(false);
  }

  /** Return the loaded tables, in the order of the rows. */
  tables() {
    return this._good().map(({ table }) => table);
  }

  /** Return the weights of the textures in each field of the pad. */
  fields() {
    const good = this._good();
    if (!good.length) return [[]];
    if (this.arrangement === "beside" && good.length > 1) {
      return good.map((_, n) => good.map((__, other) => Number(n === other)));
    }
    const sum = good.reduce((all, { weight }) => all + weight, 0);
    return [good.map(({ weight }) => (sum > 0 ? weight / sum : 1 / good.length))];
  }

  /** Return the pictures of each field, each with its opacity above those before it. */
  shown() {
    const good = this._good();
    if (this.arrangement === "beside" || good.length < 2) return good.map((row) => [{ ...picture(row), opacity: 1 }]);
    const [weights] = this.fields();
    let sum = 0;
    return [
      good.map((row, n) => {
        sum += weights[n];
        return { ...picture(row), opacity: sum > 0 ? weights[n] / sum : 0 };
      }),
    ];
  }

  /** Return a description of the pad. */
  words() {
    const good = this._good();
    if (!good.length) return "Surface: nothing selected";
    const how = good.length < 2 ? "" : this.arrangement === "mixed" ? " Mixed." : " Side by side, from left to right.";
    return `Surface. ${good.map(({ picture: shown }) => shown?.words ?? "").join("; ")}.${how}`;
  }

  /** Return the settings to store. */
  state() {
    const rows = this._rows.map(({ key, lay, speed, weight }) => ({ key, lay, speed, weight }));
    return { rows, arrangement: this.arrangement };
  }

  _good() {
    return this._rows.filter((row) => row.table);
  }

  _asked(key) {
    return this._of !== null && JSON.parse(key)[1] === this._of;
  }

  _fresh(number) {
    // Neighbours in the list are often similar: start with some that differ.
    const offer = this._offers[(3 * number) % this._offers.length];
    return { key: keyOf(offer), lay: "auto", speed: null, weight: 1 };
  }

  async _load(row) {
    const [where, of, material] = JSON.parse(row.key);
    const query = new URLSearchParams({ where, of, material, lay: row.lay, rate: String(this._rate) });
    if (row.speed) query.set("speed", String(row.speed));
    row.loading = query;
    row.table = row.picture = row.error = undefined;
    const found = await loadedFrom(query);
    // A later choice is loading; this response is outdated.
    if (row.loading === query) Object.assign(row, found);
  }

  async _change(row, values) {
    Object.assign(row, values);
    const loaded = this._load(row);
    this._show();
    await loaded;
    this._show();
    this._tell(true);
  }

  _tell(changed) {
    this._loaded({ changed });
    this.ready = true;
  }

  _show() {
    const focused = document.activeElement?.id;
    this._list.replaceChildren(...this._rows.map((row, n) => this._drawn(row, n)));
    if (focused) document.getElementById(focused)?.focus();
  }

  _drawn(row, n) {
    const item = element("li");
    const head = element("div", { className: "touch-row-head" });
    const select = element("select", { id: `touch-texture-${n}`, ariaLabel: `Texture ${"ABCD"[n]}` });
    const groups = new Map();
    for (const offer of this._offers) {
      if (!groups.has(offer.group)) groups.set(offer.group, element("optgroup", { label: offer.group }));
      groups.get(offer.group).append(element("option", { value: keyOf(offer), textContent: offer.title }));
    }
    select.append(...groups.values());
    select.value = row.key;
    select.onchange = () => this._change(row, { key: select.value, lay: "auto", speed: null });
    if (this._rows.length > 1) head.append(element("b", { textContent: "ABCD"[n] }));
    head.append(select);
    if (this._rows.length > 1) {
      const remove = element("button", { type: "button", className: "touch-button plain", textContent: "Remove" });
      remove.ariaLabel = `Remove texture ${"ABCD"[n]}`;
      remove.onclick = () => {
        this._rows.splice(n, 1);
        this._show();
        this._tell(true);
      };
      head.append(remove);
    }
    item.append(head, this._facts(row), saves(row));
    if (this.arrangement === "mixed" && this._rows.length > 1) item.append(this._weight(row, n));
    item.append(this._more(row, n));
    return item;
  }

  _facts(row) {
    const line = element("p", { className: "small quiet" });
    if (row.error) {
      line.className = "small touch-error";
      line.textContent = row.error;
    } else if (row.table) {
      const { head } = row.table;
      if (head.simulated) line.append(element("span", { className: "simulated", textContent: "simulated" }), " ");
      const at = head.recorded_mm_s ? `; generated or recorded at ${figure(head.recorded_mm_s)} mm/s` : "";
      const facts = [`follows ${head.follows}${at}`, ...head.notes, row.picture?.line ? "" : SHOWN[row.picture?.kind]].filter(Boolean);
      line.append(facts.map((text) => `${text[0].toUpperCase()}${text.slice(1)}.`).join(" "));
    } else line.textContent = "Loading … the first texture takes some seconds.";
    return line;
  }

  _weight(row, n) {
    const label = element("label", { className: "touch-slider" });
    const value = element("output", { value: row.weight.toFixed(2) });
    const range = element("input", { type: "range", min: "0", max: "1", step: "0.01", id: `touch-weight-${n}` });
    range.value = String(row.weight);
    range.oninput = () => {
      row.weight = Number(range.value);
      value.value = row.weight.toFixed(2);
      this._tell(false);
    };
    label.append(element("span", { textContent: `Weight of ${"ABCD"[n]} (share of power)` }), value, range);
    return label;
  }

  _more(row, n) {
    const details = element("details");
    const inner = element("div", { className: "touch-more" });
    const lay = element("select", { id: `touch-lay-${n}` });
    lay.append(...Object.entries(LAYOUTS).map(([value, textContent]) => element("option", { value, textContent })));
    lay.value = row.lay;
    lay.onchange = () => this._change(row, { lay: lay.value });
    const speed = element("input", { type: "number", id: `touch-recorded-${n}`, min: "1", max: "2000", step: "1" });
    speed.value = String(row.speed ?? row.table?.head.recorded_mm_s ?? "");
    speed.onchange = () => this._change(row, { speed: Number(speed.value) || null });
    inner.append(labelled("Follows", lay), labelled("Speed, mm/s", speed));
    details.append(element("summary", { textContent: "How it follows the finger" }), inner);
    details.open = row.more === true;
    details.ontoggle = () => (row.more = details.open);
    return details;
  }
}

/** Return links to the files of a row. @param {Row} row */
function saves(row) {
  const line = element("p", { className: "small touch-saves" });
  if (!row.table) return line;
  const query = new URLSearchParams(row.loading);
  query.delete("rate"); // that of the file's readers
  const script = element("a", { href: "/touch/tactogram.js", download: "", textContent: "tactogram.js" });
  const textContent = `${row.table.head.name}.json`;
  const texture = element("a", { href: `/touch/texture?${query}`, download: "", textContent });
  line.append("For a page of your own or an engine: ", texture, ", ", script, ".");
  const [where, of] = JSON.parse(row.key);
  if (where !== "run") {
    const href = `/send?${new URLSearchParams({ of: `${where}:${of}`, tab: "file" })}`;
    line.append(" ", element("a", { href, textContent: "Convert to a haptic file" }));
  }
  return line;
}

const SHOWN = {
  photograph: "photograph of the material",
  rendered: "picture rendered from the simulated surface",
  drawn: "picture drawn from the signal, no photograph",
};

const figure = (value) => Number(value.toPrecision(4)).toString();
const keyOf = ({ where, of, material }) => JSON.stringify([where, of, material]);
const picture = ({ table, picture: shown }) => ({ ...shown, name: table.head.name });

async function offersNow() {
  try {
    return await (await fetch("/touch/offers")).json();
  } catch {
    return { offers: [], waiting: "The server does not respond: is tactogram studio still running? Trying again." };
  }
}

/** Return a table and its picture, or the error. */
async function loadedFrom(query) {
  try {
    const answer = await fetch(`/touch/table?${query}`);
    if (!answer.ok) throw new Error((await answer.json()).error);
    const table = readTable(await answer.arrayBuffer());
    return { table, picture: await pictureOf(query) };
  } catch (error) {
    return { error: error.message };
  }
}

async function pictureOf(query) {
  const answer = await fetch(`/touch/picture?${query}`);
  if (!answer.ok) return null;
  const scale = Number(answer.headers.get("x-mm-per-pixel"));
  return {
    kind: answer.headers.get("x-picture"),
    mm_per_pixel: scale > 0 ? scale : null,
    line: Number(answer.headers.get("x-line")) || null,
    words: decodeURIComponent(answer.headers.get("x-words") ?? ""),
    bitmap: await createImageBitmap(await answer.blob()),
  };
}

function element(name, values = {}) {
  return Object.assign(document.createElement(name), values);
}

function labelled(text, field) {
  const label = element("label", { textContent: text });
  label.append(field);
  return label;
}
