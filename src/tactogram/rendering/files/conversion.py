"""Signals into haptic files and back, with level, loss and refusals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.drive.mean_removal import without_constant
from tactogram.rendering.files.catalogue import FORMATS, HapticFormat, format_of
from tactogram.rendering.files.documents import encoded, parse
from tactogram.rendering.files.envelope import envelope_of
from tactogram.rendering.files.formats import hjif
from tactogram.rendering.files.loss import loss_between
from tactogram.rendering.files.reduction import to_one_axis
from tactogram.signal import Signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.io.description import SignalDescription
from tactogram.signal.io.description import decode as described

READ_RATE = 8000.0
"""Rate at which a carrier is made for a file that holds an envelope, Hz."""
MOST_BYTES = 500_000_000
"""Largest file that is read."""
GRAVITY = 1.0
"""A constant of more than so many times what moves (rms) is taken out of a motion; below, a copy stays exact."""


@dataclass(frozen=True, eq=False)
class HapticFile:
    """What a haptic file holds.

    Parameters
    ----------
    signal : Signal
        In the unit and at the level that the file states; else of unit 1.
    metadata : dict
        What was given to `write_haptic`, or the file's description.
    facts : dict
        ``format``, ``full_scale`` (None if the file does not state it), and how the signal came about: ``carrier_hz``,
        ``carrier_from``, ``modality``, ``left_out``.
    """

    signal: Signal
    metadata: dict[str, Any]
    facts: dict[str, Any]


def read_haptic(path: Path | str, *, format: str | None = None, rate: float | None = None) -> HapticFile:
    """Return the signal in a haptic file.

    An envelope becomes a carrier whose frequency the file states, or else is assumed: its facts say which.

    Parameters
    ----------
    path : Path
    format : str, optional
        One of `FORMATS`; by default by suffix, and where that is shared by what is in the file.
    rate : float, Hz, optional
        Of the carrier, by default `READ_RATE`; of a waveform by default its own.

    Raises
    ------
    DataError
        If it is not valid: the first rule that it breaks.
    """
    path = Path(path)
    document, kind = _read(path, format)
    if problems := kind.validate(document):
        more = f" (and {len(problems) - 1} more: convert --check)" if len(problems) > 1 else ""
        raise DataError(f"{path}: not valid {kind.title}: {problems[0]}{more}")
    try:
        return _decoded(document, kind, path, rate)
    except ParameterError as error:
        raise DataError(f"{path}: {error}") from error


def check_file(path: Path | str, *, format: str | None = None) -> dict[str, Any]:
    """Return whether a haptic file is valid: ``file``, ``format``, ``valid``, ``problems`` (a line each).

    Raises
    ------
    DataError
        If it is not there, or of none of `FORMATS`.
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
    metadata: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Write a signal as a haptic file, checked, and say what is lost.

    Parameters
    ----------
    path : Path
        Replaced once all is written.
    signal : Signal
    format : str
        One of `FORMATS`.
    axis : str, optional
        As `to_one_axis`; a waveform format keeps all axes by default.
    full_scale : float, optional
        What 1 in the file stands for, in the signal's unit. By default 1 for a signal of unit 1 that fits, else the
        peak: of the samples in a waveform, of the envelope in an envelope. The file says it in its description.
    modality : str, optional
        Of HJIF.
    metadata : mapping, optional
        Goes along in the description.

    Returns
    -------
    dict
        ``format``, ``holds``, ``constant`` (in words, where gravity or an offset was taken out of a motion, or None),
        ``reduced_by`` (how axes became one, or None), ``full_scale``, ``scaled_by`` (what the
        samples were multiplied with), ``loss`` (by axis, as `Loss`: measured by reading the file back),
        ``resampled_to``, ``bytes``.

    Raises
    ------
    ParameterError
        If the format cannot hold the signal; nothing is written then.
    """
    path, kind = Path(path), _named(format)
    if modality is not None and kind.name != "hjif":
        raise ParameterError(f"--modality is of HJIF; {kind.title} has none")
    if kind.holds != "waveform" and signal.domain != "time":
        raise ParameterError(f"{kind.title} is over time; say how fast the finger moves with --play-at MM_S")
    signal, constant = without_constant(signal, least=GRAVITY)
    chosen, how = to_one_axis(signal, axis) if kind.holds != "waveform" or axis else (signal, None)
    scale = _full_scale(chosen, kind, full_scale)
    ready = chosen.with_samples(chosen.samples.astype(np.float64) / scale, unit="1")
    if kind.holds == "waveform":
        # Resampling may swing a little beyond full scale.
        ready = hjif.prepared(ready)
        over = float(np.abs(ready.samples).max())
        if full_scale is None and over > 1:
            scale, ready = scale * over, ready.with_samples(ready.samples / np.float32(over))
    facts = dict(metadata or {})
    # The format's own 1 is `full_scale`; the rate is that of what was written.
    whole = SignalDescription(ready.rate, chosen.unit, chosen.axes, chosen.domain, scale, facts)
    document = _encoded(kind, ready, chosen.unit, whole.encode(), modality)
    if problems := kind.validate(document):
        raise ParameterError(f"{kind.title} cannot hold this signal: {problems[0]}")
    text = encoded(document).encode("ascii")
    back = _decoded(document, kind, path, None)
    with atomic_write(path) as part:
        part.write_bytes(text)
    return {
        "format": kind.name,
        "holds": kind.holds,
        "constant": constant,
        "reduced_by": how,
        "full_scale": scale,
        "scaled_by": 1 / scale,
        "resampled_to": ready.rate if ready.rate != chosen.rate else None,
        "carrier": {k: v for k, v in back.facts.items() if k.startswith("carrier")} or None,
        "loss": losses(chosen, back.signal),
        "bytes": len(text),
    }


def losses(original: Signal, copy: Signal) -> dict[str, Any]:
    """Return the loss of each axis; of the only one without its name."""
    by_axis = {
        name: asdict(loss_between(original.select(name), copy.with_samples(copy.samples[i], axes=(name,))))
        for i, name in enumerate(original.axes)
    }
    return by_axis if len(by_axis) > 1 else next(iter(by_axis.values()))


def _encoded(
    kind: HapticFormat, signal: Signal, unit: str, description: str, modality: str | None
) -> dict[str, Any]:
    encode = kind.encode
    if kind.name == "hjif":
        usual = "Friction" if signal.domain == "displacement" else "Vibrotactile"
        encode = partial(hjif.encode, modality=modality or hjif.BY_UNIT.get(unit, usual))
    return encode(signal, description)


def _decoded(document: Any, kind: HapticFormat, path: Path, rate: float | None) -> HapticFile:
    text = _description_in(document)
    ours = described(text, str(path)) if text else None
    if kind.holds == "waveform":
        found = hjif.decode(document, rate, exact_rate=ours.rate if ours else None)
    else:
        found = kind.decode(document, rate or READ_RATE)
    signal, scale = found.signal, ours.full_scale if ours else None
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
    metadata = dict(ours.metadata) if ours else {"comment": found.description} if found.description else {}
    return HapticFile(signal, metadata, {"format": kind.name, "full_scale": scale, **found.facts})


def _description_in(document: Any) -> str:
    """Return what a valid document says of itself, wherever its format has that."""
    if not isinstance(document, dict):
        return ""
    for holder in (document, document.get("metadata"), document.get("Metadata")):
        if isinstance(holder, dict):
            for key in ("description", "Description"):
                if isinstance(holder.get(key), str):
                    return str(holder[key])
    return ""


def _full_scale(signal: Signal, kind: HapticFormat, asked: float | None) -> float:
    peak = float(np.abs(signal.samples).max()) if kind.holds == "waveform" else envelope_of(signal).peak
    if asked is not None:
        if not (asked > 0 and np.isfinite(asked)):
            raise ParameterError(f"--full-scale must be > 0 {signal.unit}, got {asked:g}")
        if peak > asked * (1 + 1e-6):
            raise ParameterError(
                f"--full-scale must be at least the peak of {peak:.6g} {signal.unit}, got {asked:g}; it would clip"
            )
        return float(asked)
    if peak == 0 or (signal.unit == "1" and peak <= 1):
        return 1.0
    return peak


def _read(path: Path, format: str | None) -> tuple[Any, HapticFormat]:
    if not path.is_file():
        raise DataError(f"{path}: {'is a folder' if path.is_dir() else 'no such file'}")
    if path.stat().st_size > MOST_BYTES:
        raise DataError(f"{path}: must be at most {MOST_BYTES} bytes, got {path.stat().st_size}")
    kind = _named(format) if format else None
    document = parse(path.read_bytes(), path)
    return document, kind or format_of(document, path)


def _named(format: str) -> HapticFormat:
    if format not in FORMATS:
        raise ParameterError(f"--format must be one of {', '.join(FORMATS)}, got {format!r}")
    return FORMATS[format]
