"""Both ends of a network that turns photographs into spectrogram pictures: pairs to learn from, signals to feel.

Four models stand between these ends: visual_tactile_gan, pix2pix, pix2pixhd and residue_fusion_gan. What a photograph,
a picture and a pair are is the same for all, as in the comparison of Neshov et al. 2026 (Sec. 4.1 and 4.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, field_validator
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.photo_crops import PhotoCrops, to_network
from tactogram.features.photo_pairs import Part, Protocol, WeakPairs, rng_of, shuffled, weak_pairs
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.model import Condition, Example, SignalKind
from tactogram.signal import Image, Signal
from tactogram.signal.joining import extend

ROUND_DB = 5.0
"""Measured ceilings are rounded up to a multiple of this."""


class PairConfig(BaseModel):
    """Photographs and pictures of a pair; numbers with their place in Neshov et al. 2026, Sec. 4.1."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    n_fft: int = Field(default=512, gt=1)
    """Samples of the Hamming window. "512-point Hamming window"."""
    hop: int = Field(default=128, gt=0)
    """Samples. "hop size of 128"."""
    frames: int = Field(default=256, gt=1)
    """Of a picture. "256 consecutive time frames"."""
    size: int = Field(default=256, gt=1)
    """Rows and columns of photograph and picture. "resized to 256 x 256"."""
    ceiling_db: float | None = Field(default=None, allow_inf_nan=False)
    """Amplitude that is 1 in a picture, dB re 1 unit. The paper names none. None: the largest of the training
    recordings, rounded up to 5 dB: measured once, saved with the weights, and the same for every signal."""
    range_db: float = Field(default=80.0, gt=0, allow_inf_nan=False)
    """The floor, -1 in a picture, is so far below the ceiling. Assumed."""
    crop: int = Field(default=256, gt=1)
    """Side of a photograph's crop, pixels. "cropping … to a resolution of 256 x 256"."""
    per_photo: int = Field(default=10, gt=0)
    """Crops of each photograph. "data augmentation ten times"."""
    per_recording: int = Field(default=10, gt=0)
    """Pictures of each recording. "randomly cropped ten times along the temporal axis"."""
    repeats: int = Field(default=10, gt=0)
    """"random pairing is repeated ten times within each material"."""
    flips: bool = True
    """"random horizontal and vertical flipping"."""
    brightness: float = Field(default=0.2, ge=0, le=1)
    """"adjustments to image brightness and contrast": by how much is assumed."""
    contrast: float = Field(default=0.2, ge=0, le=1)
    """As ``brightness``."""
    protocol: Protocol = "source-split"
    """What is split before what. Ours; our reading of the paper is ``crop-split``, on a run whose split is ``all``."""
    excitation: Literal["phase", "noise"] = "phase"
    """How a made picture becomes a signal. ``phase``: a phase is found for all of its grain. ``noise``: its grain is
    smoothed away and Gaussian noise takes its levels; for networks too small or too shortly trained to draw a grain
    that a signal can have. Ours; the paper does not evaluate it."""
    smooth: int = Field(default=17, gt=0)
    """Columns that levels are smoothed over with ``excitation = "noise"``; odd. Ours."""
    overlap: float = Field(default=0.125, gt=0, le=0.5)
    """Share of a picture's length by which the pieces of a longer signal are crossfaded. Ours."""

    @field_validator("smooth")
    @classmethod
    def _smooth_is_odd(cls, smooth: int) -> int:
        if smooth % 2 == 0:
            raise ValueError(f"smooth must be an odd number of columns, got {smooth}")
        return smooth


VARIATION = "the crop of the photograph and the phase, or noise, that is found for it: the network takes none"
"""What signals of several seeds differ by."""


