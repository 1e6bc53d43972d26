"""Haptic files written from signals and events, read back, with level and loss."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.axes import to_one_axis
from tactogram.rendering.drive.level_scaling import without_constant
from tactogram.rendering.files.analysis import READ_RATE, events_of, power_felt
from tactogram.rendering.files.catalogue import HapticFormat, haptic_format, haptic_formats
from tactogram.rendering.files.documents import DocumentHeader, Notes
from tactogram.rendering.files.events import Events, joined
from tactogram.rendering.files.loss import (
    KEPT_DB,
    ConversionLoss,
    EventCounts,
    compared,
    loss_between,
    loss_rank,
    loss_sentence,
    verdict,
)
from tactogram.rendering.files.reading import HapticFile, decoded
from tactogram.signal import Signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.content import SignalDescription
from tactogram.signal.resampling import resample

GRAVITY = 1.0
"""A motion's constant above this many times its vibration (rms) is removed; below, the copy stays exact."""
MOSTLY_FELT, FELT_AT_ALL = 0.9, 0.5
"""Shares of a signal's power up to 1000 Hz below which its rest is mentioned, and a file of events misses it. Ours."""


def write_haptic(
    path: Path | str,
    content: Signal | Events | HapticFile,
    *,
    format: str,
    axis: str | None = None,
    full_scale: float | None = None,
    modality: str | None = None,
    motor: Display | None = None,
    metadata: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Write a signal or events as a haptic file, read it back, and return what it keeps.

    Events, and those of a file, are written as events; a signal is analysed where the format holds no waveform. Raises
    `ParameterError` if an argument does not fit the format or the format cannot hold the content; nothing is written
    then.

    Parameters
    ----------
    path : Path
        Replaced once everything is written.
    content : Signal, Events or HapticFile
        Events are in parts of full scale; those of a file keep its unit and its level.
    axis : str, optional
        Of a signal, as in `to_one_axis`; a waveform format keeps all axes by default.
    full_scale : float, optional
        What 1 in the file stands for, in the content's unit; stored in the file's description. By default 1 for
        content of unit 1 that fits, the scale of a file, else the peak: of the samples in a waveform, of the events
        in others.
    modality : str, optional
        One of the format's; chosen by unit by default.
    motor : Display, optional
        Motor that a format of on and off is for: no pulse or pause is shorter than its ``shortest_ms``. By default the
        format's own.
    metadata : mapping, optional
        Stored in the description.

    Returns
    -------
    dict
        ``format``, ``holds``, ``constant`` (gravity or an offset that was removed, in words, or None), ``reduced_by``
        (how axes became one, or None), ``full_scale``, ``scaled_by`` (factor of the content), ``loss`` (by axis, as
        `ConversionLoss`: measured by reading the file back), ``events`` (of events: how many are kept, as
        `loss.EventCounts`), ``told`` (what is kept and lost, a sentence each), ``verdict`` (in words, of the axis that
        loses most), ``resampled_to``, ``carrier``, ``bytes``.
    """
    path, kind = Path(path), haptic_format(format)
    _check_modality(kind, modality)
    shortest_ms = _shortest_ms(kind, motor)
    if isinstance(content, HapticFile) and content.events is None:
        content = content.signal
    original: Signal | Events
    stored: Signal | Events
    if isinstance(content, Signal):
        original, constant, how = _felt(content, kind, axis)
        stored, usual, left_out = _held(original, kind), 1.0, None
        rate = stored.rate if isinstance(stored, Signal) else original.rate
        about = SignalDescription(rate, original.unit, original.axes, original.domain)
    else:
        file = content if isinstance(content, HapticFile) else HapticFile(content)
        axes = file.description.axes if file.description else ()
        if axis not in (None, "mean", *axes):
            raise ParameterError(f"axis: events have one axis, got {axis!r}; omit it")
        original, constant, how = file.events or Events(0.0), None, None
        stored, usual, left_out = original, file.full_scale, file.facts.get("left_out")
        about = SignalDescription(READ_RATE, file.unit, axes[:1] or ("x",))
    peak = _peak(stored, kind) if isinstance(stored, Events) else float(np.abs(stored.samples).max())
    scale = _scale(usual * peak, about.unit, full_scale, usual)
    about = replace(about, full_scale=scale, metadata=dict(metadata or {}))
    header = DocumentHeader(about.encode(), about.unit, modality, shortest_ms)
    if isinstance(stored, Events):
        document = kind.encode(stored.scaled(usual / scale), header)
    elif kind.encode_waveform:
        shares = stored.samples.astype(np.float64) / scale
        document = kind.encode_waveform(stored.with_samples(shares, unit="1"), header)
    notes = Notes()
    back = decoded(document, kind, notes)
    if broken := [*notes.problems, *notes.warnings]:
        raise ParameterError(f"{kind.title} cannot hold this signal: {broken[0]}")
    kept = _kept(original if isinstance(original, Signal) else original.scaled(usual / scale), back, kind)
    kept["told"] += [f"Not read: {left_out}."] if left_out else []
    data = kind.serialise(document)
    with atomic_write(path) as part:
        part.write_bytes(data)
    return {
        "format": kind.name,
        "holds": kind.holds,
        "constant": constant,
        "reduced_by": how,
        "full_scale": scale,
        "scaled_by": usual / scale,
        "resampled_to": about.rate if isinstance(stored, Signal) and stored is not original else None,
        "carrier": {k: v for k, v in back.facts.items() if k.startswith("carrier")} or None,
        **kept,
        "bytes": len(data),
    }


def _felt(signal: Signal, kind: HapticFormat, axis: str | None) -> tuple[Signal, str | None, str | None]:
    """Return what is written of a signal, the constant that was removed, and how axes became one, in words."""
    if kind.encode_waveform is None and signal.domain != "time":
        raise ParameterError(
            f"{kind.title} is over time: convert the displacement at a speed first (play_at)"
        )
    signal, constant = without_constant(signal, least=GRAVITY)
    chosen, how = to_one_axis(signal, axis) if kind.encode_waveform is None or axis else (signal, None)
    return chosen, constant, how


def _held(signal: Signal, kind: HapticFormat) -> Signal | Events:
    """Return the events of a signal, or itself where the format holds waveforms, at a rate that it holds."""
    if kind.encode_waveform is None:
        return events_of(signal, kind.bands)
    if kind.highest_rate is None or signal.domain != "time" or signal.rate <= kind.highest_rate:
        return signal
    return resample(signal, kind.highest_rate)


def _kept(content: Signal | Events, back: HapticFile, kind: HapticFormat) -> dict[str, Any]:
    """Return what a file keeps and loses: by axis, in a sentence each, and the verdict."""
    loss_by_axis, counts = _measured(content, back, kind)
    told = [f"{axis} {loss_sentence(loss, kind.holds, counts)}." for axis, loss in loss_by_axis.items()]
    worst = min(loss_by_axis.values(), key=lambda loss: np.inf if loss.snr_db is None else loss.snr_db)
    buzzes = back.events.count if back.events else 0
    word = verdict(worst, kind.holds, "", buzzes=buzzes, counts=counts)
    if word != verdict(worst, kind.holds, " or ".join(kind.instead), buzzes=buzzes, counts=counts):
        better = _better(content, kind, loss_rank(worst, counts))
        word = verdict(worst, kind.holds, better, buzzes=buzzes, counts=counts)
    felt_share = power_felt(content) if isinstance(content, Signal) and kind.holds != "waveform" else 1.0
    if felt_share < MOSTLY_FELT:
        share = f"{100 * felt_share:.0f} % of the signal's power"
        louder = (worst.level_db or 0.0) > KEPT_DB
        high = "which a finger does not feel" + ("" if louder else " and the file leaves out")
        told.insert(0, f"Only {share} is up to 1000 Hz; the rest is above 1000 Hz, {high}.")
        if felt_share < FELT_AT_ALL:
            remedy = "map the sound to touch instead (--map envelope)"
            told, word = told[: 1 + louder], f"not the signal, only {share}: {remedy}"
    losses = [asdict(loss) for loss in loss_by_axis.values()]
    facts = {"loss": dict(zip(loss_by_axis, losses, strict=True)) if len(losses) > 1 else losses[0]}
    return facts | ({"events": asdict(counts)} if counts else {}) | {"told": told, "verdict": word}


def _measured(
    content: Signal | Events, back: HapticFile, kind: HapticFormat
) -> tuple[dict[str, ConversionLoss], EventCounts | None]:
    """Return the loss by axis of a signal, or of events, which are counted, too."""
    if isinstance(content, Events):
        copy = back.events or events_of(back.signal)
        loss, counts = compared(content, copy, max(0.002, kind.resolution_s))
        return {"The file": loss}, counts
    single_axis = len(content.axes) == 1
    copies = (back.signal.with_samples(row, axes=("x",)) for row in back.signal.samples)
    pairs = zip(content.axes, copies, strict=True)
    return {
        "The file" if single_axis else name: loss_between(content.select(name), copy) for name, copy in pairs
    }, None


def _better(content: Signal | Events, kind: HapticFormat, lost: tuple[float, float]) -> str:
    """Return those of a format's remedies that lose less than ``lost`` (`loss_rank`), or cannot be tried."""
    formats = haptic_formats()
    return " or ".join(
        remedy
        for remedy, name in kind.instead.items()
        if (other := formats.get(name.removeprefix("."))) is None or _rank(content, other) < lost
    )


def _rank(content: Signal | Events, kind: HapticFormat) -> tuple[float, float]:
    """Return the `loss_rank` of a format, infinite if it refuses the content."""
    if isinstance(content, Signal) and kind.encode_waveform:
        return 0.0, 0.0
    events = content if isinstance(content, Events) else events_of(content, kind.bands)
    share = 1 / max(1.0, _peak(events, kind))
    try:
        back = decoded(kind.encode(events.scaled(share), DocumentHeader()), kind, Notes())
    except ParameterError:
        return np.inf, np.inf
    if isinstance(content, Signal):
        losses, counts = _measured(content.with_samples(share * content.samples), back, kind)
    else:
        losses, counts = _measured(events.scaled(share), back, kind)
    return loss_rank(losses["The file"], counts)


def _peak(events: Events, kind: HapticFormat) -> float:
    """Return the largest amplitude in any of a format's bands, each of which has an actuator of its own."""
    edges = [high for _, high in kind.bands[:-1]]
    peaks = [tap.amplitude for tap in events.transients]
    for band in range(len(edges) + 1):
        inside = (np.searchsorted(edges, part.frequency) == band for part in events.parts)
        shares = zip(events.parts, inside, strict=True)
        peaks.append(joined([replace(part, amplitude=part.amplitude * on) for part, on in shares]).peak)
    return max(peaks)


def _scale(peak: float, unit: str, full_scale: float | None, usual: float) -> float:
    """Return what 1 stands for, ``usual`` if it fits; `ParameterError` if the peak exceeds the one asked for."""
    if full_scale is None:
        fits = peak <= usual * (1 + 1e-6) and (unit == "1" or usual != 1)
        return usual if peak == 0 or fits else peak
    if not (full_scale > 0 and np.isfinite(full_scale)):
        raise ParameterError.must("full_scale", f"be > 0 {unit}", full_scale)
    if peak > full_scale * (1 + 1e-6):
        raise ParameterError.must(
            "full_scale", f"be at least the peak of {peak:.6g} {unit}", full_scale, remedy="it would clip"
        )
    return float(full_scale)


def _check_modality(kind: HapticFormat, modality: str | None) -> None:
    if modality is None or modality in kind.modalities:
        return
    if not kind.modalities:
        raise ParameterError(f"{kind.title} has no modalities; omit modality")
    raise ParameterError.one_of("modality", kind.modalities, modality)


def _shortest_ms(kind: HapticFormat, motor: Display | None) -> float | None:
    if motor is None:
        return None
    if kind.holds != "on and off":
        raise ParameterError(f"{kind.title} does not only switch on and off; omit the motor's display")
    if motor.shortest_ms is None:
        raise ParameterError(
            f"{motor.name}: states no shortest_ms, which a pattern of on and off needs; use a display that does"
        )
    return motor.shortest_ms
