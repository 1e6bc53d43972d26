"""Training plan: chosen recordings, their parts, the model and its configuration."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from tactogram import models
from tactogram.datasets import (
    Label,
    RecordingInfo,
    Segment,
    Split,
    Store,
    contiguous_blocks,
    label_of,
    open_store,
    signal_kind,
    split_fractions,
    split_last,
    split_photographs,
)
from tactogram.datasets.splits.split import By
from tactogram.errors import DataError, ParameterError, Remedy, RunError
from tactogram.model import Example, ModelConfig
from tactogram.recipe import Recipe, run_id
from tactogram.workflows.training.rated_examples import TEST_SHARE, VALIDATION_SHARE, RatingData
from tactogram.workflows.workers import absolute

if TYPE_CHECKING:
    from tactogram.training.run import Run

BLOCKS = 5
"""Contiguous blocks of which the last one of every recording is for testing."""
LOOKED_AT = 400
"""Recordings that are compared."""
GLANCE_S = 0.5
"""Length of each that is prepared, s (mm over displacement)."""


@dataclass(frozen=True)
class TrainingRequest:
    """Model, recipe, recordings and split of a training, as `tactogram.train` takes them."""

    model: str
    data: Path | str
    _: KW_ONLY
    recipe: str = "quick"
    changes: Mapping[str, Any] | None = None
    band: tuple[float, float] | None = None
    split: str = ""
    by: str = "recording"
    label: Label = "material"
    where: Mapping[str, str] | None = None
    accelerator: str = "auto"
    model_folders: Sequence[Path | str] = ()
    devices: int = 1
    logger: str | None = None

    @property
    def recipe_changes(self) -> dict[str, Any]:
        """Values of the recipe to change, by dotted key."""
        band = {} if self.band is None else {"prepare.band": list(self.band)}
        return dict(self.changes or {}) | band

    def for_workers(self) -> Self:
        """Return the request as a worker in another folder can carry it out."""
        return replace(
            self,
            data=absolute(self.data),
            recipe=absolute(self.recipe) if self.recipe.endswith(".toml") else self.recipe,
            model_folders=[absolute(folder) for folder in self.model_folders],
        )


@dataclass(frozen=True)
class TrainingPlan:
    """Plan of a training: the data and its parts, the model and its configuration."""

    store: Store
    facts: models.ModelInfo
    recipe: Recipe
    config: ModelConfig
    parts: Split
    rated: RatingData | None
    """Ratings, of a model that learns from them."""
    label: Label
    model_folders: tuple[Path, ...]

    @property
    def identity(self) -> str:
        """The run's id: a hash of everything that decides its result."""
        resolved = self.recipe.resolved(self.config) | {"split": self.parts.as_dict(), "label": self.label}
        return run_id(resolved, self.store.sha256)


def planned(request: TrainingRequest) -> TrainingPlan:
    """Return the plan of a training; no signal is prepared, nothing is written.

    Raises
    ------
    TactogramError
        If data and model do not fit, or a recipe, split or selection is not possible.
    """
    store = open_store(request.data)
    folders = tuple(Path(folder) for folder in request.model_folders)
    facts = models.find(request.model, folders).of(images=not len(store))
    recipe = Recipe.load(facts.recipe(request.recipe), changes=request.recipe_changes)
    index = select(store.index, request.where) if len(store) else []
    rated = None if facts.learns_from == "recordings" else RatingData(store, facts.learns_from)
    config = facts.config(recipe.config)
    split = request.split or ("all" if config.window_protocol else "")
    how: dict[str, Any] = {"split": split, "by": request.by, "seed": recipe.seed}
    if rated is not None:
        parts = rated.split(index, recipe.prepare, **how)
    elif split == "blocks":
        parts = block_splits(store, labelled(index, request.label), recipe, config, blocks=BLOCKS)[-1]
    else:
        parts = make_split(index, label=request.label, **how)
    if "image" in facts.needs or ("image" in facts.instead and store.photographs_by_material):
        parts = split_photographs(store, parts, seed=recipe.seed)
    return TrainingPlan(store, facts, recipe, config, parts, rated, request.label, folders)


def plan_of(run: Run, *, data: Path | str | None = None, model_folders: Sequence[Path] = ()) -> TrainingPlan:
    """Return the plan that the folder of ``run`` records; errors as of `resume`."""
    begun, recipe, parts = run.data, run.recipe, Split.load(run.folder / "split.json")
    if missing := {"path", "sha256", "label"} - begun.keys():
        raise RunError(
            f"{run.folder / 'data.json'}: damaged: lacks {', '.join(sorted(missing))}; train again"
        )
    path = data or begun["path"]
    try:
        store = open_store(path)
    except DataError as error:
        problem = f"its data is not at {path}: {error}"
        raise RunError(run.folder, problem, remedy=Remedy("give", "data")) from error
    if store.sha256 != begun["sha256"]:
        raise RunError(
            run.folder,
            f"{path} has changed since the run began",
            remedy=(Remedy("start another run"), Remedy("give the unchanged data set as", "data")),
        )
    folders = (*model_folders, *(Path(kept) for kept in begun.get("model_folders", ())))
    facts = models.find(recipe.model, folders).of(images=not len(store))
    rated = None if facts.learns_from == "recordings" else RatingData(store, facts.learns_from)
    config = facts.config(recipe.config, run=run.folder)
    return TrainingPlan(store, facts, recipe, config, parts, rated, begun["label"], folders)


