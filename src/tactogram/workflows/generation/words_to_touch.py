"""Words to touch: an image and a vibration from the same scores, in one call over one or two runs."""

from __future__ import annotations

import json
import mimetypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.datasets.ratings.ratings import SEVEN_POINT
from tactogram.errors import ParameterError
from tactogram.model import Predictor, SelectionReporter, SignalKind
from tactogram.signal import Image, Signal
from tactogram.signal.io import WRITABLE, read_signal
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.generation.generate import (
    generate,
    numbered,
    run_provenance,
    seeds_of,
    suffixes_for,
    write_made,
)
from tactogram.workflows.generation.word_scores import Rest, WordRequest, ask, scale_of
from tactogram.workflows.training.loaded_run import LoadedRun, load_run

NAMES = {"image": "image.png", "signal": "vibration.wav"}
"""What is written into a folder, by what a model gives."""
CALLED = {"image": "image", "signal": "vibration"}


def generate_from_words(
    runs: Sequence[Path | str | LoadedRun],
    out: Path,
    *,
    words: Mapping[str, float] | None = None,
    rest: Rest | None = None,
    like: str | None = None,
    vibration: Path | str | None = None,
    raters: Sequence[Path | str | LoadedRun] = (),
    seconds: float | None = None,
    seed: int = 0,
    count: int = 1,
) -> dict[str, Any]:
    """Write what each run makes of the same scores, and what was asked, filled and taken.

    Nothing is written before all of it is made.

    Parameters
    ----------
    runs : sequence of path or LoadedRun
        At most one that gives an image and one that gives a signal, of the same words.
    out : Path
        A folder: `NAMES` and ``scores.json``, numbered where there are several. With one run also a file of its format;
        the scores are then in the file's metadata alone.
    words, rest, like
        As of `tactogram.workflows.generation.word_scores.ask`.
    vibration : path, optional
        A recording for signal generators that start from one; without, they take a seeded one of their own.
    raters : sequence of path or LoadedRun
        Runs of predictors; each scores what it knows of what was made.
    seconds : float, optional
        Length of the signal.
    seed, count : int

    Returns
    -------
    dict
        ``files`` (as of `generate_files`), and ``scores``: what scores.json holds, per number.

    Raises
    ------
    ParameterError
        If runs, words, recording, length or raters do not go together.
    """
    loaded, judges = _loaded(runs), _loaded(raters)
    asked = ask(loaded, words, rest=rest, like=like)
    files = _files(loaded, out)
    recording = None if vibration is None else read_signal(vibration)
    if recording is not None and not any("vibration" in _conditions(run) for run in loaded):
        raise ParameterError(f"--vibration: no run goes by one ({', '.join(run.run.name for run in loaded)})")
    if seconds is not None and all(run.facts.gives == "image" for run in loaded):
        raise ParameterError("--seconds is for signals; an image has no length")
    for judge in judges:
        if not isinstance(judge.model, Predictor):
            raise ParameterError(f"--rater {judge.run.name}: {judge.facts.name} gives no scores")
    made = [_made(run, asked, recording, seconds=seconds, seed=seed, count=count) for run in loaded]
    notes: list[dict[str, Any]] = []
    for number, pieces in enumerate(zip(*made, strict=True), start=1):
        names = [numbered(file, number, count).name for file in files]
        note = _note(loaded, judges, asked, pieces, names) | {"seed": seed, "number": number}
        notes.append(note if vibration is None else note | {"vibration_from": Path(vibration).name})
    written: list[dict[str, Any]] = []
    for number, note in enumerate(notes, start=1):
        for run, file, each in zip(loaded, files, made, strict=True):
            piece, taken = each[number - 1]
            metadata = run_provenance(run, seed) | asked.as_dict() | {"taken": taken, "number": number}
            row = write_made(numbered(file, number, count), piece, metadata, simulated=run.simulated)
            written.append(row | {"run": str(run.run.folder)})
        if not _is_file(out):
            place = numbered(out / "scores.json", number, count)
            write_text(place, json.dumps(note, indent=1, ensure_ascii=False) + "\n")
    return {"files": written, "scores": notes}


def _loaded(runs: Sequence[Path | str | LoadedRun]) -> list[LoadedRun]:
    return [run if isinstance(run, LoadedRun) else load_run(run) for run in runs]


def _conditions(run: LoadedRun) -> tuple[str, ...]:
    return (*run.facts.needs, *run.facts.takes)


def _is_file(out: Path) -> bool:
    return out.suffix.lower() in (*WRITABLE, ".png")


