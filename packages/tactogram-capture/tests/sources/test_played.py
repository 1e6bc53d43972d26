"""The simulated hand: stroked recordings arrive through the simulated device, with losses in place."""

import numpy as np
import pytest

from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.units import STANDARD_GRAVITY
from tactogram_capture import open_source, read_log
from tactogram_capture.source import SourceEnded
from tactogram_capture.sources.played import StrokeReplay

STEP = 4e-3 * STANDARD_GRAVITY


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """Surfaces that are recognised by their constant: 1 and 2 m/s^2 along x, a ramp along y."""
    path = tmp_path_factory.mktemp("played") / "store"

    def recordings():
        for material, x in (("one", 1.0), ("two", 2.0)):
            for speed in (100.0, 200.0):
                y = np.linspace(0, 1, 660) + speed
                samples = np.stack([np.full(660, x), y, np.full(660, 9.8)]).astype(np.float32)
                signal = Signal(samples, 330.0, "m/s^2")
                yield Recording(streams={"acceleration": signal}, material=material, speed_mm_s=speed)

    create_store(path, recordings(), name="played", licence="made in a test")
    return path


def test_a_hand_strokes_the_given_material_at_the_given_speed(store):
    hand = StrokeReplay(open_store(store), rate=330.0)
    hand.touch("two", speed_mm_s=200.0)
    felt = hand.next_samples(700)
    np.testing.assert_allclose(felt[0], 2.0)
    assert felt[1].min() >= 200
    # It goes on where it was, and begins again at the end.
    steps = np.diff(felt[1])
    assert np.count_nonzero(steps < 0) in (1, 2)
    hand.rest()
    assert abs(hand.next_samples(100).mean(axis=1) - [0, 0, STANDARD_GRAVITY]).max() < 0.02


def test_a_missing_material_is_refused(store):
    with pytest.raises(ParameterError, match="material must be one of one, two, got 'three'"):
        open_source(f"played:{store}?materials=three")
    with pytest.raises(ParameterError, match="must name the store"):
        open_source("played:")


def read_out(source):
    """Return all blocks of a source that ends."""
    blocks = []
    while True:
        try:
            block = source.read(0.1)
        except SourceEnded:
            return blocks
        if block is not None:
            blocks.append(block)


def test_played_recordings_arrive_and_equal_the_log(store, tmp_path):
    log = tmp_path / "raw.log"
    address = (
        f"played:{store}?materials=one,two&each_s=0.3&seconds=0.6&loss=0.1&jitter_s=0.001&seed=2&log={log}"
    )
    with open_source(address) as source:
        samples = np.concatenate([block.samples for block in read_out(source)], axis=1)
    [logged] = read_log(log)
    np.testing.assert_array_equal(logged.samples, samples)
    assert logged.simulated
    x = samples[0, np.isfinite(samples[0])]
    assert set(np.round(x / STEP)) == {round(1 / STEP), round(2 / STEP)}
    assert np.all(np.diff(x) >= 0)
    facts = source.facts()
    assert facts["lost"] == np.isnan(samples[0]).sum() > 0
    assert facts["simulated"]
