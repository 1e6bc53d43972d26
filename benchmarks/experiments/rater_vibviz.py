"""A rater model on VibViz: cross-validated error beside the constant guess, for each of its five ratings.

Needs the files of VibViz: ``--set data=FOLDER`` (as downloaded) or a store imported from them. Each rating is one mean
over people, so how well people agree cannot be told from it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.datasets import open_store
from tactogram.errors import DataError, ParameterError
from tactogram.workflows.data.stores import import_store
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.progress import ProgressCallback

FOLDS, REPEATS = 10, 5


def run(folder: Path, *, paper: bool, progress: ProgressCallback, data: str = "") -> dict[str, Any]:
    """Return the errors of each rating; ``paper`` draws the folds five times, else twice.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment.
    data : str
        Folder of the files, or a store.
    """
    if not data:
        raise ParameterError(
            "data must be a store of VibViz, or a folder with vibrationAnnotations*.csv and its WAV files"
        )
    try:
        store = open_store(data)
    except DataError:
        made = folder / "data"
        if not (made / "dataset.json").is_file():
            import_store("vibviz", data, made, progress=progress)
        store = open_store(made)
    found: dict[str, Any] = crossval(
        "rater",
        store.path,
        recipe="vibviz",
        folds=FOLDS,
        repeats=REPEATS if paper else 2,
        out=folder / "crossval",
        progress=progress,
    )
    lines = [
        f"Mean absolute error on {store.name}, {found['items']} vibrations, scale -3 to 3; {found['split']}",
        f"{'rating':14}{'predicted':>18}{'constant guess':>16}{'p':>10}{'rank correlation':>18}",
    ]
    for word, row in (*found["per_word"].items(), ("mean", found["mean"])):
        sd = f" ± {row['mae_sd']:.3f}" if row["mae_sd"] is not None else ""
        told = f"{row['mae']:.3f}{sd}"
        lines.append(
            f"{word:14}{told:>18}{row['constant_mae']:>16.3f}{row['p_against_constant']:>10.1g}"
            f"{row['rank_correlation']:>18.2f}"
        )
    return found | {"simulated": store.simulated, "text": "\n".join(lines)}
