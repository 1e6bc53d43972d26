"""Input and output of networks that turn photographs into spectrogram pictures: training pairs, generated signals.

visual_tactile_gan, pix2pix, pix2pixhd and residue_fusion_gan share them, as in the comparison of Neshov et al. 2026
(Sec. 4.1 and 4.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import Field, field_validator
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.photo_crops import PhotoCrops, to_network
from tactogram.features.photo_pairs import Part, Protocol, WeakPairs, rng_of, weak_pairs
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.model import Condition, Example, ModelConfig, Saved, SignalKind
from tactogram.signal import Image, Signal
from tactogram.signal.joining import extend

DistanceName = Literal["lpips", "row_statistics"]
"""Distances of pictures by which weights can be chosen."""
ROUND_DB = 5.0
"""Measured ceilings are rounded up to a multiple of this."""


class PairConfig(ModelConfig):
    """Photograph and picture of a pair; numbers with their place in Neshov et al. 2026, Sec. 4.1."""

    n_fft: int = Field(default=512, gt=1)
    """Samples of the Hamming window. "512-point Hamming window"."""
    hop: int = Field(default=128, gt=0)
    """Samples. "hop size of 128"."""
    frames: int = Field(default=256, gt=1)
    """Per picture. "256 consecutive time frames"."""
    size: int = Field(default=256, gt=1)
    """Rows and columns of photograph and picture. "resized to 256 x 256"."""
    ceiling_db: float | None = Field(default=None, allow_inf_nan=False)
    """Amplitude that is 1 in a picture, dB re 1 unit; not stated in the paper. None: the largest of the training
    recordings, rounded up to 5 dB, measured once and saved with the weights."""
    range_db: float = Field(default=80.0, gt=0, allow_inf_nan=False)
    """Distance from the ceiling down to the floor, which is -1 in a picture. Assumed."""
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
    """"adjustments to image brightness and contrast"; the amount is assumed."""
    contrast: float = Field(default=0.2, ge=0, le=1)
    """As ``brightness``."""
    protocol: Protocol = "source-split"
    """Order of splitting, cutting and pairing. Ours; we read the paper as ``crop-split``, which ``paper`` takes."""
    excitation: Literal["phase", "noise"] = "phase"
    """How a generated picture becomes a signal. ``phase``: by phase recovery. ``noise``: the picture is smoothed and
    Gaussian noise takes its levels, for networks too small or too briefly trained to draw a grain that a signal can
    have. Ours; the paper does not evaluate signals."""
    smooth: int = Field(default=17, gt=0)
    """Columns that ``excitation = "noise"`` smooths levels over; odd. Ours."""
    overlap: float = Field(default=0.125, gt=0, le=0.5)
    """Crossfade between the pieces of a longer signal, as a share of a picture's length. Ours."""

    @property
    def window_protocol(self) -> str:
        """Protocol that splits crops of the training data; empty if recordings are split."""
        return "" if self.protocol == "source-split" else self.protocol

    @field_validator("smooth")
    @classmethod
    def _smooth_is_odd(cls, smooth: int) -> int:
        if smooth % 2 == 0:
            raise ValueError(f"smooth must be an odd number of columns, got {smooth}")
        return smooth


