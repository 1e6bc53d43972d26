"""Conversion loss: a signal, or events, compared to those read back from a file."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.control_points import Pulse
from tactogram.rendering.files.events import PULSE_S, STEP_S, Events, Line, spans_of, stepped
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

FLAT = 1e-6
"""Spread of samples, relative to their largest, below which a correlation is meaningless."""
FLAT_ENVELOPE = 0.02
"""The same for an envelope: smaller variations are noise of the analysis."""
KEPT_DB, KEPT_OCTAVES = 3.0, 0.25
"""Differences up to which level and frequency count as kept. Ours."""
LOSSLESS_DB = 60.0
FELT, LOST = 0.2, 0.7
"""Errors of an envelope, apart from its level: the smallest that may be felt, the smallest Weber fraction of intensity
that publications report; and that of which as much is lost as kept. Up to it the strength is roughly kept."""
CLOSE_DB = 20.0
"""Signal over error from which a stored waveform counts as the signal. Ours: a tenth of its amplitude."""
MERGED_S = 0.060
"""A transient without a counterpart is merged if one of the file begins within this time. Ours."""
SAME_S = 0.001
"""Difference of a pulse's length up to which it is the same: files state whole ms."""
ABOUT, ABOUT_SHARE = 0.02, 0.05
"""Difference of a transient's strength, of full scale and of the strength, up to which it is the same. Ours."""


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
    correlation, snr = _waveform(original, copy)
    if original.domain != "time":
        return ConversionLoss(None, None, None, None, correlation, snr)
    one, other = envelope_of(original), envelope_of(copy)
    b = np.interp(one.times, other.times, other.amplitude, right=0.0)  # the copy may be shorter
    octaves = _octaves(Events(one.end, (one,)), Events(other.end, (other,)))
    return _strength_loss(one.amplitude, b, octaves, correlation, snr)


@dataclass(frozen=True)
class EventCounts:
    """Numbers of events: the source's transients, and what became of them in a file.

    Each is ``kept``, ``merged`` with a neighbour, ``in_vibration`` (a part of the vibration), or ``lost``. Of those
    kept some are of another ``strength``, ``frequency`` or ``length``. ``added`` are transients that the source has
    not; ``vibrations`` are those of the source, from silence to silence, of which ``vibrations_lost`` are silent.
    """

    transients: int = 0
    kept: int = 0
    merged: int = 0
    in_vibration: int = 0
    lost: int = 0
    strength: int = 0
    frequency: int = 0
    length: int = 0
    added: int = 0
    vibrations: int = 0
    vibrations_lost: int = 0


def compared(source: Events, copy: Events, close_s: float) -> tuple[ConversionLoss, EventCounts]:
    """Return the loss of the events read back from a file, compared to those of its source.

    Transients are the same up to ``close_s`` apart. Frequencies that both state as shares are compared as shares.
    """
    if source.span and copy.span and source.span != copy.span:
        copy = copy.in_span(source.span)
    times = np.array([tap.time for tap in copy.transients])
    pairs: dict[int, int] = {}
    for i, tap in enumerate(source.transients):
        near = range(*np.searchsorted(times, [tap.time - close_s - 1e-9, tap.time + close_s + 1e-9]))
        match = min((j for j in near if j not in pairs), key=lambda j: abs(times[j] - tap.time), default=None)
        if match is not None:
            pairs[match] = i
    counts: Counter[str] = Counter(kept=len(pairs))
    for j, i in pairs.items():
        tap, other = source.transients[i], copy.transients[j]
        difference = abs(other.amplitude - tap.amplitude)
        counts["strength"] += difference > max(ABOUT, ABOUT_SHARE * tap.amplitude)
        octaves = abs(np.log2(max(other.frequency, 1.0) / max(tap.frequency, 1.0)))
        counts["frequency"] += bool(octaves > KEPT_OCTAVES)
        counts["length"] += isinstance(tap, Pulse) and not (
            isinstance(other, Pulse) and abs(other.seconds - tap.seconds) <= SAME_S
        )
    kept = set(pairs.values())
    missing = [tap for i, tap in enumerate(source.transients) if i not in kept]
    added = [tap for j, tap in enumerate(copy.transients) if j not in pairs and not isinstance(tap, Pulse)]
    counts["transients"], counts["added"] = len(source.transients), len(added)
    own = source.joined
    source, copy = _lasting(source, kept), _lasting(copy, set(pairs))
    # Beside whole ms, at which rounding would decide whether a transient has begun.
    t = np.arange(3e-4, max(source.seconds, copy.seconds) + STEP_S, STEP_S)
    loss = _strength_loss(source.strength(t), copy.strength(t), _octaves(source, copy))
    on = (own.amplitude[:-1] > 0) | (own.amplitude[1:] > 0)
    spans = spans_of(own.times[:-1][on], own.times[1:][on], PULSE_S)
    counts["vibrations"] = len(spans)
    begins, stops = np.array(spans).reshape(-1, 2).T
    within = np.linspace(begins, stops, 33, axis=1)
    counts["vibrations_lost"] = int((copy.strength(within.ravel()).reshape(-1, 33).max(axis=1) == 0).sum())
    for tap in missing:
        around = copy.joined.at(tap.time + np.linspace(0, 2 * PULSE_S, 9)).max()
        merged = len(times) and float(np.abs(times - tap.time).min()) <= MERGED_S
        counts["merged" if merged else "in_vibration" if around >= tap.amplitude / 2 else "lost"] += 1
    return loss, EventCounts(**counts)


