"""Conversion between signals and haptic files, with level, loss and checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.level_scaling import without_constant
from tactogram.rendering.files.catalogue import formats_with, haptic_format, recognised_format
from tactogram.rendering.files.documents import DocumentHeader, parse
from tactogram.rendering.files.envelope import Envelope, envelope_of
from tactogram.rendering.files.format import HapticFormat
from tactogram.rendering.files.loss import ConversionLoss, loss_between, verdict
from tactogram.rendering.files.reduction import to_one_axis
from tactogram.signal import Signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.description import SignalDescription
from tactogram.signal.io.description import decode as read_description
from tactogram.signal.resampling import resample

MOST_BYTES = 500_000_000
"""Largest file that is read."""
GRAVITY = 1.0
"""A motion's constant above this many times its vibration (rms) is removed; below, the copy stays exact."""


@dataclass(frozen=True, eq=False)
class HapticFile:
    """Content of a haptic file: a signal in the unit and at the level that the file states, else of unit 1.

    ``metadata`` is as passed to `write_haptic`, or the file's description. ``facts`` has ``format``, ``full_scale``
    (None if the file does not state it) and, depending on the format, ``carrier_hz``, ``carrier_from``, ``modality``,
    ``left_out``. ``envelope`` is the file's, in parts of full scale, if it holds one.
    """

    signal: Signal
    metadata: dict[str, Any]
    facts: dict[str, Any]
    envelope: Envelope | None = None


def read_haptic(path: Path | str, *, format: str | None = None, rate: float | None = None) -> HapticFile:
    """Return the signal in a haptic file.

    An envelope becomes a carrier whose frequency the file states or is assumed; its facts say which. The format is
    determined by suffix, or by content if several formats share the suffix. ``rate`` (Hz) is the carrier's,
    `envelope.READ_RATE` by default, or that of a waveform, its own by default. Raises `DataError` if the file is not
    valid: the first rule that it breaks.
    """
    path = Path(path)
    document, kind = _read(path, format)
    if problems := kind.validate(document):
        more = f" (and {len(problems) - 1} more, see check_file)" if len(problems) > 1 else ""
        raise DataError(f"{path}: not valid {kind.title}: {problems[0]}{more}")
    try:
        return _decoded(document, kind, rate)
    except (DataError, ParameterError) as error:
        raise DataError(f"{path}: {error}") from error


def check_file(path: Path | str, *, format: str | None = None) -> dict[str, Any]:
    """Return whether a haptic file is valid: ``file``, ``format``, ``valid``, ``problems`` (a line each).

    Raises `DataError` if there is no such file, or no format recognises it.
    """
    path = Path(path)
    document, kind = _read(path, format)
    problems = kind.validate(document)
    return {"file": str(path), "format": kind.name, "valid": not problems, "problems": problems}


def write_haptic(
    path: Path | str,
    signal: Signal,
    *,
    format: str,
    axis: str | None = None,
    full_scale: float | None = None,
    modality: str | None = None,
    motor: Display | None = None,
    metadata: Mapping[str, Any] | None = None,
    envelope: Envelope | None = None,
) -> dict[str, Any]:
    """Write a signal as a valid haptic file, and return what is lost.

    Raises `ParameterError` if there is no such format or modality, or the format cannot hold the signal; nothing is
    written then.

    Parameters
    ----------
    path : Path
        Replaced once everything is written.
    axis : str, optional
        As in `to_one_axis`; a waveform format keeps all axes by default.
    full_scale : float, optional
        What 1 in the file stands for, in the signal's unit; stored in the file's description. By default 1 for a
        signal of unit 1 that fits, else the peak: of the samples in a waveform, of the envelope in an envelope.
    modality : str, optional
        One of the format's; chosen by unit by default.
    motor : Display, optional
        Motor that a format of on and off is for: no pulse or pause is shorter than its ``shortest_ms``. By default the
        format's own.
    metadata : mapping, optional
        Stored in the description.
    envelope : Envelope, optional
        The envelope of ``signal``, of one axis, if it is known, such as that of a drawn effect: it is written instead
        of an analysis where the format can hold it, and its peak is the default of ``full_scale``.

    Returns
    -------
    dict
        ``format``, ``holds``, ``constant`` (gravity or an offset that was removed, in words, or None), ``reduced_by``
        (how axes became one, or None), ``full_scale``, ``scaled_by`` (factor of the samples), ``loss`` (by axis, as
        `ConversionLoss`: measured by reading the file back), ``verdict`` (in words, of the axis that loses most),
        ``resampled_to``, ``carrier``, ``bytes``.
    """
    path, kind = Path(path), haptic_format(format)
    _check_modality(kind, modality)
    shortest_ms = _shortest_ms(kind, motor)
    if kind.holds != "waveform" and signal.domain != "time":
        raise ParameterError(
            f"{kind.title} is over time: convert the displacement at a speed first (play_at)"
        )
    signal, constant = without_constant(signal, least=GRAVITY)
    chosen, how = to_one_axis(signal, axis) if kind.holds != "waveform" or axis else (signal, None)
    scale = _full_scale(chosen, kind, full_scale, envelope)
    ready = chosen.with_samples(chosen.samples.astype(np.float64) / scale, unit="1")
    if kind.holds == "waveform":
        if kind.highest_rate is not None and ready.domain == "time" and ready.rate > kind.highest_rate:
            ready = resample(ready, kind.highest_rate)
        # Resampling may overshoot full scale a little.
        over = float(np.abs(ready.samples).max())
        if full_scale is None and over > 1:
            scale, ready = scale * over, ready.with_samples(ready.samples / np.float32(over))
    facts = dict(metadata or {})
    # The rate is that of the written samples.
    whole = SignalDescription(ready.rate, chosen.unit, chosen.axes, chosen.domain, scale, facts)
    header = DocumentHeader(whole.encode(), chosen.unit, modality, shortest_ms)
    if envelope is not None and kind.encode_envelope is not None:
        document = kind.encode_envelope(envelope.scaled(1 / scale), header)
    else:
        document = kind.encode(ready, header)
    if problems := kind.validate(document):
        raise ParameterError(f"{kind.title} cannot hold this signal: {problems[0]}")
    content = kind.serialise(document)
    back = _decoded(document, kind, None)
    loss = losses(chosen, back.signal)
    with atomic_write(path) as part:
        part.write_bytes(content)
    return {
        "format": kind.name,
        "holds": kind.holds,
        "constant": constant,
        "reduced_by": how,
        "full_scale": scale,
        "scaled_by": 1 / scale,
        "resampled_to": ready.rate if ready.rate != chosen.rate else None,
        "carrier": {k: v for k, v in back.facts.items() if k.startswith("carrier")} or None,
        "loss": loss,
        "verdict": _verdict(loss, back.signal, kind),
        "bytes": len(content),
    }


