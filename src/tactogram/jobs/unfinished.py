"""A run that still trains, as its last checkpoint has it: to see and hear what it makes so far."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tactogram import models
from tactogram.datasets import signal_kind
from tactogram.errors import ParameterError, RunError
from tactogram.jobs.generate import generate, made_by, write_made
from tactogram.jobs.rated import RatedData
from tactogram.jobs.training import LoadedRun, load_run, part_examples, test_part
from tactogram.model import Condition, Generator, Kind, RatedGenerator
from tactogram.signal import Image
from tactogram.training.run import Run

SAMPLE_S = 2.0


def load_unfinished(folder: Path | str, *, model_folders: Sequence[Path] = ()) -> LoadedRun:
    """Return the run in ``folder`` as its last checkpoint has it.

    Raises
    ------
    RunError
        If there is no checkpoint yet, or the data it learns from is gone.
    """
    from tactogram.training.checkpoint import load_state

    run = Run.open(Path(folder))
    path = run.folder / "checkpoint.safetensors"
    if not path.is_file():
        raise RunError(f"{run.folder}: has no checkpoint yet; wait for the first one")
    recipe, (store, split) = run.recipe, test_part(run)
    facts = models.find(recipe.model, model_folders)
    kind: Kind
    if facts.learns_from == "recordings":
        examples = part_examples(store, split, "train", recipe.prepare, label=run.data["label"])
        kind = signal_kind(examples, simulated=store.simulated)
    else:
        rated = RatedData(store, facts.learns_from)
        kind = rated.kind(rated.examples(split, "train", recipe.prepare))
    model = facts.build(facts.config(recipe.config), kind, seed=recipe.seed)
    state, _ = load_state(path)
    model.load_state(state)
    return LoadedRun(run, facts, recipe, kind, model)


def sample(folder: Path | str, *, number: int = 0, seed: int = 0) -> dict[str, Any]:
    """Write a sample of a generator into ``samples`` of its run: of its last checkpoint where it still trains.

    Parameters
    ----------
    folder : path
    number : int
        Which of its materials, photographs or rated items to go by, counted round.
    seed : int

    Returns
    -------
    dict
        ``file``, ``of`` (what it was asked for), ``stage`` and ``step`` (null of a finished run), and what
        `tactogram.jobs.generate.write_made` says.

    Raises
    ------
    ParameterError
        If the run does not generate.
    RunError
        If there is no checkpoint yet.
    """
    from tactogram.training.checkpoint import load_state

    folder = Path(folder)
    finished = Run.open(folder).finished
    loaded = load_run(folder) if finished else load_unfinished(folder)
    if not isinstance(loaded.model, Generator):
        raise ParameterError(f"{loaded.run.name}: {loaded.facts.name} does not generate")
    position: dict[str, Any] = {"stage": None, "step": None}
    if not finished:
        _, position = load_state(folder / "checkpoint.safetensors")
    of, condition = _condition(loaded, number)
    image = loaded.facts.gives == "image"
    [made] = generate(loaded, condition, seconds=None if image else SAMPLE_S, seed=seed)
    place = "end" if finished else f"stage{position['stage']}-step{position['step']:06d}"
    file = folder / "samples" / f"{place}-{number}{'.png' if isinstance(made, Image) else '.wav'}"
    facts = {**made_by(loaded, seed), **position, "of": of}
    return {**position, "of": of, **write_made(file, made, facts, simulated=loaded.simulated)}


def _condition(loaded: LoadedRun, number: int) -> tuple[str, Condition]:
    """Return what to ask a generator for, and how it is called."""
    needs = loaded.facts.needs
    if "words" in needs and isinstance(loaded.model, RatedGenerator):
        items = sorted(loaded.model.rated_means)
        item = items[number % len(items)]
        low, high = loaded.any_kind.scale or (0.0, 1.0)
        means = loaded.model.rated_means[item]
        words = zip(loaded.any_kind.words, means.tolist(), strict=True)
        return f"scores of {item}", {"words": {word: low + mean * (high - low) for word, mean in words}}
    if "image" in needs:
        store, split = test_part(loaded.run)
        held = sorted({material for _, material in _photographed(store, split)})
        material = held[number % len(held)]
        return f"photograph of {material}", {"image": store.photograph(store.photographs_of(material)[0])}
    materials = loaded.kind.materials
    material = materials[number % len(materials)]
    return material, {"material": {material: 1.0}}


def _photographed(store: Any, split: Any) -> list[tuple[str, str]]:
    """Return recordings of a split whose material has a photograph, with the material."""
    known = [(s.id, store.info(s.id).material) for s in (*split.test, *split.train)]
    found = [(id, material) for id, material in known if material and store.photographs_of(material)]
    if not found:
        raise ParameterError("no material of the run has a photograph to go by")
    return found
