"""Registered pairs: windows of a photograph with the friction beneath them, cut on demand.

**The mapping.** A recording over displacement whose photograph has a scale is *registered*: column 0 of the
photograph is where the displacement is 0, and the finger moved to the right along its middle row. The window of
columns ``left`` to ``left + pixels`` covers ``left * mm_per_pixel`` to ``(left + pixels) * mm_per_pixel`` of the
friction, resampled to ``samples`` samples: as published 1024 pixels and 1280 samples, 1.25 samples per pixel. A
stretch begins at the nearest sample (within 0.4 pixels).

Without registration (no scale, or signals over time) a window is paired with a random stretch of the same length of its
recording: such a pair only relates a kind of friction to a kind of picture.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image as Pillow
from torch import Tensor

from tactogram.datasets.store.photographs import image_key
from tactogram.errors import ParameterError
from tactogram.model import Example
from tactogram.signal import Image, Signal
from tactogram.signal.resampling import resample

Protocol = Literal["examples", "window-split", "region-split"]
"""Separation of training and test.

``examples``: the split of the recordings (or of the materials) that these examples come from.
``window-split``: overlapping windows of one photograph, drawn at random, as published. **It leaks**: nearly every
test window has training windows one step away.
``region-split``: windows within stretches of the photograph, and of the friction, that do not overlap. Recordings
registered to one photograph share its stretches: those of the shortest.
"""
Part = Literal["train", "validation", "test"]
PARTS: tuple[Part, ...] = get_args(Part)

CACHED_BYTES = 256 * 1024 * 1024
"""Memory of decoded photographs, cut to the strips that hold windows: windows are drawn from as many as fit (some 35 as
published) at a time, so that memory does not grow with the data."""


@dataclass(frozen=True, kw_only=True)
class PhotoWindows:
    """Windows of photographs and their separation; defaults are FrictGAN's (Sec. 4)."""

    pixels: int = 1024
    """Side of a window."""
    samples: int = 1280
    """Length of the signal of a window."""
    offset: int = 2
    """Pixels between windows: "with the offset of two pixels"."""
    most: int | None = 600
    """Most windows per photograph, from the left: "the previous 600"; None takes all. (2362 pixels hold 670; the
    paper counts 669.)"""
    protocol: Protocol = "window-split"
    shares: tuple[float, float, float] = (400 / 600, 100 / 600, 100 / 600)
    """Train, validate and test, of the windows (``window-split``: 400/100/100) or of the width."""
    grey: bool = False
    """Whether a window has one channel (ITU-R 601 luma) instead of three."""
    seed: int = 0
    """Decides the part of each window."""

    def __post_init__(self) -> None:
        if min(self.pixels, self.samples, self.offset) < 1 or (self.most is not None and self.most < 1):
            raise ParameterError("pixels, samples, offset and most must be at least 1")
        if self.protocol not in get_args(Protocol):
            raise ParameterError.one_of("protocol", get_args(Protocol), self.protocol)
        if len(self.shares) != 3 or min(self.shares) < 0 or abs(sum(self.shares) - 1) > 1e-6:
            raise ParameterError.must("shares", "be three numbers >= 0 that add up to 1", self.shares)

    def lefts(self, width: int, part: Part | None) -> NDArray[np.int64]:
        """Return the first columns of the windows of ``part`` (None: of all) in ``width`` usable columns, sorted."""
        first, last = 0, width
        if self.protocol == "region-split" and part is not None:
            first, last = _stretch(width, self.shares, PARTS.index(part))
        if last - first < self.pixels:
            raise ParameterError(
                f"{last - first} usable columns of a photograph of {width} hold no window of {self.pixels}: "
                "lower config.pixels (and n_fft, hop in proportion), or change config.shares"
            )
        lefts = np.arange(first, last - self.pixels + 1, self.offset)[: self.most]
        if self.protocol != "window-split" or part is None:
            return lefts
        order = np.random.default_rng(self.seed).permutation(len(lefts))
        begin, end = _stretch(len(lefts), self.shares, PARTS.index(part))
        return np.sort(lefts[order[begin:end]])

    def window(self, image: Image, left: int) -> NDArray[np.uint8]:
        """Return a window about the middle row, uint8, shape (pixels, pixels, channel)."""
        rows, columns = image.pixels.shape[:2]
        if rows < self.pixels or columns < left + self.pixels:
            raise ParameterError(
                f"a photograph of {columns} x {rows} pixels holds no window of {self.pixels} at column {left}; "
                "take a larger photograph or a model of smaller windows"
            )
        top = (rows - self.pixels) // 2
        cut = image.pixels[top : top + self.pixels, left : left + self.pixels]
        if self.grey:
            cut = np.asarray(Pillow.fromarray(cut).convert("L"))[..., None]
        return cut

    def tensor(self, windows: Sequence[NDArray[np.uint8]]) -> Tensor:
        """Return windows as network input, float32, shape (window, channel, pixels, pixels), -1..1."""
        stacked = torch.from_numpy(np.stack(windows)).permute(0, 3, 1, 2)  # B, C, H, W
        return stacked.float().div_(127.5).sub_(1)


