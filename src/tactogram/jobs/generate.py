"""Signals from a trained generator, to files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.jobs.training import LoadedRun, load_run
from tactogram.model import Condition, Generator
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, write_signal
from tactogram.training.seeds import child_seed

LONGEST_S = 3600.0
"""Longest signal that is made in one go, in s."""


def generate(
    run: Path | str | LoadedRun,
    condition: Condition,
    *,
    seconds: float | None = None,
    seed: int = 0,
    count: int = 1,
) -> Iterator[Signal]:
    """Yield ``count`` signals for ``condition``; number n of a seed is always the same.

    Parameters
    ----------
    run : path or LoadedRun
        A trained generator.
    condition : mapping
        Names from `tactogram.model.CONDITIONS`, e.g. ``{"material": {"cork": 0.6, "tile": 0.4}}``.
    seconds : float, optional
        Length; by default the model's own.
    seed, count : int

    Raises
    ------
    ParameterError
        For a condition that the model does not take or know, or a length that makes no sense.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    if not isinstance(loaded.model, Generator):
        raise ParameterError(f"{loaded.run.name}: {loaded.facts.name} does not generate")
    if seconds is not None and not 0 < seconds <= LONGEST_S:
        raise ParameterError(f"seconds must be > 0 and at most {LONGEST_S:g}, got {seconds:g}")
    if seed < 0:
        raise ParameterError(f"seed must be >= 0, got {seed}")
    if count < 1:
        raise ParameterError(f"count must be at least 1, got {count}")
    for number in range(count):
        drawn = seed if number == 0 else child_seed(seed, "generate", number)
        signal = loaded.model.generate(condition, seconds=seconds, seed=drawn)
        if not isinstance(signal, Signal):
            raise ParameterError(f"{loaded.facts.name} generates images, not signals")
        yield signal


def generate_files(
    run: Path | str | LoadedRun,
    condition: Condition,
    out: Path,
    *,
    seconds: float | None = None,
    seed: int = 0,
    count: int = 1,
    photograph: Path | str | None = None,
) -> list[dict[str, Any]]:
    """Write ``count`` signals to ``out``, numbered ``NAME-1.wav`` and so on where there are several.

    What they are, and whether the model was trained on simulated data, is written into the files.

    Parameters
    ----------
    run, condition, seconds, seed, count
        As for `generate`.
    out : Path
    photograph : path, optional
        A picture file, for models that go by one; its name is written into the files.

    Returns
    -------
    list of dict
        ``file``, ``seconds``, ``rate_hz``, ``unit``, ``axes``, ``simulated`` (whether what it learned from
        was), ``rms`` per file; over displacement ``length_mm`` and ``rate_per_mm`` instead of seconds and Hz. Where
        the model names the surface in a photograph: ``taken_for`` and, if it gives one, ``confidence``; of several of a
        model without noise ``differ_by``.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    seen: dict[str, Any] = {}
    if photograph is not None:
        image = read_image(photograph)
        condition = {**condition, "image": image}
        seen = _taken_for(loaded.model, image)
    metadata = {
        "generated_by": f"tactogram {loaded.facts.name}",
        "run": loaded.run.data["run_id"],
        "seed": seed,
        "simulated": loaded.simulated,
        **{name: value for name, value in condition.items() if value is not None and name != "image"},
        **({} if photograph is None else {"photograph": Path(photograph).name}),
        **seen,
    }
    if count > 1 and (differ_by := getattr(loaded.model, "differ_by", "")):
        seen["differ_by"] = differ_by
    written = []
    for number, signal in enumerate(
        generate(loaded, condition, seconds=seconds, seed=seed, count=count), start=1
    ):
        file = out if count == 1 else out.with_name(f"{out.stem}-{number}{out.suffix}")
        write_signal(file, signal, metadata={**metadata, "number": number})
        extent = (
            {"seconds": signal.seconds, "rate_hz": signal.rate}
            if signal.domain == "time"
            else {"length_mm": signal.length_mm, "rate_per_mm": signal.rate}
        )
        written.append(
            {
                "file": str(file),
                **extent,
                "unit": signal.unit,
                "axes": list(signal.axes),
                "simulated": loaded.simulated,
                "rms": float((signal.samples.astype(float) ** 2).mean() ** 0.5),
                **seen,
            }
        )
    return written


def _taken_for(model: Any, image: Image) -> dict[str, Any]:
    """Return which known surface a model takes a photograph for, where it says so."""
    if hasattr(model, "label_of"):
        try:
            material, confidence = model.label_of(image)
        except ParameterError:  # a variant without a label
            return {}
        return {"taken_for": material, "confidence": round(float(confidence), 4)}
    return {"taken_for": model.material_of(image)} if hasattr(model, "material_of") else {}


def parse_mix(text: str) -> dict[str, float]:
    """Return ``"cork=0.6,tile=0.4"`` as weights by material.

    Raises
    ------
    ParameterError
        If a part is not NAME=NUMBER, or a name stands twice.
    """
    weights: dict[str, float] = {}
    for part in text.split(","):
        name, sign, value = part.rpartition("=")
        try:
            weight = float(value)
        except ValueError:
            sign = ""
        if not (sign and name.strip()):
            raise ParameterError(f"--mix needs NAME=WEIGHT,NAME=WEIGHT…, got {part!r}")
        if name.strip() in weights:
            raise ParameterError(f"--mix names {name.strip()!r} twice")
        weights[name.strip()] = weight
    return weights
