"""Conversion loss: a signal compared to the one read back from its file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.rendering.files.envelope import envelope_of
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

FLAT = 1e-6
"""Spread of samples, relative to their largest, below which a correlation is meaningless."""
FLAT_ENVELOPE = 0.02
"""The same for an envelope: smaller variations are noise of the analysis."""
KEPT, ROUGHLY = 0.9, 0.6
"""Correlations of the envelopes above which `loss_sentence` calls the strength kept, or roughly kept. Ours."""
STEADY = 0.3
"""Error of an envelope without correlation, one that hardly varies, below which it is kept. Ours."""
KEPT_DB, KEPT_OCTAVES = 3.0, 0.25
"""Differences up to which level and frequency count as kept. Ours."""
LOSSLESS_DB = 60.0
FELT = 0.2
"""Error of an envelope that may be felt: the smallest Weber fraction of intensity that publications report."""
CLOSE_DB = 20.0
"""Signal over error from which a stored waveform counts as the signal. Ours: a tenth of its amplitude."""
BUZZ_SHARE = 0.5
"""Share of the envelope's peak above which a pattern is on."""


@dataclass(frozen=True)
class ConversionLoss:
    """Differences between a signal and its copy; None if undefined, such as the correlation with a constant.

    Correlations are Pearson's, of the envelopes (20 ms windows, every 5 ms) and of the samples. ``envelope_error`` is
    the root mean square of the envelopes' difference relative to the signal's; ``level_db`` compares root mean squares
    up to 1000 Hz without the constant; ``frequency_octaves`` is the mean difference of the momentary frequencies in
    octaves, weighted by the signal's power; ``snr_db`` the samples' power relative to that of their difference.
    """

    envelope_correlation: float | None
    envelope_error: float | None
    level_db: float | None
    frequency_octaves: float | None
    waveform_correlation: float | None
    snr_db: float | None


def loss_between(original: Signal, copy: Signal) -> ConversionLoss:
    """Return the loss of ``copy`` compared to ``original``, both of one axis, the same domain and unit."""
    if original.domain != "time":
        correlation, snr = _waveform(original, copy)
        return ConversionLoss(None, None, None, None, correlation, snr)
    one, other = envelope_of(original, pulses=False), envelope_of(copy, pulses=False)
    a = one.amplitude
    b = np.interp(one.times, other.times, other.amplitude, right=0.0)  # the copy may be shorter
    power, copied = float(np.mean(a**2)), float(np.mean(b**2))
    shift = None
    if power > 0 and copied > 0:
        f = np.maximum(np.interp(one.times, other.frequency_times, other.frequency), 1.0)
        octaves = np.abs(np.log2(f / np.maximum(one.frequency, 1.0)))
        shift = float(np.average(octaves, weights=a**2))
    correlation, snr = _waveform(original, copy)
    return ConversionLoss(
        envelope_correlation=_correlation(a, b, flat=FLAT_ENVELOPE),
        envelope_error=float(np.sqrt(np.mean((a - b) ** 2) / power)) if power > 0 else None,
        level_db=10 * float(np.log10(copied / power)) if power > 0 and copied > 0 else None,
        frequency_octaves=shift,
        waveform_correlation=correlation,
        snr_db=snr,
    )


def loss_sentence(loss: ConversionLoss, holds: str) -> str:
    """Return in a sentence what a file keeps of a signal and what it loses.

    ``holds`` is that of the file's format (`HapticFormat`).
    """
    if holds == "waveform":
        if loss.snr_db is None or loss.snr_db > LOSSLESS_DB:
            return "keeps the waveform"
        return f"keeps the waveform with an error of {-loss.snr_db:.0f} dB"
    kept, lost = [], ["the waveform"]
    similar = loss.envelope_correlation
    if similar is None:
        similar = float(loss.envelope_error is None or loss.envelope_error < STEADY)
    if similar > ROUGHLY:
        kept.append("the strength over time" if similar > KEPT else "roughly the strength over time")
    else:
        lost.append("the changes of strength")
    if loss.level_db is not None:
        found = abs(loss.level_db) <= KEPT_DB
        (kept if found else lost).append("the level" if found else f"the level ({loss.level_db:+.0f} dB)")
    if (off := loss.frequency_octaves) is not None:
        found = off <= KEPT_OCTAVES
        (kept if found else lost).append(
            "the frequency" if found else f"the frequency ({off:.1f} octaves off)"
        )
    return f"keeps {_listed(kept) or 'little'}; loses {_listed(lost)}"


def verdict(loss: ConversionLoss, copy: Signal, *, holds: str, instead: str) -> str:
    """Return in a sentence what remains of a signal in a file, and what to use instead where that is too little.

    ``copy`` is the one axis read back; ``holds`` and ``instead`` are those of the file's format (`HapticFormat`).
    """
    if holds == "waveform":
        if loss.snr_db is None or loss.snr_db >= CLOSE_DB:
            return "the signal itself"
        return f"the signal, roughly: use {instead} instead"
    if holds == "on and off":
        count = _buzzes(copy)
        return f"{'one buzz' if count == 1 else f'{count} buzzes of one strength'}: use {instead} instead"
    if loss.envelope_error is None:
        return "silence, as the signal"
    similar = loss.envelope_correlation
    if loss.envelope_error >= FELT and (similar is None or similar <= KEPT):
        return f"a vibration too coarse for the signal's changes of strength: use {instead} instead"
    if loss.frequency_octaves is not None and loss.frequency_octaves > KEPT_OCTAVES:
        return f"the strength, at the wrong frequency: use {instead} instead"
    return (
        "one tone of the signal's strength and frequency: enough for an effect; a texture needs a waveform "
        "(.wav, .hjif)"
    )


def _buzzes(copy: Signal) -> int:
    """Return how often a pattern switches on."""
    amplitude = envelope_of(copy, pulses=False).amplitude
    on = amplitude > BUZZ_SHARE * amplitude.max(initial=0.0)
    return int(np.count_nonzero(np.diff(on.astype(int), prepend=0) > 0))


def _listed(parts: list[str]) -> str:
    """Return words as a list in English."""
    *first, last = parts or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _waveform(original: Signal, copy: Signal) -> tuple[float | None, float | None]:
    copy = resample(copy, original.rate)
    count = min(len(original), len(copy))
    a = original.samples[0, :count].astype(np.float64)
    b = copy.samples[0, :count].astype(np.float64)
    power, error = float(np.mean(a**2)), float(np.mean((a - b) ** 2))
    if power == 0:
        return None, None
    return _correlation(a, b), 10 * float(np.log10(power / error)) if error > 0 else None


def _correlation(a: NDArray[np.float64], b: NDArray[np.float64], flat: float = FLAT) -> float | None:
    """Return Pearson's correlation; None if either hardly varies."""
    largest = max(float(np.abs(a).max()), float(np.abs(b).max()))
    if len(a) < 2 or min(a.std(), b.std()) <= flat * largest:
        return None
    return float(np.corrcoef(a, b)[0, 1])
