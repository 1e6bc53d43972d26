"""Signals from sensors; loaded on first use."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tactogram_capture.catalogue import find_sources as find_sources, open_source as open_source
    from tactogram_capture.logs.log import SensorLog as SensorLog, read_log as read_log
    from tactogram_capture.logs.xdf import read_xdf as read_xdf
    from tactogram_capture.source import (
        Block as Block,
        Source as Source,
        SourceEnded as SourceEnded,
        SourceLost as SourceLost,
    )
    from tactogram_capture.stream.gaps import filled as filled, gap_free as gap_free, gaps as gaps
    from tactogram_capture.stream.rate_estimate import (
        RateEstimate as RateEstimate,
        estimate_rate as estimate_rate,
    )

_PLACES = {
    "find_sources": "catalogue",
    "open_source": "catalogue",
    "SensorLog": "logs.log",
    "read_log": "logs.log",
    "read_xdf": "logs.xdf",
    "Block": "source",
    "Source": "source",
    "SourceEnded": "source",
    "SourceLost": "source",
    "filled": "stream.gaps",
    "gap_free": "stream.gaps",
    "gaps": "stream.gaps",
    "RateEstimate": "stream.rate_estimate",
    "estimate_rate": "stream.rate_estimate",
}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
