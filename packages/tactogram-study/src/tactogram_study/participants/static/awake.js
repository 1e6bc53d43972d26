/** Audio contexts that start with a user's gesture and resume after a call, a lock screen or a silent switch. */

/** Events in which browsers allow sound to start; for a touch that is the one that ends it. */
const GESTURES = ["pointerdown", "pointerup", "touchend", "click", "keydown"];
/** Longest start of a sound device, ms; wireless ones take about one second. */
export const BEGINS_MS = 3000;

/** Resume a context at each gesture, while `wanted` returns true: it has not been allowed to start, or the system stopped it. */
export function keepAwake(context, wanted = () => true) {
  // A tablet's silent switch mutes "ambient" sound.
  if (navigator.audioSession) navigator.audioSession.type = "playback";
  const wake = () => {
    if (wanted() && context.state !== "running" && context.state !== "closed") context.resume().catch(() => null);
  };
  for (const name of GESTURES) document.addEventListener(name, wake, { capture: true, passive: true });
}
