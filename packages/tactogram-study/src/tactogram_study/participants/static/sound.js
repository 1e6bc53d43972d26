/** Stimuli as sound, played unchanged and without clicks, only on demand. */

import { BEGINS_MS, keepAwake } from "./awake.js";

/** Time constant of a voice's rise and fall, s; after ten of them it is silent (-87 dB). */
export const RISE_S = 0.002;
/** Length of the cross-fade between a loop's end and its beginning, s, so that its seam is not felt. */
export const SEAM_S = 0.01;
/** The tone of the sound check: audible and felt, and far from the loudest that a device plays. */
const TEST = { hz: 200, seconds: 0.5, peak: 0.1, rate: 48000 };

/**
 * Return the samples of a WAV file of 32-bit floats.
 * @param {ArrayBuffer} bytes
 * @returns {{rate: number, channels: Float32Array[]}}
 */
export function readWav(bytes) {
  const view = new DataView(bytes);
  const text = (at) => String.fromCharCode(...new Uint8Array(bytes, at, 4));
  if (bytes.byteLength < 12 || text(0) !== "RIFF" || text(8) !== "WAVE") throw new Error("not a WAV file");
  let format = null;
  for (let at = 12; at + 8 <= bytes.byteLength; ) {
    const size = view.getUint32(at + 4, true);
    if (text(at) === "fmt ") {
      const tag = view.getUint16(at + 8, true);
      const kind = tag === 0xfffe ? view.getUint16(at + 32, true) : tag;
      format = { kind, count: view.getUint16(at + 10, true), rate: view.getUint32(at + 12, true), bits: view.getUint16(at + 22, true) };
    } else if (text(at) === "data") {
      if (!format || format.kind !== 3 || format.bits !== 32) throw new Error("a WAV file must hold 32-bit floats");
      return { rate: format.rate, channels: deinterleaved(view, at + 8, size, format.count) };
    }
    at += 8 + size + (size % 2);
  }
  throw new Error("a WAV file without samples");
}

function deinterleaved(view, start, size, count) {
  const frames = Math.floor(Math.min(size, view.byteLength - start) / (4 * count));
  return Array.from({ length: count }, (_, channel) =>
    Float32Array.from({ length: frames }, (_, i) => view.getFloat32(start + 4 * (i * count + channel), true)),
  );
}

/**
 * Return samples that repeat without a step: an equal-power cross-fade of the end into the beginning.
 * @param {Float32Array} samples
 * @param {number} rate Hz
 */
export function looped(samples, rate) {
  const seam = Math.min(Math.round(SEAM_S * rate), Math.floor(samples.length / 4));
  const whole = samples.slice(0, samples.length - seam);
  const after = samples.length - seam;
  for (let i = 0; i < seam; i += 1) {
    const angle = (Math.PI / 2) * ((i + 0.5) / seam);
    whole[i] = samples[i] * Math.sin(angle) + samples[after + i] * Math.cos(angle);
  }
  return whole;
}

/**
 * Start a voice; it is silent until `swell`.
 * @param {BaseAudioContext} context
 * @param {{rate: number, channels: Float32Array[]}} sound
 * @param {{loop?: boolean, at?: number}} [options] `at` is a time of the context
 */
export function voiceOf(context, sound, { loop = false, at = context.currentTime } = {}) {
  const channels = loop ? sound.channels.map((one) => looped(one, sound.rate)) : sound.channels;
  const length = Math.max(1, channels[0].length);
  const buffer = context.createBuffer(channels.length, length, sound.rate);
  channels.forEach((samples, channel) => buffer.copyToChannel(samples, channel));
  const source = new AudioBufferSourceNode(context, { buffer, loop });
  const gain = new GainNode(context, { gain: 0 });
  source.connect(gain).connect(context.destination);
  source.start(at);
  return { source, gain, seconds: length / sound.rate };
}

/** Fade a voice to 1 or 0 from its present gain. */
export function swell(gain, to, at) {
  gain.gain.cancelScheduledValues(at);
  gain.gain.setTargetAtTime(to, at, RISE_S);
}

/** Stimuli that this device plays. */
export class BrowserSounds {
  /**
   * @param {(slot: string) => Promise<ArrayBuffer>} fetched returns the WAV of a slot
   * @param {(silent: boolean) => void} [told] whether sound that should play is silent
   */
  constructor(fetched, told = () => {}) {
    this.fetched = fetched;
    this.told = told;
    this.silent = false;
    this.sounds = new Map();
    this.contexts = new Map();
    this.voices = new Set();
  }

  static get possible() {
    return typeof AudioContext === "function";
  }

  /** Allow sound to play later: browsers require a tap first. Called within one. */
  unlock() {
    if (BrowserSounds.possible) this.context(48000).resume();
  }

