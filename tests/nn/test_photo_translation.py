"""Levels, lengths and crops on the way from photographs to signals."""

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.features.photo_pairs import shuffled
from tactogram.model import Example, SignalKind
from tactogram.nn.photo_translation import (
    PairConfig,
    PhotoTranslation,
    row_statistics_distance,
)
from tactogram.signal import Image, Signal

KIND = SignalKind(1000.0, "m/s^2", ("z",), ("a", "b"), simulated=True)
CONFIG = PairConfig(n_fft=32, hop=16, frames=32, size=16, crop=16, per_photo=2, per_recording=2, repeats=2)


def example(material, seed, level=1.0):
    rng = np.random.default_rng(seed)
    pixels = rng.integers(0, 256, (24, 40, 3), np.uint8)
    signal = Signal(level * np.sin(0.9 * np.arange(900)), 1000, "m/s^2")
    return Example(f"{material}{seed}", signal, material, photographs=(Image(pixels),))


EXAMPLES = [example(name, seed) for name in "ab" for seed in range(2)]


def translation(config=CONFIG):
    made = PhotoTranslation(config, KIND, seed=0)
    made.fit(EXAMPLES)
    return made


def test_ceiling_is_the_largest_amplitude_up_to_five_decibels():
    assert translation().ceiling_db == 0.0  # a sinusoid of 1 m/s^2 reads at most 0 dB
    louder = PhotoTranslation(CONFIG, KIND, seed=0)
    louder.fit([*EXAMPLES, example("a", 9, level=4.0)])
    assert louder.ceiling_db == 15.0  # 12 dB less what falls between bins, rounded up
    fixed = PhotoTranslation(CONFIG.model_copy(update={"ceiling_db": 20.0}), KIND, seed=0)
    fixed.fit(EXAMPLES)
    assert fixed.picture.ceiling_db == 20.0
    assert fixed.picture.floor_db == -60.0


def test_level_of_a_recording_is_recovered_from_its_picture():
    made = translation()
    picture = made.pairs(EXAMPLES).batch([0]).picture
    signal = made.signal(lambda photo: picture, {"image": EXAMPLES[0].photographs[0]}, seconds=None, seed=0)
    assert signal.seconds == pytest.approx(0.9)  # the recordings' length; a picture is shorter
    assert signal.samples.std() == pytest.approx(np.sqrt(0.5), rel=0.1)


def test_crops_of_a_photograph_are_plain_and_the_seed_chooses_them():
    made, image = translation(), EXAMPLES[0].photographs[0]
    one, same, other = (made.photo({"image": image}, 0, seed=seed) for seed in (1, 1, 2))
    torch.testing.assert_close(one, same, rtol=0, atol=0)
    assert not torch.equal(one, other)
    gray = np.rint(image.pixels @ np.array([0.299, 0.587, 0.114])) / 127.5 - 1
    places = [(r, c) for r in range(24 - 15) for c in range(40 - 15)]
    fits = [np.allclose(gray[r : r + 16, c : c + 16], one[0, 0], atol=0.01) for r, c in places]
    assert sum(fits) == 1


def test_longer_signal_of_a_seed_begins_as_the_shorter_one():
    made, image = translation(), EXAMPLES[0].photographs[0]
    short, long = (
        made.signal(lambda photo: photo, {"image": image}, seconds=seconds, seed=0).samples
        for seconds in (0.4, 1.3)
    )
    np.testing.assert_array_equal(long[:, :400], short)


def test_validation_omits_unusable_examples():
    made = translation()
    bare = [
        Example("x", EXAMPLES[0].signal, "a"),
        Example("y", EXAMPLES[0].signal.cut(0, 100), "b", {}, EXAMPLES[0].photographs),
    ]
    assert made.unseen(bare) is None
    assert made.unseen([*bare, EXAMPLES[0]]) is not None


@pytest.mark.parametrize(("count", "size"), [(7, 3), (4, 4), (2, 5)])
def test_each_item_occurs_once_per_epoch(count, size):
    drawn = np.concatenate([shuffled(count, size, number, seed=5) for number in range(count)])
    assert len(drawn) == count * size
    for epoch in drawn.reshape(size, count):
        assert sorted(epoch) == list(range(count))


def test_row_statistics_are_blind_to_time_only():
    torch.manual_seed(0)
    real = torch.rand(3, 1, 8, 20)
    assert row_statistics_distance(real.roll(5, 3), real).item() == pytest.approx(0, abs=1e-6)
    assert row_statistics_distance(real + 0.2, real).item() == pytest.approx(0.2, abs=1e-6)
    assert row_statistics_distance(real.mean(3, keepdim=True).expand_as(real), real).item() > 0.2


def test_silence_and_other_conditions_are_one_line():
    silent = [Example("s", Signal(np.zeros(900), 1000, "m/s^2"), "a", photographs=EXAMPLES[0].photographs)]
    with pytest.raises(ParameterError, match="silent"):
        PhotoTranslation(CONFIG, KIND, seed=0).fit(silent)
    with pytest.raises(ParameterError, match="must be an Image, got str"):
        translation().photo({"image": "photo.jpg"}, 0, seed=0)
    with pytest.raises(ParameterError, match="none has one"):
        PhotoTranslation(CONFIG, SignalKind(1000.0, "m/s^2", ("z",)), seed=0)
    along = SignalKind(50.0, "1", ("along",), ("a",), domain="displacement")
    with pytest.raises(ParameterError, match="must be over time, got ones over displacement; take frictgan"):
        PhotoTranslation(CONFIG, along, seed=0)


def test_an_even_number_of_columns_is_refused_before_a_training():
    with pytest.raises(ValueError, match="odd number of columns, got 4"):
        PairConfig(smooth=4)
