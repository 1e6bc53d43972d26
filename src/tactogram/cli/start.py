"""Verbs for a first look: the installation check, the list of models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tactogram.cli.printing import columns, lines_of, terminal_width
from tactogram.cli.verbs import Verb

if TYPE_CHECKING:
    from tactogram.models import ModelInfo


def _doctor_text(facts: dict[str, Any]) -> str:
    lines = [f"tactogram {facts['tactogram']}, Python {facts['python']}, {facts['platform']}"]
    lines.append(
        f"device {facts['device']}, {facts['cores']} cores, {facts['threads']} threads, "
        f"{facts['memory_gib']} GiB memory"
    )
    lines += [f"  {name} {version or 'MISSING'}" for name, version in facts["packages"].items()]
    for name, extra in facts["extras"].items():
        state = f"missing {', '.join(extra['missing'])}" if extra["missing"] else "installed"
        lines.append(f"extra {name} ({extra['for']}): {state}")
    lines += [
        f"weights of {row['network']} ({row['for']}): {row['state']}: {row['file']}, SHA-256 {row['sha256_start']}…, "
        f"from {row['url']}"
        for row in facts["weights"]
    ]
    lines += [f"! {problem}" for problem in facts["problems"]] or ["no problems found"]
    return "\n".join(lines)


def describe_models(name: str | None = None, *, recipe: str = "quick") -> dict[str, Any]:
    """List the models, or show one with the settings that `train --set` takes.

    Parameters
    ----------
    name : str, optional
        Show one model: its recipes, and the settings that `train --set` takes.
    recipe : str
        Recipe whose values are shown, by name or file.

    Returns
    -------
    dict
        By name what is known of each model, its ``recipes``, and whether it comes ``trained``; of one model ``title``,
        ``conditions and output``, ``recipes``, and ``settings`` (``value`` and ``meaning`` by key).

    Raises
    ------
    ParameterError
        If there is no such model or recipe.
    """
    from tactogram.models import available, find, shipped_run
    from tactogram.workflows.training.recipe_fields import recipe_fields

    if name:
        model = find(name)
        return {
            "title": model.title,
            "conditions and output": _in_and_out(model),
            "recipes": list(model.recipes()),
            "settings": {
                each.key: {"value": each.value, "meaning": each.text} for each in recipe_fields(model, recipe)
            },
        }
    return {
        name: model.model_dump(mode="json", exclude={"folder", "package", "name"})
        | {
            "recipes": list(model.recipes()),
            "trained": shipped_run(name) is not None,
        }
        for name, model in available().items()
    }


def _models_text(facts: dict[str, Any]) -> str:
    from tactogram.models import available
    from tactogram.workflows.training.recipe_fields import text_of

    if "settings" in facts:
        settings = [("setting", "value", "meaning")]
        settings += [
            (key, text_of(each["value"]) or "-", each["meaning"]) for key, each in facts["settings"].items()
        ]
        about = lines_of({name: value for name, value in facts.items() if name != "settings"})
        return f"{about}\n{columns(settings, width=terminal_width())}"
    rows = [
        (
            name,
            str(model.year),
            _in_and_out(model),
            model.title + ("; comes trained" if facts[name]["trained"] else ""),
        )
        for name, model in available().items()
    ]
    return columns(rows, width=terminal_width())


def _in_and_out(model: ModelInfo) -> str:
    """Return the conditions of a model in each of its faces, in brackets if it needs none, and its output."""
    faces = []
    for face in model.faces:
        needs = "+".join(face.needs) or "+".join(f"[{name}]" for name in face.takes) or "-"
        faces.append(f"{'|'.join((needs, *face.instead))} -> {face.gives}")
    return " or ".join(faces)


VERBS = {
    "doctor": Verb("tactogram.workflows.doctor:doctor", _doctor_text),
    "models": Verb("tactogram.cli.start:describe_models", _models_text, folders=("models",)),
}
