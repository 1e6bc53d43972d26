"""texture_flow beside real materials: the Penn Haptic Texture Toolkit, by names, strokes and words, in aggregates.

Its models (Culbertson et al. 2014) give the spectrum of a material, stroked by a stylus, at every speed and force that
was recorded. Levels of 20 bands, 20 to 480 Hz, are compared, in dB. The toolkit may not be passed on, so that nothing
but means over many materials is written. Families of materials, such as its seven floor tiles, stay together in one of
two halves. The simulated population was fitted to aggregates of both; the kinds of everyday surfaces, to the first
alone, but how strongly they are drawn to the mean of all was set with both in view.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.synthesis import synthesise
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram_benchmark.importers.hatt import find, read_surface

EDGES_HZ = np.geomspace(20, 480, 21)
CENTRES = np.log2(np.sqrt(EDGES_HZ[1:] * EDGES_HZ[:-1]))
LINES_HZ = np.linspace(20, 480, 461)
USUAL = {"speed_mm_s": 120.0, "force_n": 1.0}
SECONDS = 4.0
PAIRS = 5
"""Pairs of strokes of a material."""
EVERY = 5
"""Of our materials, those whose change with speed and force is measured."""
FAMILIES = (
    "Acrylic", "Alumin", "Brick", "Canvas", "Carbon", "Carpet", "Floortile", "Foam", "Leather", "Mesh", "Metal",
    "Nylon", "Paper", "Plastic", "Sandpaper", "Silk", "Stone", "Velcro", "Vinyl", "Whiteboard", "Wood",
)  # fmt: skip
NAMES = {
    "smooth-plastic": "ABS Plastic", "aluminium-foil": "Aluminum Foil", "artificial-turf": "Artificial Grass",
    "brick": "Brick 1", "bubble-wrap": "Bubble Envelope", "canvas": "Canvas 1", "cardboard": "Cardboard",
    "loop-carpet": "Carpet 1", "cork": "Cork", "cotton-sheet": "Cotton", "denim": "Denim", "felt": "Felt",
    "fleece": "Fleece", "foam-rubber": "EPDM Foam", "glazed-tiles": "Ceramic", "grained-leather": "Leather 1 Front",
    "microfibre-cloth": "Microfiber Cloth", "plastic-mesh": "Plastic Mesh 1", "polystyrene-foam": "Styrofoam",
    "printer-paper": "Resume Paper", "sandpaper": "Sandpaper 220", "coarse-sandpaper": "Sandpaper 100",
    "fine-sandpaper": "Sandpaper 320", "scouring-pad": "Scouring Pad", "silk": "Silk 1", "suede": "Leather 1 Back",
    "terracotta": "Terra Cotta", "terry-towel": "Towel", "velvet": "Velvet", "vinyl-flooring": "Vinyl 1",
    "wire-mesh": "Metal Mesh", "pine-board": "Wood", "polished-wood": "Stained Wood", "slate": "Stone Tile 1",
    "plastic-film": "Nylon Bag", "textured-plastic": "Textured Rubber",
}  # fmt: skip
"""Materials of both, ours and the toolkit's."""
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RealMaterial:
    """Strokes of a material of the toolkit: spectra, (stroke, line), (m/s^2)^2/Hz, and log2 of speed and force."""

    name: str
    spectra: Array
    at: Array
    strokes: tuple[Signal, ...]

    @property
    def bands(self) -> Array:
        """Levels of the bands, dB, shape (stroke, band)."""
        return band_levels(self.spectra)


