"""What experiments share: averages, and materials found by name."""

import numpy as np
import pytest

from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram_benchmark.experiments.artifacts import IN_RECORDINGS, materials_of, spread


def test_what_is_not_known_is_not_averaged():
    found = spread([0.2, None, 0.4])
    assert found["mean"] == pytest.approx(0.3)
    assert (found["known"], found["values"]) == (2, [0.2, None, 0.4])
    assert spread([None]) == {"mean": None, "sd": None, "known": 0, "values": [None]}


def test_the_nine_textures_are_found_by_the_names_of_the_recordings(tmp_path):
    def strokes(names):
        for place, name in enumerate(names):
            signal = Signal(np.full((3, 10), place), 1000, "m/s^2")
            yield Recording(streams={"acceleration": signal}, material=name, source=name, simulated=True)

    def store(names, place):
        create_store(tmp_path / place, strokes(names), name="s", licence="-", simulated=True)
        return open_store(tmp_path / place)

    names = sorted(IN_RECORDINGS.values())
    assert materials_of(store(names, "all")) == IN_RECORDINGS
    with pytest.raises(DataError, match="found none called tile or GreenTile"):
        materials_of(store([name for name in names if name != "GreenTile"], "some"))
