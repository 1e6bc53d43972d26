"""Signals and images from a trained generator, to files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import Any

from tactogram.datasets.everyday import known_from
from tactogram.errors import ParameterError
from tactogram.features.text_classifier import plain
from tactogram.model import (
    Condition,
    Limit,
    check_condition,
    check_options,
    condition_options,
    material_weights,
)
from tactogram.parameters import checked
from tactogram.rendering.files.catalogue import format_for, formats_with, haptic_suffixes
from tactogram.rendering.files.conversion import write_haptic
from tactogram.rendering.motion.finger_path import followed
from tactogram.rendering.motion.recorded_motion import MotionFile, SimulatedHand
from tactogram.signal import Image, Signal
from tactogram.signal.io import WRITABLE, read_image, read_signal, write_image, write_signal
from tactogram.signal.motion import Motion
from tactogram.training.seeds import child_seed
from tactogram.workflows.generation.photographs import description_facts
from tactogram.workflows.generation.text_understanding import material_in, understand
from tactogram.workflows.generation.word_scores import some_words
from tactogram.workflows.training.loaded_run import LoadedRun, load_run

MOST = 100_000
"""Largest number of results at a time."""
LONGEST_S = 3600.0
"""Longest signal, s."""
SIMULATED, SIMULATED_S = "simulated", 10.0
"""A hand that is simulated, not a person's, and how long it moves by default, s."""


@checked
def generate(
    run: Path | str | LoadedRun,
    condition: Mapping[str, Any],
    *,
    seconds: float | None = None,
    seed: int = 0,
    count: int = 1,
) -> Iterator[Signal | Image]:
    """Return signals or images from a trained generator; number n of a seed is always the same.

    The first is made at once, so that the call itself refuses what is wrong; the others when they are asked for.
    Signals of different surfaces differ in noise; one surface keeps its noise at any speed, force and motion. What is
    outside of what the run learned counts as the nearest inside (`limits`).

    Parameters
    ----------
    run : Path, str or LoadedRun
        Run of a generator, or the name of one that comes with the package.
    condition : mapping
        Names from `tactogram.model.condition_types`, e.g. ``{"material": {"cork": 0.6, "tile": 0.4}}``; words are on
        the scale of the ratings that the run was trained on. ``text``, in English, may describe the material instead.
    seconds : float, optional
        Length of a signal; by default the model's own.
    seed : int
        Seed of the noise.
    count : int
        Number of results.

    Returns
    -------
    iterator of Signal or Image

    Raises
    ------
    ParameterError
        For a condition that the model does not take or know, or a length out of range.

    Examples
    --------
    >>> made = next(tactogram.generate("texture_flow", {"material": {"cork": 1}}, seconds=1))
    >>> made.unit, made.seconds
    ('m/s^2', 1.0)
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    if not 1 <= count <= MOST:
        raise ParameterError.must("count", f"be at least 1 and at most {MOST}", count)
    condition = checked_condition(loaded, condition, seconds, seed)
    first, *others = seeds_of(seed, count)
    result = loaded.generate(condition, seconds=seconds, seed=first)
    return chain((result,), (loaded.generate(condition, seconds=seconds, seed=drawn) for drawn in others))


def checked_condition(
    run: LoadedRun, condition: Condition, seconds: float | None, seed: int
) -> dict[str, Any]:
    """Return a condition as the model takes it; `ParameterError` for what `generate` refuses before it starts."""
    _ = run.generator  # refuses a run that does not generate
    _check(seconds, seed)
    if condition.get("motion") is not None:
        _check_motion(run)
    asked = with_materials(run, condition)
    needs = () if run.facts.instead else run.facts.needs
    check_condition(asked, needs=needs, takes=(*run.facts.conditions, "text", "latent"))
    if asked.get("material") is not None:
        material_weights(asked, run.any_kind.materials)
    return within(run, asked)


def limits(run: LoadedRun, condition: Condition) -> list[Limit]:
    """Return what of a condition is outside of what a run learned; ``str`` of each is a sentence."""
    return run.generator.limits(condition)


def within(run: LoadedRun, condition: Condition) -> dict[str, Any]:
    """Return a condition with words limited to the scores of what the run learned from; models limit the rest."""
    words = condition.get("words") or {}
    used = {limit.name: limit.used for limit in limits(run, condition) if limit.name in words}
    return {**condition, "words": {**words, **used}} if used else dict(condition)


def motion_of(source: Path | str, *, seconds: float | None = None, seed: int = 0) -> Motion:
    """Return the motion of a file (`MotionFile`, interpolated), or of a `SIMULATED` hand, followed as by a stream.

    Of a file it is the first ``seconds``, by default all. Raises `ParameterError` if the motion is shorter, or longer
    than `LONGEST_S`.
    """
    _check(seconds, seed)
    if source == SIMULATED:
        length = SIMULATED_S if seconds is None else seconds
        return followed(SimulatedHand(length, seed=seed), length)
    file = MotionFile(source)
    length = file.seconds if seconds is None else seconds
    if length > file.seconds:
        raise ParameterError.must("seconds", f"be at most the motion's {file.seconds:g}", length)
    if not 0 < length <= LONGEST_S:
        raise ParameterError(
            f"{source}: a motion must have two times or more, and last at most {LONGEST_S:g} s, got {length:g}; "
            "give seconds"
        )
    file.fill(length)
    return followed(file, length)


def _check(seconds: float | None, seed: int) -> None:
    if seconds is not None and not 0 < seconds <= LONGEST_S:
        raise ParameterError.must("seconds", f"be > 0 and at most {LONGEST_S:g}", seconds)
    if seed < 0:
        raise ParameterError.must("seed", "be >= 0", seed)


def _check_motion(loaded: LoadedRun) -> None:
    if "motion" not in loaded.facts.conditions:
        streams = "; a stream follows one: tactogram stream RUN --motion FILE --backend file --out FILE"
        raise ParameterError(
            f"{loaded.facts.name} takes no motion{streams if loaded.facts.gives == 'signal' else ''}"
        )


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
    options: Mapping[str, Any] | None = None,
    reading: Mapping[str, Any] | None = None,
) -> list[dict[str, Any]]:
    """Write ``count`` signals or images to ``out``, numbered ``NAME-1.wav`` and so on where there are several.

    Provenance, and whether the model was trained on simulated data, is written into the files.

    The other parameters are those of `generate`. ``options`` state conditions further to ``condition`` as text and
    files do (`tactogram.model.condition_options`); the names of the files are written into the results. A recording is
    filtered and resampled as those that the model was trained on, and read with the arguments ``reading`` of
    `read_signal`; a motion is that of `motion_of`.

    Returns
    -------
    list of dict
        ``file``, ``seconds``, ``rate_hz``, ``unit``, ``axes``, ``simulated`` (trained on simulated data), ``rms`` per
        file; over displacement ``length_mm`` and ``rate_per_mm`` instead of seconds and Hz; of an image ``rows``,
        ``columns`` and ``simulated``; of a haptic file also ``written``, as of `write_haptic`. The facts of
        `tactogram.workflows.generation.photographs.description_facts`; of a text the ``material`` that it describes,
        weight by name, and words ``not_understood``, if it is not predicted; of an everyday material what it was
        ``set_from``; of several results of a model without noise ``differ_by``; ``limited``, sentences, if something is
        outside of what was learned.

    Raises
    ------
    ParameterError
        As `generate`; or if the suffix of ``out`` is not for the model's kind of output.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    check_suffix(loaded, out)
    how = Reading(loaded, reading or {}, seconds, seed)
    condition = {**condition, **how.condition(options or {})}
    described = condition_facts(loaded, condition)
    if how.limited:
        described["limited"] = [*described.get("limited", ()), *how.limited]
    if count > 1 and loaded.model.variation:
        described["differ_by"] = loaded.model.variation
    facts = run_provenance(loaded, seed) | _named(condition) | how.files | described
    return [
        write_made(numbered(out, number, count), made, facts | {"number": number}, simulated=loaded.simulated)
        | described
        for number, made in enumerate(
            generate(loaded, condition, seconds=seconds, seed=seed, count=count), start=1
        )
    ]


