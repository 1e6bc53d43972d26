"""C header of modulated noise, for a microcontroller: tables of one texture, and the synthesis in blocks of 5 ms.

The synthesis is that of `tactogram.signal.modulated_noise_synthesis` at one speed and force, in single precision. Its
random numbers are those of sfc32, and normal numbers sums of four uniform ones.

References
----------
- Doty-Humphrey, C. (2010). PractRand. Generator sfc32: three additions, two shifts and a rotation per 32 bits.
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import numpy as np
from jinja2 import Environment, StrictUndefined
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.drive.axes import combined
from tactogram.signal.modulated_noise import (
    BANDS,
    FRAME_S,
    LEVELS,
    SCORES,
    SUBFRAMES,
    TAPS,
    ModulatedNoise,
    level_factor,
)
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import (
    SETTLING_S,
    SILENT,
    band_sections,
    synthesise_modulated_noise,
)
from tactogram.signal.tones import START_S, no_tones

BLOCK_S = 0.005
MOST_FRAMES = 10_000
"""Frames after which their places repeat, at most."""
WORD = 4
"""Bytes of a number."""
TURN = 2.0**32
DISCARDED = 12
"""Random numbers between seeding and use."""
SCALE = math.sqrt(3) / 65536
"""Of the sum of four 16-bit numbers, without its mean, to the variance 1."""
MEAN = 2 * 65535
DRAWINGS, DRAWN_S = 8, 2.0
"""Signals to which a model of one axis is fitted, and their length, s."""


def one_axis(model: ModulatedNoise, axis: str) -> ModulatedNoise:
    """Return the model of one axis of ``model``, or of one with the power of all at every frequency (``"dft321"``).

    The gains of several axes are those of sources, which are filtered and mixed; there is no formula for those of one
    axis. So a model is fitted to signals that ``model`` makes, always the same, with the spectrum and deviation that
    follow from its own. ``"all"`` is the model itself. Raises `ParameterError` if there is no such axis.
    """
    if axis not in ("all", "dft321", *model.axes):
        raise ParameterError.must("axis", f"be dft321, all or one of {', '.join(model.axes)}", axis)
    if axis == "all" or len(model.axes) == 1:
        return model
    steady = replace(model, mean=np.zeros(len(model.axes)), tones=no_tones(len(model.axes)))
    signals = [synthesise_modulated_noise(steady, DRAWN_S, seed=seed) for seed in range(DRAWINGS)]
    fitted = fit_modulated_noise([combined(signal, axis)[0] for signal in signals], lags=model.lags)
    chosen = [axis in ("dft321", name) for name in model.axes]
    deviation, spectrum = (
        0.5 * np.log(np.sum(np.exp(2 * values[chosen]), axis=0, keepdims=True))
        for values in (model.deviation, model.spectrum)
    )
    equaliser = fitted.equaliser + spectrum - fitted.spectrum
    tones = model.tones.summed(chosen)
    return replace(fitted, deviation=deviation, spectrum=spectrum, equaliser=equaliser, tones=tones)


@dataclass(frozen=True)
class Operations:
    """Operations of a block. ``functions`` are calls of exp, sqrt, sin and cos."""

    multiplications: int
    divisions: int
    functions: int


@dataclass(frozen=True)
class HeaderCost:
    """Cost of a header: of a usual block, and the most of one in which frames of 10 ms begin."""

    usual: Operations
    dearest: Operations
    table_bytes: int
    state_bytes: int


def noise_header(model: ModulatedNoise, *, name: str, facts: Sequence[str] = ()) -> tuple[str, HeaderCost]:
    """Return the text of a header and its cost.

    ``name``: prefix of every name in it; see `c_name`. ``facts``: lines about the texture, for the comment at the top.

    Raises `ParameterError` if the rate is no fraction that frames fit, or the name no C identifier.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or keyword.iskeyword(name):
        raise ParameterError.must("name", "be a C identifier in lower case", name)
    frame = Fraction(FRAME_S).limit_denominator(1000) * Fraction(model.rate).limit_denominator(1000)
    if frame.denominator > MOST_FRAMES or abs(float(frame) - FRAME_S * model.rate) > 1e-9:
        raise ParameterError.must("rate", f"be a fraction of small numbers, got {model.rate} Hz")
    tables = _tables(model)
    words = sum(table["size"] for table in tables)
    block = max(1, round(BLOCK_S * model.rate))
    cost = _cost(model, block, words)
    tones = model.tones.unsteadiness
    environment = Environment(undefined=StrictUndefined, keep_trailing_newline=True, trim_blocks=True)
    text = environment.from_string(
        files("tactogram.rendering.embedded").joinpath("noise_header.h.jinja").read_text(encoding="utf-8")
    ).render(
        title=f"Texture {name}: modulated noise.",
        facts=facts,
        name=name,
        upper=name.upper(),
        rate=model.rate,
        unit=model.unit,
        axes=model.axes,
        block=block,
        bands=BANDS,
        subframes=SUBFRAMES,
        gains=model.gains,
        lags=model.lags,
        levels=len(LEVELS),
        taps=TAPS,
        lines=len(model.tones.frequency),
        length=FRAME_S * model.rate,
        repeat_frames=frame.denominator,
        repeat_samples=frame.numerator,
        factor=_number(level_factor(model.rate)),
        silent=_number(SILENT),
        settling=round(SETTLING_S * model.rate) + TAPS,
        start=repr(START_S * model.rate * SCALE),
        mean_deviation=_number(tones[0]),
        speed_deviation=_number(tones[1]),
        gain_deviation=_number(tones[3]),
        random_mean=MEAN,
        random_scale=SCALE,
        discarded=DISCARDED,
        tables=tables,
        cost=cost,
        version=version("tactogram"),
    )
    return text, cost


