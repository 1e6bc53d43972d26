"""Texture tables of the page Touch, for the browser's audio thread.

A table holds what `tactogram_playback.streaming` computes in advance, so that the browser makes the same samples:
models on a grid over speed and force, or a surface in copies of decreasing detail. It includes the texture's strength
(measured under a simulated hand, as in `tactogram_playback.stream`) and that of a phone's vibration.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering import (
    OVERSAMPLED,
    Level,
    SimulatedHand,
    StrengthSettings,
    combined,
    copy_count,
    open_display,
    strength,
)
from tactogram.signal import (
    FELT_HZ,
    SCORES,
    NoiseMap,
    Signal,
    TextureMap,
    band_sections,
    level_factor,
    parameter_views,
)
from tactogram_playback import (
    Along,
    ContactSettings,
    Engine,
    NoiseTable,
    StreamingTexture,
    SurfaceTexture,
    TextureSettings,
    TextureTable,
    texture_of_map,
)

MAGIC = b"TGTT"
VERSION = 1
QUANTUM = 128
"""Samples per call of an AudioWorklet (Web Audio API)."""
MOST_NODES = 4_000_000
"""Of all copies of a surface: 16 MB to send."""
TRIAL_S = 3.0
"""Length of the trial under a simulated hand, s."""
ASSUMED_SPEED_MM_S = 100.0
"""Speed of a signal over time whose recording speed is unknown."""
PHONE = "phone-on-off"
"""Display equal to a browser's vibration: on and off, no strengths."""
BITS, ROTATION_BITS, QUANTILE_BITS = 13, 10, 11
"""Of the largest parameter of noise of each kind; of its rotations and quantiles."""
FREQUENCIES = 400
"""Points at which a model's power in the felt band is integrated."""


