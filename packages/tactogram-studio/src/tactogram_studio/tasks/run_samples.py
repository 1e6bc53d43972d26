"""Samples of a generator at its last checkpoint, during training."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Split, Store, label_of, part_examples, signal_kind
from tactogram.errors import ParameterError, RunError
from tactogram.model import Condition, ImageKind, Kind, Model
from tactogram.signal import Image
from tactogram.training import Run, load_state
from tactogram.workflows import (
    LoadedRun,
    RatingData,
    generate,
    load_run,
    model_of,
    run_provenance,
    test_part,
    write_made,
)

SAMPLE_S = 2.0


def load_unfinished(folder: Path | str) -> LoadedRun:
    """Return the run in ``folder`` at its last checkpoint.

    Raises
    ------
    RunError
        If there is no checkpoint yet, or the training data is gone.
    """
    run = Run.open(Path(folder))
    path = run.folder / "checkpoint.safetensors"
    if not path.is_file():
        raise RunError(f"{run.folder}: has no checkpoint yet; wait for the first one")
    recipe, (store, split) = run.recipe, test_part(run)
    facts = model_of(run).of(images=not len(store))
    kind: Kind
    if facts.learns_from == "recordings":
        examples = part_examples(store, split, "train", recipe.prepare, label=run.data["label"])
        kind = signal_kind(examples, simulated=store.simulated)
    else:
        rated = RatingData(store, facts.learns_from)
        kind = rated.kind(rated.examples(split, "train", recipe.prepare))
    model = facts.build(facts.config(recipe.config, run=run.folder), kind, seed=recipe.seed)
    state, _ = load_state(path)
    model.load_state(state)
    return LoadedRun(run, facts, recipe, kind, model)


def sample_choices(folder: Path | str) -> list[str]:
    """Return the materials or items for a `sample`, sorted; no network is loaded.

    Raises
    ------
    RunError
        If there is no run, or its data is gone.
    """
    run = Run.open(Path(folder))
    facts = model_of(run)
    if "image" in facts.needs:
        return _photographed(*test_part(run))
    if run.finished:
        kind = run.kind()
        return sorted(kind.items if isinstance(kind, ImageKind) else kind.materials)
    store, split = test_part(run)
    if facts.of(images=not len(store)).learns_from == "images":
        keys = {region.key for region in split.photographs.get("train", ())}
        return sorted(item for item, held in store.photographs_by_material.items() if keys & set(held))
    named = (label_of(store.info(segment.id), run.data["label"]) for segment in split.train)
    return sorted({name for name in named if name is not None})


def sample(folder: Path | str, *, of: str | None = None, seed: int = 0) -> dict[str, Any]:
    """Write a sample of a generator, possibly unfinished, into ``samples`` of its run.

    ``of`` is one of `sample_choices`, by default the first.

    Returns
    -------
    dict
        ``file``, ``of``, ``stage`` and ``step`` (null of a finished run), and the facts of
        `tactogram.workflows.write_made`.

    Raises
    ------
    ParameterError
        If the run does not generate, or not of that.
    RunError
        If there is no checkpoint yet.
    """
    folder = Path(folder)
    finished = Run.open(folder).finished
    loaded = load_run(folder) if finished else load_unfinished(folder)
    generator = loaded.generator
    position: dict[str, Any] = {"stage": None, "step": None}
    if not finished:
        _, position = load_state(folder / "checkpoint.safetensors")
    name, description, condition = _condition(loaded, generator, of)
    image = loaded.facts.gives == "image"
    [content] = generate(loaded, condition, seconds=None if image else SAMPLE_S, seed=seed)
    stage_name = "end" if finished else f"stage{position['stage']}-step{position['step']:06d}"
    suffix = ".png" if isinstance(content, Image) else ".wav"
    file = folder / "samples" / f"{stage_name}-{re.sub(r'[^A-Za-z0-9_-]+', '-', name)}{suffix}"
    facts = {**run_provenance(loaded, seed), **position, "of": description}
    return {**position, "of": description, **write_made(file, content, facts, simulated=loaded.simulated)}


def _condition(loaded: LoadedRun, generator: Model, of: str | None) -> tuple[str, str, Condition]:
    """Return the material or item, a description of it, and the condition for a generator."""
    if generator.rated_means:
        item = _one(sorted(generator.rated_means), of)
        low, high = loaded.any_kind.scale or (0.0, 1.0)
        words = zip(loaded.any_kind.words, generator.rated_means[item].tolist(), strict=True)
        scores = {word: low + mean * (high - low) for word, mean in words if np.isfinite(mean)}
        return item, f"scores of {item}", {"words": scores}
    if "image" in loaded.facts.needs:
        store, split = test_part(loaded.run)
        material = _one(_photographed(store, split), of)
        image = store.photograph(store.photographs_of(material)[0])
        return material, f"photograph of {material}", {"image": image}
    material = _one(loaded.kind.materials, of)
    return material, material, {"material": {material: 1.0}}


def _one(known: Sequence[str], of: str | None) -> str:
    if of is not None and of not in known:
        raise ParameterError(f"a sample must be of one of {', '.join(known)}, got {of[:60]!r}")
    return known[0] if of is None else of


def _photographed(store: Store, split: Split) -> list[str]:
    """Return the materials of a split that have a photograph, sorted."""
    known = {store.info(segment.id).material for segment in (*split.test, *split.train)}
    materials = sorted(material for material in known if material and store.photographs_of(material))
    if not materials:
        raise ParameterError("no material of the run has a photograph")
    return materials
