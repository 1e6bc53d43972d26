"""Penn Haptic Texture Toolkit (HaTT): autoregressive models of 100 surfaces over speed and force.

One XML file ``Models_NAME.xml`` per surface. Under ``modelSet``: ``material``, ``AccelUnits`` (m/s^2), ``SpeedUnits``
(mm/s), ``ForceUnits`` (N), ``SampleRate`` (Hz), ``mu`` (kinetic friction), ``renderPicture`` (path of a square photo),
``numMod``, ``numTri``, ``maxSpeed``, ``maxForce``, ``speedList`` and ``forceList`` (one ``value`` per model), a ``tri``
per triangle (three model numbers from 1), ``numARCoeff``, ``numMACoeff`` (absent or 0 for AR models), and per
``model``: ``ARlsf`` (line spectral frequencies, rad/sample), ``MAlsf``, ``var`` (of the innovations, m^2/s^4), ``gain``
(of the moving-average part), ``speedMod``, ``forceMod``. Photos are ``images/NAME_square.bmp`` or
``TextureImages/NAME_square.bmp``.

The acceleration of an ARMA model is ``gain B(z) / A(z)`` on white noise of variance ``var``. It becomes an
autoregressive model of order `ORDER` with the same autocorrelation up to that lag, and hence the same level. Vertices
at speed 0 or force 0 have variance 0: the published way to fade out.

Checked on a public copy of the toolkit for 1 kHz: its 100 files and photos are read from end to end, all of ARMA models
(12 to 18 coefficients of the moving average); the polynomials of ``ARlsf`` and ``MAlsf`` are the ``ARcoeff`` and
``MAcoeff`` beside them to the six decimals given. Not checked on real files: AR-only models, other sampling rates.

The models were fitted to real recordings, but their output is synthesised: every recording from here is marked
simulated.

References
----------
- Culbertson, H., Lopez Delgado, J. J. & Kuchenbecker, K. J. (2014). One hundred data-driven haptic texture models and
  open-source methods for rendering on 3D objects. Proc. IEEE Haptics Symposium, 319-325. doi
  10.1109/HAPTICS.2014.6775475
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError, fromstring

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import ImportItem, Recording, finite_number
from tactogram.errors import DataError, ParameterError
from tactogram.signal import (
    AutoregressiveModel,
    TextureMap,
    polynomial_of_reflection,
    reflection_of_autocorrelation,
    reflection_of_line_spectrum,
    synthesise,
)
from tactogram.text_files import read_text

TITLE = "Penn Haptic Texture Toolkit: autoregressive models of 100 surfaces over speed and force"
LICENCE = "University of Pennsylvania: non-profit research only, no distribution to third parties"
DESCRIPTION = (
    "Models_NAME.xml: acceleration (m/s^2) synthesised at a grid of speeds (mm/s) and forces (N) from models of "
    "real recordings, marked simulated; photos NAME_square.*. Checked on 100 real files for 1 kHz."
)

SPEEDS_MM_S = (50.0, 100.0, 150.0, 200.0)
FORCES_N = (0.5, 1.0, 2.0)
"""Conditions at which a surface is synthesised; those beyond its recorded range are left out."""
SECONDS = 10.0
"""Length of each, as of the toolkit's own recordings."""
ORDER = 60
"""Order of the autoregressive models that replace ARMA ones: within 0.2 dB (rms, 10-450 Hz) of a real file's."""
SPECTRUM_SIZE = 2**14
PICTURES = {".bmp", ".png", ".jpg", ".jpeg"}


@dataclass(frozen=True)
class SurfaceModel:
    """One file: the acceleration of a surface under every speed and force."""

    material: str
    textures: TextureMap  # acceleration, m/s^2; the power is interpolated linearly, as published
    max_speed_mm_s: float  # of the recorded range
    max_force_n: float
    friction: float | None  # kinetic coefficient against the steel tip


def find(folder: Path) -> list[ImportItem]:
    """Return an item per model file, with its photo if there is one."""
    files = sorted(folder.rglob("Models_*.xml"))
    if not files:
        raise DataError(folder, "must hold model files Models_NAME.xml of the toolkit, found none")
    pictures = {p.stem.lower(): p for p in sorted(folder.rglob("*_square.*")) if p.suffix.lower() in PICTURES}
    return [
        ImportItem(
            name=file.relative_to(folder).as_posix(),
            paths=(file,),
            image=pictures.get(f"{file.stem.removeprefix('Models_')}_square".lower()),
        )
        for file in files
    ]


def read(item: ImportItem) -> list[Recording]:
    """Return the surface at every condition of the grid within its recorded range."""
    surface = read_surface(item.paths[0])
    return [
        _recording(surface, item.name, speed, force)
        for speed in _within(SPEEDS_MM_S, surface.max_speed_mm_s)
        for force in _within(FORCES_N, surface.max_force_n)
    ]


