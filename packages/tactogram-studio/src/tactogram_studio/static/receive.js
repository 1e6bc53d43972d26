/**
 * Folders and zips of recordings. Those dropped on an element with `data-receive`, or chosen in it, are sent to that
 * address; the page that the answer names is opened. A single picture goes to the uploader in `data-photograph` where
 * there is one. All listeners are on the document, so the page can be redrawn at any time. `data-most-files` and
 * `data-most-bytes` are what the server accepts.
 */

const MIB = 2 ** 20;

/** @param {Event} event @returns {HTMLElement | null} */
const zoneOf = (event) => (event.target instanceof Element ? event.target.closest("[data-receive]") : null);

/** @param {HTMLElement} zone @param {string} text @param {boolean} wrong */
function say(zone, text, wrong = false) {
  const status = zone.querySelector("[data-receive-status]");
  if (!status) return;
  status.textContent = text;
  status.classList.toggle("text-negative", wrong);
}

/** A dropped file, or the files below a dropped folder, with their paths. @returns {Promise<[string, File][]>} */
async function filesBelow(entry, path = "") {
  const name = path + entry.name;
  if (entry instanceof File) return [[name, entry]];
  if (entry.isFile) return [[name, await new Promise((done, failed) => entry.file(done, failed))]];
  const reader = entry.createReader();
  const found = [];
  for (;;) { // a browser gives some 100 at a time
    const some = await new Promise((done, failed) => reader.readEntries(done, failed));
    if (!some.length) return found;
    for (const each of some) found.push(...(await filesBelow(each, `${name}/`)));
  }
}

/** Gives a single picture to the page's uploader of photographs. @param {FileList} files @returns {boolean} */
function gavePhotograph(files) {
  const field = document.querySelector("[data-photograph] input[type=file]");
  if (!field || files.length !== 1 || !files[0].type.startsWith("image/")) return false;
  field.files = files;
  field.dispatchEvent(new Event("change", { bubbles: true }));
  return true;
}

/** @param {HTMLElement} zone @param {[string, File][]} files */
function send(zone, files) {
  const bytes = files.reduce((sum, [, file]) => sum + file.size, 0);
  const { mostFiles, mostBytes, receive } = zone.dataset;
  if (!files.length) return say(zone, "There are no files in it; choose a folder with a folder for each material.", true);
  if (files.length > Number(mostFiles) || bytes > Number(mostBytes)) {
    const most = `At most ${mostFiles} files and ${Number(mostBytes) / MIB} MiB can be sent`;
    const got = `got ${files.length} and ${(bytes / MIB).toFixed(0)} MiB`;
    return say(zone, `${most}, ${got}; put the folder into the workspace, and choose it there.`, true);
  }
  const form = new FormData();
  for (const [path, file] of files) form.append("file", file, encodeURIComponent(path));
  const request = new XMLHttpRequest();
  request.responseType = "json";
  request.upload.onprogress = ({ loaded, total }) =>
    say(zone, `Sending ${(loaded / MIB).toFixed(1)} of ${(total / MIB).toFixed(1)} MiB`);
  request.onerror = () => say(zone, "The studio cannot be reached; start it again.", true);
  request.onload = () => {
    if (request.status === 200) {
      say(zone, "Reading");
      window.location.assign(request.response.page);
    } else {
      say(zone, request.response?.problem ?? request.response?.detail ?? `Refused (${request.status}).`, true);
    }
  };
  request.open("POST", receive);
  request.send(form);
  say(zone, "Sending");
}

document.addEventListener("dragover", (event) => {
  const zone = zoneOf(event);
  if (!zone || !event.dataTransfer.types.includes("Files")) return;
  event.preventDefault();
  zone.classList.add("over");
});

document.addEventListener("dragleave", (event) => {
  const zone = zoneOf(event);
  if (zone && !zone.contains(event.relatedTarget)) zone.classList.remove("over");
});

document.addEventListener("drop", async (event) => {
  const zone = zoneOf(event);
  if (!zone || event.defaultPrevented || !event.dataTransfer.files.length) return;
  event.preventDefault();
  zone.classList.remove("over");
  if (gavePhotograph(event.dataTransfer.files)) return;
  const items = [...event.dataTransfer.items];
  const entries = items.map((item) => item.webkitGetAsEntry() ?? item.getAsFile()).filter(Boolean);
  say(zone, "Reading the folder");
  try {
    send(zone, (await Promise.all(entries.map((entry) => filesBelow(entry)))).flat());
  } catch (error) {
    say(zone, `The folder cannot be read: ${error.message}`, true);
  }
});

document.addEventListener("click", (event) => {
  const zone = zoneOf(event);
  const button = zone && event.target.closest("[data-receive-choose]");
  if (button) zone.querySelector(`input[data-receive-input="${button.dataset.receiveChoose}"]`).click();
});

document.addEventListener("change", (event) => {
  const zone = zoneOf(event);
  if (!zone || !event.target.dataset.receiveInput) return;
  send(zone, [...event.target.files].map((file) => [file.webkitRelativePath || file.name, file]));
  event.target.value = "";
});
