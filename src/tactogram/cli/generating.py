"""Verbs that generate signals and images."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from tactogram.cli.files import loss_lines
from tactogram.cli.printing import text_of
from tactogram.cli.verbs import Verb

if TYPE_CHECKING:
    from tactogram.training.run import Run

SHOWN = 8
"""Notes on the files of a table that are printed."""


def _generated(result: dict[str, Any]) -> str:
    from tactogram.workflows.generation.photographs import description_text

    if "index" in result:
        files = result["files"]
        return f"{len(files)} files in {result['index'].rpartition('/')[0]}\nindex: {result['index']}"
    lines = [line for row in result["files"] for line in (row["file"], *loss_lines(row.get("written", {})))]
    if "scores" in result:
        return "\n".join([*lines, *_score_lines(result["scores"])])
    first = result["files"][0]
    lines += filter(None, [description_text(first)])
    if "differ_by" in first:
        lines.append(f"they differ by {first['differ_by']}")
    return "\n".join(lines)


def _score_lines(scores: list[dict[str, Any]]) -> list[str]:
    """Return the scores requested, filled, used and predicted."""
    note = scores[0]
    lines = [f"requested: {text_of(note['asked']) or 'nothing'}"]
    if note["filled"]:
        lines.append(f"filled with the {note['filled_from']}: {text_of(note['filled'])}")
    for each in scores:
        number = f" {each['number']}" if len(scores) > 1 else ""
        lines += [
            f"used for the {what}{number}: {text_of(facts['taken'])}"
            for what, facts in each["made"].items()
            if "taken" in facts
        ]
        lines += [
            f"{what}{number} scored by {prediction['by']}: {text_of(prediction['scores'])}"
            for what, prediction in each.get("predicted", {}).items()
        ]
    return [*lines, *(["trained on simulated data"] if note["simulated"] else [])]


def _limits(result: dict[str, Any]) -> Iterable[str]:
    if "scores" in result:
        return [line for generated in result["scores"][0]["made"].values() for line in generated["limited"]]
    if "index" not in result:
        return list(result["files"][0].get("limited", ()))
    lines = [f"{row['file']}: {line}" for row in result["files"] for line in row.get("limited", ())]
    more = [f"{len(lines) - SHOWN} more: limited in {result['index']}"] if len(lines) > SHOWN else []
    return [*lines[:SHOWN], *more]


def _clone_facts(run: "Run") -> dict[str, Any]:
    about = run.facts()
    facts = {"run": str(run.folder), "materials": about["kind"]["materials"]}
    facts |= {"limited": about["notes"]} if about["notes"] else {}
    return facts | {name: about[name] for name in ("photographs",) if name in about}


def _cloned(run: "Run") -> str:
    from tactogram.workflows.generation.photographs import description_text

    facts = _clone_facts(run)
    materials = facts["materials"]
    lines = [f"run: {run.folder}", f"materials: {', '.join(materials)}"]
    lines += [
        f"{name}: {text}"
        for name, seen in facts.get("photographs", {}).items()
        if (text := description_text(seen))
    ]
    return "\n".join([*lines, f"tactogram stream {run.folder} --mix {materials[0]}=1"])


def _mixed(result: dict[str, Any]) -> str:
    return f"{result['in_words']}\nfigure: {result['figure']}"


VERBS = {
    "clone": Verb(
        "tactogram.workflows.generation.clone:clone",
        _cloned,
        lambda run: run.facts()["notes"],
        facts=_clone_facts,
    ),
    "generate": Verb("tactogram.cli.combined:generate_to_files", _generated, _limits, folders=("models",)),
    "mix": Verb("tactogram.workflows.evaluation.mixing_ladder:mixing_ladder", _mixed, folders=("models",)),
}
