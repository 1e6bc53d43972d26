"""Verbs that generate signals and images."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tactogram.cli.files import loss_lines
from tactogram.cli.printing import Printer, text_of
from tactogram.cli.verbs import UsageError, Verb
from tactogram.workflows.evaluation.requests import MixRequest
from tactogram.workflows.generation.requests import CloneRequest
from tactogram.workflows.request import ON, PROCESSES, Argument, Option
from tactogram.workflows.signal_options import SignalOptions

if TYPE_CHECKING:
    from tactogram.workflows.training.loaded_run import LoadedRun

SHOWN = 8
"""Notes on the files of a table that are printed."""


@dataclass(frozen=True)
class _GenerateRequest(SignalOptions):
    runs: Annotated[
        Sequence[str],
        Argument(
            "one run, or two for an image and a vibration from the same words; `texture_flow` is that which comes with "
            "the package",
            "RUN",
        ),
    ]
    out: Annotated[
        str, Option("a signal (.wav …), haptic file (.ahap …) or image; a folder for words", "FILE")
    ]
    _: KW_ONLY
    material: Annotated[str | None, Option(metavar="NAME")] = None
    mix: Annotated[Mapping[str, float] | None, Option("weights by material", "A=0.6,B=0.4")] = None
    text: Annotated[
        str | None,
        Option("the surface in English, e.g. 'coarse cork'; with --image, both", "TEXT"),
    ] = None
    words: Annotated[Mapping[str, float] | None, Option("scores from 1 to 7 by word", "rough=6,sticky=2")] = (
        None
    )
    rest: Annotated[
        Literal["mean"] | None, Option("fill the other words with the mean over the run's rated items")
    ] = None
    like: Annotated[
        str | None,
        Option("fill the other words with the scores of this rated surface or image", "ITEM"),
    ] = None
    vibration: Annotated[str | None, Option("recording of the surface", "FILE")] = None
    vibration_speed: Annotated[float | None, Option("speed of that recording, mm/s", "MM_S")] = None
    vibration_force: Annotated[float | None, Option("force of that recording, N", "N")] = None
    vibration_contactor: Annotated[
        Literal["finger", "stylus"] | None, Option("what stroked in that recording")
    ] = None
    raters: Annotated[Sequence[str], Option("rater model that scores the result", "RUN", "--rater")] = ()
    image: Annotated[str | None, Option("photograph of the surface; also with --text or --words", "FILE")] = (
        None
    )
    speed: Annotated[float | None, Option("stroking speed, mm/s", "MM_S")] = None
    force: Annotated[float | None, Option("normal force, N", "N")] = None
    contactor: Annotated[Literal["finger", "stylus"] | None, Option("what strokes the surface")] = None
    motion: Annotated[
        str | None,
        Option(
            "motion of the finger instead of --speed and --force: a CSV as for `stream`, or a simulated hand",
            "simulated|FILE",
        ),
    ] = None
    seconds: Annotated[float | None, Option("length (default: the model's own)")] = None
    seed: Annotated[int, Option()] = 0
    count: Annotated[int, Option("number of results")] = 1
    conditions: Annotated[
        str | None,
        Option(
            "a file for each row of this table, whose columns are options (TOML: [[condition]]); --out is a folder",
            "CSV|TOML",
        ),
    ] = None
    on: Annotated[str, ON] = ""
    processes: Annotated[int | None, PROCESSES] = None


def _generate(request: _GenerateRequest, show: Printer) -> None:
    from tactogram.errors import ParameterError
    from tactogram.workflows.generation.generate import generate_files
    from tactogram.workflows.generation.photographs import description_text
    from tactogram.workflows.generation.word_scores import needs_words, some_words
    from tactogram.workflows.training.loaded_run import load_run

    if request.material and request.mix:
        raise UsageError("argument --mix: not allowed with argument --material")
    if request.conditions:
        _generate_many(request, show)
        return
    if request.on or request.processes:
        raise UsageError("--on and --processes are for --conditions")
    runs = [load_run(folder) for folder in request.runs]
    if len(runs) > 1 or request.rest or request.like or request.raters or needs_words(runs[0]):
        for name in (
            "material", "mix", "text", "image", "speed", "force", "motion", "vibration_speed", "vibration_force",
            "vibration_contactor", "contactor",
        ):  # fmt: skip
            if getattr(request, name) is not None:
                raise ParameterError(f"--{name.replace('_', '-')} is not for models conditioned on words")
        _generate_from_words(request, runs, show)
        return
    _check_described(request, runs[0])
    material = {request.material: 1.0} if request.material else request.mix
    condition = {
        "material": material,
        "text": request.text,
        "words": some_words(runs[0], request.words) if request.words else None,
        "speed_mm_s": request.speed,
        "force_n": request.force,
        "vibration_speed_mm_s": request.vibration_speed,
        "vibration_force_n": request.vibration_force,
        "vibration_contactor": request.vibration_contactor,
        "contactor": request.contactor,
    }
    written = generate_files(
        runs[0],
        {name: value for name, value in condition.items() if value is not None},
        Path(request.out),
        seconds=request.seconds,
        seed=request.seed,
        count=request.count,
        photograph=request.image,
        recording=request.vibration,
        reading=request.reading,
        motion=request.motion,
    )
    first = written[0]
    lines = [line for row in written for line in (row["file"], *loss_lines(row.get("written", {})))]
    if said := description_text(first):
        lines.append(said)
    if "differ_by" in first:
        lines.append(f"they differ by {first['differ_by']}")
    show({"files": written}, "\n".join(lines))
    show.notes(first.get("limited", ()))


def _check_described(request: _GenerateRequest, run: "LoadedRun") -> None:
    """Refuse a request that describes no surface, with a command that does."""
    from tactogram.errors import ParameterError

    _ = run.generator  # refuses a run that does not generate
    materials = run.kind.materials if run.facts.gives == "signal" else ()
    options = {
        "material": f"--material {shlex.quote(materials[0])}" if materials else "",
        "image": "--image photo.jpg" if run.run.data.get("photographs", {}).get("train") else "",
        "vibration": "--vibration stroke.wav",
        "words": "--words WORD=SCORE",
    }
    named = {"material": request.material or request.mix or request.text}
    wanted = [name for name in (*run.facts.needs, *run.facts.instead) if options.get(name)]
    if not wanted or any(named.get(name) or getattr(request, name, None) for name in wanted):
        return
    if request.image:
        raise ParameterError(
            f"{request.runs[0]} was not trained with photographs and predicts nothing from one; to draw its "
            f"brightness as a relief: tactogram convert {shlex.quote(str(request.image))} {request.out}"
        )
    known = f" (one of its {len(materials)}: {', '.join(materials[:5])}, …)" if len(materials) > 5 else ""
    what = " or ".join(f"--{name}" for name in wanted)
    raise ParameterError(
        f"{request.runs[0]} needs a surface to generate, by {what}{known}: tactogram generate {request.runs[0]} "
        f"{options[wanted[0]]} --out {request.out}"
    )


def _generate_many(request: _GenerateRequest, show: Printer) -> None:
    from tactogram.workflows.generation.many import generate_many

    taken = ("runs", "out", "conditions", "seconds", "seed", "on", "processes")
    changed = [field.name for field in fields(request) if getattr(request, field.name) != field.default]
    in_table = [name for name in changed if name not in taken]
    if len(request.runs) > 1 or in_table:
        names = ", ".join(f"--{name.replace('_', '-')}" for name in in_table) or "a second RUN"
        raise UsageError(f"--conditions states all but --seconds and --seed: omit {names}")
    options = {name: getattr(request, name) for name in taken if name not in ("runs", "out", "conditions")}
    with show.progress() as progress:
        written = generate_many(
            request.runs[0], str(request.conditions), request.out, **options, progress=progress
        )
    index = Path(request.out) / "generated.json"
    show({"files": written, "index": str(index)}, f"{len(written)} files in {request.out}\nindex: {index}")
    limited = [f"{row['file']}: {line}" for row in written for line in row.get("limited", ())]
    more = [f"{len(limited) - SHOWN} more: `limited` in {index}"] if len(limited) > SHOWN else []
    show.notes([*limited[:SHOWN], *more])


def _generate_from_words(request: _GenerateRequest, runs: list[Any], show: Printer) -> None:
    from tactogram.workflows.generation.words_to_touch import generate_from_words

    result = generate_from_words(
        runs,
        Path(request.out),
        words=request.words,
        rest=request.rest,
        like=request.like,
        vibration=request.vibration,
        reading=request.reading,
        raters=request.raters,
        seconds=request.seconds,
        seed=request.seed,
        count=request.count,
    )
    note = result["scores"][0]
    lines = [line for row in result["files"] for line in (row["file"], *loss_lines(row.get("written", {})))]
    lines.append(f"requested: {text_of(note['asked']) or 'nothing'}")
    if note["filled"]:
        lines.append(f"filled with the {note['filled_from']}: {text_of(note['filled'])}")
    for each in result["scores"]:
        number = f" {each['number']}" if len(result["scores"]) > 1 else ""
        lines += [
            f"used for the {what}{number}: {text_of(facts['taken'])}"
            for what, facts in each["made"].items()
            if "taken" in facts
        ]
        lines += [
            f"{what}{number} scored by {prediction['by']}: {text_of(prediction['scores'])}"
            for what, prediction in each.get("predicted", {}).items()
        ]
    if note["simulated"]:
        lines.append("trained on simulated data")
    show(result, "\n".join(lines))
    show.notes(line for made in note["made"].values() for line in made["limited"])


def _clone(request: CloneRequest, show: Printer) -> None:
    from tactogram.workflows.generation.clone import clone
    from tactogram.workflows.generation.photographs import description_text, facts_of_files

    with show.progress() as progress:
        run = clone(**vars(request) | {"progress": progress})
    about = run.facts()
    materials, limited = about["kind"]["materials"], about["notes"]
    facts = {"run": str(run.folder), "materials": materials} | ({"limited": limited} if limited else {})
    lines = [f"run: {run.folder}", f"materials: {', '.join(materials)}"]
    if photographs := facts_of_files(request.model, request.images):
        facts["photographs"] = photographs
        lines += [f"{name}: {text}" for name, seen in photographs.items() if (text := description_text(seen))]
    show(facts, "\n".join([*lines, f"tactogram stream {run.folder} --mix {materials[0]}=1"]))
    show.notes(limited)


def _mix(request: MixRequest, show: Printer) -> None:
    from tactogram.workflows.evaluation.mixing_ladder import mixing_ladder

    with show.progress() as progress:
        result = mixing_ladder(**vars(request) | {"progress": progress})
    show(result, f"{result['in_words']}\nfigure: {result['figure']}")


VERBS = {
    "clone": Verb(CloneRequest, _clone),
    "generate": Verb(_GenerateRequest, _generate, folders=("models",)),
    "mix": Verb(MixRequest, _mix, folders=("models",)),
}
