import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.evaluation.pictures.inversion import InversionLoss, inversion_loss, invert, mean_loss
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass
from tactogram.signal.io import read_signal
from tactogram.signal.resampling import resample

PICTURE = SpectrogramPicture(
    rate=1000.0,
    floor_db=-80.0,
    ceiling_db=20.0,
    n_fft=64,
    hop=16,
    frames=64,
    rows=32,
    columns=64,
)


def noise(seed, gain=1.0):
    """Return noise of a material: low-passed, so that its spectrum has a shape."""
    white = np.random.default_rng(seed).standard_normal(1100)
    return Signal(gain * np.convolve(white, np.ones(4) / 4, "same"), 1000.0, "m/s^2")


REAL, OTHERS = [noise(k) for k in range(4)], [noise(k) for k in range(10, 14)]


def encoded(signals):
    return PICTURE.encode(torch.from_numpy(np.stack([s.samples[0, : PICTURE.length] for s in signals])))


def test_an_inverted_picture_is_a_signal_of_the_pictures_kind():
    (signal,) = invert(encoded(REAL[:1]), PICTURE, seed=0, axis="x")
    assert (signal.rate, signal.unit, signal.axes, len(signal)) == (1000.0, "m/s^2", ("x",), PICTURE.length)


def test_generated_pictures_that_are_the_real_ones_lose_by_inversion_alone():
    losses = inversion_loss(REAL, encoded(REAL), PICTURE, others=OTHERS, seed=0)
    assert "log_spectral_distance_db" in losses
    assert "coherence_distance" not in losses  # of one axis
    for loss in losses.values():
        assert loss.network == 0
        assert loss.share_of_inversion in (None, 1.0)


def test_a_generator_that_is_6_db_too_loud_is_blamed_for_6_db():
    loud = encoded([noise(k, 2.0) for k in range(4)])
    loss = inversion_loss(REAL, loud, PICTURE, others=OTHERS, seed=0)["level_difference_db"]
    assert loss.inversion < 0.5
    assert loss.total == pytest.approx(6.02, abs=0.6)
    assert loss.network == loss.total - loss.inversion
    assert loss.share_of_inversion < 0.1


def test_the_floor_is_the_distance_of_other_real_signals():
    losses = inversion_loss(REAL, encoded(OTHERS), PICTURE, others=OTHERS, seed=0)
    cut = [[s.cut(0, PICTURE.length) for s in group] for group in (REAL, OTHERS)]
    assert losses["log_spectral_distance_db"].floor == log_spectral_distance(*cut)
    assert inversion_loss(REAL, encoded(OTHERS), PICTURE, seed=0)["log_spectral_distance_db"].floor is None


def test_the_mean_is_over_materials():
    mean = mean_loss(
        [
            {"a": InversionLoss(1.0, 2.0, 4.0), "b": InversionLoss(1.0, 1.0, 1.0)},
            {"a": InversionLoss(None, 4.0, 8.0)},
        ]
    )
    assert mean == {"a": InversionLoss(None, 3.0, 6.0)}
    assert mean["a"].network == 3
    assert mean["a"].share_of_inversion == 0.5


@pytest.mark.real_data
def test_of_a_real_recording_inversion_loses_less_than_two_takes_differ(real_data):
    """Microphone sound of a tool on a surface, 20 to 1000 Hz, at the published size."""
    files = sorted((real_data("lmt108_sound") / "flac").glob("*Bamboo*"))[:4]
    takes = [resample(bandpass(read_signal(file), 20, 1000), 10_000.0) for file in files]
    picture = SpectrogramPicture(rate=10_000.0, unit=takes[0].unit, floor_db=-140.0, ceiling_db=-20.0)
    pictures = [picture.crop(torch.tensor(take.samples[0]), 60) for take in takes[2:]]
    losses = inversion_loss(takes[:2], torch.stack(pictures), picture, others=takes[2:], seed=0)
    for name in ("log_spectral_distance_db", "weighted_log_spectral_distance_db", "level_difference_db"):
        assert losses[name].inversion < 0.6 * losses[name].floor


def test_bad_input_is_one_line():
    with pytest.raises(ParameterError, match=r"1008 samples, got 500"):
        inversion_loss([REAL[0].cut(0, 500)], encoded(REAL), PICTURE, seed=0)
    with pytest.raises(ParameterError, match=r"at least one signal"):
        inversion_loss([], encoded(REAL), PICTURE, seed=0)
    with pytest.raises(ParameterError, match=r"at least one material"):
        mean_loss([])