  context(rate) {
    if (!this.contexts.has(rate)) {
      let made;
      try {
        made = new AudioContext({ sampleRate: rate, latencyHint: "interactive" });
      } catch {
        made = new AudioContext({ latencyHint: "interactive" });
      }
      keepAwake(made);
      // A call or another program may interrupt the sound: a stimulus that did not finish does not count as played.
      made.addEventListener("statechange", () => (made.state === "running" ? this._tell(false) : this.hush()));
      this.contexts.set(rate, made);
    }
    return this.contexts.get(rate);
  }

  /** Fetch the sounds of slots, so that they start at once. */
  async load(slots) {
    await Promise.all(slots.map(async (slot) => this.sounds.set(slot, readWav(await this.fetched(slot)))));
  }

  /** Play a tone that is no stimulus, to hear or feel whether the device plays. */
  test() {
    this.hush();
    const tone = Float32Array.from({ length: TEST.rate * TEST.seconds }, (_, i) => TEST.peak * Math.sin((2 * Math.PI * TEST.hz * i) / TEST.rate));
    this.sounds.set("test", { rate: TEST.rate, channels: [tone] });
    return this.play("test").ended;
  }

  clear() {
    this.hush();
    this.sounds.clear();
  }

  /**
   * Play a slot: a loop sounds while switched on by `let`; a single play resolves `ended`.
   *
   * Its end follows the sound's own clock, which stands still until the device has started.
   * @returns {{let: (on: boolean) => void, stop: () => void, ended: Promise<boolean>, audible: () => boolean}}
   */
  play(slot, { loop = false, seconds = null } = {}) {
    const sound = this.sounds.get(slot);
    const context = this.context(sound.rate);
    context.resume().catch(() => null);
    const voice = voiceOf(context, sound, { loop });
    this.voices.add(voice);
    let finish;
    const ended = new Promise((resolve) => (finish = resolve));
    const stop = (whole = false) => {
      if (!this.voices.delete(voice)) return;
      clearTimeout(waiting);
      swell(voice.gain, 0, context.currentTime);
      voice.source.stop(context.currentTime + 10 * RISE_S);
      finish(whole);
    };
    const waiting = setTimeout(() => {
      if (context.state === "running") return;
      this._tell(true);
      if (!loop) stop();
    }, BEGINS_MS);
    voice.halt = stop;
    if (!loop) {
      swell(voice.gain, 1, context.currentTime);
      const silence = Math.max(0, (seconds ?? 0) - voice.seconds);
      voice.source.onended = () => setTimeout(stop, 1000 * silence, true);
    }
    return {
      let: (on) => swell(voice.gain, on ? 1 : 0, context.currentTime),
      stop: () => stop(),
      ended,
      audible: () => context.state === "running" && this.voices.has(voice),
    };
  }

  _tell(silent) {
    if (silent !== this.silent) this.told(silent);
    this.silent = silent;
  }

  /** Return a slot's length, s. */
  seconds(slot) {
    const sound = this.sounds.get(slot);
    return sound.channels[0].length / sound.rate;
  }

  hush() {
    for (const voice of [...this.voices]) voice.halt();
  }

  /** Return the latency and rates of the sound output. */
  facts() {
    const [sound] = this.sounds.values();
    if (!sound) return {};
    const context = this.context(sound.rate);
    const latency = (context.baseLatency ?? 0) + (context.outputLatency ?? 0);
    return { audio_latency_ms: Math.round(10000 * latency) / 10, audio_rate_hz: context.sampleRate, sound_rate_hz: sound.rate };
  }
}

/** Stimuli played on the server's display. */
export class ServerSounds {
  /**
   * @param {(slot: string) => Promise<boolean>} play resolves when it has ended
   * @param {() => Promise<any>} halt
   */
  constructor(play, halt) {
    this.send = play;
    this.halt = halt;
    this.present = null;
  }

  unlock() {}

  async load() {}

  clear() {
    this.hush();
  }

  play(slot, { loop = false } = {}) {
    this.hush();
    const one = { on: !loop, over: false, running: false };
    this.present = one;
    const stop = () => {
      if (one.over) return;
      one.over = true;
      if (one.running) this.halt();
    };
    const once = async () => {
      one.running = true;
      const played = await this.send(slot);
      one.running = false;
      return played;
    };
    const again = async () => {
      while (one.on && !one.over && (await once()));
    };
    const lets = (on) => {
      const begins = on && !one.on;
      const ends = !on && one.on;
      one.on = on;
      if (begins && !one.running) again();
      if (ends && one.running) this.halt();
    };
    one.stop = stop;
    const ended = loop ? Promise.resolve(true) : once().then((played) => played && !one.over);
    return { let: lets, stop, ended, audible: () => true };
  }

  seconds() {
    return null;
  }

  hush() {
    this.present?.stop();
    this.present = null;
  }

  facts() {
    return {};
  }
}
