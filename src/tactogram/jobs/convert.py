"""From one file format to another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.signal.displacement import played
from tactogram.signal.io import read_file, write_signal
from tactogram.signal.resampling import resample


def convert(
    source: Path | str,
    target: Path | str,
    *,
    unit: str | None = None,
    rate: float | None = None,
    axes: Sequence[str] | None = None,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    full_scale: float | None = None,
    play_at: float | None = None,
    resample_to: float | None = None,
    subtype: str | None = None,
) -> dict[str, Any]:
    """Write the signal in ``source`` to ``target``, in the format of its suffix; metadata goes along.

    Parameters
    ----------
    source, target : Path
        As in `tactogram.signal.io.read_signal` and `write_signal`. ``target`` is replaced if it is there,
        once all is written, and may be ``source``.
    unit, rate, axes, columns, time, sheet, full_scale : optional
        What ``source`` does not say, as in `read_signal`.
    play_at : float, mm/s, optional
        Speed of a finger that moves over a signal over displacement: ``target`` is what it meets, over time.
    resample_to : float, Hz, optional
        Rate of ``target``; by default that of the signal.
    subtype : str, optional
        Sample format of ``target``, as in `write_signal`.

    Returns
    -------
    dict
        ``source``, ``target``, ``samples``, ``rate_hz`` (``rate_per_mm`` over displacement), ``unit``, ``axes``,
        ``rms`` (in ``unit``), ``timing`` (what time stamps in ``source`` say, see
        `tactogram.signal.timing.Timing`; None if there are none), ``metadata``.

    Raises
    ------
    DataError, ParameterError
        As `read_signal` and `write_signal`; nothing is written then.
    """
    file = read_file(
        source,
        unit=unit,
        axes=axes,
        rate=rate,
        columns=columns,
        time=time,
        sheet=sheet,
        full_scale=full_scale,
    )
    signal, metadata = file.signal, file.metadata
    timing = None if file.timing is None else asdict(file.timing)
    if timing is not None:
        metadata["timing"] = timing
    if play_at is not None:
        if not (play_at > 0 and math.isfinite(play_at)):
            raise ParameterError(f"--play-at must be a speed > 0 mm/s, got {play_at:g}")
        signal = played(signal, play_at, resample_to or signal.rate * play_at)
        metadata["played_at_mm_s"] = play_at
    elif resample_to is not None:
        signal = resample(signal, resample_to)
    write_signal(target, signal, metadata=metadata, subtype=subtype)
    return {
        "source": str(source),
        "target": str(target),
        "samples": len(signal),
        "rate_hz" if signal.domain == "time" else "rate_per_mm": signal.rate,
        "unit": signal.unit,
        "axes": list(signal.axes),
        "rms": float((signal.samples.astype(float) ** 2).mean() ** 0.5),
        "timing": timing,
        "metadata": metadata,
    }