def _files(runs: Sequence[LoadedRun], out: Path) -> list[Path]:
    """Return where each run's piece goes; refuses two of one kind, and a file for several."""
    gives = [run.facts.gives for run in runs]
    for run in runs:
        if run.facts.gives not in NAMES:
            raise ParameterError(f"{run.run.name}: {run.facts.name} does not generate")
    if len(set(gives)) < len(gives):
        raise ParameterError(
            f"runs must give one image and one vibration, got {' and '.join(CALLED[g] for g in gives)}; make them in "
            "calls of their own"
        )
    if not _is_file(out):
        media = mimetypes.guess_type(out.name)[0] is not None and not out.is_dir()
        if media or any(place.is_file() for place in (out, *out.parents)):
            raise ParameterError(f"--out must be a folder, {_shown(gives)}; got {out}")
        return [out / NAMES[g] for g in gives]
    if len(runs) > 1:
        raise ParameterError(f"--out must be a folder for {len(runs)} runs, got {out}")
    wanted = suffixes_for(gives[0])
    if out.suffix.lower() not in wanted:
        raise ParameterError(
            f"--out for {gives[0]}s must be a folder or end in {', '.join(wanted)}, got {out}"
        )
    return [out]


def _shown(gives: Sequence[str]) -> str:
    """Return which files may stand in a folder's place, in words."""
    if len(gives) > 1:
        return "with two runs always"
    return "or a file that ends in " + (".png" if gives[0] == "image" else ", ".join(WRITABLE))


def _made(
    run: LoadedRun,
    asked: WordRequest,
    recording: Signal | None,
    *,
    seconds: float | None,
    seed: int,
    count: int,
) -> list[tuple[Signal | Image, dict[str, Any]]]:
    """Return each piece, and what the model took for it where it says so: plate, cluster, spectrum."""
    condition: dict[str, Any] = {"words": asked.on_scale_of(run)}
    if recording is not None and "vibration" in _conditions(run):
        condition["vibration"] = recording
    length = seconds if run.facts.gives == "signal" else None
    pieces = generate(run, condition, seconds=length, seed=seed, count=count)
    return [
        (piece, _taken(run.model, condition, drawn))
        for piece, drawn in zip(pieces, seeds_of(seed, count), strict=True)
    ]


def _taken(model: object, condition: Mapping[str, Any], seed: int) -> dict[str, Any]:
    return dict(model.selection_for(condition, seed=seed)) if isinstance(model, SelectionReporter) else {}


def _note(
    runs: Sequence[LoadedRun],
    judges: Sequence[LoadedRun],
    asked: WordRequest,
    pieces: Sequence[tuple[Signal | Image, Mapping[str, Any]]],
    names: Sequence[str],
) -> dict[str, Any]:
    """Return what was asked, what each run took for its piece, and what rater models say of it."""
    note = asked.as_dict() | {
        "simulated": any(run.simulated for run in (*runs, *judges)),
        "made": {
            CALLED[run.facts.gives]: _facts(run, asked, taken) | {"file": name}
            for run, name, (_, taken) in zip(runs, names, pieces, strict=True)
        },
    }
    if judges:
        note["predicted"] = _predicted(judges, runs, [piece for piece, _ in pieces])
    return note


def _facts(run: LoadedRun, asked: WordRequest, taken: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "run": str(run.run.folder),
        "run_id": run.run.data["run_id"],
        "model": run.facts.name,
        "simulated": run.simulated,
        "scale": list(scale_of(run)),
        "scores": {word: round(score, 4) for word, score in asked.on_scale_of(run).items()},
        **({"taken": dict(taken)} if taken else {}),
    }


def _predicted(
    judges: Sequence[LoadedRun], runs: Sequence[LoadedRun], pieces: Sequence[Signal | Image]
) -> dict[str, Any]:
    """Return what rater models say of each piece that they know, on the 7-point scale."""
    found: dict[str, Any] = {}
    for judge in judges:
        of_signals = isinstance(judge.any_kind, SignalKind)
        for run, piece in zip(runs, pieces, strict=True):
            if isinstance(piece, Signal) is not of_signals:
                continue
            said = judge.predictor.predict(judge.prepare(piece) if isinstance(piece, Signal) else piece)
            low, high = scale_of(judge)
            found[CALLED[run.facts.gives]] = {
                "by": "a rater model" + (" of simulated raters" if judge.simulated else ""),
                "run": str(judge.run.folder),
                "scores": {
                    word: round(float(SEVEN_POINT.from_unit((score - low) / (high - low))), 4)
                    for word, score in said.items()
                },
            }
    if not found:
        names = ", ".join(judge.run.name for judge in judges)
        raise ParameterError(f"--rater: {names} knows none of what was made")
    return found
