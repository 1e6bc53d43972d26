"""Hatori & Takemura 2023, Sec. III-C, on a simulated transducer: what arrives of the modulation, and tracking.

The publication says how its display was driven (amplitude modulation of about 28.2 kHz, gain 10, 22 V, the admittance
kept at its maximum by the driving frequency) and neither the transducer's Q nor what arrived. Here a simulated one
(Butterworth-Van Dyke) is driven so at Q 30, 100 and 300, with and without pre-emphasis; and its resonance is followed
through a drift of 80 Hz, also while it is touched. Nothing in it was measured on a device.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.experiments.simulated_transducer import (
    DriftingTransducer,
    SimulatedAdmittance,
    SimulatedTouch,
    TrackingResult,
    demodulated,
    simulate_envelope,
    simulate_waveform,
    track,
)
from benchmarks.experiments.transducer_figures import (
    EnvelopeTransmission,
    admittance_figure,
    envelope_figure,
    tracking_figure,
)
from tactogram.evaluation.report import save_figure
from tactogram.rendering.families.ultrasonic import Settings, modulated
from tactogram.signal import Signal
from tactogram.signal.crest_factor import low_crest_phases, periodic_signal
from tactogram.workflows.progress import ProgressCallback
from tactogram_playback.transducer.circuit import PRESETS, Transducer
from tactogram_playback.transducer.resonance_tracking import TrackingSettings

QS = (30, 100, 300)
RATE, WAVEFORM_RATE = 96_000, 1_000_000
LINES = (10, 1000, 10)
"""Hz: first, last and step of the modulating signal's lines, equally strong; the publication's end at 1 kHz."""
METHODS = ("climb_admittance", "dither_admittance", "dither_conductance", "motional_phase")
TRACKED = {"free": "free, Q 800", "plate": "plate, Q 300", "finger": "finger, Q 100"}
STEPS, DRIFT_HZ, NOISE = 300, 80.0, 0.01
TOUCH = SimulatedTouch(100, 200)
Array = NDArray[np.float64]


def run(folder: Path, *, paper: bool, progress: ProgressCallback, seeds: int = 20) -> dict[str, Any]:
    """Return what arrives at each Q, and how each way of tracking follows the drift; figures are in ``folder``.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; there is one size.
    seeds : int
        Of the measurement's noise.
    """
    rows, arriving = [], []
    signal = texture()
    for q in QS:
        pair = [_passed(signal, q, emphasised=emphasised) for emphasised in (False, True)]
        rows.append((pair[0][0], pair[1][0]))
        arriving += [figures for _, figures in pair]
    title = "AM drive and recovered envelope through a simulated transducer"
    save_figure(folder / "envelope.png", envelope_figure(rows, start_s=0.4, seconds=0.03, title=title))
    shown, tracking = _tracking(folder, seeds)
    title = f"Tracking a simulated transducer through {DRIFT_HZ:g} Hz, {100 * NOISE:g} % noise"
    save_figure(folder / "tracking.png", tracking_figure(shown, touches=[TOUCH], title=title))
    title = "Simulated transducers: the maxima of |Y| and of Re Y"
    circuits = {TRACKED[name]: PRESETS[name] for name in TRACKED}
    save_figure(folder / "admittance.png", admittance_figure(circuits, title=title))
    result: dict[str, Any] = {
        "section": "III-C",
        "simulated": True,
        "data": "simulated transducers, tactogram_playback.transducer.circuit.PRESETS and Q as said",
        "modulating": f"lines from {LINES[0]} to {LINES[1]} Hz every {LINES[2]} Hz, equally strong, crest factor low",
        "arriving": arriving,
        "waveform_check": _waveform_check(signal),
        "drift_hz": DRIFT_HZ,
        "steps": STEPS,
        "noise": NOISE,
        "touch": {
            "steps": [TOUCH.start, TOUCH.stop],
            "q": TOUCH.q,
            "r1_ohm": TOUCH.r1_ohm,
            "shift_hz": TOUCH.shift_hz,
        },
        "seeds": seeds,
        "tracking": tracking,
        "figures": ["envelope.png", "tracking.png", "admittance.png"],
        "log": "tracking-log.csv",
        "published": {
            "carrier_hz": 28_200,
            "gain": 10,
            "limit_v": 22,
            "tracking": "maximum of the admittance",
        },
    }
    result["text"] = _text(result)
    return result


def texture() -> Signal:
    """Return one period of the modulating signal: unit 1, full scale, 1 s."""
    first, last, step = LINES
    wanted = np.zeros(last)
    wanted[first - 1 :: step] = 1.0
    phases = low_crest_phases(wanted, length=8000, rng=np.random.default_rng(0))
    x = periodic_signal(wanted, phases, length=8000)
    return Signal(x / np.abs(x).max(), 8000, "1")


def _passed(signal: Signal, q: int, *, emphasised: bool) -> tuple[EnvelopeTransmission, dict[str, Any]]:
    """Return what arrives of ``signal`` at a Q, drawn and in figures."""
    transducer = Transducer(q=q)
    settings = Settings(q=q, pre_emphasis=emphasised, loop=True, output="envelope")
    drive, facts = modulated(signal, settings, rate=RATE)
    # The second time round it has settled: one period, so that every line is a bin.
    twice = drive.with_samples(np.tile(drive.samples, 2))
    arrived = simulate_envelope(transducer, twice).samples[0, len(drive) :].astype(np.float64)
    wanted = (
        modulated(signal, Settings(output="envelope", loop=True), rate=RATE)[0].samples[0].astype(np.float64)
    )
    wanted = wanted / settings.carrier_v - 1
    lines = np.arange(LINES[0], LINES[1] + 1, LINES[2])
    gain = np.abs(np.fft.rfft(arrived)[lines] / np.fft.rfft(wanted)[lines])
    # By formula: the low-pass, with what pre-emphasis gave before.
    low_pass = np.abs(transducer.envelope_response(lines))
    cap = 10 ** (settings.cap_db / 20)
    expected = low_pass * (np.minimum(1 / low_pass, cap) if emphasised else 1.0)
    gain_relative = gain / gain[0] * expected[0]
    swing = (arrived / settings.carrier_v).std() / wanted.std()
    found = facts["transducer"]
    how = f"with pre-emphasis (cap {settings.cap_db:g} dB)" if emphasised else "without pre-emphasis"
    passed = EnvelopeTransmission(
        f"Q {q}, {how}",
        float(RATE),
        wanted,
        drive.samples[0].astype(np.float64) / settings.peak_v,
        arrived / settings.peak_v,
        lines.astype(np.float64),
        gain_relative,
        expected,
        found["flat_to_hz"],
    )
    return passed, {
        "q": q,
        "pre_emphasis": emphasised,
        "cutoff_hz": found["cutoff_hz"],
        "flat_to_hz": found["flat_to_hz"],
        "minus_3_db_hz": found["minus_3_db_hz"],
        "minus_3_db_hz_simulated": _crossing(lines.astype(np.float64), gain_relative),
        "unevenness_db_to_flat": _unevenness(lines, gain_relative, found["flat_to_hz"]),
        "largest_difference_from_formula_db": float(np.abs(20 * np.log10(gain_relative / expected)).max()),
        "correlation": float(np.corrcoef(arrived, wanted)[0, 1]),
        "depth": facts["depth"],
        "recovered_depth": facts["recovered_depth"],
        "recovered_swing_db": float(20 * np.log10(swing)),
        "highest_v_at_transducer": facts["highest_v"] * settings.amplifier_gain,
    }


def _waveform_check(signal: Signal) -> dict[str, float]:
    """Return how far the waveform, carrier and all, differs from its envelope at Q 100, with pre-emphasis."""
    settings = Settings(q=100, pre_emphasis=True)
    short = signal.cut(0, 2000)
    waveform, _ = modulated(short, settings, rate=WAVEFORM_RATE)
    envelope, _ = modulated(short, settings.model_copy(update={"output": "envelope"}), rate=WAVEFORM_RATE)
    transducer = Transducer(q=100)
    heard = demodulated(simulate_waveform(transducer, waveform), carrier_hz=28_200, band_hz=5000)
    wanted = simulate_envelope(transducer, envelope)
    inside = slice(WAVEFORM_RATE // 50, -WAVEFORM_RATE // 50)
    away = np.abs(heard.samples[0, inside] - wanted.samples[0, inside])
    return {"q": 100, "rate": WAVEFORM_RATE, "largest_difference": float(away.max() / wanted.samples.max())}


def _tracking(folder: Path, seeds: int) -> tuple[dict[str, dict[str, TrackingResult]], list[dict[str, Any]]]:
    """Return one run of each way to be drawn, and a row of figures for each over all seeds."""
    cases = {name: DriftingTransducer(PRESETS[name], DRIFT_HZ, STEPS) for name in TRACKED}
    titles = dict(TRACKED)
    cases["touched"] = DriftingTransducer(PRESETS["plate"], DRIFT_HZ, STEPS, (TOUCH,))
    titles["touched"] = "plate, touched meanwhile"
    shown: dict[str, dict[str, TrackingResult]] = {}
    rows = []
    for name, case in cases.items():
        for method in METHODS:
            settings = TrackingSettings(method=method)  # type: ignore[arg-type]
            runs = [
                track(
                    SimulatedAdmittance(case, noise=NOISE, rng=np.random.default_rng(seed)),
                    settings,
                    steps=STEPS,
                )
                for seed in range(seeds)
            ]
            shown.setdefault(titles[name], {})[method] = runs[0]
            summaries = [one.summary() for one in runs]
            rows.append(
                {
                    "transducer": name,
                    "q": case.transducer.q,
                    "method": method,
                    **{key: float(np.mean([s[key] for s in summaries])) for key in summaries[0]},
                    "max_hz_of_all": max(s["max_hz"] for s in summaries),
                    "bias_by_formula_hz": _bias(case.transducer) if "admittance" in method else 0.0,
                    "touched": bool(case.touches),
                    "lost": sum(point.state == "lost" for one in runs for point in one.tracker.log),
                }
            )
    shown[titles["plate"]]["motional_phase"].tracker.write_log(folder / "tracking-log.csv")
    return shown, rows


def _bias(transducer: Transducer) -> float:
    """Return where abs(Y) is largest, less the resonance, Hz."""
    span = 2 * transducer.envelope_cutoff_hz
    f = np.linspace(transducer.resonance_hz - span, transducer.resonance_hz + span, 40_001)
    return float(f[np.abs(transducer.admittance(f)).argmax()] - transducer.resonance_hz)


def _crossing(frequency: Array, gain: Array) -> float | None:
    """Return where ``gain`` first falls by 3 dB, between two lines; None if nowhere."""
    below = np.flatnonzero(gain < np.sqrt(0.5))
    if len(below) == 0 or below[0] == 0:
        return None
    k = below[0]
    return float(np.interp(-np.sqrt(0.5), -gain[k - 1 : k + 1], frequency[k - 1 : k + 1]))


def _unevenness(frequency: NDArray[np.int64], gain: Array, flat_to: float) -> float | None:
    """Return the spread of ``gain`` up to ``flat_to``, dB; None where nothing is flat."""
    inside = 20 * np.log10(gain[frequency <= flat_to])
    return float(np.ptp(inside)) if len(inside) else None


def _text(result: dict[str, Any]) -> str:
    lines = [
        "Simulated transducers; nothing was measured on a device. Modulation: " + result["modulating"] + ".",
        "What arrives (swing: of the modulation, against a full one):",
        f"{'Q':>5}{'pre-emph.':>11}{'cut-off Hz':>12}{'flat to Hz':>12}{'-3 dB Hz':>10}{'simulated':>11}"
        f"{'correlation':>13}{'depth':>8}{'swing dB':>10}",
    ]
    for row in result["arriving"]:
        half = row["minus_3_db_hz_simulated"]
        lines.append(
            f"{row['q']:>5}{'yes' if row['pre_emphasis'] else 'no':>11}{row['cutoff_hz']:>12.0f}"
            f"{row['flat_to_hz']:>12.0f}{row['minus_3_db_hz']:>10.0f}{'>1000' if half is None else f'{half:.0f}':>11}"
            f"{row['correlation']:>13.4f}{row['recovered_depth']:>8.3f}{row['recovered_swing_db']:>10.1f}"
        )
    lines += [
        f"Carrier less resonance over {result['steps']} steps and a drift of {result['drift_hz']:g} Hz, "
        f"{result['seeds']} seeds, Hz:",
        f"{'transducer':>12}{'method':>22}{'mean':>9}{'sd':>8}{'max':>8}{'by formula':>12}{'lost':>6}",
    ]
    lines += [
        f"{row['transducer']:>12}{row['method']:>22}{row['mean_hz']:>9.2f}{row['sd_hz']:>8.2f}{row['max_hz']:>8.1f}"
        f"{'-' if row['touched'] else format(row['bias_by_formula_hz'], '.1f'):>12}{row['lost']:>6}"
        for row in result["tracking"]
    ]
    return "\n".join(lines)
