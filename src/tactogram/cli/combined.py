"""Functions of the verbs that combine several workflows: training, and generation."""

from __future__ import annotations

import shlex
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Optional

from tactogram.cli.verbs import UsageError, spelt
from tactogram.errors import ParameterError
from tactogram.parameters import Count, Parameter, checked, parameters, with_further
from tactogram.workflows.data.convert import READING, reading_parameters
from tactogram.workflows.evaluation.crossval import crossval  # noqa: F401  (its parameters are referred to)
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.train import train

if TYPE_CHECKING:
    from tactogram.cli.printing import Printer
    from tactogram.workflows.training.loaded_run import LoadedRun

Purpose = Literal["recognition", "generate", "photograph", "words", "rating"]
SIGNALS = (signal.SIGINT, signal.SIGTERM)


def _training_parameters() -> Iterator[Parameter]:
    """Yield the settings of `train`."""
    return (parameter for parameter in parameters(train) if parameter.name not in ("model", "data", "resume"))


@checked
@with_further(_training_parameters)
def train_or_resume(
    model: str | None = None,
    *,
    data: str | None = None,
    resume: str | None = None,
    purpose: Purpose | None = None,
    progress: ProgressCallback,
    show: Printer,
    **settings: Any,
) -> dict[str, Any] | None:
    """Train a model on a data set, or continue a run.

    ``settings`` are those of `train`.

    Parameters
    ----------
    model : str, optional
        Omit with --resume RUN or --for.
    data : str, optional
        As of `train`.
    resume : str, optional
        Continue RUN with its own settings; without RUN, the run in --out if its settings are the same.
    purpose : str, optional
        Instead of MODEL: the best one to recognise materials, to generate them by name, from photographs or from words,
        or to predict ratings.

    Returns
    -------
    dict
        ``run``, ``run_id``, ``validation`` and ``notes``; None in a further process.
    """
    from tactogram.datasets import open_store
    from tactogram.training.device import is_first_process
    from tactogram.workflows.training import execution
    from tactogram.workflows.training.model_choice import model_choice

    if resume:
        anew = {name: settings.pop(name) for name in settings.keys() - _OF_RESUMED}
        _refuse_settings(resume, {"model": model, "purpose": purpose, **anew})
        with _catch_stop_signals() as stop:
            run = execution.resume(resume, data=data, **settings, progress=progress, stop=stop)
    elif not data or bool(model) == bool(purpose):
        raise UsageError("needs --data DIR and MODEL or --for, or --resume RUN to continue a run")
    else:
        if purpose:
            model, own, why = model_choice(purpose, open_store(data), label=settings.get("label", "material"))
            show.notes([f"{model}: {why}"])
            settings = {"recipe": own} | settings
        with _catch_stop_signals() as stop:
            run = train(str(model), data, **settings, resume=resume is not None, progress=progress, stop=stop)
    if not is_first_process():
        return None
    facts = run.facts()
    return {
        "run": str(run.folder),
        "run_id": run.data["run_id"],
        "validation": facts["validation"],
        "notes": facts["notes"],
    }


_OF_RESUMED = {"accelerator", "devices", "logger", "model_folders"}
"""Settings of `train` that a resumed run takes."""


def _refuse_settings(resume: str, settings: Mapping[str, Any]) -> None:
    """Refuse settings of a training that has its own."""
    changed = ["MODEL" if name == "model" else spelt(name) for name, value in settings.items() if value]
    changed.sort(key=lambda option: (option.startswith("--"), option))
    if changed:
        raise UsageError(
            f"--resume {resume} continues the run with its own settings: omit {', '.join(changed)}, or start "
            "another run with --out"
        )