def losses(original: Signal, copy: Signal) -> dict[str, Any]:
    """Return the loss of each axis by name, or of a single axis without its name."""
    by_axis = {
        name: asdict(loss_between(original.select(name), copy.with_samples(copy.samples[i], axes=(name,))))
        for i, name in enumerate(original.axes)
    }
    return by_axis if len(by_axis) > 1 else next(iter(by_axis.values()))


def _verdict(loss: dict[str, Any], copy: Signal, kind: HapticFormat) -> str:
    by_axis = [ConversionLoss(**one) for one in (loss.values() if len(copy.axes) > 1 else [loss])]
    worst = min(by_axis, key=lambda one: np.inf if one.snr_db is None else one.snr_db)
    return verdict(worst, copy, holds=kind.holds, instead=kind.instead)


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


def _decoded(document: Any, kind: HapticFormat, rate: float | None) -> HapticFile:
    content = kind.decode(document, rate)
    ours = read_description(content.description, kind.title) if content.description else None
    signal, scale = content.signal, ours.full_scale if ours else None
    if ours is not None:
        factor = scale or 1.0
        axes = ours.axes if len(ours.axes) == len(signal.axes) else signal.axes
        signal = Signal(
            (signal.samples.astype(np.float64) * factor).astype(np.float32),
            signal.rate,
            ours.unit,
            axes,
            ours.domain,
        )
    metadata = (
        dict(ours.metadata) if ours else {"comment": content.description} if content.description else {}
    )
    facts = {"format": kind.name, "full_scale": scale, **content.facts}
    return HapticFile(signal, metadata, facts, content.envelope)


def _full_scale(
    signal: Signal, kind: HapticFormat, full_scale: float | None, envelope: Envelope | None
) -> float:
    samples = kind.holds == "waveform"
    peak = float(np.abs(signal.samples).max()) if samples else (envelope or envelope_of(signal)).peak
    if full_scale is not None:
        if not (full_scale > 0 and np.isfinite(full_scale)):
            raise ParameterError(f"full_scale must be > 0 {signal.unit}, got {full_scale:g}")
        if peak > full_scale * (1 + 1e-6):
            raise ParameterError(
                f"full_scale must be at least the peak of {peak:.6g} {signal.unit}, got {full_scale:g}; it would clip"
            )
        return float(full_scale)
    if peak == 0 or (signal.unit == "1" and peak <= 1):
        return 1.0
    return peak


def _read(path: Path, name: str | None) -> tuple[Any, HapticFormat]:
    if not path.is_file():
        raise DataError(f"{path}: {'is a folder' if path.is_dir() else 'no such file'}")
    if path.stat().st_size > MOST_BYTES:
        raise DataError(f"{path}: must be at most {MOST_BYTES} bytes, got {path.stat().st_size}")
    candidates = [haptic_format(name)] if name else formats_with(path.suffix)
    if len(candidates) == 1:
        return candidates[0].parse(path.read_bytes(), path), candidates[0]
    document = parse(path.read_bytes(), path)
    return document, recognised_format(document, path)
