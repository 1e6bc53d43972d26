/** Latest values from the audio thread. */
export interface TactogramReport {
  /** Whether the finger is unknown, lifted, at rest or sliding. */
  state: "lost" | "air" | "rest" | "slide";
  /** mm/s */
  speed: number;
  /** N */
  force: number;
  /** Of the texture's signal since the last report, in its unit, before `gain`. */
  rms: number;
  peak: number;
}

/**
 * `<tactogram-pad src="corduroy.json">`: a texture to stroke with a mouse, finger, pen or the arrow keys.
 * Its height is the CSS property `--tactogram-pad-height` (18rem).
 */
export class TactogramPad extends HTMLElement {
  /** Address of a document that `tactogram touch` or the studio's page Touch wrote. */
  src: string;
  /** Attribute `gain`: parts of full scale per unit of the texture; by default its largest sample is at -20 dB. */
  readonly gain: number;
  /** Attribute `label`: accessible name, by default "Surface of" and the texture's name. */
  readonly report: TactogramReport;
}

declare global {
  interface HTMLElementTagNameMap {
    "tactogram-pad": TactogramPad;
  }
}
