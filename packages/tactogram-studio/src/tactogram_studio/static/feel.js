/**
 * Plays one haptic file on a phone: by the motor, which a browser can only switch on and off, and as sound.
 */

const find = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
const button = /** @type {HTMLButtonElement} */ (find("play"));
const sound = /** @type {HTMLAudioElement} */ (find("sound"));
const canVibrate = typeof navigator.vibrate === "function";

/** @param {{title: string, file: string, format: string, simulated: boolean, pattern: number[]}} file */
function show(file) {
  find("title").textContent = file.title;
  document.title = `${file.title} · tactogram`;
  find("what").textContent = `${file.file}: ${file.format}${file.simulated ? ", from a simulated signal" : ""}`;
  find("motor").textContent = canVibrate
    ? "A browser can only switch the phone's motor on and off; the strength and frequency in the file are in the sound alone."
    : "This browser cannot vibrate (Chrome on Android can, iPhones cannot): the file is played as sound.";
  find("pattern").textContent = `On and off, ms: ${file.pattern.join(" · ")}`;
  const bars = file.pattern.map((ms, n) => {
    const bar = document.createElement("span");
    bar.className = n % 2 === 0 ? "on" : "";
    bar.style.flexGrow = String(ms);
    return bar;
  });
  find("bars").replaceChildren(...bars);
  button.disabled = false;
  button.addEventListener("click", () => {
    if (button.getAttribute("aria-pressed") === "true") {
      stop();
      return;
    }
    button.setAttribute("aria-pressed", "true");
    button.textContent = "Stop";
    sound.currentTime = 0;
    sound.play().catch((error) => { find("pattern").textContent = `The sound did not start: ${error.message}`; });
    if (canVibrate) navigator.vibrate(file.pattern);
  });
}

function stop() {
  button.setAttribute("aria-pressed", "false");
  button.textContent = "Play";
  sound.pause();
  if (canVibrate) navigator.vibrate(0);
}

// The motor's pattern may outlast the sound by the time that the motor needs.
sound.addEventListener("ended", () => { button.setAttribute("aria-pressed", "false"); button.textContent = "Play"; });
sound.src = `${location.pathname}/sound.wav`;
const answer = await fetch(`${location.pathname}/file`);
if (answer.ok) show(await answer.json());
else find("title").textContent = "This file was deleted. Write it again on the page Edit.";
