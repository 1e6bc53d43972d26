"""Placement of a mix's steps between its ends, by texture features: position, distance, order against chance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import detrend, hilbert, periodogram, welch
from scipy.stats import t as student

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.measure import check_alike, segments
from tactogram.evaluation.measures.spectra import band_sums, felt_edges
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass
from tactogram.text_files import finite_json

Array = NDArray[np.float64]

SIGNIFICANCE = 0.05
DRAWS = 999
ROUNDING = 1e-9
"""Differences of position below this are rounding errors."""
FIGURES = (
    "resolution",
    "monotone_p",
    "tau",
    "tau_low",
    "tau_high",
    "half_weight",
    "half_low",
    "half_high",
)
OVERALL = "overall"
"""Name of the column for all axes together."""
SEGMENT_S = 0.5
"""Length of the segments of a spectrum, s: bins of 2 Hz, about one in the narrowest band."""
CARRIERS_HZ = ((20.0, 100.0), (100.0, 1000.0))
"""Bands whose envelopes are computed: roughly those of the rapidly adapting and the Pacinian channel."""
MODULATIONS_HZ = (2.0, 4.0, 8.0, 16.0, 32.0)
"""Octave bands of the envelopes."""
POWER_FLOOR, DEPTH_FLOOR = 1e-14, 1e-5
"""Added to powers (unit²) and to modulation (a share of the mean, squared), so that silence has a level."""


class IndistinctEndsError(ParameterError):
    """The ends of a ladder cannot be distinguished, so no position between them is defined."""


@dataclass(frozen=True, eq=False)
class MixingLadder:
    """Positions of a ladder of mixes from its start (0) to its end (1). NaN where the ends do not differ.

    A column is an axis; in the last one, `OVERALL`, each axis counts by its share of the squared distance between
    the ends. Arrays have shape (column,) unless stated.
    """

    columns: tuple[str, ...]
    weights: Array
    """Weight of the end's material, rising, shape (step,)."""
    position: Array
    """Position of the step's mean along the line between the ends' means, shape (step, column)."""
    error: Array
    """Standard error of ``position``, that of the ends included, shape (step, column)."""
    off_line: Array
    """Distance of the step's mean from that line over the ends' distance, less what chance explains, shape (step,
    column): 0 is between the ends, 1 as far from the line as the ends are apart ("neither")."""
    spread: Array
    """Standard deviation of the positions of a step's signals, shape (step, column)."""
    end_spread: Array
    """The same for the signals of the start and the end, shape (2, column)."""
    distance_db: Array
    """Distance between the ends' means, root mean square over features, dB, less what chance explains."""
    resolution: Array
    """Largest difference between two steps that chance explains (95 %)."""
    monotone_p: Array
    """Probability of drops as large as the observed ones by chance; see `positions`."""
    tau: Array
    """Kendall's rank correlation of weight and position, with its 95 % interval."""
    tau_low: Array
    tau_high: Array
    half_weight: Array
    """Weight at which the position crosses one half, with its 95 % interval; infinite if it never does."""
    half_low: Array
    half_high: Array
    largest_rise: Array
    """Largest rise from one step to the next."""
    largest_drop: Array
    """Deepest fall below an earlier step."""

    @property
    def monotone(self) -> NDArray[np.bool_]:
        """Whether the ladder rises (``tau_low`` > 0) without a drop beyond chance, bool, shape (column,)."""
        return (self.tau_low > 0) & (self.monotone_p >= SIGNIFICANCE)

    def as_dict(self) -> dict[str, Any]:
        """Return the values as JSON types, each by column; None stands for NaN and infinity."""
        result: dict[str, Any] = {"weights": self.weights.tolist(), "columns": list(self.columns)}
        for field in fields(self):
            if field.name not in result:
                result[field.name] = self._by_column(getattr(self, field.name))
        monotone = self._by_column(self.monotone)
        result["monotone"] = {n: None if result["tau"][n] is None else monotone[n] for n in self.columns}
        return result

    def _by_column(self, values: NDArray[Any]) -> dict[str, Any]:
        return {name: finite_json(values[..., column].tolist()) for column, name in enumerate(self.columns)}


@dataclass(frozen=True, eq=False)
class _AxisResult:
    """Positions in one axis or all, before the tests against chance."""

    position: Array
    signals: tuple[Array, ...]
    """Positions of each step's signals."""
    off_line: Array
    error: Array
    end_spread: Array
    end_error: Array
    distance_db: float

    @classmethod
    def undefined(cls, steps: Sequence[Array]) -> _AxisResult:
        """Return a column of NaN, in which the ends do not differ."""
        nothing = np.full(len(steps), np.nan)
        each = tuple(np.full(len(step), np.nan) for step in steps)
        pair = np.full(2, np.nan)
        return cls(nothing, each, nothing, nothing, pair, pair, np.nan)


