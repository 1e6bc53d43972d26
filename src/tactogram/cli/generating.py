"""Verbs that generate signals and images."""

from __future__ import annotations

from typing import Any

from tactogram.cli.options import Verbs, models_option
from tactogram.cli.printing import Arguments, print_result, text_of


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("generate", generate)
    add(
        "run_folders",
        metavar="RUN",
        nargs="+",
        help="one run, or two for an image and a vibration from the same words",
    )
    models_option(add)
    what = verbs.parser("generate").add_mutually_exclusive_group()
    what.add_argument("--material", metavar="NAME")
    what.add_argument("--mix", metavar="A=0.6,B=0.4", help="weights by material")
    add("--words", metavar="rough=6,sticky=2", help="scores from 1 to 7 by word")
    add("--rest", choices=("mean",), help="fill the other words with the mean over the run's rated items")
    add("--like", metavar="ITEM", help="fill the other words with the scores of this rated surface or image")
    add("--vibration", metavar="FILE", help="recording of the surface, for models that start from one")
    add("--rater", metavar="RUN", action="append", default=[], help="rater model that scores the result")
    add("--image", metavar="FILE", help="photograph of the surface")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    add("--seconds", type=float, help="length (default: the model's own)")
    add("--seed", type=int, default=0)
    add("--count", type=int, default=1, help="number of results (default %(default)s)")
    add(
        "--out",
        required=True,
        metavar="FILE",
        help=".wav, .flac, .csv, .npz, .xlsx or .png; a folder for words",
    )

    add = verbs.add("mix", mix)
    add("run_folder", metavar="RUN")
    add("start", metavar="A")
    add("end", metavar="B")
    models_option(add)
    add("--mode", choices=("sum", "add"), default="sum", help="weights that sum to 1, or A at 1 and B added")
    add("--steps", type=int, default=11, help="weights of B from 0 to 1 (default %(default)s)")
    add("--signals", type=int, default=6, help="signals measured at each step (default %(default)s)")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    add("--seconds", type=float, help="length of each (default: the model's own)")
    add("--seed", type=int, default=0)
    add("--out", metavar="DIR", help="folder for figure, sounds and JSON (default RUN/mixing/A-B-MODE)")


def generate(a: Arguments) -> None:
    """Generate signals or images with a trained run, or both from the same words with two."""
    from pathlib import Path

    from tactogram.errors import ParameterError
    from tactogram.workflows.generation.generate import generate_files, parse_mix
    from tactogram.workflows.generation.word_scores import conditions_on_words
    from tactogram.workflows.training.loaded_run import load_run

    runs = [load_run(folder) for folder in a.run_folders]
    by_words = {"words": a.words, "rest": a.rest, "like": a.like, "vibration": a.vibration, "rater": a.rater}
    if len(runs) > 1 or any(by_words.values()) or conditions_on_words(runs[0]):
        for name in ("material", "mix", "image", "speed", "force"):
            if getattr(a, name) is not None:
                raise ParameterError(f"--{name} is not for models conditioned on words")
        _generate_from_words(a, runs)
        return
    material = {a.material: 1.0} if a.material else parse_mix(a.mix) if a.mix else None
    condition = {"material": material, "speed_mm_s": a.speed, "force_n": a.force}
    condition = {name: value for name, value in condition.items() if value is not None}
    written = generate_files(
        runs[0],
        condition,
        Path(a.out),
        seconds=a.seconds,
        seed=a.seed,
        count=a.count,
        photograph=a.image,
    )
    seen = written[0]
    lines = [row["file"] for row in written]
    if "taken_for" in seen:
        sure = f", confidence {seen['confidence']:.2f}" if "confidence" in seen else ""
        lines.append(f"photograph classified as {seen['taken_for']}{sure}")
    if "differ_by" in seen:
        lines.append(f"they differ by {seen['differ_by']}")
    print_result(a, {"files": written}, "\n".join(lines))


def _generate_from_words(a: Arguments, runs: list[Any]) -> None:
    from pathlib import Path

    from tactogram.workflows.generation.generate import parse_words
    from tactogram.workflows.generation.words_to_touch import generate_from_words

    result = generate_from_words(
        runs,
        Path(a.out),
        words=parse_words(a.words) if a.words else None,
        rest=a.rest,
        like=a.like,
        vibration=a.vibration,
        raters=a.rater,
        seconds=a.seconds,
        seed=a.seed,
        count=a.count,
    )
    note = result["scores"][0]
    lines = [row["file"] for row in result["files"]]
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
            f"{what}{number} scored by {said['by']}: {text_of(said['scores'])}"
            for what, said in each.get("predicted", {}).items()
        ]
    if note["simulated"]:
        lines.append("trained on simulated data")
    print_result(a, result, "\n".join(lines))


def mix(a: Arguments) -> None:
    """Generate a ladder of mixes of two materials, and measure where each step lies."""
    from pathlib import Path

    from tactogram.workflows.evaluation.mixing_ladder import mixing_ladder
    from tactogram.workflows.progress import shown

    condition = {"speed_mm_s": a.speed, "force_n": a.force}
    with shown() as progress:
        result = mixing_ladder(
            a.run_folder,
            a.start,
            a.end,
            steps=a.steps,
            signals=a.signals,
            mode=a.mode,
            seconds=a.seconds,
            seed=a.seed,
            condition={name: value for name, value in condition.items() if value is not None},
            out=Path(a.out) if a.out else None,
            progress=progress,
        )
    print_result(a, result, f"{result['in_words']}\nfigure: {result['figure']}")
