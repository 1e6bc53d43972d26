"""What a store takes, once, or refuses and leaves nothing."""

from dataclasses import replace

import numpy as np
import pytest
from tests.datasets.store.sample_recordings import FACTS, recording

from tactogram.datasets import Recording, add_recordings, create_store
from tactogram.errors import DataError
from tactogram.signal import Image, Signal


def test_a_photograph_that_many_share_is_stored_once(tmp_path):
    pixels = np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)
    shared = (recording(i, image=Image(pixels.copy())) for i in range(20))
    store = create_store(tmp_path / "s", shared, **FACTS)
    store = add_recordings(store, [recording(99, image=Image(pixels))])
    [stored] = store.facts.images
    assert stored.rows == 1
    assert len({store.image_id(info.id) for info in store.index}) == 1


def test_the_same_samples_are_one_recording_and_it_is_said(tmp_path):
    one = recording(1)
    again = replace(one, source="copy.wav")
    store = create_store(tmp_path / "s", [one, recording(2), again], **FACTS)
    assert len(store) == 2
    assert store.facts.duplicates == ({"id": one.id, "kept": "cork/1.wav", "dropped": "copy.wav"},)


def test_the_same_samples_under_two_names_are_refused(tmp_path):
    with pytest.raises(DataError, match=r"copy.wav: the same samples as cork/1.wav"):
        create_store(
            tmp_path / "s",
            [recording(1), replace(recording(1), material="jeans", source="copy.wav")],
            **FACTS,
        )
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_left_when_a_recording_fails(tmp_path):
    def failing():
        yield recording(1)
        raise DataError("broken.wav: no samples")

    with pytest.raises(DataError, match="broken"):
        create_store(tmp_path / "s", failing(), **FACTS)
    assert list(tmp_path.iterdir()) == []


def test_other_units_are_refused(tmp_path):
    volts = Recording(streams={"acceleration": Signal(np.ones(3), 10.0, "V")}, source="v.wav")
    with pytest.raises(DataError, match=r"v.wav: stream 'acceleration' must be in m/s\^2"):
        create_store(tmp_path / "s", [recording(1), volts], **FACTS)


def test_an_empty_store_is_refused(tmp_path):
    with pytest.raises(DataError, match="no recordings"):
        create_store(tmp_path / "s", [], **FACTS)
    assert list(tmp_path.iterdir()) == []
