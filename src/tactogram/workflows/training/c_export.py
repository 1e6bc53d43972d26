"""A texture of a run as a C header for a microcontroller."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.rendering.embedded.noise_header import c_name, noise_header
from tactogram.rendering.streaming.noise_texture import one_axis
from tactogram.signal.io.atomic import write_text
from tactogram.signal.texture_map import NoiseMap
from tactogram.workflows.training.loaded_run import load_run


def export_c(
    run: Path | str,
    out: Path | str,
    *,
    material: str | None = None,
    speed: float | None = None,
    force: float | None = None,
    axis: str = "dft321",
) -> dict[str, Any]:
    """Write a material at a speed (mm/s) and force (N), by default the median recorded ones; return the header's facts.

    Raises
    ------
    ParameterError
        If the run has no modulated noise, no such material, or unknown speeds or forces.
    """
    loaded = load_run(run)
    found = {
        name: each
        for name, each in zip(loaded.kind.materials, loaded.model.maps, strict=False)
        if isinstance(each, NoiseMap)
    }
    if not found:
        raise ParameterError(
            f"{loaded.run.name}: a C header needs a run of texture_var, this is {loaded.facts.name}"
        )
    if material not in found:
        raise ParameterError(f"material must be one of {', '.join(found)}, got {material}")
    texture = one_axis(found[material].at(speed, force), axis)
    at = [f"{value:g} {unit}" for value, unit in ((speed, "mm/s"), (force, "N")) if value is not None]
    facts = [
        f"Material {material} of run {loaded.run.data['run_id']}, {' and '.join(at) or 'median speed and force'}.",
        *(["Learned from simulated recordings."] if loaded.simulated else []),
    ]
    name = c_name(material)
    text, cost = noise_header(texture, name=name, facts=facts)
    write_text(Path(out), text)
    return {"file": str(out), "name": name, "material": material, "rate_hz": texture.rate, **asdict(cost)}
