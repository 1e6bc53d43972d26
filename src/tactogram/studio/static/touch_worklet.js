/** The sound of the page Touch, in the audio thread. */

import { Player } from "./touch_player.js";

class TouchProcessor extends AudioWorkletProcessor {
  constructor(options) {
    super();
    this._player = new Player(sampleRate, (report) => this.port.postMessage(report));
    this.port.onmessage = (event) => this._player.hear(event.data, currentTime);
    for (const message of options.processorOptions?.messages ?? []) this._player.hear(message, currentTime);
  }

  process(_inputs, outputs) {
    const [first, ...others] = outputs[0];
    this._player.render(currentTime, first);
    for (const other of others) other.set(first);
    return true;
  }
}

registerProcessor("tactogram-touch", TouchProcessor);