@dataclass(frozen=True, eq=False)
class FrictionBatch:
    """Pairs: photographs, (pair, channel, pixels, pixels), -1..1, and friction, (pair, axis, samples).

    ``places``, int64, (pair, 2), are the number of the example and the first column of the window.
    """

    photo: Tensor
    friction: Tensor
    places: NDArray[np.int64]


class RegisteredPairs:
    """Pairs of ``examples`` with a photograph as condition ``image``, or in `Example.photographs`.

    ``part`` None takes all windows; ``mm_per_pixel`` is the common scale of the photographs, by default that of the
    first one with a scale.
    """

    def __init__(
        self,
        examples: Sequence[Example],
        windows: PhotoWindows,
        *,
        part: Part | None = None,
        mm_per_pixel: float | None = None,
    ) -> None:
        if not examples:
            raise ParameterError("there are no examples to pair with photographs")
        self.examples, self.windows, self.part = examples, windows, part
        self.mm_per_pixel = mm_per_pixel
        self.cached = len(examples)
        """Photographs that are cached."""
        self._photos: OrderedDict[int, Image] = OrderedDict()
        self._signals: OrderedDict[int, Signal] = OrderedDict()
        self.registered: list[bool] = []
        widths: list[tuple[str, int]] = []  # key of the photograph, and its usable columns
        for number in range(len(examples)):
            image, signal = self._photo(number), examples[number].signal
            if self.mm_per_pixel is None and image.mm_per_pixel is not None:
                self.mm_per_pixel = image.mm_per_pixel
            registered = signal.domain == "displacement" and image.mm_per_pixel is not None
            self.registered.append(registered)
            rows, width = image.pixels.shape[:2]
            if rows < windows.pixels:
                raise ParameterError(
                    f"recording {examples[number].id}: a photograph of {width} x {rows} pixels holds no window of "
                    f"{windows.pixels}; lower config.pixels (and n_fft, hop in proportion)"
                )
            self.cached = min(self.cached, max(1, CACHED_BYTES // image.pixels.nbytes))
            if registered:
                width = min(width, int(len(self._signal(number)) * windows.pixels / windows.samples))
            elif len(signal) < windows.samples:
                raise ParameterError(
                    f"recording {examples[number].id} has {len(signal)} samples, a pair needs {windows.samples}; "
                    "lower config.hop and config.n_fft, or omit the recording"
                )
            widths.append((image_key(image) if registered else "", width))
        shared: dict[str, int] = {}  # regions are those of the shortest recording of a photograph
        for key, width in widths:
            shared[key] = min(width, shared.get(key, width))
        regions = windows.protocol == "region-split"
        self._lefts = [
            windows.lefts(shared[key] if regions and key else width, part) for key, width in widths
        ]
        self._bounds = np.cumsum([len(lefts) for lefts in self._lefts])

    def __len__(self) -> int:
        return int(self._bounds[-1])

    def of(self, number: int) -> range:
        """Return the places of the windows of example ``number``."""
        return range(int(self._bounds[number]) - len(self._lefts[number]), int(self._bounds[number]))

    def order(self, seed: int) -> Iterator[int]:
        """Yield every place once per epoch, without end, at random among `cached` photographs at a time."""
        epoch = 0
        while True:
            random = np.random.default_rng([seed, epoch])
            numbers = random.permutation(len(self.examples))
            for first in range(0, len(numbers), self.cached):
                places = np.concatenate([self.of(int(n)) for n in numbers[first : first + self.cached]])
                yield from random.permutation(places).tolist()
            epoch += 1

    def batch(self, places: Sequence[int], *, seed: int = 0) -> FrictionBatch:
        """Return the pairs at ``places``; ``seed`` draws the stretches of unregistered recordings."""
        photos, frictions, cuts = [], [], []
        for index in places:
            number = int(np.searchsorted(self._bounds, index, side="right"))
            left = int(self._lefts[number][index - self.of(number).start])
            photos.append(self.windows.window(self._photo(number), left))
            frictions.append(self._friction(number, left, np.random.default_rng([seed, index])))
            cuts.append((number, left))
        friction = torch.from_numpy(np.stack(frictions))
        return FrictionBatch(self.windows.tensor(photos), friction, np.array(cuts, np.int64).reshape(-1, 2))

    def _friction(self, number: int, left: int, random: np.random.Generator) -> NDArray[np.float32]:
        count = self.windows.samples
        signal = self._signal(number)
        if self.registered[number]:
            start = min(round(left * count / self.windows.pixels), len(signal) - count)
        else:
            first, last = 0, len(signal)
            if self.windows.protocol == "region-split" and self.part is not None:
                first, last = _stretch(len(signal), self.windows.shares, PARTS.index(self.part))
            if last - first < count:
                raise ParameterError(
                    f"recording {self.examples[number].id}: {last - first} samples of its {self.part} part hold no "
                    f"stretch of {count}; change config.shares"
                )
            start = int(random.integers(first, last - count + 1))
        return signal.samples[:, start : start + count]

    def _signal(self, number: int) -> Signal:
        image = self._photo(number)
        signal = self.examples[number].signal
        if signal.domain != "displacement" or image.mm_per_pixel is None:
            return signal
        if number not in self._signals:
            rate = self.windows.samples / (self.windows.pixels * image.mm_per_pixel)
            self._signals[number] = resample(signal, rate)
            while len(self._signals) > self.cached:
                self._signals.popitem(last=False)
        return self._signals[number]

    def _photo(self, number: int) -> Image:
        """Return the strip of an example's photograph that holds its windows, at the common scale."""
        if number in self._photos:
            self._photos.move_to_end(number)
            return self._photos[number]
        image = photograph_of(self.examples[number])
        if self.mm_per_pixel is not None:
            image = scaled(image, self.mm_per_pixel)
        rows, size = image.pixels.shape[0], self.windows.pixels
        if rows > size:
            image = image.cut((rows - size) // 2, 0, (rows - size) // 2 + size)
        self._photos[number] = image
        while len(self._photos) > self.cached:  # which falls with larger photographs
            self._photos.popitem(last=False)
        return image


def photograph_of(example: Example) -> Image:
    """Return the photograph that an example was recorded with, else the first of its surface."""
    image = example.condition.get("image")
    if image is None and len(example.photographs):
        image = example.photographs[0]
    if not isinstance(image, Image):
        raise ParameterError(
            f"recording {example.id} has no photograph; add one when importing, or omit the recording"
        )
    return image


def scaled(image: Image, mm_per_pixel: float) -> Image:
    """Return a photograph resized to another scale, by area if it shrinks; unchanged if it has no scale."""
    if image.mm_per_pixel is None or abs(image.mm_per_pixel / mm_per_pixel - 1) < 1e-3:
        return image
    rows, columns = (max(1, round(n * image.mm_per_pixel / mm_per_pixel)) for n in image.pixels.shape[:2])
    smaller = image.mm_per_pixel < mm_per_pixel
    resampling = Pillow.Resampling.BOX if smaller else Pillow.Resampling.BICUBIC
    return Image(np.asarray(Pillow.fromarray(image.pixels).resize((columns, rows), resampling)), mm_per_pixel)


def _stretch(count: int, shares: Sequence[float], part: int) -> tuple[int, int]:
    """Return first and last (exclusive) of ``count`` consecutive items in a part."""
    edges = np.round(np.cumsum((0.0, *shares)) * count).astype(int)
    return int(edges[part]), int(edges[part + 1])
