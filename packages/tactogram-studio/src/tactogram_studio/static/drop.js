/** A file that is dropped anywhere on a page goes to the file field that takes its kind, else to the first, which refuses it. */

/** @returns {HTMLInputElement[]} None on pages that take files in their own way. */
function fields() {
  if (document.querySelector("[data-receive], [data-drop]")) return [];
  return [...document.querySelectorAll(".q-uploader input[type=file]")];
}

/** @param {HTMLInputElement} field @param {File} file */
const takes = ({ accept }, file) =>
  accept.split(",").some((kind) => (kind === "image/*" ? file.type.startsWith("image/") : file.name.toLowerCase().endsWith(kind.trim())));

document.addEventListener("dragover", (event) => {
  if (!event.dataTransfer.types.includes("Files") || !fields().length) return;
  event.preventDefault();
  document.body.classList.add("dragging");
});
document.addEventListener("dragleave", (event) => event.relatedTarget ?? document.body.classList.remove("dragging"));
document.addEventListener("drop", (event) => {
  document.body.classList.remove("dragging");
  const { files } = event.dataTransfer;
  const all = fields();
  const field = files.length ? (all.find((each) => takes(each, files[0])) ?? all[0]) : null;
  if (!field) return;
  event.preventDefault();
  field.files = files;
  field.dispatchEvent(new Event("change", { bubbles: true }));
});
