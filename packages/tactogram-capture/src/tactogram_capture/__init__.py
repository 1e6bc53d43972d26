"""Signals from sensors."""

from tactogram_capture.catalogue import find_sources, open_source
from tactogram_capture.logs.log import SensorLog, read_log
from tactogram_capture.logs.xdf import read_xdf
from tactogram_capture.source import Block, Source, SourceEnded, SourceLost
from tactogram_capture.stream.gaps import filled, gap_free, gaps
from tactogram_capture.stream.rate_estimate import RateEstimate, estimate_rate

__all__ = [
    "Block",
    "RateEstimate",
    "SensorLog",
    "Source",
    "SourceEnded",
    "SourceLost",
    "estimate_rate",
    "filled",
    "find_sources",
    "gap_free",
    "gaps",
    "open_source",
    "read_log",
    "read_xdf",
]