def positions(
    steps: Sequence[Sequence[Signal]],
    start: Sequence[Signal],
    end: Sequence[Signal],
    *,
    weights: ArrayLike | None = None,
    level: bool = True,
    seed: int = 0,
) -> MixingLadder:
    """Place each step of a mix on the line between the means of its two ends.

    Every signal is a point, its `texture_features` in dB; with s and e the ends' means and m a step's, the
    position is (m - s)·(e - s) / |e - s|². Both products are corrected for the bias from the noise of s and e.
    Positions are in dB: two materials 20 dB apart, mixed to equal parts of their powers, give a result 3 dB below
    the louder one, at position 0.85.

    Whether the ladder is monotone is tested against chance. The residual of the least increasing curve through the
    positions (isotonic regression) is compared with that of steps that all lie at the same place and differ by
    chance alone, the hardest case to distinguish (Robertson, Wright and Dykstra 1988, Sec. 2.3, with the variance
    pooled over steps). Whether it moves at all is Kendall's (1938) tau with an interval from draws of the positions
    within their errors.

    Raises `IndistinctEndsError` if the squared distance of the ends is less than twice its expectation for equal ends;
    `ParameterError` if there are too few signals or they differ in kind, or weights do not rise.

    Parameters
    ----------
    steps : sequence of sequences of Signal
        From start to end: at least 2 steps of at least 2 signals each.
    start, end : sequence of Signal
        At least 2 signals each, drawn independently of the steps.
    weights : array-like, shape (step,), optional
        Weight of the end's material, rising; by default evenly from 0 to 1.
    level : bool
        Whether the level counts; without it, only the shape of the spectrum and the modulation do.
    """
    w = np.linspace(0, 1, len(steps)) if weights is None else np.asarray(weights, np.float64)
    if w.shape != (len(steps),) or len(w) < 2 or not (np.isfinite(w).all() and (np.diff(w) > 0).all()):
        raise ParameterError.must("weights", f"be {max(2, len(steps))} rising numbers", w.tolist())
    groups = (start, end, *steps)
    if min(map(len, groups)) < 2:
        raise ParameterError("each end and each step must have at least 2 signals: one has no spread")
    features = texture_features([signal for group in groups for signal in group], level=level)
    first, last, *rungs = np.split(features, np.cumsum([len(group) for group in groups])[:-1])
    axes = groups[0][0].axes
    columns = [_column(*(part[:, axis] for part in (first, last, *rungs))) for axis in range(len(axes))]
    columns.append(_column(*(part.reshape(len(part), -1) for part in (first, last, *rungs)), needed=True))
    orders = [
        order_of(c.position, c.signals, w, end_error=c.end_error, rng=np.random.default_rng([seed, column]))
        for column, c in enumerate(columns)
    ]
    return MixingLadder(
        columns=(*axes, OVERALL),
        weights=w,
        position=np.stack([c.position for c in columns], axis=1),
        error=np.stack([c.error for c in columns], axis=1),
        off_line=np.stack([c.off_line for c in columns], axis=1),
        spread=np.array([[part.std(ddof=1) for part in c.signals] for c in columns]).T,
        end_spread=np.stack([c.end_spread for c in columns], axis=1),
        distance_db=np.array([c.distance_db for c in columns]),
        largest_rise=np.array([np.diff(c.position).max() for c in columns]),
        largest_drop=np.array([(np.maximum.accumulate(c.position) - c.position).max() for c in columns]),
        **{name: np.array([order[name] for order in orders]) for name in orders[0]},
    )