def run(
    folder: Path, *, paper: bool, progress: ProgressCallback, generator: str = "texture_flow", data: str = "",
    half: str = "reported",
) -> dict[str, Any]:  # fmt: skip
    """Return the figures of one half of the toolkit's materials.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``folder`` and ``paper`` change nothing.
    generator : str
        Run of texture_flow, or the one that it comes with.
    data : str
        Folder of the toolkit.
    half : str
        ``reported`` or ``chosen``, on which simulator and prediction were chosen.
    """
    if not data or half not in ("reported", "chosen"):
        raise ParameterError(
            "data must be a folder of the Penn Haptic Texture Toolkit, half reported or chosen"
        )
    loaded = load_run(generator)
    stylus = {"contactor": "stylus"} if "contactor" in loaded.facts.takes else {}
    real = read(Path(data), progress)
    own = [each for each in real if in_first_half(each.name) == (half == "chosen")]
    others = [each for each in real if in_first_half(each.name) != (half == "chosen")]
    result: dict[str, Any] = {
        "generator": {"run_id": loaded.run.data["run_id"], "data": loaded.run.data.get("name")},
        "data": "Penn Haptic Texture Toolkit, aggregates of its models",
        "half": half,
        "materials": len(own),
        "population": _population(loaded, own, stylus, progress),
        "names": _names(loaded, own, others, stylus, progress),
        "one stroke": _one_stroke(loaded, own, others, stylus, progress),
        "words": _words(loaded, stylus),
    }
    return result | {"text": _text(result)}


def read(folder: Path, progress: ProgressCallback) -> list[RealMaterial]:
    """Return the materials of the toolkit; conditions that it only copied to the borders of its map are left out."""
    items, found = find(folder), []
    for number, item in enumerate(items, 1):
        surface = read_surface(item.paths[0])
        textures = surface.textures
        models = [
            (model, at)
            for model, at in zip(textures.models, np.asarray(textures.conditions), strict=True)
            if min(at) > 0 and at[1] < surface.max_force_n and model.innovation.max() > 0
        ]
        seed = zlib.crc32(surface.material.encode())
        found.append(
            RealMaterial(
                surface.material,
                np.stack([model.power_spectrum(LINES_HZ)[0] for model, _ in models]),
                np.log2([at for _, at in models]),
                tuple(
                    synthesise(model, SECONDS, seed=seed + place) for place, (model, _) in enumerate(models)
                ),
            )
        )
        progress("materials", number, len(items))
    return found


def in_first_half(name: str) -> bool:
    """Return whether the family of a material is in the half that is chosen on."""
    family = next((each for each in FAMILIES if each in name), re.sub(r" \d+.*", "", name))
    return zlib.crc32(family.encode()) % 2 == 0


def band_levels(spectra: Array) -> Array:
    """Return mean densities of bands, dB: (…, line) -> (…, 20)."""
    band = np.digitize(LINES_HZ, EDGES_HZ[1:-1])
    return np.stack([10 * np.log10(spectra[..., band == k].mean(-1) + 1e-12) for k in range(20)], -1)


def levels(bands: Array) -> Array:
    """Return the level of all bands, dB."""
    return np.asarray(10 * np.log10((10 ** (bands / 10) * np.diff(EDGES_HZ)).sum(-1)))


def pooled_law(materials: Sequence[RealMaterial]) -> Array:
    """Return the slopes of the bands, dB per octave of speed and of force: (condition, band)."""
    steps = np.vstack([each.at - each.at.mean(0) for each in materials])
    changes = np.vstack([each.bands - each.bands.mean(0) for each in materials])
    return np.asarray(np.linalg.lstsq(steps, changes, rcond=None)[0])


def spectrum_of(made: Signal) -> Array:
    """Return the density of a signal at `LINES_HZ`."""
    size = 2 ** round(np.log2(made.rate / 2))
    frequencies, density = welch(made.samples.astype(np.float64), made.rate, nperseg=size)
    return np.asarray(np.interp(LINES_HZ, frequencies, density.sum(0)))


def _at_usual(material: RealMaterial, law: Array) -> Array:
    """Return the bands of a material at the `USUAL` speed and force."""
    return np.asarray((material.bands + (np.log2([*USUAL.values()]) - material.at) @ law).mean(0))


