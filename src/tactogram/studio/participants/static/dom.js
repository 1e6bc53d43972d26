/** Elements, made in one line each. */

/**
 * Return a new element.
 * @param {string} tag
 * @param {Object<string, any>} [values] attributes; `on…` listeners; `text`; `class`
 * @param {...(Node|string)} inner
 * @returns {HTMLElement}
 */
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

/**
 * Keep a screen as it is: no zoom, no menu, no dragging of pictures, no way back by a swipe or a button.
 * What is shown follows from the server, so that going back has nothing to go back to.
 */
export function holdStill() {
  const stop = (event) => event.preventDefault();
  for (const name of ["contextmenu", "dragstart", "gesturestart", "gesturechange"]) {
    document.addEventListener(name, stop, { passive: false });
  }
  document.addEventListener("wheel", (event) => event.ctrlKey && stop(event), { passive: false });
  document.addEventListener("touchmove", (event) => event.touches.length > 1 && stop(event), { passive: false });
  document.addEventListener("keydown", (event) => {
    const zooms = (event.ctrlKey || event.metaKey) && ["+", "-", "=", "0"].includes(event.key);
    const goesBack = event.altKey && ["ArrowLeft", "ArrowRight"].includes(event.key);
    if (zooms || goesBack) stop(event);
  });
  history.pushState(null, "", location.href);
  window.addEventListener("popstate", () => history.pushState(null, "", location.href));
}
