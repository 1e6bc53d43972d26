"""Weak pairs: what is cut, what is paired with what, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.features.photo_crops import PhotoCrops, to_network
from tactogram.features.photo_pairs import shuffled, weak_pairs
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.model import Example
from tactogram.signal import Image, Signal

PICTURE = SpectrogramPicture(
    rate=1000.0, floor_db=-80.0, ceiling_db=20.0, n_fft=32, hop=8, frames=16, rows=16, columns=16
)
CROPS = PhotoCrops(crop=24, size=16, per_photo=10, per_recording=10, repeats=3)
MATERIALS = ("cork", "felt", "tile")


class Counted(list):
    """Photographs that count how often they are read."""

    reads = 0

    def __getitem__(self, place):
        Counted.reads += 1
        return super().__getitem__(place)


def photo(seed, rows=40, columns=48):
    return Image(np.random.default_rng(seed).integers(0, 256, (rows, columns, 3), np.uint8))


def part(seed, materials=MATERIALS, photos=3, recordings=4, length=400):
    """Return examples of a part of a split: its own photographs and recordings of each material."""
    random = np.random.default_rng(seed)
    examples = []
    for m, material in enumerate(materials):
        pictures = Counted(photo((seed, m, k)) for k in range(photos))
        for k in range(recordings):
            samples = (1 + m) * random.standard_normal(length)
            examples.append(
                Example(
                    f"{seed}-{material}-{k}",
                    Signal(samples, 1000.0, "m/s^2"),
                    material,
                    photographs=pictures,
                )
            )
    return examples


PARTS = {"train": part(1), "validation": part(2, photos=1, recordings=2), "test": part(3, photos=1)}


def pairs(examples=PARTS["train"], crops=CROPS, **options):
    return weak_pairs(examples, PICTURE, crops, seed=5, **options)


def test_a_batch_has_the_shapes_and_types_of_network_input():
    batch = pairs().batch([0, 100, 359])
    assert batch.photo.shape == (3, 1, 16, 16)
    assert batch.picture.shape == (3, 1, 16, 16)
    assert batch.photo.dtype == batch.picture.dtype == torch.float32
    assert batch.photo.abs().max() <= 1
    assert batch.picture.abs().max() <= 1
    assert batch.label.tolist() == [0, 0, 2]


def test_the_counts_are_the_papers():
    """Ten photographs and ten recordings of a material: 100 crops of each, 1000 pairs (Sec. 4.1)."""
    examples = part(0, photos=10, recordings=10)
    crops = replace(CROPS, repeats=10)
    whole = weak_pairs(examples, PICTURE, crops, seed=0)
    assert len(whole) == 3 * 1000
    for protocol in ("crop-split", "pair-then-split"):
        counts = [
            len(weak_pairs({"all": examples}, PICTURE, crops, seed=0, protocol=protocol, part=p))
            for p in ("train", "validation", "test")
        ]
        assert counts == [3 * 800, 3 * 100, 3 * 100]


def test_a_pair_is_of_one_material():
    made = pairs()
    photo, recording = made.pairs.T // 10
    for p, r in zip(photo, recording, strict=True):
        assert made.photo_sources[p].material == made.recording_sources[r].material
    assert made.materials == MATERIALS
    assert np.bincount(made.labels).tolist() == [3 * 40] * 3


def test_every_crop_is_paired_in_every_repeat():
    made = pairs()  # 30 crops of photographs and 40 of recordings per material, three times
    photos, recordings = (
        np.bincount(column, minlength=n) for column, n in zip(made.pairs.T, (90, 120), strict=True)
    )
    assert (recordings == 3).all()
    assert photos.min() >= 3
    assert photos.max() <= 6
    assert len(np.unique(made.pairs[:40], axis=0)) == 40


def test_the_picture_of_a_pair_is_that_of_its_recording():
    made = pairs()
    batch = made.batch([7])
    crop = int(made.pairs[7, 1])
    example = next(
        e for e in PARTS["train"] if e.id == made.recording_sources[crop // CROPS.per_recording].id
    )
    samples = torch.tensor(example.signal.samples[0])
    torch.testing.assert_close(batch.picture[0], PICTURE.crop(samples, made.picture_place(crop)))


def test_the_photo_of_a_pair_is_a_crop_of_its_photograph():
    plain = replace(CROPS, flips=False, brightness=0.0, contrast=0.0, size=24, grayscale=False)
    made = pairs(crops=plain)
    crop = int(made.pairs[11, 0])
    source = made.photo_sources[crop // 10]
    top, left = made.photo_place(crop)
    expected = source.image().pixels[top : top + 24, left : left + 24].transpose(2, 0, 1)
    torch.testing.assert_close(made.batch([11]).photo[0], to_network(np.ascontiguousarray(expected)))


def test_a_pair_is_the_same_in_any_batch():
    one, other = pairs(), pairs(cache_mib=0)
    many = one.batch(np.arange(50))
    for place in (0, 13, 49):
        alone = other.batch([place])
        assert torch.equal(alone.photo[0], many.photo[place])
        assert torch.equal(alone.picture[0], many.picture[place])


def test_a_batch_depends_on_seed_and_number_alone():
    made = pairs()
    for number in range(14):  # beyond one epoch of 360
        last = made.batch(shuffled(len(made), 32, number, seed=5)).picture
    assert torch.equal(pairs().batch(shuffled(360, 32, 13, seed=5)).picture, last)
    assert not np.array_equal(shuffled(360, 32, 0, seed=5), shuffled(360, 32, 1, seed=5))
    assert not np.array_equal(shuffled(360, 32, 0, seed=5), shuffled(360, 32, 0, seed=6))


@pytest.mark.parametrize("size", [1, 7, 360, 500, 1000])
def test_an_epoch_has_every_pair_once(size):
    batches = [shuffled(360, size, number, seed=5) for number in range(-(-720 // size))]
    order = np.concatenate(batches)[:720]
    for epoch in (order[:360], order[360:]):
        assert sorted(epoch) == list(range(360))
    assert not np.array_equal(order[:360], order[360:])


def test_photographs_are_decoded_on_demand_and_cached():
    Counted.reads = 0
    made = pairs()
    assert Counted.reads == 0  # a list is iterated, not indexed
    made.batch([0, 1])
    reads = Counted.reads
    assert reads <= 2
    made.batch([0, 1])
    assert Counted.reads == reads


def test_the_cache_is_bounded():
    made = pairs(cache_mib=0.01)  # 10 KiB: ten pictures of 1 KiB or so
    made.batch(np.arange(len(made)))
    assert sum(array.nbytes for array in made._cache._arrays.values()) <= 0.01 * 2**20


def test_an_unknown_material_has_the_label_minus_one():
    made = pairs(PARTS["test"], materials=("felt", "oak"))
    assert set(made.batch(np.arange(len(made))).label.tolist()) == {0, -1}
    assert made.materials == ("felt", "oak")


def test_bad_input_is_one_line():
    with pytest.raises(ParameterError, match=r"protocol must be one of source-split, crop-split"):
        pairs(protocol="random")
    with pytest.raises(ParameterError, match=r"crop-split leaks .*needs the examples of all parts"):
        pairs(protocol="crop-split")
    with pytest.raises(ParameterError, match=r"part must be one of"):
        pairs(part="all")
    with pytest.raises(ParameterError, match=r"of 40 x 48 pixels is smaller than the crop of 64"):
        pairs(crops=replace(CROPS, crop=64))
    with pytest.raises(ParameterError, match=r"recording 0.05 s"):
        pairs(part(1, length=50))
    with pytest.raises(ParameterError, match=r"must have a photograph.*felt"):
        pairs([e if e.material != "felt" else replace(e, photographs=()) for e in PARTS["train"]])
    with pytest.raises(ParameterError, match=r"one axis, got x,y,z"):
        pairs([replace(e, signal=Signal(np.zeros((3, 400)), 1000.0, "m/s^2")) for e in PARTS["train"]])
    with pytest.raises(ParameterError, match=r"rate 1000, got 500"):
        pairs([replace(e, signal=replace(e.signal, rate=500.0)) for e in PARTS["train"]])
    few = replace(CROPS, per_photo=1, per_recording=1)
    with pytest.raises(ParameterError, match=r"leaves nothing of cork for validation"):
        pairs({"all": part(1, photos=1, recordings=1)}, crops=few, protocol="crop-split", part="validation")
