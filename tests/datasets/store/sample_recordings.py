"""Recordings of noise, and what is said of their store."""

from dataclasses import fields

import numpy as np

from tactogram.datasets import Recording, RecordingInfo
from tactogram.signal import Signal

FACTS = {"name": "test", "licence": "CC0-1.0"}


def recording(seed, *, material="cork", samples=200, axes=("x", "y", "z"), **changes):
    rng = np.random.default_rng(seed)
    acceleration = Signal(rng.standard_normal((len(axes), samples)), 1000.0, "m/s^2", axes)
    force = Signal(rng.standard_normal(samples // 10), 100.0, "N")
    values = {"source": f"{material}/{seed}.wav", "streams": {"acceleration": acceleration, "force": force}}
    return Recording(material=material, **(values | changes))


def assert_same(got, expected):
    for field in fields(RecordingInfo):
        assert getattr(got, field.name) == getattr(expected, field.name), field.name
    assert set(got.streams) == set(expected.streams)
    for name, signal in expected.streams.items():
        back = got.streams[name]
        assert (back.rate, back.unit, back.axes, back.domain) == (
            signal.rate,
            signal.unit,
            signal.axes,
            signal.domain,
        )
        np.testing.assert_array_equal(back.samples, signal.samples)
