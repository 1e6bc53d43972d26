/**
 * Pointer and keyboard input of the page Make: the point on the map of materials, and photographs (dropped, pasted, taken
 * with the camera, cropped by dragging). All listeners are on the document, so the page can be redrawn at any time.
 * Changes reach the server as the events `make-map` and `make-crop`; pictures go through the page's upload element.
 */

/** @param {Element} at @param {string} name @param {object} detail */
function notify(at, name, detail) {
  at.dispatchEvent(new CustomEvent(name, { detail, bubbles: true }));
}

/** @param {number} value @returns {number} */
const clamped = (value) => Math.min(1, Math.max(0, value));

/** Place of an event in a box, as shares of its sides. @param {Element} box @param {PointerEvent} event */
function placeIn(box, event) {
  const { left, top, width, height } = box.getBoundingClientRect();
  return [clamped((event.clientX - left) / width), clamped((event.clientY - top) / height)];
}

// -- the map -------------------------------------------------------------------------------------------------

const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** @param {HTMLElement} handle @returns {[number, number]} */
const pointOf = (handle) => [parseFloat(handle.style.left) / 100, parseFloat(handle.style.top) / 100];

/** @param {number} x @param {number} y */
function point(x, y) {
  const handle = document.querySelector("[data-map-handle]");
  if (!(handle instanceof HTMLElement)) return;
  handle.style.left = `${100 * x}%`;
  handle.style.top = `${100 * y}%`;
}

/** @type {Element | null} */
let draggedMap = null;
let lastSent = 0;

document.addEventListener("pointerdown", (event) => {
  const map = event.target instanceof Element ? event.target.closest("[data-map]") : null;
  if (map && event.button === 0) {
    draggedMap = map;
    moveMap(event, false);
    map.querySelector("[data-map-handle]")?.focus();
    event.preventDefault();
  }
});
document.addEventListener("pointermove", (event) => draggedMap && moveMap(event, false));
for (const name of ["pointerup", "pointercancel"]) {
  document.addEventListener(name, (event) => {
    if (draggedMap) moveMap(event, true);
    draggedMap = null;
  });
}

/** @param {PointerEvent} event @param {boolean} last */
function moveMap(event, last) {
  const [x, y] = placeIn(draggedMap, event);
  point(x, y);
  const now = performance.now();
  if (!last && now - lastSent < 50) return;
  lastSent = now;
  notify(draggedMap, "make-map", { x, y, last });
}

document.addEventListener("keydown", (event) => {
  const handle = event.target;
  if (!(handle instanceof HTMLElement) || !handle.matches("[data-map-handle]") || !(event.key in STEPS)) return;
  event.preventDefault();
  const step = event.shiftKey ? 0.1 : 0.02;
  const [dx, dy] = STEPS[event.key];
  const [x, y] = pointOf(handle);
  point(clamped(x + step * dx), clamped(y + step * dy));
  const [nx, ny] = pointOf(handle);
  notify(handle, "make-map", { x: nx, y: ny, last: false });
});
document.addEventListener("keyup", (event) => {
  const handle = event.target;
  if (!(handle instanceof HTMLElement) || !handle.matches("[data-map-handle]") || !(event.key in STEPS)) return;
  const [x, y] = pointOf(handle);
  notify(handle, "make-map", { x, y, last: true });
});

// -- photographs ---------------------------------------------------------------------------------------------

/** @param {number} id Of the upload element. @param {File[]} files */
function send(id, files) {
  window.getElement(id)?.$refs.qRef.addFiles(files.slice(0, 1));
}

/** @param {number} id */
function choose(id) {
  window.getElement(id)?.$refs.qRef.pickFiles();
}

/** @param {DataTransfer | null} transfer @returns {File[]} */
const pictures = (transfer) => [...(transfer?.files ?? [])];

