"""Tactile signal and photograph: samples with rate, unit, axes and domain; pixels with scale."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from tactogram.errors import ParameterError, one_line, shown

UNITS = ("m/s^2", "m/s", "m", "N", "V", "rad/s", "rad", "Pa", "T", "1")
"""Units of a sample. ``"1"`` is a ratio: a friction coefficient, sensor counts, or full scale in -1..1."""

RATES = (1e-6, 1e9)
"""Lowest and highest rate, beyond which sample counts overflow."""
MOST_AXES = 16
"""More rows than this, of one or three columns, are samples in time, not axes without names."""
Domain = Literal["time", "displacement"]


def check_rate(rate: float, name: str = "rate") -> float:
    """Return ``rate`` as a float; `ParameterError` if it is not within `RATES`."""
    try:
        rate = float(rate)
    except (TypeError, ValueError):
        raise ParameterError.must(name, "be a number", rate) from None
    if not (rate > 0 and np.isfinite(rate)):
        raise ParameterError(f"{name} must be > 0 and finite, got {rate:g}")
    if not RATES[0] <= rate <= RATES[1]:
        raise ParameterError(f"{name} must be {RATES[0]:g} to {RATES[1]:g}, got {rate:g}")
    return rate


@dataclass(frozen=True, eq=False, repr=False)
class Signal:
    """A tactile signal, frozen: operations are functions that return new ones.

    Parameters
    ----------
    samples : float32 array, shape (axis, time)
        In ``unit``. Copied unless already a read-only float32 array; read-only afterwards: ``np.array(signal)`` is a
        copy to write to, or for ``torch.from_numpy``. A 1-D array is one axis; shape (time, axis) is turned where only
        that fits the axes. At least one sample; all finite.
    rate : float
        Samples per second (Hz), or per millimetre if ``domain`` is ``"displacement"``. Within `RATES`.
    unit : str
        One of `UNITS`.
    axes : tuple of str, optional
        One name per axis. By default ``("z",)`` for one axis and ``("x", "y", "z")`` for three.
    domain : {"time", "displacement"}
        Domain of the last dimension of ``samples``.

    Raises
    ------
    ParameterError
        If any of the above does not hold.

    Examples
    --------
    >>> tactogram.Signal([0, 0.5, -0.5, 0], 1000, "m/s^2")
    <Signal: z in m/s^2, 0.004 s at 1000 Hz>
    """

    samples: NDArray[np.float32]
    rate: float
    unit: str
    axes: tuple[str, ...] = ()
    domain: Domain = "time"

    def __post_init__(self) -> None:
        samples = _frozen(self.samples)
        axes = tuple(self.axes)
        fitting, most = ((len(axes),), 1) if axes else ((1, 3), MOST_AXES)
        if len(samples) not in fitting and samples.shape[1] in fitting and len(samples) > most:
            samples = _frozen(samples.T)
        axes = axes or {1: ("z",), 3: ("x", "y", "z")}.get(len(samples), ())
        if len(axes) != len(samples) or len(set(axes)) != len(axes):
            raise ParameterError.must("axes", f"be {len(samples)} different names", axes)
        rate = check_rate(self.rate)
        if self.unit not in UNITS:
            raise ParameterError.one_of("unit", UNITS, self.unit)
        if self.domain not in ("time", "displacement"):
            raise ParameterError.must("domain", "be 'time' or 'displacement'", self.domain)
        object.__setattr__(self, "samples", samples)
        object.__setattr__(self, "axes", axes)
        object.__setattr__(self, "rate", rate)

    def __len__(self) -> int:
        return int(self.samples.shape[1])

    def __repr__(self) -> str:
        extent, per = ("s", " Hz") if self.domain == "time" else ("mm", " per mm")
        axes = ", ".join(self.axes)
        return f"<Signal: {axes} in {self.unit}, {self.extent:g} {extent} at {self.rate:g}{per}>"

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Return the samples, as ``np.asarray(signal)`` does."""
        return np.array(self.samples, dtype, copy=copy)

    def _repr_html_(self) -> str:
        from tactogram.signal.figure import signal_html

        return signal_html(self)

    def plot(self, *, title: str = "", shown: float = 2.0) -> NDArray[Any]:
        """Draw waveform and spectrogram of each axis in a new figure of pyplot.

        Parameters
        ----------
        title : str
        shown : float, s or mm
            Length of the waveform that is drawn.

        Returns
        -------
        object array of matplotlib.axes.Axes, shape (axis, 2)
        """
        import matplotlib.pyplot as plt

        from tactogram.signal.figure import signal_figure

        figure = signal_figure(self, title=title, shown=shown, figure=plt.figure(layout="constrained"))
        return np.array(figure.axes[: 2 * len(self.axes)], object).reshape(-1, 2)

    @property
    def seconds(self) -> float:
        """Duration in s; a `ParameterError` for a signal over displacement."""
        if self.domain != "time":
            raise ParameterError("a signal over displacement has no duration; use length_mm")
        return len(self) / self.rate

    @property
    def sha256(self) -> str:
        """Hash of the samples (little-endian float32, axis by axis), rate and unit."""
        digest = hashlib.sha256(f"{self.rate!r} {self.unit}\n".encode())
        digest.update(np.ascontiguousarray(self.samples, dtype="<f4").tobytes())
        return digest.hexdigest()

    @property
    def extent(self) -> float:
        """Length over its domain: s over time, mm over displacement."""
        return len(self) / self.rate

    @property
    def length_mm(self) -> float:
        """Path length in mm; a `ParameterError` for a signal over time."""
        if self.domain != "displacement":
            raise ParameterError("a signal over time has no path length; use seconds")
        return len(self) / self.rate

    def axis(self, name: str) -> NDArray[np.float32]:
        """Return the samples of one axis, float32, shape (time,); `ParameterError` if there is none of this name."""
        if name not in self.axes:
            raise ParameterError.one_of("axis", self.axes, name)
        samples: NDArray[np.float32] = self.samples[self.axes.index(name)]
        return samples

    def select(self, *names: str) -> Signal:
        """Return the named axes only, in this order."""
        return replace(self, samples=np.stack([self.axis(name) for name in names]), axes=names)

    def cut(self, start: int, stop: int | None = None) -> Signal:
        """Return samples ``start`` to ``stop`` (exclusive, as in a slice)."""
        return replace(self, samples=self.samples[:, start:stop])

    def with_samples(self, samples: ArrayLike, **changes: Any) -> Signal:
        """Return this with other samples, shape (axis, time), in its unit, and ``changes``; errors as `Signal`."""
        return replace(self, samples=np.asarray(samples), **changes)


