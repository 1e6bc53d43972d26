"""Amplitude spectra of sensor and display signals, and the scores that go with them: what networks are trained on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.features import Spectrum
from tactogram.model import Example, ItemRatings
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.signal import Signal

WINDOW_S = 1.0
"""Length of a window, and so of the generated loop: bins are 1 Hz apart. Sec. III-B."""


@dataclass(frozen=True, eq=False)
class SideSpectra:
    """The spectra of one side and the scores of the items that they are of.

    Parameters
    ----------
    spectra : float32 array, shape (spectrum, bin)
        Amplitudes.
    item : int array, shape (spectrum,)
        Which of ``items`` each is of.
    place : int array, shape (spectrum, 3)
        Which recording, axis and window it is.
    items, recordings : tuple of str
    scores : list of float32 arrays, shape (rater, word)
        Of each item, 0 to 1.
    means : float64 array, shape (item, word)
    filled : float
        Share of the scores that raters did not give, and that are the item's mean.
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
        """How many raters' scores each spectrum may be drawn with, shape (spectrum,)."""
        counts: NDArray[np.int64] = np.array([len(given) for given in self.scores])[self.item]
        return counts

    @property
    def table(self) -> NDArray[np.float32]:
        """Scores, (item, rater, word), as long as the longest; what lies beyond an item's raters is not theirs."""
        most = max(len(given) for given in self.scores)
        return np.stack([np.resize(given, (most, given.shape[1])) for given in self.scores])


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
    """Return the spectra of display signals; their level is kept."""
    names = sorted({str(example.item) for example in examples})
    return _side(examples, [e.item for e in examples], names, lambda s: display_spectra(s, config))


def sensor_spectra(signal: Signal, config: Config) -> NDArray[np.float32]:
    """Return the amplitude spectra of the windows of the stable part, each axis standardised. Sec. III-B.

    Parameters
    ----------
    signal : Signal
        Over time, at least a window long. The middle ``stable_s`` of it are taken, or all of it if it is shorter.
    config : Config

    Returns
    -------
    float32 array, shape (axis, window, bin)
        Of the standardised signal: a sinusoid alone reads sqrt(2).

    Raises
    ------
    ParameterError
        If the signal is too short, too slow, or constant.
    """
    spectrum = _spectrum(signal, config)
    length = min(len(signal), round(config.stable_s * signal.rate))
    start = (len(signal) - length) // 2
    x = signal.samples[:, start : start + length].astype(np.float64)
    x -= x.mean(axis=1, keepdims=True)
    spread = x.std(axis=1, keepdims=True)
    if not (spread > 0).all():
        name = signal.axes[int(np.argmin(spread[:, 0]))]
        raise ParameterError(f"axis {name} must vary to be standardised, got a constant")
    hop = max(1, round(config.hop_s * signal.rate))
    windows = np.lib.stride_tricks.sliding_window_view(x / spread, spectrum.length, axis=1)[:, ::hop]
    found: NDArray[np.float32] = spectrum.encode(torch.tensor(windows)).numpy().astype(np.float32)
    return found


def display_spectra(signal: Signal, config: Config) -> NDArray[np.float32]:
    """Return the amplitude spectrum of the first window of each axis, shape (axis, 1, bin), in the signal's unit."""
    spectrum = _spectrum(signal, config)
    x = torch.tensor(signal.samples[:, : spectrum.length], dtype=torch.float64)
    found: NDArray[np.float32] = spectrum.encode(x)[:, None].numpy().astype(np.float32)
    return found


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
    found: list[NDArray[np.float32]] = []
    item: list[int] = []
    place: list[tuple[int, int, int]] = []
    rated: list[ItemRatings | None] = [None] * len(items)
    for recording, (example, name) in enumerate(zip(examples, names, strict=True)):
        if name not in number:
            raise ParameterError(f"recording {example.id}: surface must be one trained on, got {name!r}")
        try:
            made = spectra_of(example.signal)
        except ParameterError as error:
            raise ParameterError(f"recording {example.id} ({name}): {error}") from error
        axes, windows, _ = made.shape
        found.append(made.reshape(axes * windows, -1))
        item += [number[name]] * (axes * windows)
        place += [(recording, axis, window) for axis in range(axes) for window in range(windows)]
        rated[number[name]] = example.rated
    scores, gaps, means = [], 0, []
    for name, one in zip(items, rated, strict=True):
        if one is None or np.isnan(one.means).any():
            word = "" if one is None else f" for {one.words[int(np.argmax(np.isnan(one.means)))]!r}"
            raise ParameterError(f"{name}: must be recorded and rated in every word, got no score{word}")
        given, lacking = filled(one)
        scores.append(given)
        means.append(one.means)
        gaps += lacking
    return SideSpectra(
        np.concatenate(found),
        np.array(item),
        np.array(place),
        tuple(items),
        tuple(example.id for example in examples),
        tuple(scores),
        np.array(means),
        gaps / sum(given.size for given in scores),
    )


def _spectrum(signal: Signal, config: Config) -> Spectrum:
    """Return the convention of a one-second window, amplitudes as they are."""
    if signal.domain != "time" or not float(signal.rate).is_integer() or signal.rate <= 2 * config.bins:
        raise ParameterError(
            f"signal must be over time, at a whole number of Hz above {2 * config.bins}; "
            f"got {signal.rate:g} over {signal.domain}"
        )
    length = round(WINDOW_S * signal.rate)
    if len(signal) < length:
        raise ParameterError(f"signal must last {WINDOW_S:g} s or longer, got {signal.seconds:g} s")
    # Linear, and no amplitude of a float32 signal reaches the end of the range.
    return Spectrum(
        rate=signal.rate, unit=signal.unit, scaling="linear", ref=1e6, low=0.0, high=1e6,
        length=length, first=1, bins=config.bins,
    )  # fmt: skip
