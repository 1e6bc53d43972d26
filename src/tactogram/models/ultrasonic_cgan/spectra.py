"""Training data: amplitude spectra of sensor and display signals, and the scores of their items."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.fft import rfft
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Example, ItemRatings
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.signal import Signal

FLOOR, SILENCE = 1e-3, 1e-9
"""Powers added to bands and to bins, relative to the mean display signal's whole."""
WINDOW_S = 1.0
"""Length of a window, and so of the generated loop: bins are 1 Hz apart. Sec. III-B."""


@dataclass(frozen=True, eq=False)
class SideSpectra:
    """Spectra of one side, sensor or display, and the scores of their items.

    Parameters
    ----------
    spectra : float32 array, shape (spectrum, bin)
        Amplitudes.
    item : int array, shape (spectrum,)
        Place in ``items``.
    place : int array, shape (spectrum, 3)
        Recording, axis and window.
    items, recordings : tuple of str
    scores : list of float32 arrays, shape (rater, word)
        Of each item, 0 to 1.
    means : float64 array, shape (item, word)
    filled : float
        Share of missing scores, which are replaced by the item's mean.
    """

    spectra: NDArray[np.float32]
    item: NDArray[np.int64]
    place: NDArray[np.int64]
    items: tuple[str, ...]
    recordings: tuple[str, ...]
    scores: tuple[NDArray[np.float32], ...]
    means: NDArray[np.float64]
    filled: float

    @property
    def raters(self) -> NDArray[np.int64]:
        """Number of raters of each spectrum's item, shape (spectrum,)."""
        counts: NDArray[np.int64] = np.array([len(scores) for scores in self.scores])[self.item]
        return counts

    @property
    def table(self) -> NDArray[np.float32]:
        """Scores, (item, rater, word), repeated up to the most raters of an item."""
        most = max(len(scores) for scores in self.scores)
        return np.stack([np.resize(scores, (most, scores.shape[1])) for scores in self.scores])


def surfaces_of(examples: Sequence[Example]) -> list[Example]:
    """Return the recordings of rated surfaces: those with a material."""
    return [example for example in examples if example.material is not None]


def signals_of(examples: Sequence[Example]) -> list[Example]:
    """Return the rated display signals: those without a material."""
    return [example for example in examples if example.material is None]


def sensor_side(examples: Sequence[Example], config: Config, plates: Sequence[str]) -> SideSpectra:
    """Return the spectra of all windows of all axes of recordings of surfaces, in the order of ``plates``."""
    return _side(examples, [e.material for e in examples], plates, lambda s: sensor_spectra(s, config))


def display_side(examples: Sequence[Example], config: Config) -> SideSpectra:
    """Return the spectra of display signals at their levels."""
    names = sorted({str(example.item) for example in examples})
    return _side(examples, [e.item for e in examples], names, lambda s: display_spectra(s, config))


def sensor_spectra(signal: Signal, config: Config) -> NDArray[np.float32]:
    """Return the amplitude spectra of the windows of the stable part, each axis standardised. Sec. III-B.

    ``signal``: over time, at least a window long. Its middle ``stable_s`` are used, or all of a shorter signal.

    Raises `ParameterError` if the signal is too short, too slow, or constant.

    Returns
    -------
    float32 array, shape (axis, window, bin)
        Of the standardised signal: a sinusoid alone reads sqrt(2).
    """
    window = _window_length(signal, config)
    stable = min(len(signal), round(config.stable_s * signal.rate))
    start = (len(signal) - stable) // 2
    x = signal.samples[:, start : start + stable].astype(np.float64)
    x -= x.mean(axis=1, keepdims=True)
    spread = x.std(axis=1, keepdims=True)
    if not (spread > 0).all():
        name = signal.axes[int(np.argmin(spread[:, 0]))]
        raise ParameterError(f"axis {name} must vary to be standardised, got a constant")
    hop = max(1, round(config.hop_s * signal.rate))
    return _amplitudes(sliding_window_view(x / spread, window, axis=1)[:, ::hop], config)