def _made(loaded: LoadedRun, condition: Mapping[str, Any]) -> Array:
    made: Any = loaded.generator.generate(condition, seconds=SECONDS, seed=0)
    return band_levels(spectrum_of(made))


def _centroid(bands: Array) -> Array:
    power = 10 ** (bands / 10) * np.diff(EDGES_HZ)
    return np.asarray((power * 2**CENTRES).sum(-1) / power.sum(-1))


def slopes(bands: Array) -> Array:
    """Return the slopes of spectra, dB per octave."""
    return np.asarray(np.polyfit(CENTRES, bands.T, 1)[0])


def _population(
    loaded: LoadedRun, real: Sequence[RealMaterial], stylus: Mapping[str, Any], progress: ProgressCallback
) -> dict[str, Any]:
    law = pooled_law(real)
    usual = np.stack([_at_usual(each, law) for each in real])
    axes = np.vstack([each.at - each.at.mean(0) for each in real])

    def powers(figure: Any) -> list[float]:
        changes = np.concatenate([figure(each.bands) - figure(each.bands).mean() for each in real])
        return [float(v) for v in np.linalg.lstsq(axes, changes, rcond=None)[0]]

    ours, moved = [], []
    for number, name in enumerate(loaded.kind.materials):
        ours.append(_made(loaded, {"material": name, **USUAL, **stylus}))
        if number % EVERY == 0:
            at = [{**USUAL, name_of: USUAL[name_of] * by} for name_of in USUAL for by in (0.5, 2.0)]
            moved.append([_made(loaded, {"material": name, **each, **stylus}) for each in at])
        progress("population", number + 1, len(loaded.kind.materials))
    made, changed = np.array(ours), np.array(moved)

    def by(figure: Any, low: int, high: int) -> float:
        return float(np.mean(figure(changed[:, high]) - figure(changed[:, low])) / 2)

    def octaves(bands: Array) -> Array:
        return np.log2(_centroid(bands))

    def described(bands: Array, level: Sequence[float], centroid: Sequence[float]) -> dict[str, Any]:
        return {
            "level": _spread(levels(bands)),
            "centroid_hz": _spread(_centroid(bands)),
            "slope": _spread(slopes(bands)),
            "level by speed, force": [x / 6.02 for x in level],
            "centroid by speed, force": list(centroid),
            "mean spectrum": [round(float(x), 1) for x in bands.mean(0)],
        }

    return {
        "real": described(usual, powers(levels), powers(octaves)),
        "by name": described(
            made,
            [by(levels, 0, 1), by(levels, 2, 3)],
            [by(octaves, 0, 1), by(octaves, 2, 3)],
        ),
    }


def _names(
    loaded: LoadedRun,
    own: Sequence[RealMaterial],
    others: Sequence[RealMaterial],
    stylus: Mapping[str, Any],
    progress: ProgressCallback,
) -> dict[str, Any]:
    law = pooled_law([*own, *others])
    truth = {each.name: _at_usual(each, law) for each in [*own, *others]}
    known = {name: real for name, real in NAMES.items() if name in loaded.kind.materials}
    mean = np.mean([truth[each.name] for each in others], 0)
    table = np.array([*truth.values()])
    rows = []
    for name, real in known.items():
        if real not in {each.name for each in own}:
            continue
        made = _made(loaded, {"material": name, **USUAL, **stylus})
        row: dict[str, float] = {"level": float(levels(made) - levels(truth[real]))}
        for kind, shape in (("raw", False), ("shape", True)):

            def centred(bands: Array, shape: bool = shape) -> Array:
                return np.asarray(bands - shape * bands.mean(-1, keepdims=True))

            far = np.sqrt(np.mean((centred(table) - centred(made)) ** 2, 1))
            place = [*truth].index(real)
            row |= {
                f"{kind}: to the named": far[place],
                f"{kind}: to another": np.delete(far, place).mean(),
                f"{kind}: of the mean material": np.sqrt(
                    np.mean((centred(mean) - centred(table[place])) ** 2)
                ),
                f"{kind}: rank": np.mean(far < far[place]),
            }
        rows.append(row)
    found = {key: float(np.mean([abs(row[key]) for row in rows])) for key in rows[0]}
    return {"materials": len(rows), "level, mean": float(np.mean([row["level"] for row in rows]))} | found


