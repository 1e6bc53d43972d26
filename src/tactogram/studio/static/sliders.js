/**
 * What a slider is, is said on the element that the keyboard reaches. Quasar says it on the one around: the focus would
 * be on an element without a role and a name.
 */

const SAID = ["role", "aria-label", "aria-orientation", "aria-valuemin", "aria-valuemax", "aria-valuenow", "aria-disabled", "aria-readonly"];

/** @param {Element} slider */
function say(slider) {
  const reached = slider.querySelector(".q-slider__track-container");
  if (!reached) return;
  for (const name of SAID) {
    const value = slider.getAttribute(name);
    if (value === null) continue;
    reached.setAttribute(name, value);
    slider.removeAttribute(name);
  }
}

/** @param {Node} node */
function sayIn(node) {
  if (!(node instanceof Element)) return;
  if (node.matches(".q-slider")) say(node);
  node.querySelectorAll(".q-slider").forEach(say);
}

new MutationObserver((changes) => {
  for (const { type, target, addedNodes } of changes) {
    if (type === "childList") addedNodes.forEach(sayIn);
    else if (target instanceof Element && target.matches(".q-slider")) say(target);
  }
}).observe(document, { subtree: true, childList: true, attributeFilter: SAID });
sayIn(document.documentElement);