def make_split(index: Sequence[RecordingInfo], *, split: str, by: By, seed: int, label: Label) -> Split:
    """Return the parts that ``split`` and ``by`` of a `TrainingRequest` describe, each with all classes."""
    index = labelled(index, label)
    if split.startswith("last="):
        number = split.removeprefix("last=")
        if not number.isdecimal():
            raise ParameterError.must("split", "have a number of recordings in last=N", split)
        if by != "recording":
            problem = f"last=N goes by recording and cannot keep {by}s together"
            raise ParameterError(problem, parameter="split", remedy=Remedy("omit it or", "by"))
        # The recording before these, if there are enough, calibrates "none of these".
        fewest = min(Counter(info.material for info in index).values())
        return split_last(index, int(number), validation=int(fewest > int(number) + 1))
    if split == "all":
        return Split(tuple(Segment(info.id) for info in index), (), (), by=by, seed=seed)
    if split:
        raise ParameterError.must("split", "be last=N, blocks or all", split)
    return split_fractions(index, by=by, test=TEST_SHARE, validation=VALIDATION_SHARE, seed=seed)


def block_splits(
    store: Store,
    index: Sequence[RecordingInfo],
    recipe: Recipe,
    config: ModelConfig,
    *,
    blocks: int,
    remedy: Remedy = Remedy("record longer, or use", "split", "all"),  # noqa: B008 - frozen
) -> list[Split]:
    """Return a split for each of ``blocks`` contiguous parts of every recording, one window apart from the others."""
    stream = recipe.prepare.stream_of(tuple(store.streams))
    seconds = {info.id: store.length(info.id, stream) / store.rate(info.id, stream) for info in index}
    rate = recipe.prepare.rate_of(store.rate(index[0].id, stream))
    gap = config.input_samples(rate) / rate
    if (shortest := min(seconds.values())) < 3 * gap * blocks:
        raise ParameterError(
            f"{blocks} blocks of a recording need at least {3 * gap * blocks:.3g} s, got {shortest:.3g} s",
            remedy=remedy,
        )
    return contiguous_blocks(index, seconds, blocks=blocks, gap_s=gap)


def labelled(index: Sequence[RecordingInfo], label: Label) -> list[RecordingInfo]:
    """Return ``index`` with the class of each recording as its material: splits distribute classes."""
    if not index:
        raise ParameterError("there are no recordings to learn from, only photographs")
    named = [replace(info, material=label_of(info, label)) for info in index]
    nameless = [info for info in named if info.material is None]
    if nameless:
        name = nameless[0].source or nameless[0].id
        remedy = Remedy("exclude it with", "where")
        raise ParameterError(f"recording {name} has no {label}", remedy=remedy)
    return named


def select(index: Sequence[RecordingInfo], where: Mapping[str, str] | None) -> list[RecordingInfo]:
    """Return the recordings whose fields, or labels, have the values of ``where``.

    Numbers are compared by value; ``A|B`` is either, ``!A|B`` neither, and an empty value none at all.

    Raises
    ------
    ParameterError
        If none has.
    """
    kept = [info for info in index if all(_has(info, key, value) for key, value in (where or {}).items())]
    if not kept:
        conditions = ", ".join(f"{key}={value}" for key, value in (where or {}).items()) or "anything"
        raise ParameterError(f"no recording has {conditions}")
    return kept


def _has(info: RecordingInfo, key: str, value: str) -> bool:
    if value.startswith("!"):
        return not _has(info, key, value[1:])
    if "|" in value:
        return any(_has(info, key, alternative) for alternative in value.split("|"))
    got = info.labels.get(key) if key in info.labels else getattr(info, key, None)
    if not value:
        return got is None
    if isinstance(got, float):
        try:
            return got == float(value)
        except ValueError:
            return False
    return got is not None and str(got) == str(value)


def check_training(request: TrainingRequest) -> dict[str, Any]:
    """Return the facts of a training that could be done, or refuse it as the training would.

    Rate, axes, unit and domain of `LOOKED_AT` recordings, even over the training part, are compared by a short
    piece of one of each sort. Faults that only whole recordings show, such as a short one, come later.

    Returns
    -------
    dict
        ``train``, ``validation``, ``test`` (recordings, or rated items, in each part), ``materials``, ``rate``,
        ``unit`` and ``axes`` of the signals (null of models that learn from ratings), ``simulated``.

    Raises
    ------
    TactogramError
        In one sentence: the mismatch, and what to do.
    """
    plan = planned(request)
    parts = {part: len(held) for part, held in plan.parts.parts.items()}
    facts: Mapping[str, Any] = {"materials": [], "rate": None, "unit": None, "axes": None}
    if plan.rated is None:
        kind = signal_kind(_glances(plan), simulated=plan.store.simulated)
        facts = {
            "materials": list(kind.materials),
            "rate": kind.rate,
            "unit": kind.unit,
            "axes": list(kind.axes),
        }
    return {**parts, **facts, "simulated": plan.store.simulated}


def _glances(plan: TrainingPlan) -> list[Example]:
    """Return a short prepared piece of one recording of each rate and set of axes."""
    store, prepare = plan.store, plan.recipe.prepare
    ids = list(dict.fromkeys(segment.id for segment in plan.parts.train))
    if not ids:
        raise ParameterError("there are no examples: the part of the split is empty")
    pieces: dict[tuple[Any, ...], Example] = {}
    for id in ids[:: -(-len(ids) // LOOKED_AT)]:
        stream = prepare.stream_of(store.streams_of(id))
        rate = store.rate(id, stream)
        piece = store.signal(id, stream, stop=min(store.length(id, stream), max(64, round(GLANCE_S * rate))))
        material = store.info(id).material
        sort = (piece.rate, piece.axes, piece.unit, piece.domain, material)
        if sort not in pieces:
            pieces[sort] = Example(id, prepare.apply(piece), material)
    return list(pieces.values())
