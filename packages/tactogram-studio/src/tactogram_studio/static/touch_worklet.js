/** The sound of the page Touch, in the audio thread; elsewhere this module does nothing. */

import { Player } from "./touch_player.js";

const Processor = globalThis.AudioWorkletProcessor ?? Object;

class TouchProcessor extends Processor {
  constructor(options) {
    super();
    this._player = new Player(sampleRate, (report) => this.port.postMessage(report));
    this.port.onmessage = (event) => this._hear(event.data);
    for (const message of options.processorOptions?.messages ?? []) this._hear(message);
  }

  _hear(message) {
    try {
      this._player.hear(message, currentTime);
    } catch (error) {
      this.port.postMessage({ error: String(error) });
    }
  }

  process(_inputs, outputs) {
    const [first, ...others] = outputs[0];
    this._player.render(currentTime, first);
    for (const other of others) other.set(first);
    return true;
  }
}

globalThis.registerProcessor?.("tactogram-touch", TouchProcessor);
