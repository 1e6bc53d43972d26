"""Leak of a pairing protocol: test data that was trained on."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.features.photo_pairs import WeakPairs


@dataclass(frozen=True)
class PairLeak:
    """Shares of the different test crops of photographs and of recordings, 0..1; all are 0 if nothing leaks.

    ``known``: crops whose photograph or recording is trained on, wherever in it; ``overlaps``: with a pixel or frame in
    common with a training crop; ``same``: themselves trained on.
    """

    protocol: str
    photo_crops: int
    picture_crops: int
    photo_known: float
    photo_overlaps: float
    photo_same: float
    recording_known: float
    recording_overlaps: float
    recording_same: float

    @property
    def leaks(self) -> bool:
        """Whether a pixel or a frame is on both sides; regions of one photograph may be."""
        return self.photo_overlaps > 0 or self.recording_overlaps > 0


def pair_leak(train: WeakPairs, test: WeakPairs) -> PairLeak:
    """Return the leak of ``train`` into ``test``, pairs of one protocol. Nothing is decoded."""
    photo = _shares(*(_by_source(_photo_boxes(pairs)) for pairs in (train, test)))
    recording = _shares(*(_by_source(_recording_boxes(pairs)) for pairs in (train, test)))
    return PairLeak(test.protocol, photo[0], recording[0], *photo[1:], *recording[1:])


Boxes = Mapping[str, NDArray[np.int64]]
"""Crops by source, shape (crop, edge): top, left, bottom, right; or start, stop."""


def _photo_boxes(pairs: WeakPairs) -> Iterator[tuple[str, tuple[int, ...]]]:
    for crop in np.unique(pairs.pairs[:, 0]):
        source = pairs.photo_sources[crop // pairs.crops.per_photo]
        top, left = pairs.photo_place(int(crop))
        top, left = top + source.top, left + source.left
        yield source.key, (top, left, top + pairs.crops.crop, left + pairs.crops.crop)


def _recording_boxes(pairs: WeakPairs) -> Iterator[tuple[str, tuple[int, ...]]]:
    hop, frames = pairs.picture.hop, pairs.picture.frames
    for crop in np.unique(pairs.pairs[:, 1]):
        source = pairs.recording_sources[crop // pairs.crops.per_recording]
        start = source.start + pairs.picture_place(int(crop)) * hop
        yield source.id, (start, start + frames * hop)


def _by_source(boxes: Iterable[tuple[str, tuple[int, ...]]]) -> Boxes:
    boxes_by_key: dict[str, list[tuple[int, ...]]] = defaultdict(list)
    for key, box in boxes:
        boxes_by_key[key].append(box)
    return {key: np.array(members, np.int64) for key, members in boxes_by_key.items()}


def _shares(train: Boxes, test: Boxes) -> tuple[int, float, float, float]:
    """Return the number of crops in ``test``, and the shares of known, overlapping and same ones."""
    count = known = overlap = same = 0
    for key, boxes in test.items():
        count += len(boxes)
        if key in train:
            known += len(boxes)
            a, b = boxes[:, None], train[key][None]  # test crop, train crop, edge
            half = boxes.shape[1] // 2
            before = (a[..., :half] < b[..., half:]) & (b[..., :half] < a[..., half:])
            overlap += int(np.all(before, axis=2).any(axis=1).sum())
            same += int(np.all(a == b, axis=2).any(axis=1).sum())
    return count, known / count, overlap / count, same / count
