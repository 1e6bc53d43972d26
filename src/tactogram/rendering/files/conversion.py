"""Haptic files written from signals and events, read back, with level and loss."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.level_scaling import without_constant
from tactogram.rendering.files.analysis import READ_RATE, events_of, power_felt
from tactogram.rendering.files.catalogue import haptic_format
from tactogram.rendering.files.documents import DocumentHeader, Notes
from tactogram.rendering.files.events import Events
from tactogram.rendering.files.format import HapticFormat
from tactogram.rendering.files.loss import (
    ConversionLoss,
    compared,
    events_verdict,
    loss_between,
    loss_sentence,
    verdict,
)
from tactogram.rendering.files.reading import HapticFile, decoded
from tactogram.rendering.files.reduction import to_one_axis
from tactogram.signal import Signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.description import SignalDescription
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
    header = DocumentHeader("", "1", modality, _shortest_ms(kind, motor))
    if isinstance(content, HapticFile) and content.events is None:
        content = content.signal
    unit = "1" if isinstance(content, Events) else content.unit
    if full_scale is not None and not (full_scale > 0 and np.isfinite(full_scale)):
        raise ParameterError(f"full_scale must be > 0 {unit}, got {full_scale:g}")
    options = (kind, axis, full_scale, replace(header, unit=unit), dict(metadata or {}))
    if isinstance(content, Signal):
        facts, document = _signal_written(content, *options)
    else:
        facts, document = _events_written(content, *options)
    data = kind.serialise(document)
    with atomic_write(path) as part:
        part.write_bytes(data)
    return {"format": kind.name, "holds": kind.holds, **facts, "bytes": len(data)}


def _events_written(
    content: Events | HapticFile,
    kind: HapticFormat,
    axis: str | None,
    full_scale: float | None,
    header: DocumentHeader,
    metadata: dict[str, Any],
) -> tuple[dict[str, Any], Any]:
    """Return the facts and the document of events."""
    file = content if isinstance(content, HapticFile) else HapticFile(content)
    events = file.events or Events(0.0)
    if axis is not None and axis not in (*(file.description.axes if file.description else ()), "mean"):
        raise ParameterError(f"axis: events have one axis, got {axis!r}; omit it")
    scale = _scale(events.peak * file.full_scale, header.unit, full_scale, usual=file.full_scale)
    ready = events if file.full_scale == scale else events.scaled(file.full_scale / scale)
    axes = file.description.axes[:1] if file.description else ("x",)
    whole = SignalDescription(READ_RATE, header.unit, axes, "time", scale, metadata)
    document, back = _read_back(kind.encode(ready, replace(header, description=whole.encode())), kind)
    loss, counts = compared(ready, back.events or events_of(back.signal), max(0.002, kind.resolution_s))
    told = f"The file {loss_sentence(loss, 'envelope', counts)}."
    facts = _facts(back, None, None, scale, file.full_scale / scale, None)
    return facts | {
        "loss": asdict(loss),
        "events": asdict(counts),
        "told": [told, *([f"Not read: {file.facts['left_out']}."] if "left_out" in file.facts else [])],
        "verdict": events_verdict(loss, counts, kind.holds, kind.instead),
    }, document


def _signal_written(
    signal: Signal,
    kind: HapticFormat,
    axis: str | None,
    full_scale: float | None,
    header: DocumentHeader,
    metadata: dict[str, Any],
) -> tuple[dict[str, Any], Any]:
    """Return the facts and the document of a signal."""
    waveform = kind.encode_waveform
    if waveform is None and signal.domain != "time":
        raise ParameterError(
            f"{kind.title} is over time: convert the displacement at a speed first (play_at)"
        )
    signal, constant = without_constant(signal, least=GRAVITY)
    chosen, how = to_one_axis(signal, axis) if waveform is None or axis else (signal, None)
    rate = chosen.rate
    if waveform is None:
        events = events_of(chosen, kind.bands)
        scale = _scale(events.peak, chosen.unit, full_scale)
    else:
        scale = _scale(float(np.abs(chosen.samples).max()), chosen.unit, full_scale)
        ready = chosen.with_samples(chosen.samples.astype(np.float64) / scale, unit="1")
        if kind.highest_rate is not None and ready.domain == "time" and ready.rate > kind.highest_rate:
            ready = resample(ready, kind.highest_rate)
        # Resampling may overshoot full scale a little.
        over = float(np.abs(ready.samples).max())
        if full_scale is None and over > 1:
            scale, ready = scale * over, ready.with_samples(ready.samples / np.float32(over))
        rate = ready.rate
    # The rate is that of the written samples.
    whole = SignalDescription(rate, chosen.unit, chosen.axes, chosen.domain, scale, metadata)
    header = replace(header, description=whole.encode())
    made = waveform(ready, header) if waveform else kind.encode(events.scaled(1 / scale), header)
    document, back = _read_back(made, kind)
    loss = losses(chosen, back.signal)
    told, word = _told(loss, chosen, back.signal, kind)
    facts = _facts(back, constant, how, scale, 1 / scale, rate if rate != chosen.rate else None)
    return facts | {"loss": loss, "told": told, "verdict": word}, document


def losses(original: Signal, copy: Signal) -> dict[str, Any]:
    """Return the loss of each axis by name, or of a single axis without its name."""
    by_axis = {
        name: asdict(loss_between(original.select(name), copy.with_samples(copy.samples[i], axes=(name,))))
        for i, name in enumerate(original.axes)
    }
    return by_axis if len(by_axis) > 1 else next(iter(by_axis.values()))


def _told(loss: dict[str, Any], signal: Signal, copy: Signal, kind: HapticFormat) -> tuple[list[str], str]:
    """Return what a file keeps and loses of a signal, a sentence per axis, and the verdict."""
    by_axis = loss if len(signal.axes) > 1 else {"The file": loss}
    found = {axis: ConversionLoss(**one) for axis, one in by_axis.items()}
    told = [f"{axis} {loss_sentence(one, kind.holds)}." for axis, one in found.items()]
    if kind.holds != "waveform" and (felt := power_felt(signal)) < MOSTLY_FELT:
        share = f"{100 * felt:.0f} % of the signal's power"
        high = "the rest is above 1000 Hz, which a finger does not feel and the file leaves out"
        told.insert(0, f"Only {share} is up to 1000 Hz; {high}.")
        if felt < FELT_AT_ALL:
            remedy = "map the sound to touch instead (--map envelope)"
            return told[:1], f"not the signal, only {share}: {remedy}"
    worst = min(found.values(), key=lambda one: np.inf if one.snr_db is None else one.snr_db)
    return told, verdict(worst, copy, holds=kind.holds, instead=kind.instead)


def _facts(
    back: HapticFile, constant: str | None, how: str | None, scale: float, factor: float, rate: float | None
) -> dict[str, Any]:
    return {
        "constant": constant,
        "reduced_by": how,
        "full_scale": scale,
        "scaled_by": factor,
        "resampled_to": rate,
        "carrier": {k: v for k, v in back.facts.items() if k.startswith("carrier")} or None,
    }


def _read_back(document: Any, kind: HapticFormat) -> tuple[Any, HapticFile]:
    """Return a document, and what is read of it; `ParameterError` if it breaks any rule."""
    notes = Notes()
    back = decoded(document, kind, notes)
    if broken := [*notes.problems, *notes.warnings]:
        raise ParameterError(f"{kind.title} cannot hold this signal: {broken[0]}")
    return document, back


def _scale(peak: float, unit: str, full_scale: float | None, usual: float = 1.0) -> float:
    """Return what 1 stands for; `ParameterError` if the peak exceeds the one asked for."""
    if full_scale is None:
        fits = peak <= usual * (1 + 1e-6) and (unit == "1" or usual != 1)
        return usual if peak == 0 or fits else peak
    if peak > full_scale * (1 + 1e-6):
        raise ParameterError(
            f"full_scale must be at least the peak of {peak:.6g} {unit}, got {full_scale:g}; it would clip"
        )
    return float(full_scale)


def _check_modality(kind: HapticFormat, modality: str | None) -> None:
    if modality is None or modality in kind.modalities:
        return
    if not kind.modalities:
        raise ParameterError(f"{kind.title} has no modalities; omit modality")
    raise ParameterError(f"modality must be one of {', '.join(kind.modalities)}, got {modality!r}")


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