@dataclass(frozen=True, eq=False)
class TouchTexture:
    """A texture for the browser: ``head`` holds kind, strength and what it follows, as JSON values."""

    head: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]

    @property
    def nbytes(self) -> int:
        """Size of the arrays, bytes."""
        return sum(array.nbytes for array in self.arrays.values())

    def packed(self) -> bytes:
        """Return ``TGTT``, the length of a JSON text (uint32), the text, and the arrays; all little-endian.

        ``arrays`` in the text holds the type, offset (a multiple of 8) and length of each array.
        """
        places: dict[str, Any] = {}
        for name, array in self.arrays.items():
            places[name] = {"type": array.dtype.name, "offset": 0, "length": array.size}
        # Leaves room for offsets of any size: the text's length must not depend on them.
        length = -(-(len(self._text(places)) + 24 * len(places)) // 8) * 8
        offset = 8 + length
        for name, array in self.arrays.items():
            places[name]["offset"] = offset
            offset += -(-array.nbytes // 8) * 8
        parts = [MAGIC, np.uint32(length).tobytes(), self._text(places).ljust(length)]
        for array in self.arrays.values():
            data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes()
            parts += [data, b"\0" * (-len(data) % 8)]
        return b"".join(parts)

    def _text(self, places: Mapping[str, Any]) -> bytes:
        return json.dumps({**self.head, "arrays": places}).encode()


def table_of_map(
    name: str, surface: TextureMap | NoiseMap, *, rate: float, axes: str = "dft321", simulated: bool = False
) -> TouchTexture:
    """Return the table of models over speed and force; ``rate`` is that of the browser's audio, Hz.

    Raises `ParameterError` if the texture is silent, or ``axes`` does not make one of several axes.
    """
    texture = texture_of_map(name, surface, TextureSettings(rate, QUANTUM, axes))
    if len(texture.axes) > 1:
        raise ParameterError.must(
            "axes", "combine several axes into one", axes, remedy="use dft321 or an axis's name"
        )
    table, grid = texture.table, texture.table.grid
    known_v, known_f = surface.has_conditions
    speeds, forces = grid.speeds if known_v else None, grid.forces if known_f else None
    arrays: dict[str, NDArray[Any]] = {
        "speeds": grid.speeds,
        "forces": grid.forces,
        "kernel": texture.resampler.kernel.ravel(),
        "vibration": _felt_amplitudes(table).ravel(),
    }
    kind: dict[str, Any]
    if isinstance(table, NoiseTable):
        kind = {"kind": "noise", "lags": table.lags, "level_factor": level_factor(table.rate)}
        whole, steps = rounded_parameters(table)
        # Neighbours differ little: as second differences along the speed, zlib makes a tenth of them.
        curved = np.diff(whole, n=2, axis=0, prepend=np.zeros((2, *whole.shape[1:]), np.int16))
        arrays |= {"values": curved.transpose(2, 1, 0).ravel(), "steps": steps, "scores": SCORES}
        arrays["sections"] = band_sections(table.rate).ravel()
    else:
        kind = {"kind": "autoregressive", "order": table.order}
        arrays["reflection"] = table.grid.reflection[:, :, 0].ravel()
        arrays["deviation"] = table.grid.deviation[:, :, 0].ravel()
    follows, notes = _followed(speeds, forces)
    if len(surface.models[0].axes) > 1:
        joined = "its axes combined into one with the same energy (DFT321)"
        notes.append(joined if axes == "dft321" else f"axis {axes} only")
    head = {
        **_head(name, texture, rate=rate, simulated=simulated),
        **kind,
        "table_rate": table.rate,
        "half": texture.resampler.half,
        "follows": follows,
        "notes": notes,
    }
    return TouchTexture(head, arrays)


def table_of_signal(
    name: str,
    signal: Signal,
    *,
    rate: float,
    speed_mm_s: float | None = None,
    along: Along = "path",
    axes: str = "dft321",
    periodic: bool = False,
    simulated: bool = False,
    limited: Iterable[str] = (),
) -> TouchTexture:
    """Return the table of a signal that is laid out over the surface, for audio at ``rate`` (Hz).

    Its mean (gravity, a sensor's offset) is removed, since a sound card cannot play it. A friction coefficient's
    deviations from its mean are played like a vibration, silent at rest. A signal over time without ``speed_mm_s`` gets
    `ASSUMED_SPEED_MM_S` and a note; what was ``limited`` as it was generated are others. One that is ``periodic`` keeps
    its positions; others are made a loop, which begins later.

    Raises `ParameterError` if the signal is silent, too short for a loop, or has too many axes.
    """
    notes = [*limited]
    if signal.domain == "time" and speed_mm_s is None:
        speed_mm_s = ASSUMED_SPEED_MM_S
        notes.append(f"its recording speed is unknown: {speed_mm_s:g} mm/s is assumed")
    if signal.domain == "displacement":
        speed_mm_s = None
    steady = signal.samples - signal.samples.mean(axis=1, keepdims=True, dtype=np.float64)
    vibration, words = combined(signal.with_samples(steady.astype(np.float32)), axes)
    if len(signal.axes) > 1:
        notes.append(words)
    if len(vibration.axes) > 1:
        raise ParameterError.must(
            "axes", "combine several axes into one", axes, remedy="use dft321, mean or an axis's name"
        )
    copies = copy_count(vibration.rate / (speed_mm_s or 1.0), rate)
    most = MOST_NODES // (OVERSAMPLED * copies)
    if len(vibration) > most:
        notes.append(f"only its first {100 * most / len(vibration):.0f} %: the rest is too long to send")
        vibration = vibration.cut(0, most)
    texture = SurfaceTexture(
        name, vibration, rate=rate, speed_mm_s=speed_mm_s, along=along, periodic=periodic
    )
    texture.holds_at_rest = False
    common = _head(name, texture, rate=rate, simulated=simulated)
    envelope, step_mm = _envelope(texture, speed_mm_s or ASSUMED_SPEED_MM_S)
    head = {
        **common,
        "kind": "surface",
        "along": along,
        "copies": len(texture.nodes),
        "nodes_per_mm": texture.nodes_per_mm,
        "samples_per_speed": texture.samples_per_speed,
        "length_mm": texture.length_mm,
        "recorded_mm_s": speed_mm_s,
        "vibration_step_mm": step_mm,
        "follows": {"path": "the finger's path", "x": "the position along x", "y": "the position along y"}[
            along
        ],
        "notes": notes,
    }
    return TouchTexture(head, {"nodes": texture.nodes[:, 0].ravel(), "vibration": envelope})


def _head(name: str, texture: StreamingTexture, *, rate: float, simulated: bool) -> dict[str, Any]:
    """Return the facts of every table; the texture cannot be used afterwards."""
    rms, peak = _measured(texture, rate)
    if peak == 0:
        raise ParameterError(f"{name} is silent: there is nothing to feel")
    phone = open_display(PHONE)
    return {
        "version": VERSION,
        "name": name,
        "unit": texture.unit,
        "rate": rate,
        "simulated": simulated,
        "level": texture.level,
        "rms": rms,
        "peak": peak,
        "phone": {
            "display": PHONE,
            "step_ms": 1e3 / phone.rate,
            "shortest_steps": phone.shortest_steps,
        },
    }


def _measured(texture: StreamingTexture, rate: float) -> tuple[float, float]:
    """Return rms while sliding and peak under a simulated hand, in the unit."""
    engine = Engine(
        [texture], SimulatedHand(TRIAL_S + 1, seed=1), rate=rate, most=QUANTUM, contact=ContactSettings()
    )
    peak, square, slid = 0.0, 0.0, 0
    for number in range(int(TRIAL_S * rate / QUANTUM)):
        block = engine.render(number * QUANTUM / rate).astype(np.float64)
        peak = max(peak, float(np.abs(block).max()))
        if engine.tracker.state == "slide":
            square += float(np.mean(block**2))
            slid += 1
    return float(np.sqrt(square / max(slid, 1))), peak


def rounded_parameters(table: NoiseTable) -> tuple[NDArray[np.int16], NDArray[np.float32]]:
    """Return the parameters of a grid's nodes as multiples of steps, and the step of each.

    Rotations are shortened first, so that rounding makes no vector longer and any path over the grid stays stable.

    Returns
    -------
    int16 array, shape (speed, force, parameter)
    float32 array, shape (parameter,)
    """
    values = table.grid.values.astype(np.float64)
    steps = np.abs(values).max(axis=(0, 1))
    noise, tones = parameter_views(steps, axes=1, lags=table.lags)
    for part in (*noise, *tones):
        rough = QUANTILE_BITS if part is noise.quantiles else BITS
        bits = ROTATION_BITS if part is noise.rotations else rough
        part[...] = np.exp2(np.ceil(np.log2(part.max(initial=1e-30))) - bits)
    rotations = values[:, :, : noise.rotations.size]
    exact = rotations.copy()
    for margin in (0.0, 2.0, 4.0, 8.0):  # 8 steps are the bound of 16 x 16 numbers rounded by half a step
        rotations[:] = exact * (1 - margin * steps[0])
        whole = np.rint(values / steps)
        if (
            _longest((whole * steps)[:, :, : noise.rotations.size].reshape(-1, *noise.rotations.shape[1:]))
            <= 1
        ):
            break
    return whole.astype(np.int16), steps.astype(np.float32)


def _longest(rotations: NDArray[np.float64]) -> float:
    """Return how long rotations (rotation, 3, gain, gain) make a vector of length 1."""
    s, k, t = rotations.transpose(1, 0, 2, 3)
    return float(np.linalg.norm(np.block([[s, k], [-k.swapaxes(1, 2), t]]), 2, axis=(1, 2)).max())


def _felt_amplitudes(table: TextureTable | NoiseTable) -> NDArray[np.float32]:
    """Return at every node the amplitude of the sine with the model's power in the felt band, shape (S, F)."""
    low, high = open_display(PHONE).band or FELT_HZ
    high = min(high, table.rate / 2)
    frequency = np.linspace(low, high, FREQUENCIES) if low < high else np.array([low])
    amplitudes = np.empty((len(table.grid.speeds), len(table.grid.forces)), np.float32)
    for i, speed in enumerate(table.grid.speeds):
        for j, force in enumerate(table.grid.forces):
            density = table.at(float(speed), float(force)).power_spectrum(frequency)[0]
            amplitudes[i, j] = np.sqrt(2 * np.trapezoid(density, frequency))
    return amplitudes


def _envelope(texture: SurfaceTexture, speed_mm_s: float) -> tuple[NDArray[np.float32], float]:
    """Return the amplitude along a loop in its unit, measured like a phone's strength, and the step in mm."""
    loop = texture.loop
    over_time = Signal(loop.samples, loop.rate * speed_mm_s, loop.unit, loop.axes)
    phone = open_display(PHONE)
    # Far enough below full drive that nothing is limited.
    gain = 0.25 / float(np.abs(loop.samples).max())
    curve = strength(over_time, phone.settings_as(StrengthSettings), display=phone, level=Level("gain", gain))
    return (curve.share / gain).astype(np.float32), texture.length_mm / len(curve.share)


def _followed(
    speeds: NDArray[np.float64] | None, forces: NDArray[np.float64] | None
) -> tuple[str, list[str]]:
    """Return what a grid of models follows, and what counts in place of strokes outside of it, for people."""
    names, notes = [], []
    for values, name, unit, preposition, less, more in (
        (speeds, "speed", "mm/s", "at", "slower", "faster"),
        (forces, "force", "N", "with", "lighter", "firmer"),
    ):
        if values is None:
            continue
        low, high = f"{values[0]:.4g}", f"{values[-1]:.4g}"
        if len(values) > 1:
            names.append(name)
            notes.append(
                f"recorded {preposition} {low} to {high} {unit}; {less} strokes count as {low}, {more} ones as {high}"
            )
        else:
            notes.append(f"recorded {preposition} {low} {unit}; a stroke of any other {name} counts as that")
    return " and ".join(names) or "whether the finger slides", notes
