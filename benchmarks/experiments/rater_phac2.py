"""Adjectives of PHAC-2's sixty objects from a robot's touch, whole objects held out: AUC of two regressions.

Needs the files: ``--set data=FOLDER`` with ``object_adjectives.csv`` and ``phac2_static_features.npz``. There are no
waveforms, so that the rater model's features cannot be had; what is tried is its regression on the statistics that
the files hold, beside a plain logistic regression. Adjectives of one object are left out: with that object held out,
nothing is left to learn from.
"""

from __future__ import annotations

from pathlib import Path
from statistics import mean, stdev
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from benchmarks.experiments.phac2 import AdjectiveTrials, read_phac2
from tactogram.errors import DataError, ParameterError
from tactogram.models.rater import Config
from tactogram.models.rater.regression import fit_regression
from tactogram.workflows.progress import ProgressCallback

FOLDS = 10
STRENGTH = 0.1
"""Of the logistic regression, scikit-learn's C; fixed, not searched for."""
REFERENCE = 0.80
"""About what plain logistic regression reaches with whole objects held out."""
Floats = NDArray[np.float64]


def run(
    folder: Path, *, paper: bool, progress: ProgressCallback, data: str = "", seeds: int = 0
) -> dict[str, Any]:
    """Return the area under the ROC curve of each adjective over held-out objects, mean and sd over drawings.

    An object's score is the mean over its ten trials. Scores of all folds are put in order together.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment.
    data : str
        Folder of the files.
    seeds : int
        Drawings of the folds; by default 5 with ``paper``, else 2.
    """
    if not data:
        raise ParameterError("data must be a folder with object_adjectives.csv and phac2_static_features.npz")
    held = read_phac2(data)
    several = [number for number, row in enumerate(held.table.T) if 1 < row.sum() < len(row) - 1]
    drawings = seeds or (5 if paper else 2)
    found: dict[str, list[Floats]] = {"logistic regression": [], "rater's regression": []}
    for seed in range(drawings):
        folds = drawn_folds(held.table[:, several], seed)
        for name, scored in (("logistic regression", _logistic), ("rater's regression", _rater)):
            scores = np.full(held.table.shape, np.nan)
            for unseen in folds:
                scores[unseen] = scored(held, unseen, several, seed)
            found[name].append(
                np.array([roc_auc_score(held.table[:, n], scores[:, n]) for n in several], np.float64)
            )
    rows = {
        name: {
            "mean_auc": mean(float(aucs.mean()) for aucs in drawn),
            "sd": stdev(float(aucs.mean()) for aucs in drawn) if len(drawn) > 1 else None,
            "per_adjective": {
                held.adjectives[n]: float(value)
                for n, value in zip(several, np.mean(drawn, axis=0), strict=True)
            },
        }
        for name, drawn in found.items()
    }
    result: dict[str, Any] = {
        "data": "PHAC-2 adjectives",
        "simulated": False,
        "objects": len(held.objects),
        "adjectives": len(several),
        "left_out": [name for n, name in enumerate(held.adjectives) if n not in several],
        "split": f"{FOLDS} folds by object, drawn {drawings} times",
        "reference": REFERENCE,
        "rows": rows,
    }
    return result | {"text": _text(result)}


def drawn_folds(table: NDArray[np.bool_], seed: int) -> list[NDArray[np.int64]]:
    """Return the objects of each fold, drawn until no adjective has all its objects, or all others, in one fold.

    Parameters
    ----------
    table : bool array, shape (object, adjective)
        Each adjective of two objects or more, and not of all but one.

    Raises
    ------
    DataError
        If 1,000 drawings bring none.
    """
    rng = np.random.default_rng(seed)
    for _ in range(1000):
        folds = np.array_split(rng.permutation(len(table)), FOLDS)
        held = np.array([table[unseen].sum(0) for unseen in folds])
        others = np.array([(~table[unseen]).sum(0) for unseen in folds])
        if (held < table.sum(0)).all() and (others < (~table).sum(0)).all():
            return folds
    raise DataError(
        f"no {FOLDS} folds of {len(table)} objects leave every adjective with two classes to learn from"
    )


def _logistic(held: AdjectiveTrials, unseen: NDArray[np.int64], several: list[int], seed: int) -> Floats:
    """Return scores of the unseen objects, shape (object, adjective)."""
    known = ~np.isin(held.trial_object, unseen)
    scores = np.full((len(unseen), len(held.adjectives)), np.nan)
    for n in several:
        model = make_pipeline(StandardScaler(), LogisticRegression(C=STRENGTH, max_iter=500))
        model.fit(held.features[known], held.labels[known, n])
        said = model.decision_function(held.features[~known])
        scores[:, n] = [said[held.trial_object[~known] == one].mean() for one in unseen]
    return scores


def _rater(held: AdjectiveTrials, unseen: NDArray[np.int64], several: list[int], seed: int) -> Floats:
    """Return scores of the unseen objects, shape (object, adjective)."""
    known = ~np.isin(held.trial_object, unseen)
    model = fit_regression(
        held.features[known],
        held.labels[known].astype(np.float64),
        items=[held.objects[n] for n in held.trial_object[known]],
        weights=np.ones(int(known.sum())),
        blocks=(held.features.shape[1],),
        config=Config(kernels=("linear",)),
        rng=np.random.default_rng(seed),
    )
    said = model.unbounded(held.features[~known])
    return np.array([said[held.trial_object[~known] == one].mean(0) for one in unseen])


def _text(result: dict[str, Any]) -> str:
    lines = [
        f"AUC of {result['adjectives']} adjectives, {result['objects']} objects, {result['split']}; "
        f"plain logistic regression was found to reach about {result['reference']:.2f}"
    ]
    for name, row in result["rows"].items():
        sd = "" if row["sd"] is None else f" ± {row['sd']:.3f}"
        lines.append(f"{name:22}{row['mean_auc']:.3f}{sd}")
    lines.append(f"left out, of one object each: {', '.join(result['left_out'])}")
    return "\n".join(lines)
