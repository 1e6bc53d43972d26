"""Signals and images from a trained generator, to files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.model import Condition, NoiselessGenerator, PhotographClassifier
from tactogram.signal import Image, Signal
from tactogram.signal.io import WRITABLE, read_image, write_image, write_signal
from tactogram.training.seeds import child_seed
from tactogram.workflows.training.loaded_run import LoadedRun, load_run

MOST = 100_000
"""Pieces that are made in one go."""
LONGEST_S = 3600.0
"""Longest signal that is made in one go, in s."""


def generate(
    run: Path | str | LoadedRun,
    condition: Condition,
    *,
    seconds: float | None = None,
    seed: int = 0,
    count: int = 1,
) -> Iterator[Signal | Image]:
    """Yield ``count`` signals or images for ``condition``; number n of a seed is always the same.

    Parameters
    ----------
    run : path or LoadedRun
        A trained generator.
    condition : mapping
        Names from `tactogram.model.CONDITIONS`, e.g. ``{"material": {"cork": 0.6, "tile": 0.4}}``. Words are on the
        scale of the ratings that the run learned from.
    seconds : float, optional
        Length; by default the model's own. An image has none.
    seed, count : int

    Raises
    ------
    ParameterError
        For a condition that the model does not take or know, or a length that makes no sense.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    generator = loaded.generator
    if seconds is not None and not 0 < seconds <= LONGEST_S:
        raise ParameterError(f"seconds must be > 0 and at most {LONGEST_S:g}, got {seconds:g}")
    if seed < 0:
        raise ParameterError(f"seed must be >= 0, got {seed}")
    if not 1 <= count <= MOST:
        raise ParameterError(f"count must be at least 1 and at most {MOST}, got {count}")
    for drawn in seeds_of(seed, count):
        yield generator.generate(condition, seconds=seconds, seed=drawn)


def seeds_of(seed: int, count: int) -> list[int]:
    """Return the seed of each of ``count`` pieces; the first is ``seed`` itself."""
    return [seed, *(child_seed(seed, "generate", number) for number in range(1, count))]


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
    """Write ``count`` signals or images to ``out``, numbered ``NAME-1.wav`` and so on where there are several.

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
        was), ``rms`` per file; over displacement ``length_mm`` and ``rate_per_mm`` instead of seconds and Hz; of an
        image ``rows``, ``columns`` and ``simulated``. Where the model names the surface in a photograph: ``taken_for``
        and, if it gives one, ``confidence``; of several of a model without noise ``differ_by``.

    Raises
    ------
    ParameterError
        As `generate`; or if files of the suffix of ``out`` hold nothing that the model gives.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    known = suffixes_for(loaded.facts.gives)
    if out.suffix.lower() not in known:
        raise ParameterError(f"{out}: suffix must be one of {', '.join(known)}, got {out.suffix or 'none'}")
    seen: dict[str, Any] = {}
    if photograph is not None:
        image = read_image(photograph)
        condition = {**condition, "image": image}
        seen = _taken_for(loaded.model, image)
    more = {} if photograph is None else {"photograph": Path(photograph).name}
    facts = run_provenance(loaded, seed) | _named(condition) | more | seen
    if count > 1 and isinstance(loaded.model, NoiselessGenerator):
        seen["differ_by"] = loaded.model.variation
    return [
        write_made(numbered(out, number, count), made, facts | {"number": number}, simulated=loaded.simulated)
        | seen
        for number, made in enumerate(
            generate(loaded, condition, seconds=seconds, seed=seed, count=count), start=1
        )
    ]


def suffixes_for(gives: str) -> tuple[str, ...]:
    """Return the suffixes of files that can hold what a model gives, ``image`` or some kind of signal."""
    return (".png",) if gives == "image" else WRITABLE


def run_provenance(run: LoadedRun, seed: int) -> dict[str, Any]:
    """Return what is written into every file that a run made."""
    return {
        "generated_by": f"tactogram {run.facts.name}",
        "run": run.run.data["run_id"],
        "seed": seed,
        "simulated": run.simulated,
    }


def numbered(file: Path, number: int, count: int) -> Path:
    """Return ``file``, or where there are several the one of ``number``."""
    return file if count == 1 else file.with_name(f"{file.stem}-{number}{file.suffix}")


def write_made(
    file: Path, made: Signal | Image, metadata: Mapping[str, Any], *, simulated: bool
) -> dict[str, Any]:
    """Write a signal or an image and return what it is."""
    if isinstance(made, Image):
        write_image(file, made, metadata=metadata)
        rows, columns = made.size
        return {"file": str(file), "rows": rows, "columns": columns, "simulated": simulated}
    write_signal(file, made, metadata=metadata)
    extent = (
        {"seconds": made.seconds, "rate_hz": made.rate}
        if made.domain == "time"
        else {"length_mm": made.length_mm, "rate_per_mm": made.rate}
    )
    return {
        "file": str(file),
        **extent,
        "unit": made.unit,
        "axes": list(made.axes),
        "simulated": simulated,
        "rms": float((made.samples.astype(float) ** 2).mean() ** 0.5),
    }


def _named(condition: Condition) -> dict[str, Any]:
    """Return what of a condition can be written into a file."""
    return {
        name: value
        for name, value in condition.items()
        if value is not None and name not in ("image", "vibration")
    }


def _taken_for(model: object, image: Image) -> dict[str, Any]:
    """Return the known surface that a model classifies a photograph as, where it does."""
    if not isinstance(model, PhotographClassifier):
        return {}
    try:
        material, confidence = model.classify_photograph(image)
    except ParameterError:  # a variant without a label
        return {}
    found: dict[str, Any] = {"taken_for": material}
    return found if confidence is None else {**found, "confidence": round(float(confidence), 4)}


def parse_mix(text: str) -> dict[str, float]:
    """Return ``"cork=0.6,tile=0.4"`` as weights by material.

    Raises
    ------
    ParameterError
        If a part is not NAME=NUMBER, or a name stands twice.
    """
    return _numbers(text, option="--mix", number="WEIGHT")


def parse_words(text: str) -> dict[str, float]:
    """Return ``"rough=6,uneven=5"`` as scores by word.

    Raises
    ------
    ParameterError
        If a part is not WORD=NUMBER, or a word stands twice.
    """
    return _numbers(text, option="--words", number="SCORE")


def _numbers(text: str, *, option: str, number: str) -> dict[str, float]:
    found: dict[str, float] = {}
    for part in text.split(","):
        name, sign, value = part.rpartition("=")
        try:
            read = float(value)
        except ValueError:
            sign = ""
        if not (sign and name.strip()):
            raise ParameterError(f"{option} needs NAME={number},NAME={number}…, got {part!r}")
        if name.strip() in found:
            raise ParameterError(f"{option} names {name.strip()!r} twice")
        found[name.strip()] = read
    return found