def check_suffix(run: LoadedRun, out: Path) -> None:
    """Refuse a file whose suffix is not for the model's kind of output.

    Raises `ParameterError`.
    """
    known = suffixes_for(run.facts.gives)
    if out.suffix.lower() not in known:
        raise ParameterError(f"{out}: suffix must be one of {', '.join(known)}, got {out.suffix or 'none'}")


@dataclass(frozen=True)
class Reading:
    """Reader of the options of a condition: for a run, with arguments of `read_signal`, a length and a seed.

    ``files`` gets the names of the files that were read, by their key in the metadata of the results, and ``limited``
    sentences on what a recording lacks.
    """

    run: LoadedRun
    arguments: Mapping[str, Any]
    seconds: float | None = None
    seed: int = 0
    files: dict[str, str] = field(default_factory=dict)
    limited: list[str] = field(default_factory=list)

    def condition(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """Return the condition that the values of options state; None states nothing."""
        check_options(options)
        known, condition = condition_options(), {}
        for name, value in options.items():
            if value is None:
                continue
            condition_type, option = known[name]
            if option.read:
                module, _, function = option.read.partition(":")
                condition[condition_type.name] = getattr(import_module(module), function)(value, self)
            else:
                condition[condition_type.name] = value
            if option.file:
                self.files[option.file] = Path(value).name
        return condition


def read_photograph(file: Path | str, how: Reading) -> Image:
    """Return a photograph."""
    return read_image(file)


def read_words(words: Mapping[str, float], how: Reading) -> dict[str, float]:
    """Return scores from 1 to 7 on the scale of the run's ratings."""
    return some_words(how.run, words)


def read_recording(file: Path | str, how: Reading) -> Signal:
    """Return a recording of a surface as the run's model was trained on it."""
    recorded = read_signal(file, **how.arguments)
    how.limited.extend(how.run.missing_band(recorded))
    return how.run.prepare_vibration(recorded)


def read_motion(source: Path | str, how: Reading) -> Motion:
    """Return the motion of a file or of a simulated hand."""
    _check_motion(how.run)
    return motion_of(source, seconds=how.seconds, seed=how.seed)


def condition_facts(run: LoadedRun, condition: Condition) -> dict[str, Any]:
    """Return the facts of `generate_files` on what a condition describes, and on what of it is limited."""
    asked, text = with_materials(run, condition), condition.get("text")
    facts: dict[str, Any] = {} if text is None else {"text": text}
    if text is not None and "material" in asked:
        facts["material"] = asked["material"]
        if unknown := understand(text, run.any_kind.materials).unknown:
            facts["not_understood"] = list(unknown)
    facts |= description_facts(run, asked)
    if origins := set_from(run, asked.get("material")):
        facts["set_from"] = origins
    if limited := [*map(str, limits(run, asked))]:
        facts["limited"] = limited
    return facts


def suffixes_for(gives: str) -> tuple[str, ...]:
    """Return the suffixes of files for a model's output, ``image`` or some kind of signal: haptic files, too."""
    if gives == "image":
        return (".png",)
    return *WRITABLE, *(suffix for suffix in haptic_suffixes() if len(formats_with(suffix)) == 1)


def run_provenance(run: LoadedRun, seed: int) -> dict[str, Any]:
    """Return the metadata of every file that a run generated."""
    return {
        "generated_by": f"tactogram {run.facts.name}",
        "run": run.run.data["run_id"],
        "seed": seed,
        "simulated": run.simulated,
    }


def numbered(file: Path, number: int, count: int) -> Path:
    """Return ``file``, with a number if there are several."""
    return file if count == 1 else file.with_name(f"{file.stem}-{number}{file.suffix}")


def write_made(
    file: Path, made: Signal | Image, metadata: Mapping[str, Any], *, simulated: bool
) -> dict[str, Any]:
    """Write a signal or an image and return its facts."""
    if isinstance(made, Image):
        write_image(file, made, metadata=metadata)
        rows, columns = made.size
        return {"file": str(file), "rows": rows, "columns": columns, "simulated": simulated}
    kind, written = format_for(file), {}
    if kind is None:
        write_signal(file, made, metadata=metadata)
    else:
        written = {"written": write_haptic(file, made, format=kind.name, metadata=metadata)}
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
        **written,
    }