@contextmanager
def _catch_stop_signals() -> Iterator[Callable[[], bool]]:
    """Yield a function that is true after Ctrl-C or SIGTERM (a second ends at once); outside the main thread never."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    stopped = False
    before = {number: signal.getsignal(number) for number in SIGNALS}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def ask(number: int, frame: Any) -> None:
        nonlocal stopped
        stopped = True
        restore()

    for number in SIGNALS:
        signal.signal(number, ask)
    try:
        yield lambda: stopped
    finally:
        restore()


def _generation_parameters() -> Iterator[Parameter]:
    """Yield the options of every condition, and what is known of a recording."""
    from tactogram.model import condition_options

    for name, (_, option) in condition_options().items():
        annotation = getattr(option.kind, "__name__", str(option.kind))
        text = option.help[:1].upper() + option.help[1:]
        yield Parameter(name, annotation, Optional[option.kind], None, f"{text}.", False)  # noqa: UP045
    yield from reading_parameters()


@checked
@with_further(_generation_parameters)
def generate_to_files(
    runs: Sequence[str],
    *,
    out: str,
    rest: Literal["mean"] | None = None,
    like: str | None = None,
    raters: Sequence[str] = (),
    seconds: float | None = None,
    seed: int = 0,
    count: int = 1,
    conditions: str | None = None,
    on: str = "",
    processes: Count | None = None,
    progress: ProgressCallback,
    **stated: Any,
) -> dict[str, Any]:
    """Generate signals or images with a trained run, or both from the same words with two.

    Further parameters are the options of the conditions (`tactogram.model.condition_options`) and those of
    `tactogram.convert` on how a recording is read.

    Parameters
    ----------
    runs : sequence of str
        One run, or two for an image and a vibration from the same words; `texture_flow` is that which comes with the
        package.
    out : str
        A signal (.wav …), haptic file (.ahap …) or image; a folder for words.
    rest : str, optional
        Fill the other words with the mean over the run's rated items.
    like : str, optional
        Fill the other words with the scores of this rated surface or image.
    raters : sequence of str
        Rater model that scores the result.
    seconds : float, optional
        Length, by default the model's own.
    seed : int
        Of what is drawn.
    count : int
        Number of results.
    conditions : str, optional
        A file for each row of this table (CSV, or TOML: [[condition]]), whose columns are options; --out is a folder.
    on, processes
        As of `crossval`.

    Returns
    -------
    dict
        ``files``; of a table also ``index``; of words ``scores``.
    """
    from tactogram.workflows.generation.generate import generate_files
    from tactogram.workflows.generation.many import generate_many
    from tactogram.workflows.generation.word_scores import needs_words
    from tactogram.workflows.generation.words_to_touch import generate_from_words
    from tactogram.workflows.training.loaded_run import load_run

    stated = {name: value for name, value in stated.items() if value is not None}
    reading = {name: stated.pop(name) for name in READING if name in stated}
    of_words = {"rest": rest, "like": like, "raters": raters or None}
    if conditions:
        beside = {**stated, **of_words, **reading, "count": None if count == 1 else count}
        in_table = [spelt(name) for name, value in beside.items() if value is not None]
        if len(runs) > 1 or in_table:
            names = ", ".join(in_table) or "a second RUN"
            raise UsageError(f"--conditions states all but --seconds and --seed: omit {names}")
        written = generate_many(
            runs[0],
            conditions,
            out,
            seconds=seconds,
            seed=seed,
            on=on,
            processes=processes,
            progress=progress,
        )
        return {"files": written, "index": str(Path(out) / "generated.json")}
    if on or processes:
        raise UsageError("--on and --processes are for --conditions")
    loaded = [load_run(run) for run in runs]
    if len(loaded) > 1 or any(of_words.values()) or needs_words(loaded[0]):
        if others := stated.keys() - signature(generate_from_words).parameters.keys():
            raise ParameterError(f"{spelt(min(others))} is not for models conditioned on words")
        return generate_from_words(
            loaded, Path(out), **stated, rest=rest, like=like, reading=reading, raters=raters, seconds=seconds,
            seed=seed, count=count,
        )  # fmt: skip
    _check_described(loaded[0], runs[0], out, stated)
    written = generate_files(
        loaded[0], {}, Path(out), seconds=seconds, seed=seed, count=count, options=stated, reading=reading
    )
    return {"files": written}


def _check_described(run: LoadedRun, name: str, out: str, stated: Mapping[str, Any]) -> None:
    """Refuse options that describe no surface, with a command that does."""
    from tactogram.model import condition_options, condition_types

    _ = run.generator  # refuses a run that does not generate
    materials = run.kind.materials if run.facts.gives == "signal" else ()
    lacking = {"material": not materials, "image": not run.run.data.get("photographs", {}).get("train")}
    known, examples = condition_options(), {}
    for need in (*run.facts.needs, *run.facts.instead):
        option = next((candidate for candidate in condition_types()[need].options if candidate.example), None)
        if option is not None and not lacking.get(need):
            example = materials[0] if need == "material" else option.example
            examples[need] = f"{spelt(option.name)} {shlex.quote(example)}"
    named = {"material" if option == "text" else known[option][0].name for option in stated}
    if not examples or named & examples.keys():
        return
    if "image" in stated:
        raise ParameterError(
            f"{name} was not trained with photographs and predicts nothing from one; to draw its brightness as a "
            f"relief: tactogram convert {shlex.quote(str(stated['image']))} {out}"
        )
    several = f" (one of its {len(materials)}: {', '.join(materials[:5])}, …)" if len(materials) > 5 else ""
    what = " or ".join(example.split()[0] for example in examples.values())
    raise ParameterError(
        f"{name} needs a surface to generate, by {what}{several}: tactogram generate {name} "
        f"{next(iter(examples.values()))} --out {out}"
    )
