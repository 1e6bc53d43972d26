/** Audio of the page Touch: context, worklet, spectrum and latency. */

import { keepAwake } from "/participants/static/awake.js";

import { Player, QUANTUM } from "./touch_player.js";

/** Peak of the first textures, in dB of full scale: audible, and harmless on headphones. */
export const SAFE_DB = -20;
const KEPT = 400;
/** A block must last at most 5 ms; headsets with a microphone use 16 or 24 kHz. */
const LEAST_HZ = QUANTUM / 0.005;
const USUAL_HZ = 48_000;

/** Sound controlled by messages (see `touch_player.js`) that reports back. */
export class Sound {
  /**
   * @param {(report: Record<string, any>) => void} report
   * @param {number} [rate] Hz, where the textures need one; by default the device's.
   */
  constructor(report, rate) {
    this._report = report;
    this.context = rate ? new AudioContext({ latencyHint: "interactive", sampleRate: rate }) : contextOf();
    /** Whether the sound is switched on. */
    this.wanted = false;
    keepAwake(this.context, () => this.wanted);
    this.analyser = new AnalyserNode(this.context, { fftSize: 8192, smoothingTimeConstant: 0.6 });
    this.analyser.connect(this.context.destination);
    /** Whether the samples are made in the audio thread; without a worklet, in the page's. */
    this.threaded = this.context.audioWorklet !== undefined;
    /** Seconds from a pointer event to the output of the first block that follows it, newest last. */
    this.latencies = [];
    this._ready = this.threaded ? this._withWorklet().catch(() => this._withoutWorklet()) : this._withoutWorklet();
  }

  get rate() {
    return this.context.sampleRate;
  }

  /**
   * Tell the player something.
   * @param {Record<string, any>} message
   */
  async tell(message) {
    await this._ready;
    this._send(message);
  }

  /** Send a message immediately if the sound plays: motion is useless later. */
  tellNow(message) {
    if (this.context.state === "running") this._send?.(message);
  }

  /** Start; browsers allow it only just after a user's gesture. */
  async begin() {
    this.wanted = true;
    const resumed = this.context.resume();
    await this._ready;
    await resumed;
  }

  /** Give the sound output back. */
  close() {
    this.wanted = false;
    this.context.close();
  }

  /** Return the delays that the browser reports, s; null if it does not. */
  delays() {
    const { baseLatency, outputLatency } = this.context;
    return { base: baseLatency ?? null, output: outputLatency > 0 ? outputLatency : null };
  }

  _heard(report) {
    if (report.error) {
      console.error(report.error);
      return;
    }
    if (report.motion === report.motion) {
      const late = this._lateness(report);
      if (late !== null) {
        this.latencies.push(late);
        if (this.latencies.length > KEPT) this.latencies.shift();
      }
    }
    this._report(report);
  }

  /** Time from a pointer event to the output of the first block that it changed, s. */
  _lateness({ motion, motion_block: block }) {
    const stamp = this.context.getOutputTimestamp?.();
    if (!stamp || !(stamp.performanceTime > 0)) return null;
    const { currentTime, outputLatency = 0 } = this.context;
    const late = leaves(block, { ...clocks(stamp), now: performance.now() / 1e3, currentTime, outputLatency }) - motion;
    return late > 0 && late < 2 ? late : null;
  }

  async _withWorklet() {
    await this.context.audioWorklet.addModule(new URL("touch_worklet.js", import.meta.url));
    const worklet = new AudioWorkletNode(this.context, "tactogram-touch", {
      numberOfInputs: 0,
      outputChannelCount: [2],
    });
    worklet.port.onmessage = (event) => this._heard(event.data);
    worklet.connect(this.analyser);
    this._send = (message) => worklet.port.postMessage(message);
  }

  /** Browsers have no worklet over plain HTTP beyond this machine: then the page's thread makes the samples. */
  async _withoutWorklet() {
    this.threaded = false;
    const player = new Player(this.context.sampleRate, (report) => this._heard(report));
    const script = this.context.createScriptProcessor(1024, 0, 2);
    script.onaudioprocess = ({ outputBuffer, playbackTime }) => {
      const [left, right] = [outputBuffer.getChannelData(0), outputBuffer.getChannelData(1)];
      for (let i = 0; i < left.length; i += QUANTUM) {
        player.render(playbackTime + i / this.rate, left.subarray(i, i + QUANTUM));
      }
      right.set(left);
    };
    script.connect(this.analyser);
    this._send = (message) => player.hear(message, this.context.currentTime);
  }
}

/** Return a context at the device's rate, or at one that suits the textures. */
export function contextOf() {
  const own = new AudioContext({ latencyHint: "interactive" });
  if (own.sampleRate >= LEAST_HZ) return own;
  own.close();
  return new AudioContext({ latencyHint: "interactive", sampleRate: USUAL_HZ });
}

const clocks = ({ contextTime, performanceTime }) => ({ heard: contextTime, at: performanceTime / 1e3 });

/**
 * Return when a block leaves the browser, on the page's clock, s.
 *
 * A browser reports what is `heard`, and `at` which time. Some (Firefox) shift both by the output's latency, as if a
 * block were heard as soon as it is made; then the latency is added.
 * @param {number} block On the context's clock, s.
 * @param {{heard: number, at: number, now: number, currentTime: number, outputLatency: number}} said
 */
export function leaves(block, { heard, at, now, currentTime, outputLatency }) {
  const behind = currentTime - heard - (now - at);
  return at + block - heard + (behind < outputLatency / 2 ? outputLatency : 0);
}

/** Return a quantile of values. */
export function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

/**
 * Draw a spectrum from 0 to 1000 Hz.
 * @param {HTMLCanvasElement} canvas
 * @param {AnalyserNode} analyser
 * @param {Float32Array} bins
 * @param {number} high dB of full scale at the top; the bottom is 80 dB below.
 */
export function drawSpectrum(canvas, analyser, bins, high) {
  const { width, height } = fitted(canvas);
  const pen = canvas.getContext("2d");
  const style = getComputedStyle(canvas);
  const [most, foot, low] = [1000, 18, high - 80];
  analyser.getFloatFrequencyData(bins);
  const perBin = analyser.context.sampleRate / analyser.fftSize;
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = style.getPropertyValue("--quiet") || "#51606e";
  pen.strokeStyle = style.getPropertyValue("--line") || "#d5dce2";
  for (let hz = 0; hz <= most; hz += 200) {
    const x = (hz / most) * (width - 1) + 0.5;
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x, height - foot);
    pen.stroke();
    pen.textAlign = hz === 0 ? "left" : hz === most ? "right" : "center";
    pen.fillText(hz === most ? `${hz} Hz` : String(hz), x, height - 4);
  }
  pen.fillStyle = style.getPropertyValue("--accent") || "#0b5d66";
  pen.beginPath();
  pen.moveTo(0, height - foot);
  for (let n = 1; n * perBin <= most && n < bins.length; n++) {
    const share = Math.min(1, Math.max(0, (bins[n] - low) / (high - low)));
    pen.lineTo(((n * perBin) / most) * width, (1 - share) * (height - foot));
  }
  pen.lineTo(width, height - foot);
  pen.fill();
}

/**
 * Set a canvas to the screen's resolution; return its size in CSS pixels.
 * @param {HTMLCanvasElement} canvas
 */
export function fitted(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const ratio = devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
  return { width, height };
}
