"""Words to touch: an image and a vibration from the same scores, in one call over one or two runs."""

from __future__ import annotations

import json
import mimetypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.datasets.ratings.ratings import SEVEN_POINT
from tactogram.errors import ParameterError
from tactogram.model import SignalKind
from tactogram.parameters import checked
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_signal
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.generation.generate import (
    generate,
    limits,
    numbered,
    run_provenance,
    seeds_of,
    suffixes_for,
    within,
    write_made,
)
from tactogram.workflows.generation.word_scores import Rest, WordRequest, ask, scale_of
from tactogram.workflows.training.loaded_run import LoadedRun, load_run

NAMES = {"image": "image.png", "signal": "vibration.wav"}
"""Files in a folder, by a model's kind of output."""
CALLED = {"image": "image", "signal": "vibration"}


@checked
def generate_from_words(
    runs: Sequence[Path | str | LoadedRun],
    out: Path,
    *,
    words: Mapping[str, float] | None = None,
    rest: Rest | None = None,
    like: str | None = None,
    vibration: Path | str | None = None,
    reading: Mapping[str, Any] | None = None,
    raters: Sequence[Path | str | LoadedRun] = (),
    seconds: float | None = None,
    seed: int = 0,
    count: int = 1,
) -> dict[str, Any]:
    """Generate with each run from the same scores, and write the results with the scores requested, filled and used.

    Nothing is written before everything is generated. Of ``runs`` at most one generates images and one signals, of the
    same words. ``out`` is a folder for `NAMES` and ``scores.json``, numbered if there are several; with one run it may
    be a file, whose metadata then holds the scores. ``words``, ``rest`` and ``like`` are those of
    `tactogram.workflows.generation.word_scores.ask`. ``vibration`` is a recording for signal generators that start from
    one; by default they draw one of their own. Each of ``raters``, runs of predictors, scores the results it can read.

    Returns
    -------
    dict
        ``files`` (as of `generate_files`), and ``scores``: the content of scores.json, per number.

    Raises
    ------
    ParameterError
        If runs, words, recording, length or raters do not go together.
    """
    loaded, rater_models = _loaded(runs), _loaded(raters)
    request = ask(loaded, words, rest=rest, like=like)
    files = _files(loaded, out)
    recording = None if vibration is None else read_signal(vibration, **reading or {})
    if recording is not None and not any("vibration" in run.facts.conditions for run in loaded):
        others = ", ".join(run.run.name for run in loaded)
        raise ParameterError.must("vibration", f"be omitted: no run starts from one ({others})")
    if seconds is not None and all(run.facts.gives == "image" for run in loaded):
        raise ParameterError("is for signals; an image has no length", parameter="seconds")
    for rater in rater_models:
        if rater.facts.task != "prediction":
            raise ParameterError.must("raters", f"give scores, unlike {rater.facts.name} of {rater.run.name}")
    results = [_made(run, request, recording, seconds=seconds, seed=seed, count=count) for run in loaded]
    notes: list[dict[str, Any]] = []
    for number, pieces in enumerate(zip(*results, strict=True), start=1):
        names = [numbered(file, number, count).name for file in files]
        note = _note(loaded, rater_models, request, pieces, names) | {"seed": seed, "number": number}
        notes.append(note if vibration is None else note | {"vibration_from": Path(vibration).name})
    written: list[dict[str, Any]] = []
    for number, note in enumerate(notes, start=1):
        for run, file, each in zip(loaded, files, results, strict=True):
            piece, taken = each[number - 1]
            facts = {
                "taken": taken,
                "number": number,
                "limited": note["made"][CALLED[run.facts.gives]]["limited"],
            }
            metadata = run_provenance(run, seed) | request.as_dict() | facts
            row = write_made(numbered(file, number, count), piece, metadata, simulated=run.simulated)
            written.append(row | {"run": str(run.run.folder)})
        if not _is_file(out):
            note_file = numbered(out / "scores.json", number, count)
            write_text(note_file, json.dumps(note, indent=1, ensure_ascii=False) + "\n")
    return {"files": written, "scores": notes}


def _loaded(runs: Sequence[Path | str | LoadedRun]) -> list[LoadedRun]:
    return [run if isinstance(run, LoadedRun) else load_run(run) for run in runs]


def _is_file(out: Path) -> bool:
    return out.suffix.lower() in (*suffixes_for("signal"), ".png")