def _named(condition: Condition) -> dict[str, Any]:
    """Return the part of a condition that can be written into a file."""
    return {
        name: value
        for name, value in condition.items()
        if value is not None and name not in ("image", "vibration", "motion")
    }


def with_materials(run: LoadedRun, condition: Condition) -> dict[str, Any]:
    """Return a condition whose ``text``, if it has one, is replaced by the weights of the materials it describes.

    The name of a material, with no photograph, is that material. Another text stays for a run that predicts surfaces
    from text; otherwise it is a mix of the materials that it names (`text_understanding.understand`).

    Raises `ParameterError` if the model takes no material or knows none, a material is given too, or the text of a mix
    names none of them; `MissingExtraError` if it names several, without the extra ``text``.
    """
    asked = dict(condition)
    text = asked.pop("text", None)
    if text is None:
        return asked
    if asked.get("material") is not None:
        raise ParameterError("conditions 'material' and 'text' describe the surface twice; give one of them")
    materials = run.any_kind.materials
    if "material" not in run.facts.conditions or not materials:
        raise ParameterError(f"condition 'text' needs a run that knows materials; {run.run.name} knows none")
    if not isinstance(text, str) or not text.strip():
        raise ParameterError.must("text", "describe a material, e.g. 'corrugated cardboard'", text)
    if asked.get("image") is None and (named := [name for name in materials if plain(name) == plain(text)]):
        return asked | {"material": {named[0]: 1.0}}
    if run.model.prediction_facts(condition):
        return asked | {"text": text}
    return asked | {"material": material_in(text, materials)}


def set_from(run: LoadedRun, material: str | Mapping[str, float] | None) -> dict[str, str]:
    """Return what each everyday material named was set from, in words; empty for a run of other materials."""
    if run.run.data.get("materials", {}).get("name") != "everyday (simulated)":
        return {}
    named = {material} if isinstance(material, str) else {*(material or ())}
    return {name: known_from(name) for name in run.any_kind.materials if name in named}
