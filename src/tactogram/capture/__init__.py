"""Signals out of sensors."""

from tactogram.capture.addresses import open_source, sources
from tactogram.capture.gaps import filled, gap_free, gaps
from tactogram.capture.log import Logged, read_log
from tactogram.capture.rate_estimate import RateEstimate, estimate_rate
from tactogram.capture.source import Block, Source, SourceEnded, SourceLost
from tactogram.capture.xdf import read_xdf

__all__ = [
    "Block",
    "Logged",
    "RateEstimate",
    "Source",
    "SourceEnded",
    "SourceLost",
    "estimate_rate",
    "filled",
    "gap_free",
    "gaps",
    "open_source",
    "read_log",
    "read_xdf",
    "sources",
]
