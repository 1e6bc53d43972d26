/** Stimuli streamed on the server's display: this page sends where the finger is, and hears whether it is felt. */

import { pxPerMm } from "./millimetres.js";

/** A finger that rests is sent again after this time, ms: a stream without news for 100 ms goes to rest. */
const STILL_HERE_MS = 30;

export class FingerSounds {
  /** Stimuli follow the finger: they are shown as areas to stroke. */
  streamed = true;

  /**
   * @param {() => string} address of the page's websocket
   * @param {(status: number) => void} [told] status of the refusal to stream a stimulus, as of a request; 0 if it streams
   */
  constructor(address, told = () => {}) {
    this.address = address;
    this.told = told;
    this.socket = null;
    this.present = null;
  }

  unlock() {}

  async load(slots) {
    if (slots.length) this.connect();
  }

  connect() {
    this.socket?.close();
    const place = new URL(this.address(), location.href);
    place.protocol = place.protocol.replace("http", "ws");
    const socket = new WebSocket(place);
    socket.addEventListener("message", (event) => this.hear(JSON.parse(event.data)));
    socket.addEventListener("close", () => this.socket === socket && this.present && (this.present.felt = false));
    this.socket = socket;
  }

  hear({ slot, state, status }) {
    if (slot === this.present?.slot) this.present.felt = state === "playing";
    this.told(state === "failed" ? status : 0);
  }

  /** Leave the page: the display goes to rest. */
  clear() {
    this.hush();
    this.socket?.close();
    this.socket = null;
  }

  /**
   * Begin to follow a finger on a slot.
   * @returns {{moved: Function, beat: Function, let: Function, stop: () => void, audible: () => boolean}}
   */
  play(slot) {
    this.hush();
    if (this.socket?.readyState > WebSocket.OPEN) this.connect();
    const one = { slot, felt: false, last: null };
    this.present = one;
    const send = (samples) => {
      if (this.present !== one || !samples.length) return;
      one.last = samples[samples.length - 1];
      if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ slot, samples }));
    };
    one.stop = () => {
      if (one.last?.[3]) send([[one.last[0] + 1, one.last[1], one.last[2], 0]]);
      if (this.present === one) this.present = null;
    };
    return {
      moved: send,
      /** Say that the finger is still there, where the screen reports nothing. */
      beat: (ms) => one.last?.[3] && ms - one.last[0] > STILL_HERE_MS && send([[ms, one.last[1], one.last[2], 1]]),
      let: () => {},
      stop: one.stop,
      audible: () => one.felt && this.present === one,
    };
  }

  hush() {
    this.present?.stop();
    this.present = null;
  }

  facts() {
    return {};
  }
}

/**
 * Return a position as it is sent: ms, mm right of and above the middle of the page, 1 while the finger touches.
 * @param {{clientX: number, clientY: number, timeStamp: number}} event
 * @param {boolean} touches
 */
export function sampleOf(event, touches) {
  const scale = pxPerMm();
  return [event.timeStamp, (event.clientX - innerWidth / 2) / scale, (innerHeight / 2 - event.clientY) / scale, touches ? 1 : 0];
}
