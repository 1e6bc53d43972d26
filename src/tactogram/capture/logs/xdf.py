"""XDF: the files that Lab Streaming Layer's recorders write."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tactogram.capture.logs.log import SensorLog
from tactogram.capture.sources.lsl import known_unit, split_at_gaps
from tactogram.capture.stream.rate_estimate import estimate_rate
from tactogram.errors import DataError
from tactogram.extras import imported, one_line


def read_xdf(path: Path | str, *, unit: str | None = None) -> list[SensorLog]:
    """Return every stream of numbers in an XDF file, in the order in which they stand.

    Clocks are brought together as the format's own reader does it. Its evening out of time stamps is not used: it draws
    one line across gaps of up to 5 s at 100 Hz. Where stamps leap by as much as in `capture.sources.lsl`, samples
    are missing, and NaN stand for them.

    Parameters
    ----------
    path : Path
    unit : str, optional
        Unit of the samples; by default what a stream says, or 1.

    Raises
    ------
    MissingExtraError
        If pyxdf is not installed.
    DataError
        If it is no XDF, or holds no numbers.
    """
    pyxdf = imported("pyxdf", extra="lsl", what="XDF files")
    path = Path(path)
    if not path.is_file():
        raise DataError(f"{path}: there is no such file")
    try:
        with path.open("rb") as file:
            streams, _ = pyxdf.load_xdf(file, dejitter_timestamps=False, verbose=False)
    except Exception as error:
        # Its reader raises whatever a damaged file leads to.
        raise DataError(f"{path}: is no XDF file that can be read ({one_line(error)})") from error
    logged = [found for stream in streams if (found := _logged(stream, unit)) is not None]
    if not logged:
        raise DataError(f"{path}: holds no stream of numbers")
    return logged


def _logged(stream: dict[str, Any], unit: str | None) -> SensorLog | None:
    info = stream["info"]
    rows, stamps = stream["time_series"], np.asarray(stream["time_stamps"], np.float64)
    if not isinstance(rows, np.ndarray) or rows.ndim != 2 or rows.dtype.kind not in "fiu" or not len(rows):
        return None
    labels, units = _channels(info, rows.shape[1])
    said, factor = known_unit(unit, units)
    samples = (rows.T.astype(np.float64) * factor).astype(np.float32)
    rate = float(info["nominal_srate"][0])
    whole = np.concatenate(split_at_gaps(samples, stamps, rate or None, None), axis=1)
    # Where each sample that came stands among those that are missing.
    places = (
        np.flatnonzero(~np.isnan(whole[0])) + 1 if np.isfinite(samples).all() else np.arange(1, len(rows) + 1)
    )
    estimate = estimate_rate(places, stamps)
    default = {1: ("z",), 3: ("x", "y", "z")}.get(
        rows.shape[1], tuple(f"c{i + 1}" for i in range(rows.shape[1]))
    )
    lost = whole.shape[1] - len(rows)
    facts = {
        "samples": len(rows),
        "lost": lost,
        "rejected": {},
        "rate": None if estimate is None else estimate.facts(),
        "nominal_rate": rate or None,
        "simulated": False,
    }
    return SensorLog(
        name=str(info["name"][0]),
        samples=whole,
        axes=tuple(labels) if len(set(labels)) == rows.shape[1] else default,
        unit=said,
        rate=estimate,
        start_s=float(stamps[0]),
        facts=facts,
        simulated=False,
    )


def _channels(info: dict[str, Any], count: int) -> tuple[list[str], list[str]]:
    try:
        channels = info["desc"][0]["channels"][0]["channel"]
        labels = [str(channel["label"][0]) for channel in channels]
        units = [str((channel.get("unit") or [""])[0] or "") for channel in channels]
    except (KeyError, IndexError, TypeError):
        return [], []
    return (labels, units) if len(labels) == count else ([], [])
