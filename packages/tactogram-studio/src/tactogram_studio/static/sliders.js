/**
 * Moves the role and name of a slider to the element that receives the keyboard focus. Quasar puts them on the element
 * around it, so that a screen reader would announce neither.
 */

const ATTRIBUTES = ["role", "aria-label", "aria-orientation", "aria-valuemin", "aria-valuemax", "aria-valuenow", "aria-disabled", "aria-readonly"];

/** @param {Element} slider */
function describe(slider) {
  const focusable = slider.querySelector(".q-slider__track-container");
  if (!focusable) return;
  for (const name of ATTRIBUTES) {
    const value = slider.getAttribute(name);
    if (value === null) continue;
    focusable.setAttribute(name, value);
    slider.removeAttribute(name);
  }
}

/** @param {Node} node */
function describeIn(node) {
  if (!(node instanceof Element)) return;
  if (node.matches(".q-slider")) describe(node);
  node.querySelectorAll(".q-slider").forEach(describe);
}

new MutationObserver((changes) => {
  for (const { type, target, addedNodes } of changes) {
    if (type === "childList") addedNodes.forEach(describeIn);
    else if (target instanceof Element && target.matches(".q-slider")) describe(target);
  }
}).observe(document, { subtree: true, childList: true, attributeFilter: ATTRIBUTES });
describeIn(document.documentElement);