def _column(start: Array, end: Array, *steps: Array, needed: bool = False) -> _AxisResult:
    """Return positions along the line from ``start`` to ``end``; all have shape (signal, feature)."""
    s, e = start.mean(axis=0), end.mean(axis=0)
    way = e - s
    noise_s, noise_e = _noise(start), _noise(end)
    if not way @ way > 2 * (noise_s + noise_e):
        if needed:
            apart, chance = np.sqrt([way @ way / way.size, (noise_s + noise_e) / way.size])
            raise IndistinctEndsError(
                f"the two ends must differ, got {apart:.2g} dB between them and {chance:.2g} dB by chance: "
                "take two other materials, or more signals"
            )
        return _AxisResult.undefined(steps)
    squared = way @ way - noise_s - noise_e
    along = way / np.sqrt(way @ way)
    unit = way / squared
    across_s, across_e = (_noise(part - np.outer(part @ along, along)) for part in (start, end))
    position, signals, off, error = [], [], [], []
    for step in steps:
        each = ((step - s) @ way - noise_s) / squared
        t = each.mean()
        rest = (step - s) - np.outer((step - s) @ along, along)
        r = rest.mean(axis=0)
        chance = _noise(rest) + (1 - t) ** 2 * across_s + t**2 * across_e
        off.append(np.sqrt(max(0.0, r @ r - chance) / squared))
        # Derivatives of t by the ends' means s and e.
        by_start, by_end = (1 - t) * unit + r / squared, t * unit - r / squared
        variance = _noise(each) + _noise(start @ by_start) + _noise(end @ by_end)
        error.append(np.sqrt(variance))
        position.append(t)
        signals.append(each)
    spreads = np.array([(part @ unit).std(ddof=1) for part in (start, end)])
    return _AxisResult(
        np.array(position),
        tuple(signals),
        np.array(off),
        np.array(error),
        spreads,
        spreads / np.sqrt([len(start), len(end)]),
        float(np.sqrt(squared / way.size)),
    )


def _noise(part: Array) -> float:
    """Return the expected squared error of the mean of ``part``, shape (signal,) or (signal, feature)."""
    return float(part.var(axis=0, ddof=1).sum() / len(part))


def order_of(
    position: Array,
    members: Sequence[Array],
    weights: Array,
    *,
    end_error: Array,
    rng: np.random.Generator,
) -> dict[str, float]:
    """Return the test of whether ``position`` rises with ``weights``, shape (step,), and the weight at one half.

    The result holds `FIGURES`, as in `MixingLadder`; NaN where ``position`` is.

    Parameters
    ----------
    position : float64 array, shape (step,)
        Mean of each step's ``members``; NaN where it is undefined.
    members : sequence of float64 arrays, shape (signal,)
        Positions of the step's signals; their variance is pooled over steps.
    end_error : float64 array, shape (2,)
        Standard errors of the ends at 0 and 1, which move all steps together.
    """
    if np.isnan(position).any():
        return dict.fromkeys(FIGURES, np.nan)
    counts = np.array([len(part) for part in members])
    freedom = int((counts - 1).sum())
    pooled = sum(float(part.var(ddof=1)) * (len(part) - 1) for part in members) / freedom
    seen = float(_drops(position[None], counts)[0])
    if pooled > ROUNDING**2:
        same = rng.standard_normal((DRAWS, len(counts))) / np.sqrt(counts)
        scale = rng.chisquare(freedom, DRAWS) / freedom
        drops = _drops(same, counts) / scale
        p = float((1 + np.count_nonzero(drops >= seen / pooled - ROUNDING)) / (1 + DRAWS))
    else:
        p = 1.0 if seen <= ROUNDING**2 else 0.0
    own = np.sqrt(pooled / counts) * rng.standard_t(freedom, (DRAWS, len(counts)))
    tau = _tau(position + own)
    # The noise of the ends moves all steps together: it changes where they lie, not their order.
    ends = rng.standard_normal((DRAWS, 2)) * end_error
    moved = position + own - ends[:, :1] * (1 - position) - ends[:, 1:] * position
    halves = _halves(weights, moved, counts)
    tails = (SIGNIFICANCE / 2, 1 - SIGNIFICANCE / 2)
    tau_low, tau_high = np.quantile(tau, tails)
    half_low, half_high = np.quantile(halves, tails, method="inverted_cdf")
    reach = student.ppf(tails[1], freedom) * np.sqrt(2 * pooled / counts.mean())
    half = _halves(weights, position[None], counts)[0]
    figures = (reach, p, _tau(position[None])[0], tau_low, tau_high, half, half_low, half_high)
    return {name: float(value) for name, value in zip(FIGURES, figures, strict=True)}


def _drops(position: Array, counts: NDArray[np.int_]) -> Array:
    """Return the squared residual of each row from its increasing curve, weighted by counts, float64, shape (row,)."""
    residuals: Array = (position - _increasing(position, counts)) ** 2 @ counts
    return residuals


def _halves(weights: Array, position: Array, counts: NDArray[np.int_]) -> Array:
    """Return the weight at which each row's increasing curve crosses one half; infinite where it stays below."""
    fit = _increasing(position, counts)
    below = (fit < 0.5).sum(axis=1)  # steps before the crossing
    last = np.clip(below, 1, len(counts) - 1)
    low, high = np.take_along_axis(fit, np.stack([last - 1, last], axis=1), axis=1).T
    before, after = weights[last - 1], weights[last]
    inside = (below > 0) & (below < len(counts))
    share = np.divide(0.5 - low, high - low, out=np.zeros_like(low), where=inside)
    return np.where(below < len(counts), before + share * (after - before), np.inf)