def read_surface(path: Path) -> SurfaceModel:
    """Read one model file."""
    root = _parse(path)
    material = _text(path, root, "material").strip() or path.stem.removeprefix("Models_")
    for name, unit in (("AccelUnits", "m/s^2"), ("SpeedUnits", "mm/s"), ("ForceUnits", "N")):
        if (got := _text(path, root, name).strip()) != unit:
            raise DataError(path, f"{name} must be {unit}, got {got!r}")
    if (rate := _number(path, root, "SampleRate")) <= 0:
        raise DataError(path, f"SampleRate must be > 0 Hz, got {rate:g}")
    nodes = root.findall("model")
    count = int(_number(path, root, "numMod"))
    if not nodes or len(nodes) != count:
        raise DataError(path, f"numMod says {count} models, found {len(nodes)}")
    models, conditions = [], []
    for number, node in enumerate(nodes, start=1):
        where = f"{path}, model {number}"
        models.append(_model(where, node, rate))
        conditions.append((_number(where, node, "speedMod"), _number(where, node, "forceMod")))
    friction = root.findtext("mu")
    return SurfaceModel(
        material,
        _map(path, models, conditions, _triangles(path, root, count)),
        _number(path, root, "maxSpeed"),
        _number(path, root, "maxForce"),
        None if friction is None else _number(path, root, "mu"),
    )


def _recording(surface: SurfaceModel, name: str, speed: float, force: float) -> Recording:
    seed = zlib.crc32(f"{surface.material}|{speed:g}|{force:g}".encode())
    labels = {"synthesised_from": "autoregressive models of real recordings"}
    if surface.friction is not None:
        labels["friction_coefficient"] = f"{surface.friction:g}"
    return Recording(
        streams={"acceleration": synthesise(surface.textures.at(speed, force), SECONDS, seed=seed)},
        material=surface.material,
        speed_mm_s=speed,
        force_n=force,
        contactor="tool",
        labels=labels,
        source=f"{name}#{speed:g}mm/s,{force:g}N",
        history=(
            "models read from the Penn Haptic Texture Toolkit",
            f"each written as an autoregressive model of order {ORDER}",
            f"synthesised at {speed:g} mm/s and {force:g} N, seed {seed}",
        ),
        simulated=True,
    )


def _model(where: str, node: Element, rate: float) -> AutoregressiveModel:
    poles = _polynomial(where, node, "ARlsf")
    zeros, gain = np.ones(1), 1.0
    if node.find("MAlsf") is not None and len(node.findall("MAlsf/value")):
        zeros, gain = _polynomial(where, node, "MAlsf"), _number(where, node, "gain")
    variance = _number(where, node, "var") * gain**2
    if variance < 0:
        raise DataError(where, f"var must be >= 0, got {variance:g}")
    if zeros.size == 1:
        return AutoregressiveModel.from_coefficients(poles, variance, rate=rate, unit="m/s^2")
    response = np.abs(np.fft.rfft(zeros, SPECTRUM_SIZE)) / np.abs(np.fft.rfft(poles, SPECTRUM_SIZE))
    autocorrelation = np.fft.irfft(response**2)[: ORDER + 1]
    reflection = reflection_of_autocorrelation(autocorrelation)
    innovation = variance * autocorrelation[0] * np.prod((1 - reflection) * (1 + reflection))
    return AutoregressiveModel(reflection[None], np.array([[innovation]]), rate, "m/s^2", ("z",))


def _polynomial(where: str, node: Element, name: str) -> NDArray[np.float64]:
    lines = [finite_number(where, name, value.text) for value in node.findall(f"{name}/value")]
    if not lines:
        raise DataError(where, f"expected values in {name}, found none")
    try:
        return polynomial_of_reflection(reflection_of_line_spectrum(lines))
    except ParameterError as error:
        raise DataError(where, f"{name}: {error}") from None


def _triangles(path: Path, root: Element, count: int) -> NDArray[np.intp] | None:
    rows = [[finite_number(path, "tri", v.text) for v in tri.findall("value")] for tri in root.findall("tri")]
    if not rows:
        return None
    if any(len(row) != 3 or not all(1 <= v <= count and v == int(v) for v in row) for row in rows):
        raise DataError(path, f"each tri must be three model numbers from 1 to {count}")
    return np.array(rows, np.intp) - 1


def _map(
    path: Path,
    models: list[AutoregressiveModel],
    conditions: list[tuple[float, float]],
    triangles: NDArray[np.intp] | None,
) -> TextureMap:
    _, first = np.unique(conditions, axis=0, return_index=True)
    if len(first) < len(models):  # a repeated vertex makes the triangles ambiguous
        kept = sorted(first)
        models, conditions, triangles = [models[i] for i in kept], [conditions[i] for i in kept], None
    try:
        return TextureMap(models, conditions, triangles=triangles, level="linear")
    except ParameterError as error:
        raise DataError(path, error) from None


def _within(values: tuple[float, ...], highest: float) -> tuple[float, ...]:
    return tuple(value for value in values if value <= highest) or (highest,)


def _parse(path: Path) -> Element:
    """Return the root of an XML file without document type, and so without entities to expand."""
    try:
        text = read_text(path)
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise DataError(path, "a document type or entity is declared; the toolkit's files have none")
        root = fromstring(text)
    except ParseError as error:
        raise DataError(path, f"not readable as XML: {error}") from None
    if root.tag != "modelSet":
        raise DataError(path, f"expected <modelSet> of the toolkit, got <{root.tag}>")
    return root


def _text(where: object, node: Element, name: str) -> str:
    text = node.findtext(name)
    if text is None:
        raise DataError(where, f"expected <{name}> in <{node.tag}>, found none")
    return text


def _number(where: object, node: Element, name: str) -> float:
    return finite_number(where, name, _text(where, node, name))
