"""Lab Streaming Layer: streams of any device on the local network, on one clock."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from tactogram.errors import DeviceError, ParameterError
from tactogram.extras import device_errors, lsl
from tactogram.validation import FrozenModel
from tactogram_capture.source import Block, SourceKind
from tactogram_capture.stream.channels import DeviceSource, described_axes, described_unit, split_at_gaps


class LslOptions(FrozenModel):
    """Options of ``lsl:NAME``."""

    type: str | None = None
    """Find the stream by its type instead: ``lsl:?type=Acceleration``."""
    unit: str | None = None
    """Unit of the samples; by default the stream's own, or 1."""
    find_s: float = Field(default=3.0, gt=0, le=60)
    """Time to search for the stream, s."""


class LslSource(DeviceSource):
    """A stream of Lab Streaming Layer; ``stream`` is its name, empty to find it by its type.

    While connected, the layer itself loses nothing; samples are missing where its buffer overflowed or the sender
    was interrupted, which the time stamps reveal (`split_at_gaps`). Its `LostError` and `InternalError` are of modules
    that differ between versions, and both a RuntimeError.
    """

    def __init__(self, stream: str, options: LslOptions, *, name: str) -> None:
        if not stream and not options.type:
            raise ParameterError(f"{name}: must name a stream, or its type (?type=Acceleration)")
        super().__init__(name)
        self._stream, self._options = stream, options
        self._factor = 1.0
        self._last_stamp: float | None = None

    def _open(self) -> Any:
        pylsl, find_s = lsl(), self._options.find_s
        by, value = ("name", self._stream) if self._stream else ("type", self._options.type or "")
        with device_errors(self.name, library="pylsl"):
            streams = pylsl.resolve_byprop(by, value, 1, find_s)
            if not streams:
                raise DeviceError(f"{self.name}: no stream of the {by} {value!r} within {find_s:g} s")
            inlet = pylsl.StreamInlet(streams[0], max_buflen=60, recover=False)
            info = inlet.info(find_s)
            if info.channel_format() == pylsl.cf_string:
                raise DeviceError(f"{self.name}: contains text, not samples")
            inlet.open_stream(find_s)
        rate = float(info.nominal_srate())
        self.rate = rate if rate > 0 else None
        labels, units = _channels(info)
        self.axes = described_axes(int(info.channel_count()), labels)
        self.unit, self._factor = described_unit(self._options.unit, units)
        return inlet

    def _close(self, device: Any) -> None:
        device.close_stream()

    def _read(self, device: Any, timeout_s: float) -> Block | None:
        rows, stamps = device.pull_chunk(timeout=timeout_s, max_samples=4096, min_samples=1)
        if not len(stamps):
            return None
        samples = (np.asarray(rows, np.float64).T * self._factor).astype(np.float32)
        pieces = split_at_gaps(samples, np.asarray(stamps, np.float64), self.rate, self._last_stamp)
        self._last_stamp = float(stamps[-1])
        return self._block(np.concatenate(pieces, axis=1), measured_s=self._last_stamp)


def _channels(info: Any) -> tuple[list[str], list[str]]:
    """Return labels and units of the channels, as far as the stream describes them."""
    labels, units = [], []
    channel = info.desc().child("channels").child("channel")
    for _ in range(int(info.channel_count())):
        labels.append(channel.child_value("label"))
        units.append(channel.child_value("unit"))
        channel = channel.next_sibling("channel")
    return ([] if "" in labels else labels), units


def _find(find_s: float) -> dict[str, str]:
    return {
        f"lsl:{stream.name()}": f"{stream.channel_count()} x {stream.nominal_srate():g} Hz, {stream.type()}"
        for stream in lsl().resolve_streams(find_s)
    }


SOURCE = SourceKind("lsl", "Lab Streaming Layer stream", "lsl:NAME", LslOptions, LslSource, find=_find)