document.addEventListener("dragover", (event) => {
  const drop = document.querySelector("[data-drop]");
  if (!drop) return;
  event.preventDefault();
  drop.classList.toggle("over", event.target instanceof Element && drop.contains(event.target));
});
document.addEventListener("dragleave", () => document.querySelector("[data-drop]")?.classList.remove("over"));
document.addEventListener("drop", (event) => {
  const drop = document.querySelector("[data-drop]");
  if (!drop) return;
  event.preventDefault();
  drop.classList.remove("over");
  const files = pictures(event.dataTransfer);
  if (files.length) send(Number(drop.getAttribute("data-drop")), files);
});
document.addEventListener("paste", (event) => {
  const drop = document.querySelector("[data-drop]");
  const files = pictures(event.clipboardData).filter((file) => file.type.startsWith("image/"));
  if (drop && files.length) send(Number(drop.getAttribute("data-drop")), files);
});

/** @param {string} text @param {() => void} done @returns {HTMLButtonElement} */
function button(text, done) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.addEventListener("click", done);
  return made;
}

/** Shows the camera's picture until a photograph is taken. @param {number} id Of the upload element. */
async function camera(id) {
  const place = document.querySelector("[data-camera]");
  if (!place) return;
  if (!navigator.mediaDevices?.getUserMedia) {
    place.textContent = "The camera only works if the page is opened on this machine (localhost) or over https.";
    return;
  }
  let stream;
  try {
    stream = await navigator.mediaDevices.getUserMedia({ video: { facingMode: "environment" } });
  } catch (error) {
    place.textContent = `The camera is not available: ${error instanceof Error ? error.message : error}`;
    return;
  }
  const video = document.createElement("video");
  video.autoplay = video.muted = video.playsInline = true;
  video.srcObject = stream;
  const end = () => {
    for (const track of stream.getTracks()) track.stop();
    place.replaceChildren();
  };
  const take = () => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
    canvas.getContext("2d")?.drawImage(video, 0, 0);
    canvas.toBlob((blob) => {
      end();
      if (blob) send(id, [new File([blob], "camera.png", { type: "image/png" })]);
    }, "image/png");
  };
  place.replaceChildren(video, button("Take photograph", take), button("Close", end));
}

// -- cropping ------------------------------------------------------------------------------------------------

/** @type {{place: Element, x: number, y: number} | null} */
let crop = null;

document.addEventListener("pointerdown", (event) => {
  const place = event.target instanceof Element ? event.target.closest("[data-crop]") : null;
  if (!place || event.button !== 0) return;
  const [x, y] = placeIn(place, event);
  crop = { place, x, y };
  event.preventDefault();
});
document.addEventListener("pointermove", (event) => crop && drawCrop(boxOf(event)));
document.addEventListener("pointerup", (event) => {
  if (!crop) return;
  notify(crop.place, "make-crop", boxOf(event));
  crop = null;
});
document.addEventListener("pointercancel", () => (crop = null));

/** @param {PointerEvent} event */
function boxOf(event) {
  const [x, y] = placeIn(crop.place, event);
  return {
    left: Math.min(x, crop.x),
    top: Math.min(y, crop.y),
    right: Math.max(x, crop.x),
    bottom: Math.max(y, crop.y),
  };
}

/** @param {{left: number, top: number, right: number, bottom: number}} box */
function drawCrop(box) {
  const shown = crop.place.querySelector("[data-crop-box]");
  if (!(shown instanceof HTMLElement)) return;
  shown.classList.remove("whole");
  shown.style.left = `${100 * box.left}%`;
  shown.style.top = `${100 * box.top}%`;
  shown.style.width = `${100 * (box.right - box.left)}%`;
  shown.style.height = `${100 * (box.bottom - box.top)}%`;
}

/** Scroll to the results where they are below the form. */
function showResults() {
  const [form, results] = ["form", "results"].map((name) => document.querySelector(`.make-${name}`)?.getBoundingClientRect());
  if (!form || !results || results.left > form.left) return;
  const behavior = matchMedia("(prefers-reduced-motion: reduce)").matches ? "auto" : "smooth";
  document.querySelector(".make-results")?.scrollIntoView({ behavior });
}

/** Called by the page and by tests. */
window.tactogramMake = { point, choose, camera, send, showResults };