def _increasing(position: Array, counts: NDArray[np.int_]) -> Array:
    """Return the least-squares increasing curve of each row, weighted by counts, float64, shape (row, step).

    At a step it is the largest, over blocks' first steps, of the smallest mean of a block that contains the step
    (Robertson, Wright and Dykstra 1988, Theorem 1.4.4).
    """
    sums = np.cumsum(np.insert(position * counts, 0, 0, axis=1), axis=1)
    totals = np.cumsum(np.insert(counts, 0, 0))
    fit = np.full(position.shape, -np.inf)
    for first in range(len(counts)):
        means = (sums[:, first + 1 :] - sums[:, first, None]) / (totals[first + 1 :] - totals[first])
        smallest = np.minimum.accumulate(means[:, ::-1], axis=1)[:, ::-1]  # of blocks that end there or later
        fit[:, first:] = np.maximum(fit[:, first:], smallest)
    return fit


def _tau(position: Array) -> Array:
    """Return Kendall's tau of each row with the order of its columns, float64, shape (row,)."""
    one, other = np.triu_indices(position.shape[1], k=1)
    tau: Array = np.sign(position[:, other] - position[:, one]).mean(axis=1)
    return tau


def texture_features(signals: Sequence[Signal], *, level: bool = True) -> NDArray[np.float64]:
    """Return features of each signal's texture that do not depend on phase, in dB.

    Per axis: the level in each third-octave band that is felt (Welch 1967); then the depth of modulation of the
    envelope of each of `CARRIERS_HZ` in each of `MODULATIONS_HZ`, 10 log10 of the envelope's variance in that
    band over its squared mean. The logarithm of a noisy power has a bias that depends on the amount of data:
    signals are therefore cut to pieces as long as the shortest of them, and features are means over pieces.

    Without ``level``, the levels of an axis are relative to its power in all bands. Raises `ParameterError` if signals
    differ in rate, unit or axes, are not over time, or one is shorter than `SEGMENT_S`.

    Returns
    -------
    float64 array, shape (signal, axis, feature), dB
    """
    seconds = min((signal.seconds for signal in signals), default=0.0)
    check_alike(signals, shortest_s=max(SEGMENT_S, seconds))
    if signals and signals[0].rate * SEGMENT_S < 8:
        raise ParameterError.must("rate", f"be at least {8 / SEGMENT_S:g} Hz", signals[0].rate)
    return np.array([np.mean([_features(p, level) for p in segments([s], seconds)], axis=0) for s in signals])


def _features(signal: Signal, level: bool) -> NDArray[np.float64]:
    depths = [_depths(signal, *carrier) for carrier in _carriers(signal.rate)]
    return np.concatenate([_levels(signal, level), *depths], axis=1)


def _levels(signal: Signal, level: bool) -> NDArray[np.float64]:
    """Return the level in each band, dB re 1 unit², float64, shape (axis, band)."""
    f, density = welch(signal.samples.astype(np.float64), signal.rate, nperseg=round(SEGMENT_S * signal.rate))
    powers = band_sums(density * f[1], f, felt_edges(signal.rate))
    decibels: NDArray[np.float64] = 10 * np.log10(powers + POWER_FLOOR)
    if not level:
        decibels -= 10 * np.log10(powers.sum(axis=1, keepdims=True) + POWER_FLOOR)
    return decibels


def _carriers(rate: float) -> list[tuple[float, float]]:
    """Return the bands of which a signal of ``rate`` Hz contains at least an octave."""
    cut = [(low, min(high, 0.45 * rate)) for low, high in CARRIERS_HZ]
    return [(low, high) for low, high in cut if high >= 2 * low]


def _depths(signal: Signal, low: float, high: float) -> NDArray[np.float64]:
    """Return the depth of modulation of one carrier band in dB, float64, shape (axis, modulation band)."""
    envelope = np.abs(hilbert(bandpass(signal, low, high).samples.astype(np.float64), axis=1))
    relative = envelope / (envelope.mean(axis=1, keepdims=True) + np.sqrt(POWER_FLOOR))
    f, density = periodogram(detrend(relative, type="constant"), signal.rate, "hann")
    known = [c for c in MODULATIONS_HZ if c / np.sqrt(2) >= 1.5 / signal.seconds]
    edges = np.array([c / np.sqrt(2) for c in (*known, 2 * known[-1])]) if known else np.empty(0)
    depth = band_sums(density * f[1], f, edges) if known else np.empty((len(envelope), 0))
    return np.asarray(10 * np.log10(depth + DEPTH_FLOOR))