def c_name(text: str) -> str:
    """Return a name in C for a text such as ``"Sandpaper P80"``."""
    name = re.sub(r"\W+", "_", text.lower(), flags=re.ASCII).strip("_")
    return name if re.match(r"[a-z]", name) else f"texture_{name}".rstrip("_")


def _tables(model: ModulatedNoise) -> list[dict[str, Any]]:
    """Return the tables of a header: name, meaning, shape and values in C, and their count."""
    rotations, root = model.lattice
    sections = band_sections(model.rate)
    filters = np.column_stack((sections[:, :3], 2 + sections[:, 4], 1 - sections[:, 5]))
    arrays: list[tuple[str, str, ArrayLike]] = [
        ("rotations", "Rotations S, K and T of the lattice, by lag", rotations),
        ("root", "Root of the covariance of the scores", root),
        ("offset_root", "Root of the covariance of the offsets", model.offset_root),
        ("quantiles", "Logarithms of the gains at the normal scores", model.quantiles),
        ("normal_scores", "Normal scores of the quantiles", SCORES),
        ("coupling", "Roots of the correlation of the axes left in each band", model.coupling_root),
        ("mixing", "Mix of the sources to axes", model.mixing),
        ("filters", "Band-pass filters: b0, b1, b2, 2 + a1, 1 - a2", filters),
        ("taps", "Minimum-phase filters", model.filter),
    ]
    tables = [
        {"name": name, "meaning": meaning, **_in_c(np.asarray(values, np.float64), _number)}
        for name, meaning, values in arrays
    ]
    if lines := len(model.tones.frequency):
        kept = model.tones.unsteadiness[[2, 4]]
        steps = np.round(model.tones.frequency / model.rate * TURN)
        fresh = np.sqrt(np.maximum(0, 1 - kept**2))
        tables += [
            {"name": name, "meaning": meaning, **_in_c(values, _number)}
            for name, meaning, values in (
                ("kept", "Autocorrelation of the speed and of the gain of tones", kept),
                ("fresh", "Share that is drawn", fresh),
                ("amplitudes", "Cosine and negative sine parts of the lines", model.tones.amplitude),
            )
        ]
        meaning = f"Frequencies of {lines} lines, turns of 2^32 per sample"
        tables.append({"name": "steps", "meaning": meaning, **_in_c(steps, lambda x: f"{x:.0f}u")})
        tables[-1]["kind"] = "uint32_t"
    return [{"kind": "", **table} for table in tables]


def _in_c(values: NDArray[np.float64], text: Any) -> dict[str, Any]:
    """Return dimensions, initialiser and count of an array."""

    def nested(part: NDArray[np.float64], indent: str) -> str:
        if part.ndim == 1:
            numbers = [text(x) for x in part.tolist()]
            rows = [", ".join(numbers[k : k + 8]) for k in range(0, len(numbers), 8)]
            return "{" + f",\n{indent} ".join(rows) + "}"
        return "{" + f",\n{indent} ".join(nested(each, indent + " ") for each in part) + "}"

    shape = "".join(f"[{n}]" for n in values.shape)
    return {"shape": shape, "values": nested(values, ""), "size": values.size}


def _number(value: float) -> str:
    """Return a number with all digits of single precision."""
    text = f"{float(value):.9g}"
    return text if re.search(r"[.e]", text) else f"{text}.0"


def _cost(model: ModulatedNoise, block: int, table_words: int) -> HeaderCost:
    """Return what `noise_header` computes; ``tests/rendering/embedded`` counts it in the compiled header."""
    axes, gains, lags, lines = len(model.axes), model.gains, model.lags, len(model.tones.frequency)
    of_band = axes + 7  # coupling, five of the filter, interpolation, gain
    sample = Operations(
        BANDS * axes + axes * (BANDS * of_band + 4 + axes + TAPS), 2 + axes, axes * (BANDS + 2)
    )
    frame = Operations(gains + 2 * gains**2 * (2 * lags - 1) + 2 * gains**2 + 2 * gains, 2 * gains, 0)
    state = 8 + gains * (lags + 5) + axes * (2 * BANDS + 1 + TAPS) + 8
    if lines:
        sample = _added(sample, Operations(5 + lines * (2 + 3 * axes), 1, 2 + 2 * lines))
        frame = _added(frame, Operations(6, 0, 0))
        state += 4 + 5 + lines + 4
    usual = Operations(block * sample.multiplications, block * sample.divisions, block * sample.functions)
    return HeaderCost(usual, _added(usual, frame), WORD * table_words, WORD * state)


def _added(one: Operations, other: Operations) -> Operations:
    return Operations(
        one.multiplications + other.multiplications,
        one.divisions + other.divisions,
        one.functions + other.functions,
    )