def _one_stroke(
    loaded: LoadedRun,
    own: Sequence[RealMaterial],
    others: Sequence[RealMaterial],
    stylus: Mapping[str, Any],
    progress: ProgressCallback,
) -> dict[str, Any]:
    law = pooled_law(others)
    known = {f"vibration_{name}": value for name, value in stylus.items()}
    methods = ("copy", "pooled law of the other half", "from the stroke")
    errors: dict[str, list[list[float]]] = {name: [] for name in methods}
    for number, material in enumerate(own, 1):
        rng = np.random.default_rng(zlib.crc32(material.name.encode()))
        bands = material.bands
        rows: dict[str, list[list[float]]] = {name: [] for name in methods}
        for _ in range(PAIRS):
            one, other = rng.choice(len(bands), 2, replace=False)
            step = material.at[other] - material.at[one]
            (v0, f0), (v1, f1) = 2 ** material.at[[one, other]]
            given = loaded.prepare_vibration(material.strokes[one])
            made = _made(
                loaded,
                {
                    "vibration": given, "vibration_speed_mm_s": v0, "vibration_force_n": f0,
                    "speed_mm_s": v1, "force_n": f1, **known, **stylus,
                },
            )  # fmt: skip
            for name, found in zip(methods, (bands[one], bands[one] + step @ law, made), strict=True):
                rows[name].append([
                    float(np.sqrt(np.mean((found - bands[other]) ** 2))),
                    float(abs(levels(found) - levels(bands[other]))),
                    float(abs(step[0]) >= 1),
                ])  # fmt: skip
        for name in methods:
            errors[name] += rows[name]
        progress("strokes", number, len(own))
    tables = {name: np.array(rows, np.float64) for name, rows in errors.items()}
    return {
        name: {
            "spectrum": float(rows[:, 0].mean()),
            "level": float(rows[:, 1].mean()),
            "spectrum, an octave of speed or more": float(rows[rows[:, 2] > 0, 0].mean()),
            "pairs": len(rows),
        }
        for name, rows in tables.items()
    }


def _words(loaded: LoadedRun, stylus: Mapping[str, Any]) -> dict[str, Any]:
    """Return what 1 to 7 of a word, and 7 of it alone, does."""
    found = {}
    for word in loaded.kind.words:
        low, high = (_made(loaded, {"words": {word: score}, **USUAL, **stylus}) for score in (1.0, 7.0))
        shape = (high - high.mean()) - (low - low.mean())
        found[word] = {
            "level": float(levels(high) - levels(low)),
            "centroid_hz": float(_centroid(high) - _centroid(low)),
            "shape": float(np.sqrt(np.mean(shape**2))),
            "level of 7": float(levels(high)),
        }
    return found


def _spread(values: Array) -> list[float]:
    return [float(np.mean(values)), float(np.std(values))]


def _text(result: Mapping[str, Any]) -> str:
    lines = [f"{result['data']}, half {result['half']}, {result['materials']} materials"]
    for part in ("population", "names", "one stroke", "words"):
        lines.append(f"{part}:")
        for name, value in result[part].items():
            shown = value if isinstance(value, Mapping) else {"": value}
            lines.append(f"  {name}: " + "; ".join(f"{k} {_short(v)}".strip() for k, v in shown.items()))
    return "\n".join(lines)


def _short(value: Any) -> str:
    return " ".join(f"{v:.2f}" for v in value) if isinstance(value, list) else f"{value:.2f}"
