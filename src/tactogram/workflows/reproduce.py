"""Run the experiment behind a published table or figure: every module of `tactogram.experiments` is one."""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from tactogram import experiments as package
from tactogram.errors import ParameterError
from tactogram.experiments._jobs import Jobs
from tactogram.signal.io.atomic import write_text
from tactogram.signal.io.writable import check_writable
from tactogram.workflows.capture.live import live
from tactogram.workflows.capture.session import capture
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram.workflows.data.stores import import_store
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.mixing_ladder import mixing_ladder, recorded
from tactogram.workflows.evaluation.pictures import compare_pictures, judge_pictures
from tactogram.workflows.evaluation.rating_crossval import crossval_ratings
from tactogram.workflows.evaluation.ratings import judge_reproduction, predicted_ratings
from tactogram.workflows.evaluation.word_signals import made_by_words
from tactogram.workflows.experiment_list import experiments
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.progress import Progress, silent
from tactogram.workflows.recognition.score import score
from tactogram.workflows.training.train import load_run, train


class AllJobs:
    """Every job that an experiment may call: a `tactogram.experiments._jobs.Jobs`."""

    def __init__(self, progress: Progress) -> None:
        self.simulate = partial(simulate_to_store, progress=progress)
        self.import_store = partial(import_store, progress=progress)
        self.crossval = partial(crossval, progress=progress)
        self.train = partial(train, progress=progress)
        self.evaluate = partial(evaluate, progress=progress)
        self.judge_pictures = partial(judge_pictures, progress=progress)
        self.crossval_ratings = partial(crossval_ratings, progress=progress)
        self.compare_pictures = partial(compare_pictures, progress=progress)
        self.mixing_ladder = partial(mixing_ladder, progress=progress)
        self.generate = generate
        self.made_by_words = made_by_words
        self.predicted_ratings = predicted_ratings
        self.judge_reproduction = judge_reproduction
        self.recorded = recorded
        self.load_run = load_run
        self.score = score
        self.capture = capture
        self.live = live


def reproduce(
    name: str,
    *,
    recipe: str = "bench",
    out: Path | str | None = None,
    options: Mapping[str, Any] | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Run the experiment ``name`` and return its result, also written to ``OUT/result.json``.

    Parameters
    ----------
    name : str
        One of `experiments`.
    recipe : {"bench", "paper"}
        ``bench`` is sized for two cores, ``paper`` is the published size.
    out : path, optional
        Folder for everything it makes; by default ``runs/NAME``. Data and finished runs that are there
        already are not made again.
    options : mapping, optional
        What the experiment leaves open, such as ``{"model": "ar_texture"}``: the keyword arguments of its ``run``
        that have a default.

    Returns
    -------
    dict
        The experiment's figures, and ``text``: its table, published beside ours.

    Raises
    ------
    ParameterError
        If there is no such experiment or recipe, it does not leave open what ``options`` name, or ``out`` cannot be
        written to.
    """
    if name not in experiments():
        raise ParameterError(f"experiment must be one of {', '.join(experiments())}, got {name!r}")
    if recipe not in ("bench", "paper"):
        raise ParameterError(f"--recipe must be bench or paper, got {recipe!r}")
    run = import_module(f"{package.__name__}.{name}").run
    left_open = [p.name for p in inspect.signature(run).parameters.values() if p.default is not p.empty]
    for key in options or {}:
        if key not in left_open:
            raise ParameterError(
                f"{name} leaves open {', '.join(left_open) or 'nothing'}; there is no option {key!r}"
            )
    folder = Path(out) if out else Path("runs") / name
    check_writable(folder, folder=True)
    folder.mkdir(parents=True, exist_ok=True)
    jobs: Jobs = AllJobs(progress)
    result: dict[str, Any] = run(jobs, folder, paper=recipe == "paper", **(options or {}))
    write_text(folder / "result.json", json.dumps(result, indent=1) + "\n")
    return result
