"""What each protocol leaks."""

import numpy as np
import pytest
from tests.features.test_photo_pairs import CROPS, PARTS, PICTURE, pairs

from tactogram.features.pair_leak import pair_leak
from tactogram.features.photo_pairs import weak_pairs


class Counted(list):
    """Photographs that count how often they are read."""

    reads = 0

    def __getitem__(self, place):
        Counted.reads += 1
        return super().__getitem__(place)


def test_source_split_leaks_nothing():
    train, test = pairs(), pairs(PARTS["test"])
    leak = pair_leak(train, test)
    assert leak.photo_crops == 30
    assert leak.picture_crops == 120
    assert (leak.photo_known, leak.photo_overlaps, leak.photo_same) == (0, 0, 0)
    assert (leak.recording_known, leak.recording_overlaps, leak.recording_same) == (0, 0, 0)
    assert not leak.leaks
    assert train.leaks == ""


def test_crop_split_leaks_siblings_and_no_crop():
    """Neshov et al. 2026, Sec. 4.1: "avoid any overlap of images or spectrograms between subsets", which are crops."""
    train, test = (pairs(PARTS, protocol="crop-split", part=p) for p in ("train", "test"))
    leak = pair_leak(train, test)
    assert leak.photo_known > 0.9
    assert leak.photo_overlaps > 0.9  # 24 of 40 x 48: any two crops overlap, or nearly
    assert leak.recording_known > 0.9
    assert leak.recording_overlaps > 0.5
    crops = [set(np.unique(made.pairs[:, 0])) for made in (train, test)]
    assert not crops[0] & crops[1]
    assert leak.leaks
    assert "overlap" in train.leaks


def test_pair_then_split_leaks_the_crops_themselves():
    made = {p: pairs(PARTS, protocol="pair-then-split", part=p) for p in ("train", "validation", "test")}
    leak = pair_leak(made["train"], made["test"])
    assert leak.photo_same > 0.8
    assert leak.recording_same > 0.8
    # The pairs themselves are split: together they are all pairs, once.
    together = np.concatenate([m.pairs for m in made.values()])
    assert len(together) == sum(len(m) for m in made.values())
    assert sorted(map(tuple, together)) == sorted(map(tuple, weak_pairs(PARTS, PICTURE, CROPS, seed=5).pairs))


def test_leak_by_hand():
    """Crops of one recording whose frames overlap by one, touch, and are apart."""
    train, test = pairs(PARTS["train"][:1]), pairs(PARTS["train"][:1])
    train.pairs, test.pairs = train.pairs[:1], np.array([[0, 0], [0, 1], [0, 2]])
    train.picture_place = lambda crop: 0
    test.picture_place = lambda crop: (15, 16, 30)[crop]
    leak = pair_leak(train, test)
    assert leak.picture_crops == 3
    assert leak.recording_known == 1
    assert leak.recording_overlaps == pytest.approx(1 / 3)
    assert leak.recording_same == 0