class PhotoTranslation(Saved):
    """Training pairs, and signals of generated pictures; ``seed`` decides crops and pairing in all parts."""

    saved = ("ceiling_db", "seconds")

    def __init__(self, config: PairConfig, kind: SignalKind, *, seed: int) -> None:
        if not kind.materials:
            raise ParameterError("photographs and recordings are paired by material, and none has one")
        if kind.domain != "time":
            raise ParameterError.must(
                "recordings", f"be over time, got ones over {kind.domain}; take frictgan or texture_flow"
            )
        if len(kind.axes) != 1:
            raise ParameterError(
                f"a picture has one axis, got {','.join(kind.axes)}: set prepare.axes=['{kind.axes[-1]}'] "
                "to take one, or prepare.axes=dft321 to combine three"
            )
        self.config, self.kind, self.seed = config, kind, seed
        self.ceiling_db = 0.0 if config.ceiling_db is None else config.ceiling_db
        self.seconds = 0.0
        self._cache: dict[Part, tuple[Sequence[Example], WeakPairs]] = {}

    @property
    def picture(self) -> SpectrogramPicture:
        """Convention of the pictures, with the levels of the last `fit`."""
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
    def crops(self) -> PhotoCrops:
        """Cropping and augmentation of photographs."""
        names = ("crop", "size", "per_photo", "per_recording", "repeats", "flips", "brightness", "contrast")
        return PhotoCrops(**{name: getattr(self.config, name) for name in names})

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure the level that is 1 in a picture, and the median length; both are saved with the weights."""
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
        """Return the pairs of ``examples``; the last pairs of each part are cached, with their finished crops."""
        pairs = self._cached(examples, part)
        if pairs is None or pairs.picture != self.picture:
            # A training refuses unusable examples before it begins; a validation omits them.
            usable = examples if part == "train" else [e for e in examples if self._usable(e)]
            pairs = weak_pairs(
                {"all": usable},
                self.picture,
                self.crops,
                seed=self.seed,
                protocol=self.config.protocol,
                part=part,
                materials=self.kind.materials,
            )
            self._cache[part] = examples, pairs
        return pairs

    def _cached(self, examples: Sequence[Example], part: Part) -> WeakPairs | None:
        of, pairs = self._cache.get(part, (None, None))
        return pairs if of is examples else None

    def check(self, examples: Sequence[Example]) -> None:
        """Refuse training examples that lack a material's photographs or recordings."""
        self.kind.check_all_present(examples)
        if not any(len(example.photographs) for example in examples):
            raise ParameterError("no recording has a photograph: import photographs, or take another model")
        self.pairs(examples)

    @staticmethod
    def batch(pairs: WeakPairs, places: NDArray[np.int64]) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return photographs and pictures (batch, 1, row, column), labels and crop numbers (batch,)."""
        batch = pairs.batch(places)
        return batch.photo, batch.picture, batch.label, torch.from_numpy(pairs.pairs[places, 0])

    def unseen(self, examples: Sequence[Example]) -> WeakPairs | None:
        """Return the pairs of the validation part; None if no example has a photograph and is long enough."""
        usable = self._cached(examples, "validation") or any(self._usable(example) for example in examples)
        return self.pairs(examples, "validation") if usable else None

    def _usable(self, example: Example) -> bool:
        enough = self.picture.spectrogram.frames(len(example.signal)) >= self.config.frames
        return enough and len(example.photographs) > 0

    def photo(self, condition: Condition, number: int, *, seed: int) -> Tensor:
        """Return crop ``number`` of ``condition["image"]``, not augmented: shape (1, 1, row, column), -1 to 1."""
        image = condition["image"]
        if not isinstance(image, Image):
            raise ParameterError(f"condition 'image' must be an Image, got {type(image).__name__}")
        plain = replace(self.crops, flips=False, brightness=0.0, contrast=0.0)
        return to_network(plain.random(image, rng_of(seed, "crop", number)))[None]

    def inverted(self, pictures: Tensor, *, seed: int) -> Tensor:
        """Return the samples, shape (..., time), of pictures, shape (..., 1, row, column), by ``config.excitation``."""
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

        A signal longer than a picture is made of several crops, crossfaded. ``seed`` decides the crops and the
        recovered phase; the pictures depend on the crops alone, unless ``make`` draws noise.

        ``make`` maps photographs (1, 1, row, column) in -1 to 1 to pictures of that shape; ``seconds`` is by default
        the median of the training recordings.
        """
        picture = self.picture

        def piece(number: int) -> Signal:
            generated = make(self.photo(condition, number, seed=seed)).float().cpu()
            phase = int(rng_of(seed, "phase", number).integers(2**63))
            return self.kind.signal(self.inverted(generated[0], seed=phase).numpy())

        length = seconds if seconds is not None else self.seconds or picture.length / self.kind.rate
        overlap = round(self.config.overlap * picture.length) / self.kind.rate
        return extend(piece, seconds=length, overlap_s=overlap)


def photos_of(pairs: WeakPairs, crops: NDArray[np.int64]) -> tuple[Tensor, Tensor]:
    """Return crops of photographs by number, float32 (crop, 1, row, column) in -1 to 1, and their labels.

    A label is the place of the material in ``pairs.materials``, -1 for a material not among them; int64, (crop,).
    """
    number_of = {name: number for number, name in enumerate(pairs.materials)}
    sources = (pairs.photo_sources[crop // pairs.crops.per_photo] for crop in crops)
    labels = torch.tensor([number_of.get(source.material, -1) for source in sources])
    return to_network(np.stack([pairs.photo_crop(int(crop)) for crop in crops])), labels


def photo_crops(pairs: WeakPairs) -> NDArray[np.int64]:
    """Return the numbers of the photographs' crops in ``pairs``, each once."""
    return np.unique(pairs.pairs[:, 0])


def row_statistics_distance(made: Tensor, real: Tensor) -> Tensor:
    """Return the distance of generated from real pictures in the statistics of their rows.

    The mean absolute difference of the means of rows, plus that of their standard deviations over time. Replaces LPIPS
    where its weights are missing; blind to the time of an event, as weak pairs demand.
    Pictures have shape (item, 1, row, column), -1 to 1.
    """
    mean = (made.mean(3) - real.mean(3)).abs().mean()
    spread = (made.std(3) - real.std(3)).abs().mean()
    return mean + spread
