"""Verbs for a first look: the demo, the installation check, the list of models."""

from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Annotated

from tactogram.cli.printing import Printer, accuracies, columns, lines_of, terminal_width
from tactogram.cli.verbs import Verb
from tactogram.workflows.request import Argument, Option, Request

if TYPE_CHECKING:
    from tactogram.models import ModelInfo


@dataclass(frozen=True)
class _DemoRequest(Request):
    out: Annotated[str, Option("folder for everything it makes")] = "runs/demo"
    seed: Annotated[int, Option()] = 0


@dataclass(frozen=True)
class _DoctorRequest(Request):
    pass


@dataclass(frozen=True)
class _ModelsRequest(Request):
    name: Annotated[
        str | None,
        Argument("show one model: its recipes, and the settings that `train --set` takes", "MODEL"),
    ] = None
    _: KW_ONLY
    recipe: Annotated[str, Option("recipe whose values are shown", "NAME|FILE")] = "quick"


def _demo(request: _DemoRequest, show: Printer) -> None:
    from tactogram.workflows.demo import demo

    with show.progress() as progress:
        result = demo(request.out, seed=request.seed, progress=progress)
    unmet = result["none_of_these"]
    text = [
        f"simulated strokes classified correctly: {accuracies(result)}",
        f"of {unmet['unknown']} strokes over a surface absent from training, "
        f"{100 * unmet['unknown_rejected']:.0f} % are classified as none of these",
        f"mixtures: {result['mixing']}",
        f"report with pictures and sounds (open it in a browser): {result['report']}",
        "to explore the same in the browser: tactogram studio",
    ]
    show(result, "\n".join(text))


def _doctor(request: _DoctorRequest, show: Printer) -> None:
    from tactogram.workflows.doctor import doctor

    facts = doctor()
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
        f"weights of {one['network']} ({one['for']}): {one['state']}: {one['file']}, SHA-256 {one['sha256_start']}…, "
        f"from {one['url']}"
        for one in facts["weights"]
    ]
    lines += [f"! {problem}" for problem in facts["problems"]] or ["no problems found"]
    show(facts, "\n".join(lines))


def _models(request: _ModelsRequest, show: Printer) -> None:
    from tactogram.models import available, shipped_run

    if request.name:
        _model(request.name, request.recipe, show)
        return
    models = available()
    trained = {name: shipped_run(name) is not None for name in models}
    rows = [
        (
            name,
            str(model.year),
            " or ".join(map(_in_and_out, model.faces)),
            model.title + "; comes trained" * trained[name],
        )
        for name, model in models.items()
    ]
    facts = {
        name: model.model_dump(mode="json", exclude={"folder", "package", "name"})
        | {"recipes": list(model.recipes()), "trained": trained[name]}
        for name, model in models.items()
    }
    show(facts, columns(rows, width=terminal_width()))


def _model(name: str, recipe: str, show: Printer) -> None:
    from tactogram.models import find
    from tactogram.workflows.training.recipe_fields import recipe_fields, text_of

    model = find(name)
    fields = recipe_fields(model, recipe)
    rows = [("setting", "value", "meaning")]
    rows += [(each.key, text_of(each.value) or "-", each.text) for each in fields]
    about = {
        "title": model.title,
        "conditions and output": " or ".join(map(_in_and_out, model.faces)),
        "recipes": list(model.recipes()),
    }
    facts = about | {"settings": {each.key: {"value": each.value, "meaning": each.text} for each in fields}}
    show(facts, f"{lines_of(about)}\n{columns(rows, width=terminal_width())}")


def _in_and_out(model: "ModelInfo") -> str:
    """Return the conditions of a model, in brackets if it needs none, and its output."""
    needs = "+".join(model.needs) or "+".join(f"[{name}]" for name in model.takes) or "-"
    return f"{'|'.join((needs, *model.instead))} -> {model.gives}"


VERBS = {
    "demo": Verb(_DemoRequest, _demo),
    "doctor": Verb(_DoctorRequest, _doctor),
    "models": Verb(_ModelsRequest, _models, folders=("models",)),
}