def display_spectra(signal: Signal, config: Config) -> NDArray[np.float32]:
    """Return the amplitude spectrum of the first window of each axis, shape (axis, 1, bin), in the signal's unit."""
    x = signal.samples[:, : _window_length(signal, config)].astype(np.float64)
    return _amplitudes(x, config)[:, None]


def felt_features(spectra: Tensor) -> Tensor:
    """Return what is felt of scaled spectra, (item, bin) -> (item, feature), dB, differentiable.

    Levels of octave bands from the first bin on and of the whole, and the number of lines: the exponential of the
    entropy of the power over the bins. Amplitudes below 0 count as 0, as in use.
    """
    power = spectra.clamp_min(0).square() / spectra.shape[1]  # I, bin
    octaves = [2**k - 1 for k in range(1, spectra.shape[1].bit_length())]  # first bins of all bands but one
    levels = [band.sum(1) + FLOOR for band in (*power.tensor_split(octaves, 1), power)]  # I each
    share = (power + SILENCE) / (power + SILENCE).sum(1, keepdim=True)
    lines = (-share * share.log()).sum(1).exp()  # I
    return 10 * torch.log10(torch.stack((*levels, lines), 1))


def filled(rated: ItemRatings) -> tuple[NDArray[np.float32], int]:
    """Return the scores of each rater, (rater, word), gaps filled with the item's mean; and how many gaps."""
    gaps = np.isnan(rated.scores)
    return np.where(gaps, rated.means, rated.scores).astype(np.float32), int(gaps.sum())


def _side(
    examples: Sequence[Example],
    names: Sequence[str | None],
    items: Sequence[str],
    spectra_of: Callable[[Signal], NDArray[np.float32]],
) -> SideSpectra:
    number: dict[str | None, int] = {name: n for n, name in enumerate(items)}
    spectra: list[NDArray[np.float32]] = []
    item: list[int] = []
    sources: list[tuple[int, int, int]] = []
    rated: list[ItemRatings | None] = [None] * len(items)
    for recording, (example, name) in enumerate(zip(examples, names, strict=True)):
        if name not in number:
            raise ParameterError(f"recording {example.id}: surface must be a training surface, got {name!r}")
        try:
            transformed = spectra_of(example.signal)
        except ParameterError as error:
            raise ParameterError(f"recording {example.id} ({name}): {error}") from error
        axes, windows, _ = transformed.shape
        spectra.append(transformed.reshape(axes * windows, -1))
        item += [number[name]] * (axes * windows)
        sources += [(recording, axis, window) for axis in range(axes) for window in range(windows)]
        rated[number[name]] = example.rated
    scores, gaps, means = [], 0, []
    for name, rating in zip(items, rated, strict=True):
        if rating is None or np.isnan(rating.means).any():
            word = "" if rating is None else f" for {rating.words[int(np.argmax(np.isnan(rating.means)))]!r}"
            raise ParameterError(f"{name}: must be recorded and rated in every word, got no score{word}")
        complete, lacking = filled(rating)
        scores.append(complete)
        means.append(rating.means)
        gaps += lacking
    return SideSpectra(
        np.concatenate(spectra),
        np.array(item),
        np.array(sources),
        tuple(items),
        tuple(example.id for example in examples),
        tuple(scores),
        np.array(means),
        gaps / sum(matrix.size for matrix in scores),
    )


def _amplitudes(x: NDArray[np.float64], config: Config) -> NDArray[np.float32]:
    """Return the amplitudes of sinusoids in windows, (..., time) -> (..., bin), from 1 Hz on."""
    amplitudes = np.abs(rfft(x)[..., 1 : config.bins + 1]) / (x.shape[-1] / 2)
    return np.asarray(amplitudes, np.float32)


def _window_length(signal: Signal, config: Config) -> int:
    if signal.domain != "time" or not float(signal.rate).is_integer() or signal.rate <= 2 * config.bins:
        raise ParameterError.must(
            "signal",
            f"be over time, at a whole number of Hz above {2 * config.bins}; got {signal.rate:g} over {signal.domain}",
        )
    length = round(WINDOW_S * signal.rate)
    if len(signal) < length:
        raise ParameterError.must("signal", f"last {WINDOW_S:g} s or longer, got {signal.seconds:g} s")
    return length
