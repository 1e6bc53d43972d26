"""Response of a display, measured by a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from annotated_types import Gt, Le

from tactogram.errors import ParameterError, Remedy
from tactogram.parameters import Count, Positive, Settings, checked

PositiveShare = Annotated[float, Gt(0), Le(1)]


@checked
def write_sweep(
    display: str,
    out: Path | str,
    *,
    seconds: float = 10.0,
    share: PositiveShare = 0.25,
    band: tuple[float, float] | None = None,
    changes: Settings | None = None,
) -> dict[str, Any]:
    """Write the sweep that measures a display's response.

    Parameters
    ----------
    display : str
        One of `displays`, or a TOML file.
    out : Path or str
        File of the sweep.
    seconds : float
        Length of the sweep, s.
    share : float
        Amplitude as a share of the display's limit.
    band : tuple of float, optional
        Lowest and highest frequency, Hz; by default the display's.
    changes : dict, optional
        Change a value of the display, e.g. limit=2.

    Returns
    -------
    dict
        ``file``, ``seconds``, ``rate``, ``display``, ``sweep``, ``band``, ``share_of_limit``.

    Raises
    ------
    ParameterError
        If there is no such display, or it cannot play the band.
    """
    from tactogram.rendering import open_display
    from tactogram.signal.io import write_signal
    from tactogram_playback.sweep import exponential_sweep

    known = open_display(display, changes=changes)
    sweep = exponential_sweep(known, seconds=seconds, level=share, band=band)
    measured = band or known.band or (10.0, 0.45 * known.rate)
    facts = {"display": known.name, "sweep": True, "band": list(measured), "share_of_limit": share}
    write_signal(out, sweep, metadata=facts)
    return {"file": str(out), "seconds": sweep.seconds, "rate": sweep.rate, **facts}


@checked
def write_identified(
    played: Path | str,
    recorded: Sequence[Path | str],
    out: Path | str,
    *,
    band: tuple[float, float] | None = None,
    axis: str | None = None,
    unit: str | None = None,
    rate: Positive | None = None,
    axes: tuple[str, ...] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    part: Count | None = None,
) -> dict[str, Any]:
    """Identify a display's response from a played sweep and its recording.

    Parameters
    ----------
    played : Path or str
        The sweep, as `sweep` wrote it.
    recorded : sequence of Path or str
        The measured output; several takes are averaged.
    out : Path or str
        The response, .csv.
    band : tuple of float, optional
        Lowest and highest frequency, Hz; by default the sweep's.
    axis : str, optional
        Axis of the recordings, where they have several.
    unit, rate, axes, time, sheet, part
        As of `tactogram.convert`.

    Returns
    -------
    dict
        ``file``, ``unit``, ``band``, ``delay_ms``, ``gain_largest``, ``at_hz``, ``coherence_median``,
        ``coherence_least``, ``trusted_hz`` (from and to where the coherence is at least 0.9), ``takes``.

    Raises
    ------
    ParameterError
        If ``out`` is no CSV, the sweep does not state its band, or a recording has several axes and none is named.
    """
    import numpy as np

    from tactogram.rendering import write_response
    from tactogram.signal.io import read_metadata, read_signal
    from tactogram_playback.sweep import identify

    out = Path(out)
    if out.suffix.lower() != ".csv":
        raise ParameterError.must("out", "end in .csv", out)
    sweep = read_signal(played)
    band = band or read_metadata(played).get("band")
    if band is None:
        raise ParameterError(played, "does not state the band it sweeps", remedy=Remedy("give", "band"))
    recordings = [
        read_signal(file, unit=unit, rate=rate, axes=axes, time=time, sheet=sheet, part=part)
        for file in recorded
    ]
    if axis:
        recordings = [recording.select(axis) for recording in recordings]
    for file, recording in zip(recorded, recordings, strict=True):
        if len(recording.axes) > 1:
            remedy = Remedy("choose one with", "axis")
            raise ParameterError(file, f"has axes {', '.join(recording.axes)}", remedy=remedy)
    low, high = band
    result = identify(
        sweep.select(sweep.axes[0]), recordings[0], band=(low, high), repeats=tuple(recordings[1:])
    )
    write_response(out, result.frequency, result.response, unit=result.unit, coherence=result.coherence)
    trusted = result.frequency[result.coherence >= 0.9]
    return {
        "file": str(out),
        "unit": result.unit,
        "band": [low, high],
        "delay_ms": 1e3 * result.delay_s,
        "gain_largest": float(np.abs(result.response).max()),
        "at_hz": float(result.frequency[np.abs(result.response).argmax()]),
        "coherence_median": float(np.median(result.coherence)),
        "coherence_least": float(result.coherence.min()),
        "trusted_hz": [float(trusted.min()), float(trusted.max())] if len(trusted) else None,
        "takes": len(recordings),
    }
