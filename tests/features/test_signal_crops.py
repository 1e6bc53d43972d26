import numpy as np
from tests.signal.seams import seam_excess_db

from tactogram.features.signal_crops import SignalCrops
from tactogram.model import Example
from tactogram.signal import Signal

LENGTH, OVERLAP = 1024, 128


def noise(length, seed=0):
    x = np.cumsum(np.random.default_rng(seed).standard_normal((2, length)), axis=1)
    return Signal(x - np.linspace(x[:, 0], x[:, -1], length).T, 1000.0, "m/s^2", ("x", "y"))


def repeated(*signals, lead=0):
    """Crops of recordings repeated ten times."""
    examples = [Example(str(i), s, "a") for i, s in enumerate(signals)]
    return SignalCrops(examples, LENGTH, OVERLAP, repetitions=10, lead=lead)


def crossfaded(signal):
    return SignalCrops([Example("0", signal, "a")], LENGTH, OVERLAP)


def seeded(seed):
    return lambda purpose, number: np.random.default_rng([seed, len(purpose), number])


def test_a_long_recording_is_cropped_anywhere():
    signal = Signal(np.arange(2000.0), 10.0, "1")
    found = [repeated(signal, lead=7).cut(signal, np.random.default_rng(i)) for i in range(200)]
    assert all(x.shape == (1, LENGTH + 7) for x in found)
    assert all((np.diff(x) == 1).all() for x in found)
    starts = [x[0, 0] for x in found]
    assert 0 <= min(starts) < 30
    assert 2000 - LENGTH - 7 - 30 < max(starts) <= 2000 - LENGTH - 7


def test_a_short_recording_is_repeated_ten_times_as_published():
    """Sec. III-B: repeated ten times, and the network's length cut from that at random."""
    signal = noise(250)
    whole = np.tile(signal.samples, 10)
    for seed in range(20):
        x = repeated(signal).cut(signal, np.random.default_rng(seed))
        start = int(np.random.default_rng(seed).integers(2500 - LENGTH + 1))
        np.testing.assert_array_equal(x, whole[:, start : start + LENGTH])


def test_very_short_recordings_are_repeated_more_often():
    signal = noise(50)
    assert repeated(signal).cut(signal, np.random.default_rng(0)).shape == (2, LENGTH)


def test_repetition_jumps_at_its_seams_and_crossfades_do_not():
    signal = noise(400).with_samples(noise(400).samples + np.linspace(0, 30, 400))
    whole = signal.with_samples(np.tile(signal.samples, 10))
    assert seam_excess_db(whole, range(400, 4000, 400)) > 15
    rng = np.random.default_rng(0)
    worst = [np.abs(np.diff(crossfaded(signal).cut(signal, rng))).max() for _ in range(20)]
    jump = np.abs(np.diff(whole.samples)).max()
    assert max(worst) < jump / 3


def test_a_crossfaded_recording_is_the_recording_elsewhere():
    signal = noise(900)
    x = crossfaded(signal).cut(signal, np.random.default_rng(3))
    assert x.shape == (2, LENGTH)
    place = int(np.flatnonzero((signal.samples == x[:, :1]).all(0))[0])
    np.testing.assert_array_equal(x[:, :128], signal.samples[:, place : place + 128])


def test_crops_depend_on_generators_and_number_alone():
    data = repeated(noise(300), noise(1500), noise(4000))
    assert data.epoch.tolist() == [0, 1, 2, 2, 2]
    all_of_them = data.draw(0, 12, seeded(4))
    for start, count in ((0, 5), (5, 7), (11, 1)):
        part = data.draw(start, count, seeded(4))
        for (one, x), (other, y) in zip(all_of_them[start : start + count], part, strict=True):
            assert one.id == other.id
            np.testing.assert_array_equal(x, y)
    assert sorted(e.id for e, _ in all_of_them[:5]) == ["0", "1", "2", "2", "2"]