def signal_of(value: object, name: str = "signal") -> Signal:
    """Return a `Signal`; `ParameterError` for anything else, such as an array, whose rate and unit are not known."""
    if isinstance(value, Signal):
        return value
    got = shown(value) if isinstance(value, str | Path) else type(value).__name__
    how = f"read it, `read_signal({got})`"
    if not isinstance(value, str | Path):
        how = "make one, `Signal(samples, rate, unit)`"
    raise ParameterError(
        f"must be a Signal, which states its rate and unit, got {got}",
        parameter=name,
        value=value,
        expected="be a Signal",
        remedy=how,
    )


def _frozen(samples: ArrayLike) -> NDArray[np.float32]:
    """Return ``samples`` as a read-only float32 array (axis, time)."""
    try:
        array = np.asarray(samples)
    except ValueError as error:
        raise ParameterError.must("samples", f"be an array (axis, time): {one_line(error)}") from None
    if array.ndim not in (1, 2) or array.size == 0:
        raise ParameterError.must("samples", f"be (axis, time), not empty, got shape {array.shape}")
    if array.dtype.kind not in "fiub":
        raise ParameterError.must("samples", f"be real numbers, got dtype {array.dtype}")
    array = np.atleast_2d(array)
    if array.dtype != np.float32 or array.flags.writeable:
        with np.errstate(over="ignore"):
            array = np.array(array, dtype=np.float32)
    if not np.isfinite(array).all():
        axis, sample = np.argwhere(~np.isfinite(array))[0]
        raise ParameterError.must(
            "samples", f"be finite, got {array[axis, sample]} at axis {axis}, sample {sample}"
        )
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class Image:
    """A photograph of a surface, or a generated one.

    Parameters
    ----------
    pixels : uint8 array, shape (row, column, 3)
        sRGB. Copied; read-only afterwards.
    mm_per_pixel : float, optional
        Scale of the surface in the picture; None if unknown.
    """

    pixels: NDArray[np.uint8]
    mm_per_pixel: float | None = None

    def __post_init__(self) -> None:
        pixels = np.asarray(self.pixels)
        if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.size == 0:
            raise ParameterError.must(
                "pixels", f"be uint8 (row, column, 3), got {pixels.dtype} of shape {pixels.shape}"
            )
        if self.mm_per_pixel is not None and not 0 < self.mm_per_pixel < np.inf:
            raise ParameterError.must("mm_per_pixel", "be > 0", self.mm_per_pixel)
        pixels = np.array(pixels)
        pixels.flags.writeable = False
        object.__setattr__(self, "pixels", pixels)

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.pixels.shape[0], self.pixels.shape[1]

    def cut(self, top: int = 0, left: int = 0, bottom: int | None = None, right: int | None = None) -> Image:
        """Return rows ``top`` to ``bottom`` and columns ``left`` to ``right`` (exclusive), at the same scale."""
        return replace(self, pixels=self.pixels[top:bottom, left:right])
