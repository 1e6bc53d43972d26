"""Word scores of a request: some given, the others filled from ratings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from tactogram.datasets.ratings.ratings import SEVEN_POINT
from tactogram.datasets.ratings.words import word_of
from tactogram.errors import ParameterError, Remedy
from tactogram.workflows.training.loaded_run import LoadedRun

Rest = Literal["mean"]


@dataclass(frozen=True)
class WordRequest:
    """Scores of words, on the 7-point scale.

    ``given`` were requested, ``filled`` are the others, and ``filled_from`` describes their source. Words that no run
    needs may be missing.
    """

    given: Mapping[str, float]
    filled: Mapping[str, float] = field(default_factory=dict)
    filled_from: str = ""

    @property
    def scores(self) -> dict[str, float]:
        """Scores given and filled."""
        return {**self.filled, **self.given}

    def on_scale_of(self, run: LoadedRun) -> dict[str, float]:
        """Return the scores on the scale of a run's ratings, in the order of its words.

        Lowest is mapped to lowest, highest to highest. Of yes/no ratings it is the share of people: 4 is one half.
        """
        scaled = _on_scale(self.scores, run)
        return {word: scaled[word] for word in run.any_kind.words if word in scaled}

    def as_dict(self) -> dict[str, Any]:
        """Return JSON values: ``scale``, ``asked``, ``filled``, ``filled_from``, ``scores``."""
        return {
            "scale": [SEVEN_POINT.low, SEVEN_POINT.high],
            "asked": dict(self.given),
            "filled": {word: round(score, 4) for word, score in self.filled.items()},
            "filled_from": self.filled_from,
            "scores": {word: round(score, 4) for word, score in self.scores.items()},
        }


def ask(
    runs: Sequence[LoadedRun],
    words: Mapping[str, float] | None = None,
    *,
    rest: Rest | None = None,
    like: str | None = None,
) -> WordRequest:
    """Return the scores that condition ``runs``, which are of the same words.

    ``words`` are on the 7-point scale; the ten words of the studies may be in Japanese, romaji or any case. Missing
    scores are filled with the means over the rated items of the first run that has any (``rest``), or the measured
    means of the item ``like``, from the first run that has it; they stay open where no run needs them.

    Raises
    ------
    ParameterError
        For a run that is not conditioned on words, runs of different words, an unknown word or item, a score off the
        scale, or missing words, each by name.
    """
    names = _names(runs)
    scores = _checked(words or {}, names)
    missing = [word for word in names if word not in scores]
    if rest is not None and like is not None:
        raise ParameterError(
            "must fill missing scores alone", parameter="rest", remedy=Remedy("omit", "like")
        )
    if not missing or (rest is None and like is None and not any(map(needs_words, runs))):
        return WordRequest(scores)
    if like is not None:
        means, source = _of_item(runs, like)
    elif rest == "mean":
        means, source = _of_all(runs)
    elif rest is None:
        raise ParameterError(
            f"scores are missing for {', '.join(missing)}",
            remedy=(
                Remedy("give them in", "words"),
                Remedy("fill them with", "rest", "mean"),
                Remedy("with", "like"),
            ),
        )
    else:
        raise ParameterError.must("rest", "be mean", rest)
    return WordRequest(scores, {word: means[word] for word in missing}, source)


def some_words(run: LoadedRun, words: Mapping[str, float]) -> dict[str, float]:
    """Return the scores of some words, on the 7-point scale, as the ``words`` of a run's condition.

    They are on the scale of its ratings; errors are those of `ask`.
    """
    return _on_scale(_checked(words, _names([run])), run)


def rated_means(run: LoadedRun) -> dict[str, dict[str, float]]:
    """Return the mean scores of a run's training items, on the 7-point scale, by item and word."""
    words = run.any_kind.words
    return {
        item: {w: float(SEVEN_POINT.from_unit(m)) for w, m in zip(words, means, strict=True)}
        for item, means in run.model.rated_means.items()
        if np.isfinite(means).all()
    }


def needs_words(run: LoadedRun) -> bool:
    """Return whether a run needs scores of all its words."""
    return "words" in run.facts.needs


def scale_of(run: LoadedRun) -> tuple[float, float]:
    """Return the lowest and highest score of a run's ratings."""
    if run.any_kind.scale is None:
        raise ParameterError(f"{run.run.name}: states no scale of its ratings")
    return run.any_kind.scale


def _checked(words: Mapping[str, float], names: Sequence[str]) -> dict[str, float]:
    """Return valid scores in the order of ``names``."""
    scores: dict[str, float] = {}
    for name, score in words.items():
        word = name if name in names else word_of(name) or name
        if word in scores:
            raise ParameterError(f"words name {word!r} twice")
        scores[word] = float(score)
    for word, score in scores.items():
        if word not in names:
            raise ParameterError.must("words", f"be of {', '.join(names)}", word, choices=names)
        if not SEVEN_POINT.low <= score <= SEVEN_POINT.high:
            raise ParameterError(
                f"{word} must be {SEVEN_POINT.low:g} to {SEVEN_POINT.high:g}, the raters' scale; got {score:g}"
            )
    return {word: scores[word] for word in names if word in scores}


def _on_scale(scores: Mapping[str, float], run: LoadedRun) -> dict[str, float]:
    low, high = scale_of(run)
    return {word: low + float(SEVEN_POINT.to_unit(score)) * (high - low) for word, score in scores.items()}


def _names(runs: Sequence[LoadedRun]) -> tuple[str, ...]:
    for run in runs:
        if "words" not in run.facts.conditions or not run.any_kind.words:
            raise ParameterError(f"{run.run.name}: {run.facts.name} is not conditioned on words")
    first = runs[0]
    for other in runs[1:]:
        if set(other.any_kind.words) != set(first.any_kind.words):
            raise ParameterError.must(
                "runs",
                f"be of the same words: {first.run.name} has {', '.join(first.any_kind.words)}; "
                f"{other.run.name} has {', '.join(other.any_kind.words)}",
            )
    return first.any_kind.words


def _of_item(runs: Sequence[LoadedRun], item: str) -> tuple[dict[str, float], str]:
    known: list[str] = []
    for run in runs:
        means = rated_means(run)
        if item in means:
            return means[
                item
            ], f"measured means of {item}, as {run.run.name} learned from it{_simulated(run)}"
        known += means
    shown = ", ".join(known[:24]) + (f" and {len(known) - 24} more" if len(known) > 24 else "")
    raise ParameterError.must(
        "like", f"be one of {shown or 'nothing: no run holds rated items'}; got {item!r}"
    )


def _of_all(runs: Sequence[LoadedRun]) -> tuple[dict[str, float], str]:
    for run in runs:
        if means := list(rated_means(run).values()):
            every = {word: float(np.mean([m[word] for m in means])) for word in run.any_kind.words}
            return every, f"mean over the {len(means)} rated items of {run.run.name}{_simulated(run)}"
    remedy = Remedy("give all words in", "words")
    raise ParameterError("mean needs a run that holds rated items", parameter="rest", remedy=remedy)


def _simulated(run: LoadedRun) -> str:
    return " (simulated raters)" if run.simulated else ""
