/** Sound that is let begin by a person's hand, and goes on after a call, a lock screen or a silent switch. */

/** Events within which browsers let sound begin; of a finger it is the one that lifts it. */
const GESTURES = ["pointerdown", "pointerup", "touchend", "click", "keydown"];
/** So long a sound device may take to begin, ms; wireless ones take about one second. */
export const BEGINS_MS = 3000;

/**
 * Let each gesture wake a context that was not let begin yet, or that the system has stopped meanwhile.
 * @param {AudioContext} context
 * @param {() => boolean} [wanted]
 */
export function keepAwake(context, wanted = () => true) {
  // As "ambient" sound a tablet's silent switch would mute it.
  if (navigator.audioSession) navigator.audioSession.type = "playback";
  const wake = () => {
    if (wanted() && context.state !== "running" && context.state !== "closed") context.resume().catch(() => null);
  };
  for (const name of GESTURES) document.addEventListener(name, wake, { capture: true, passive: true });
}
