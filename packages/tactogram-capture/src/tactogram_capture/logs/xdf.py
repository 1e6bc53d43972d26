"""XDF: the files of Lab Streaming Layer's recorders."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError, TactogramError, one_line
from tactogram.extras import imported
from tactogram_capture.logs.log import SensorLog
from tactogram_capture.stream.channels import described_axes, described_unit, split_at_gaps
from tactogram_capture.stream.rate_estimate import estimate_rate


def read_xdf(path: Path | str, *, unit: str | None = None) -> list[SensorLog]:
    """Return every numeric stream in an XDF file, in file order.

    Clocks are synchronised by the format's own reader. Its smoothing of time stamps is not used: it fits
    one line across gaps of up to 5 s at 100 Hz. Where stamps jump (`stream.channels.split_at_gaps`), NaN takes the
    place of the missing samples.

    ``unit``: unit of the samples; by default the stream's own, or 1.

    Raises `MissingExtraError` if pyxdf is not installed; `DataError` if it is not readable as XDF, or contains no
    numbers.
    """
    pyxdf = imported("pyxdf", extra="lsl", what="XDF files")
    path = Path(path)
    try:
        with path.open("rb") as file, _captured_warnings() as warnings:
            streams, _ = pyxdf.load_xdf(file, dejitter_timestamps=False, verbose=False)
        logs = [log for stream in streams if (log := _sensor_log(stream, unit, warnings)) is not None]
    except TactogramError:
        raise
    except FileNotFoundError:
        raise DataError(f"{path}: no such file") from None
    except Exception as error:  # pyxdf has no error of its own for damaged files
        raise DataError(f"{path}: not readable as XDF ({one_line(error)})") from error
    if not logs:
        raise DataError(f"{path}: contains no stream of numbers")
    return logs


@contextmanager
def _captured_warnings() -> Iterator[list[str]]:
    """Collect pyxdf's log messages instead of printing them."""
    logger, lines = logging.getLogger("pyxdf"), list[str]()
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: lines.append(record.getMessage())  # type: ignore[method-assign]
    propagate, logger.propagate = logger.propagate, False
    logger.addHandler(handler)
    try:
        yield lines
    finally:
        logger.removeHandler(handler)
        logger.propagate = propagate


def _sensor_log(stream: dict[str, Any], unit: str | None, warnings: list[str]) -> SensorLog | None:
    info = stream["info"]
    rows, stamps = stream["time_series"], np.asarray(stream["time_stamps"], np.float64)
    if not isinstance(rows, np.ndarray) or rows.ndim != 2 or rows.dtype.kind not in "fiu" or not len(rows):
        return None
    labels, units = _channels(info, rows.shape[1])
    unit, factor = described_unit(unit, units)
    samples = (rows.T.astype(np.float64) * factor).astype(np.float32)
    rate = float(info["nominal_srate"][0])
    whole = np.concatenate(split_at_gaps(samples, stamps, rate or None, None), axis=1)
    # Positions of the received samples, missing ones counted.
    places = (
        np.flatnonzero(~np.isnan(whole[0])) + 1 if np.isfinite(samples).all() else np.arange(1, len(rows) + 1)
    )
    estimate = estimate_rate(places, stamps)
    facts = {
        "samples": len(rows),
        "lost": whole.shape[1] - len(rows),
        "rejected": {},
        "rate": None if estimate is None else estimate.facts(),
        "nominal_rate": rate or None,
        "simulated": False,
        **({"damaged": warnings} if warnings else {}),
    }
    return SensorLog(
        name=str(info["name"][0]),
        samples=whole,
        axes=described_axes(rows.shape[1], labels),
        unit=unit,
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
