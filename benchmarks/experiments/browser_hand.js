// The hand of a simulated participant: it does on the page what a person does, by the events that a person causes.
async ({ answers, strokeMs }) => {
  const form = document.querySelector("form.page");
  const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const pointer = (element, name, x, y) =>
    element.dispatchEvent(new PointerEvent(name, { pointerId: 7, pointerType: "touch", isPrimary: true, bubbles: true, cancelable: true, clientX: x, clientY: y }));

  for (const press of form.querySelectorAll("[data-play]")) {
    press.click();
    do await pause(40);
    while (press.disabled || document.querySelector(".playing"));
  }
  for (const pad of form.querySelectorAll(".pad")) {
    const box = pad.getBoundingClientRect();
    const target = pad.querySelector(".target");
    const begun = performance.now();
    pointer(pad, "pointerdown", box.left + 10, box.top + box.height / 2);
    for (let i = 0; performance.now() - begun < strokeMs || pad.parentNode.querySelector(".state").textContent === ""; i += 1) {
      if (performance.now() - begun > 20 * strokeMs) break;
      await pause(16);
      const where = target.getBoundingClientRect();
      pointer(pad, "pointermove", where.left + where.width / 2 + (i % 2), box.top + box.height / 2);
      if (performance.now() - begun >= strokeMs) {
        pointer(pad, "pointerup", box.left + 10, box.top + box.height / 2);
        pointer(pad, "pointerdown", box.left + 10, box.top + box.height / 2);
      }
    }
    pointer(pad, "pointerup", box.left + 10, box.top + box.height / 2);
  }
  for (const [key, value] of Object.entries(answers)) {
    if (value === "") continue;
    const question = form.querySelector(`[data-key="${CSS.escape(key)}"]`);
    const line = question.querySelector(".vas");
    const written = question.querySelector("input.number, textarea");
    if (line) {
      const box = line.querySelector(".vas-line").getBoundingClientRect();
      const [low, high] = ["min", "max"].map((end) => Number(line.getAttribute(`aria-value${end}`)));
      const x = box.left + (box.width * (Number(value) - low)) / (high - low);
      for (const name of ["pointerdown", "pointerup"]) pointer(line, name, x, box.top);
    } else if (written) {
      written.value = value;
      written.dispatchEvent(new Event("input", { bubbles: true }));
    } else {
      question.querySelector(`input[value="${CSS.escape(value)}"]`).click();
    }
  }
  await pause(400);
  form.querySelector(".foot button").click();
  return form.querySelector(".reason").textContent;
};
