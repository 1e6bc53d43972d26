"""XDF: the files that Lab Streaming Layer's recorders write."""

from __future__ import annotations

import logging
import mmap
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.capture.logs.log import SensorLog
from tactogram.capture.sources.lsl import known_unit, split_at_gaps
from tactogram.capture.stream.rate_estimate import estimate_rate
from tactogram.errors import DataError, TactogramError
from tactogram.extras import imported, one_line

HEADER, SAMPLES = b"\x02\x00", b"\x03\x00"
"""Tags of chunks."""
BOUNDARY = bytes.fromhex("43a546dccbf5410fb30ed5467383cbe4")


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
        _check_chunks(path)
        with path.open("rb") as file, _kept_log() as complaints:
            streams, _ = pyxdf.load_xdf(file, dejitter_timestamps=False, verbose=False)
        logged = [found for stream in streams if (found := _logged(stream, unit, complaints)) is not None]
    except TactogramError:
        raise
    except Exception as error:
        # Its reader raises whatever a damaged file leads to.
        raise DataError(f"{path}: is no XDF file that can be read ({one_line(error)})") from error
    if not logged:
        raise DataError(f"{path}: holds no stream of numbers")
    return logged


def _check_chunks(path: Path) -> None:
    """Refuse chunks that claim more samples than their bytes can hold: pyxdf takes memory for what is claimed."""
    sizes: dict[bytes, int] = {}
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        at = 4
        while at + 9 < len(data):
            length, start = _whole_number(data, at)
            if length is None:
                # As pyxdf does: go on after the next boundary.
                found = data.find(BOUNDARY, start)
                at = found + len(BOUNDARY) if found >= 0 else len(data)
                continue
            tag, stream, at = data[start : start + 2], data[start + 2 : start + 6], start + max(length, 2)
            if tag == HEADER:
                sizes[stream] = _sample_bytes(data[start + 6 : at])
            elif tag == SAMPLES and start + 6 < len(data):
                count, first = _whole_number(data, start + 6)
                if (count or 0) * sizes.get(stream, 1) > len(data) - first:
                    raise DataError(
                        f"{path}: damaged at byte {start}: {len(data) - first} bytes cannot hold {count} samples; "
                        "cut the file there"
                    )


def _whole_number(data: mmap.mmap, at: int) -> tuple[int | None, int]:
    """Return a number of 1, 4 or 8 bytes whose length stands before it, None if it has another; and where it ends."""
    end = at + 1 + data[at]
    return (int.from_bytes(data[at + 1 : end], "little") if data[at] in (1, 4, 8) else None), end


def _sample_bytes(header: bytes) -> int:
    """Return the fewest bytes that a sample of a stream takes."""
    channels = re.search(rb"<channel_count>\s*(\d+)\s*<", header)
    kind = re.search(rb"<channel_format>[a-z]*(\d*)<", header)
    return 1 + int(channels[1] if channels else 0) * (int((kind and kind[1]) or 16) // 8)


@contextmanager
def _kept_log() -> Iterator[list[str]]:
    """Keep what pyxdf logs, in place of printing it."""
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


def _logged(stream: dict[str, Any], unit: str | None, complaints: list[str]) -> SensorLog | None:
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
        **({"damaged": complaints} if complaints else {}),
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