def loss_sentence(loss: ConversionLoss, holds: str, counts: EventCounts | None = None) -> str:
    """Return in a sentence what a file keeps and what it loses, of a signal or of events, which have ``counts``.

    ``holds`` is that of the file's format (`HapticFormat`).
    """
    if holds == "waveform" and counts is None:
        if loss.snr_db is None or loss.snr_db > LOSSLESS_DB:
            return "keeps the waveform"
        return f"keeps the waveform with an error of {-loss.snr_db:.0f} dB"
    kept, lost = _kept_and_lost(loss, counts)
    return f"keeps {_listed(kept) or 'little'}; loses {_listed(lost) or 'nothing'}"


def _kept_and_lost(loss: ConversionLoss, counts: EventCounts | None) -> tuple[list[str], list[str]]:
    """Return what is kept, and what is lost, in words: `loss_sentence` and `verdict` follow it."""
    kept, lost = _counted(counts) if counts else ([], ["the waveform"])
    if counts is None or counts.vibrations:
        shape = _shape_error(loss)
        if shape < LOST:
            kept.append(f"{'' if shape < FELT else 'roughly '}the strength over time")
        if shape >= (FELT if counts else LOST):
            lost.append(f"{'some' if shape < LOST else 'the'} changes of strength")
        level, octaves = loss.level_db, loss.frequency_octaves
        if level is not None:
            same = abs(level) <= KEPT_DB
            (kept if same else lost).append("the level" + ("" if same else f" ({level:+.0f} dB)"))
        if octaves is not None:
            same = octaves <= KEPT_OCTAVES
            (kept if same else lost).append(
                "the frequency" + ("" if same else f" ({octaves:.1f} octaves off)")
            )
    return kept, lost


def loss_rank(loss: ConversionLoss, counts: EventCounts | None) -> tuple[float, float]:
    """Return the number of missing events, or else the share that `loss_sentence` calls lost, and the error."""
    missing = counts.transients - counts.kept + counts.vibrations_lost if counts else 0
    kept, lost = _kept_and_lost(loss, counts)
    return missing or len(lost) / (1 + len(kept) + len(lost)), loss.envelope_error or 0.0


def _shape_error(loss: ConversionLoss) -> float:
    """Return the error of the strength over time apart from its level, relative to that of the copy."""
    if loss.envelope_error is None or loss.level_db is None:
        return float(loss.envelope_error or 0.0)
    # The copy is the strength times a factor, and a rest: error and level are known, so the rest is.
    power = 10 ** (loss.level_db / 10)
    factor = (1 + power - loss.envelope_error**2) / 2
    return float(max(0.0, 1 - factor**2 / power) ** 0.5)


def _counted(counts: EventCounts) -> tuple[list[str], list[str]]:
    """Return what of events is kept, and what is lost, in words."""
    of = f"of {_number(counts.transients, 'transient')}"
    kept = [f"{counts.kept} {of}"] if counts.transients else []
    words = {
        "merged": f"{counts.merged} {of} (merged with a neighbour)",
        "in_vibration": f"{counts.in_vibration} {of} (part of a vibration)",
        "lost": f"{counts.lost} {of} (left out)",
        "strength": f"the strength of {counts.strength} {of}",
        "frequency": f"the frequency of {counts.frequency} {of}",
        "length": f"the length of {counts.length} {of}",
        "vibrations_lost": f"{counts.vibrations_lost} of {_number(counts.vibrations, 'vibration')}",
        "added": f"{_number(counts.added, 'vibration')} (now short pulses)",
    }
    return kept, [text for name, text in words.items() if getattr(counts, name)]


