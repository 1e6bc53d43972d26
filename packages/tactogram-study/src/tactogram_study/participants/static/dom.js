/** Elements of a page, made in one line each, and its banner. */

/** Return a new element; `values` are attributes, `on…` listeners and `text`. */
export function make(tag, values = {}, ...inner) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(values)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "text") element.textContent = value;
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...inner);
  return element;
}

/** Return a large button. */
export function button(text, press, values = {}) {
  return make("button", { type: "button", class: "large", text, onclick: press, ...values });
}

/** Show a message above the page; "" hides it. */
export function tell(text) {
  const banner = document.getElementById("banner");
  banner.textContent = text;
  banner.hidden = text === "";
}

/**
 * Lock the screen: no menu, no dragging of pictures, no way back by a swipe or a button. The server decides what is
 * shown, so that there is no page to go back to.
 */
export function holdStill() {
  const stop = (event) => event.preventDefault();
  for (const name of ["contextmenu", "dragstart"]) document.addEventListener(name, stop);
  document.addEventListener("keydown", (event) => event.altKey && ["ArrowLeft", "ArrowRight"].includes(event.key) && stop(event));
  window.addEventListener("pageshow", (event) => event.persisted && location.reload());
  history.pushState(null, "", location.href);
  window.addEventListener("popstate", () => history.pushState(null, "", location.href));
}
