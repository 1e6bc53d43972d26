"""Properties that all signals, or all images, of a run share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.model.examples import Example
from tactogram.signal import Signal
from tactogram.signal.signal import Domain


@dataclass(frozen=True)
class SignalKind:
    """Properties that all signals of a run share; saved with the weights.

    Parameters
    ----------
    rate : float, Hz
    unit : str
    axes : tuple of str
    materials : tuple of str
        The classes, sorted.
    simulated : bool
        Whether any of the training data was simulated.
    domain : {"time", "displacement"}
        Over displacement ``rate`` is in samples per mm.
    words : tuple of str
        Words of the ratings, for models that learn from ratings.
    scale : tuple of (float, float), optional
        Lowest and highest possible rating.
    """

    rate: float
    unit: str
    axes: tuple[str, ...]
    materials: tuple[str, ...] = ()
    simulated: bool = False
    domain: Domain = "time"
    words: tuple[str, ...] = ()
    scale: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.domain not in ("time", "displacement"):
            raise ParameterError(f"domain must be 'time' or 'displacement', got {self.domain!r}")

    def signal(self, samples: Any) -> Signal:
        """Return samples, shape (axis, time), as a signal of this kind."""
        return Signal(np.asarray(samples), self.rate, self.unit, self.axes, self.domain)

    def check(self, signal: Signal) -> None:
        """Refuse a signal of another rate, unit, set of axes or domain.

        Raises
        ------
        ParameterError
            Naming the expected properties and those of ``signal``.
        """
        got = (signal.rate, signal.unit, signal.axes, signal.domain)
        if got != (self.rate, self.unit, self.axes, self.domain):
            alike = (signal.rate, signal.unit, signal.domain) == (self.rate, self.unit, self.domain)
            renamed = alike and len(signal.axes) == len(self.axes)
            hint = f"; read it with axes {','.join(self.axes)} if these are the same" if renamed else ""
            raise ParameterError(f"signal must be {_properties(self)}; got {_properties(signal)}{hint}")

    def require_materials(self, model: str) -> None:
        """Refuse a kind without materials.

        Raises
        ------
        ParameterError
            Naming ``model``.
        """
        if not self.materials:
            raise ParameterError(f"{model} needs recordings with a material, got none")

    def check_all_present(self, examples: Sequence[Example]) -> None:
        """Refuse training examples without a recording of one of ``materials``.

        Raises
        ------
        ParameterError
            Naming the materials.
        """
        present = {example.material for example in examples}
        if missing := [name for name in self.materials if name not in present]:
            raise ParameterError(f"no training recording of {', '.join(missing)}; leave it out of the data")

    def by_material(self, examples: Sequence[Example]) -> dict[str, list[Example]]:
        """Return the training examples of each of ``materials``.

        Raises
        ------
        ParameterError
            If an example is of another kind or material, or a material has none.
        """
        found: dict[str, list[Example]] = {name: [] for name in self.materials}
        for example in examples:
            if example.material not in found:
                raise ParameterError(
                    f"recording {example.id}: material must be one of {', '.join(self.materials)}, "
                    f"got {example.material!r}"
                )
            self.check(example.signal)
            found[example.material].append(example)
        self.check_all_present(examples)
        return found


@dataclass(frozen=True)
class ImageKind:
    """Properties that all images of a run share; saved with the weights.

    Parameters
    ----------
    words : tuple of str
    scale : tuple of (float, float)
    items : tuple of str
        Items of the training part, sorted.
    simulated : bool
    """

    words: tuple[str, ...]
    scale: tuple[float, float]
    items: tuple[str, ...]
    simulated: bool = False

    @property
    def materials(self) -> tuple[str, ...]:
        """Empty: images have no classes."""
        return ()


Kind = SignalKind | ImageKind


def unit_scores(words: Mapping[str, float], kind: Kind, *, partial: bool = False) -> NDArray[np.float64]:
    """Return scores as 0 to 1 in the order of ``kind.words``, shape (word,): (x - 1) / 6 on the 7-point scale.

    Missing words are NaN if ``partial``.

    Raises
    ------
    ParameterError
        For an unknown or missing word, or a score off the scale.
    """
    low, high = kind.scale or (0.0, 1.0)
    for word, score in words.items():
        if word not in kind.words:
            raise ParameterError(f"words must be of {', '.join(kind.words)}; got {word!r}")
        if not low <= score <= high:
            raise ParameterError(f"{word} must be {low:g} to {high:g}, got {score:g}")
    if not partial and (missing := [word for word in kind.words if word not in words]):
        raise ParameterError(f"a score is needed of {', '.join(missing)}")
    return np.array([(float(words.get(word, np.nan)) - low) / (high - low) for word in kind.words])


def _properties(signal: Signal | SignalKind) -> str:
    per = "Hz" if signal.domain == "time" else "samples per mm"
    return f"{signal.rate:g} {per}, {signal.unit}, axes {','.join(signal.axes)}"