def verdict(
    loss: ConversionLoss, holds: str, instead: str, *, buzzes: int = 0, counts: EventCounts | None = None
) -> str:
    """Return in a sentence what remains in a file, and what to use instead where that is too little.

    ``holds`` is that of the file's format (`HapticFormat`), ``instead`` what keeps more, if anything, ``buzzes`` how
    often a pattern switches on. Events have ``counts``, a signal has none.
    """
    remedy = f": use {instead} instead" if instead else ""
    if holds == "on and off":
        return f"{'one buzz' if buzzes == 1 else f'{buzzes} buzzes of one strength'}{remedy}"
    if counts:
        gone = {"transient": counts.transients - counts.kept, "vibration": counts.vibrations_lost}
        count = {"transient": counts.transients, "vibration": counts.vibrations}
        lost = [f"{gone[noun]} of {_number(count[noun], noun)}" for noun in gone if gone[noun]]
        if lost:
            return f"not all events: {_listed(lost)} missing{remedy.replace(':', ';', 1)}"
    elif holds == "waveform":
        close = loss.snr_db is None or loss.snr_db >= CLOSE_DB
        return "the signal itself" if close else f"the signal, roughly{remedy}"
    elif loss.envelope_error is None:
        return "silence, as the signal"
    if (counts is None or counts.vibrations) and _shape_error(loss) >= FELT:
        return f"a vibration too coarse for the changes of strength{remedy}"
    if (loss.frequency_octaves or 0) > KEPT_OCTAVES or (counts and counts.frequency):
        return f"the strength, at the wrong frequency{remedy}"
    if counts:
        lost = _kept_and_lost(loss, counts)[1]
        return f"the events without {_listed(lost)}{remedy}" if lost else "the events themselves"
    return (
        "one tone of the signal's strength and frequency: enough for an effect; a texture needs a waveform "
        "(.wav, .hjif)"
    )


def _strength_loss(
    a: Line, b: Line, octaves: float | None, correlation: float | None = None, snr: float | None = None
) -> ConversionLoss:
    """Return the loss of a strength ``b`` compared to ``a`` at the same times, with what is known of it."""
    power, copied = float(np.mean(a**2)), float(np.mean(b**2))
    return ConversionLoss(
        envelope_correlation=_correlation(a, b, flat=FLAT_ENVELOPE),
        envelope_error=float(np.sqrt(np.mean((a - b) ** 2) / power)) if power > 0 else None,
        level_db=10 * float(np.log10(copied / power)) if power > 0 and copied > 0 else None,
        frequency_octaves=octaves,
        waveform_correlation=correlation,
        snr_db=snr,
    )


def _lasting(events: Events, matched: set[int]) -> Events:
    """Return events with the pulses that are not ``matched`` as what they are, short vibrations."""
    whole, parts = events.joined, list(events.parts)
    pulses = [tap for i, tap in enumerate(events.transients) if i not in matched and isinstance(tap, Pulse)]
    for tap in pulses:
        above = tap.amplitude**2 - float(whole.at(tap.time + tap.seconds / 2)) ** 2
        edges = np.array([tap.time, tap.time + tap.seconds])
        parts.append(stepped(edges, np.array([max(0.0, above) ** 0.5]), tap.frequency))
    taps = tuple(tap for tap in events.transients if tap not in pulses)
    return replace(events, parts=tuple(parts), transients=taps)


def _octaves(source: Events, copy: Events) -> float | None:
    """Return the mean difference of frequency of each vibration to the closest that sounds at its time in the copy."""
    starts, ends = (np.array([getattr(piece, name) for piece in copy.parts]) for name in ("start", "end"))
    total = weight = 0.0
    for part in source.parts:
        edges = np.linspace(part.start, part.end, 2 + int((part.end - part.start) / STEP_S))
        t = (edges[:-1] + edges[1:]) / 2
        off = np.full(len(t), np.inf)
        for i in np.flatnonzero((starts < part.end) & (ends > part.start)):
            hz = np.maximum(copy.parts[i].hz(t), 1) / np.maximum(part.hz(t), 1)
            off = np.minimum(off, np.where(copy.parts[i].at(t) > 0, np.abs(np.log2(hz)), np.inf))
        power = np.where(np.isfinite(off), part.at(t) ** 2 * (edges[1] - edges[0]), 0.0)
        total += float(power @ np.where(power > 0, off, 0.0))
        weight += float(power.sum())
    return total / weight if weight else None


def _number(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _listed(parts: list[str]) -> str:
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


def _correlation(a: Line, b: Line, flat: float = FLAT) -> float | None:
    """Return Pearson's correlation; None if either hardly varies."""
    largest = max(float(np.abs(a).max()), float(np.abs(b).max()))
    if len(a) < 2 or min(a.std(), b.std()) <= flat * largest:
        return None
    return float(np.corrcoef(a, b)[0, 1])