class PhotoTranslation:
    """Pairs of a training, and signals from what a network makes of photographs.

    Parameters
    ----------
    config : PairConfig
    kind : SignalKind
        One axis.
    seed : int
        Decides which crops there are and how they are paired; the same in every part of a split.
    """

    def __init__(self, config: PairConfig, kind: SignalKind, *, seed: int) -> None:
        if not kind.materials:
            raise ParameterError("photographs and recordings are paired by material, and none has one")
        if len(kind.axes) != 1:
            raise ParameterError(
                f"a picture is of one axis, got {','.join(kind.axes)}: --set prepare.axes=['{kind.axes[-1]}'] "
                "takes one, prepare.axes=dft321 combines three"
            )
        self.config, self.kind, self.seed = config, kind, seed
        self.ceiling_db = 0.0 if config.ceiling_db is None else config.ceiling_db
        self.seconds = 0.0
        self._pairs: dict[tuple[int, Part], tuple[Any, SpectrogramPicture, WeakPairs]] = {}

    @property
    def picture(self) -> SpectrogramPicture:
        """The picture's convention; its levels are those of the last `fit`."""
        c = self.config
        return SpectrogramPicture(
            rate=self.kind.rate,
            unit=self.kind.unit,
            domain=self.kind.domain,
            floor_db=self.ceiling_db - c.range_db,
            ceiling_db=self.ceiling_db,
            n_fft=c.n_fft,
            hop=c.hop,
            frames=c.frames,
            rows=c.size,
            columns=c.size,
        )

    @property
    def splits_crops(self) -> str:
        """The protocol that splits crops of what is trained on; empty where photographs and recordings are split."""
        return "" if self.config.protocol == "source-split" else self.config.protocol

    @property
    def crops(self) -> PhotoCrops:
        """How photographs are cut and augmented."""
        names = ("crop", "size", "per_photo", "per_recording", "repeats", "flips", "brightness", "contrast")
        return PhotoCrops(**{name: getattr(self.config, name) for name in names})

    # -- training ----------------------------------------------------------------------------------------

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure what is saved with the weights: the level that is 1 in a picture, and the usual length."""
        spectrogram, most = self.picture.spectrogram, 0.0
        for example in examples:
            self.kind.check(example.signal)
            amplitudes = spectrogram.amplitudes(spectrogram.stft(torch.tensor(example.signal.samples)))
            most = max(most, amplitudes.max().item())
        if self.config.ceiling_db is None:
            if most == 0:
                raise ParameterError("every training recording is silent: there is nothing to learn")
            self.ceiling_db = ROUND_DB * math.ceil(20 * math.log10(most) / ROUND_DB)
        self.seconds = float(np.median([example.signal.seconds for example in examples]))
        return {"ceiling_db": self.ceiling_db, "seconds": self.seconds}

    def pairs(self, examples: Sequence[Example], part: Part = "train") -> WeakPairs:
        """Return the pairs of ``examples``; the last ones of each part are kept, with their finished crops."""
        key = (id(examples), part)
        kept = self._pairs.get(key)
        if kept is None or kept[1] != self.picture:
            # A training refuses what it cannot use, before it begins; a validation leaves it out.
            held = examples if part == "train" else [e for e in examples if self._usable(e)]
            found = weak_pairs(
                {"all": held},
                self.picture,
                self.crops,
                seed=self.seed,
                protocol=self.config.protocol,
                part=part,
                materials=self.kind.materials,
            )
            self._pairs = {k: v for k, v in self._pairs.items() if k[1] != part}
            kept = self._pairs[key] = (
                examples,
                self.picture,
                found,
            )  # the examples, so that the id stays theirs
        return kept[2]

    def check(self, examples: Sequence[Example]) -> None:
        """Refuse training examples that lack a material's photographs or recordings."""
        present = {example.material for example in examples}
        if missing := [name for name in self.kind.materials if name not in present]:
            raise ParameterError(f"no training recording of {', '.join(missing)}; leave it out of the data")
        if not any(len(example.photographs) for example in examples):
            raise ParameterError("no recording has a photograph: import photographs, or take another model")
        self.pairs(examples)

    def batches(
        self, examples: Sequence[Example], *, size: int, seed: int, start: int = 0
    ) -> Iterator[tuple[int, Tensor, Tensor, Tensor, Tensor]]:
        """Yield number, photographs and pictures (batch, 1, row, column), labels and crop numbers (batch,)."""
        pairs = self.pairs(examples)
        while True:
            places = shuffled(len(pairs), size, start, seed=seed)
            batch = pairs.batch(places)
            crops = torch.from_numpy(pairs.pairs[places, 0])
            yield start, batch.photo, batch.picture, batch.label, crops
            start += 1

    def unseen(self, examples: Sequence[Example]) -> WeakPairs | None:
        """Return the pairs of the validation part; None where no example has a photograph and is long enough."""
        kept = self._pairs.get((id(examples), "validation"))
        usable = kept is not None or any(self._usable(example) for example in examples)
        return self.pairs(examples, "validation") if usable else None

    def _usable(self, example: Example) -> bool:
        enough = self.picture.spectrogram.frames(len(example.signal)) >= self.config.frames
        return enough and len(example.photographs) > 0

    def state(self) -> dict[str, Any]:
        """Return what was measured."""
        return {"ceiling_db": self.ceiling_db, "seconds": self.seconds}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`."""
        self.ceiling_db, self.seconds = float(state["ceiling_db"]), float(state["seconds"])

    # -- use ---------------------------------------------------------------------------------------------

    def photo(self, condition: Condition, number: int, *, seed: int) -> Tensor:
        """Return crop ``number`` of the photograph asked for, plain, shape (1, 1, row, column), -1 to 1."""
        image = condition["image"]
        if not isinstance(image, Image):
            raise ParameterError(f"condition 'image' must be an Image, got {type(image).__name__}")
        plain = replace(self.crops, flips=False, brightness=0.0, contrast=0.0)
        return to_network(plain.random(image, rng_of(seed, "crop", number)))[None]

    def inverted(self, pictures: Tensor, *, seed: int) -> Tensor:
        """Return the samples, shape (..., time), of pictures (..., 1, row, column), as ``config.excitation`` says."""
        if self.config.excitation == "noise":
            return self.picture.noise(pictures, smooth=self.config.smooth, seed=seed)
        return self.picture.signal(pictures, seed=seed)

    def signal(
        self,
        make: Callable[[Tensor], Tensor],
        condition: Condition,
        *,
        seconds: float | None,
        seed: int,
    ) -> Signal:
        """Return the signal of the pictures that ``make`` makes of crops of ``condition["image"]``.

        A signal longer than a picture is of several crops, crossfaded. ``seed`` decides the crops and the phase
        that is found; the pictures themselves follow from the crops, unless ``make`` draws noise.

        Parameters
        ----------
        make : callable
            Photographs (1, 1, row, column) in -1 to 1 to pictures of that shape.
        seconds : float, optional
            By default the usual length of the training recordings.
        """
        picture = self.picture

        def piece(number: int) -> Signal:
            made = make(self.photo(condition, number, seed=seed)).float().cpu()
            phase = int(rng_of(seed, "phase", number).integers(2**63))
            samples = self.inverted(made[0], seed=phase)
            return Signal(samples.numpy(), self.kind.rate, self.kind.unit, self.kind.axes, self.kind.domain)

        length = seconds if seconds is not None else self.seconds or picture.length / self.kind.rate
        overlap = round(self.config.overlap * picture.length) / self.kind.rate
        return extend(piece, seconds=length, overlap_s=overlap)


def photos_of(pairs: WeakPairs, crops: NDArray[np.int64]) -> tuple[Tensor, Tensor]:
    """Return crops of photographs by number, float32 (crop, 1, row, column) in -1 to 1, and their labels.

    A label is the place of the material in ``pairs.materials``, -1 for one that is not there; int64, (crop,).
    """
    place = {name: number for number, name in enumerate(pairs.materials)}
    sources = (pairs.photo_sources[crop // pairs.crops.per_photo] for crop in crops)
    labels = torch.tensor([place.get(source.material, -1) for source in sources])
    return to_network(np.stack([pairs.photo_crop(int(crop)) for crop in crops])), labels


def photo_crops(pairs: WeakPairs) -> NDArray[np.int64]:
    """Return the numbers of the photographs' crops that are in ``pairs``, each once."""
    return np.unique(pairs.pairs[:, 0])


def row_statistics_distance(made: Tensor, real: Tensor) -> Tensor:
    """Return how far made pictures are from real ones in what is the same at every moment of a texture.

    The mean absolute difference of each row's mean, plus that of each row's standard deviation over time, of a made
    and a real picture. Stands in for LPIPS where its weights are absent; blind, as
    weak pairs demand, to when something happens.

    Parameters
    ----------
    made, real : float Tensor, shape (item, 1, row, column), -1 to 1

    Returns
    -------
    Tensor, scalar
    """
    mean = (made.mean(3) - real.mean(3)).abs().mean()
    spread = (made.std(3) - real.std(3)).abs().mean()
    return mean + spread