def _files(runs: Sequence[LoadedRun], out: Path) -> list[Path]:
    """Return the file of each run's result; refuse two of one kind, and a file for several."""
    gives = [run.facts.gives for run in runs]
    for run in runs:
        if run.facts.gives not in NAMES:
            raise ParameterError(f"{run.run.name}: {run.facts.name} does not generate")
    if len(set(gives)) < len(gives):
        raise ParameterError.must(
            "runs",
            "give one image and one vibration",
            " and ".join(CALLED[g] for g in gives),
            remedy="make them in calls of their own",
        )
    if not _is_file(out):
        media = mimetypes.guess_type(out.name)[0] is not None and not out.is_dir()
        if media or any(path.is_file() for path in (out, *out.parents)):
            raise ParameterError.must("out", f"be a folder, {_shown(gives)}; got {out}")
        return [out / NAMES[g] for g in gives]
    if len(runs) > 1:
        raise ParameterError.must("out", f"be a folder for {len(runs)} runs", out)
    suffixes = suffixes_for(gives[0])
    if out.suffix.lower() not in suffixes:
        problem = f"for {gives[0]}s must be a folder or end in {', '.join(suffixes)}, got {out}"
        raise ParameterError(problem, parameter="out")
    return [out]


def _shown(gives: Sequence[str]) -> str:
    """Return the files that are accepted instead of a folder, in words."""
    if len(gives) > 1:
        return "with two runs always"
    return "or a file that ends in " + (", ".join(suffixes_for(gives[0])))


def _made(
    run: LoadedRun,
    request: WordRequest,
    recording: Signal | None,
    *,
    seconds: float | None,
    seed: int,
    count: int,
) -> list[tuple[Signal | Image, dict[str, Any]]]:
    """Return each result, and the plate, cluster or spectrum that the model selected for it."""
    condition: dict[str, Any] = {"words": request.on_scale_of(run)}
    if recording is not None and "vibration" in run.facts.conditions:
        condition["vibration"] = recording
    condition = within(run, condition)
    length = seconds if run.facts.gives == "signal" else None
    pieces = generate(run, condition, seconds=length, seed=seed, count=count)
    return [
        (piece, run.model.selection_for(condition, run.seed_of(condition, drawn)))
        for piece, drawn in zip(pieces, seeds_of(seed, count), strict=True)
    ]


def _note(
    runs: Sequence[LoadedRun],
    rater_models: Sequence[LoadedRun],
    request: WordRequest,
    pieces: Sequence[tuple[Signal | Image, Mapping[str, Any]]],
    names: Sequence[str],
) -> dict[str, Any]:
    """Return the scores, the selection of each run, and the scores predicted by rater models."""
    note = request.as_dict() | {
        "simulated": any(run.simulated for run in (*runs, *rater_models)),
        "made": {
            CALLED[run.facts.gives]: _facts(run, request, taken) | {"file": name}
            for run, name, (_, taken) in zip(runs, names, pieces, strict=True)
        },
    }
    if rater_models:
        note["predicted"] = _predicted(rater_models, runs, [piece for piece, _ in pieces])
    return note


def _facts(run: LoadedRun, request: WordRequest, taken: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "run": str(run.run.folder),
        "run_id": run.run.data["run_id"],
        "model": run.facts.name,
        "simulated": run.simulated,
        "scale": list(scale_of(run)),
        "scores": {word: round(score, 4) for word, score in request.on_scale_of(run).items()},
        **({"taken": dict(taken)} if taken else {}),
        "limited": [str(limit) for limit in limits(run, {"words": request.on_scale_of(run)})],
    }


def _predicted(
    rater_models: Sequence[LoadedRun], runs: Sequence[LoadedRun], pieces: Sequence[Signal | Image]
) -> dict[str, Any]:
    """Return the scores of rater models for each result they can read, on the 7-point scale."""
    predicted: dict[str, Any] = {}
    for rater in rater_models:
        of_signals = isinstance(rater.any_kind, SignalKind)
        for run, piece in zip(runs, pieces, strict=True):
            if isinstance(piece, Signal) is not of_signals:
                continue
            scores = rater.predictor.predict(rater.prepare(piece) if isinstance(piece, Signal) else piece)
            low, high = scale_of(rater)
            predicted[CALLED[run.facts.gives]] = {
                "by": "a rater model" + (" of simulated raters" if rater.simulated else ""),
                "run": str(rater.run.folder),
                "scores": {
                    word: round(float(SEVEN_POINT.from_unit((score - low) / (high - low))), 4)
                    for word, score in scores.items()
                },
            }
    if not predicted:
        names = ", ".join(rater.run.name for rater in rater_models)
        raise ParameterError(f"can score none of the results: {names}", parameter="raters")
    return predicted
