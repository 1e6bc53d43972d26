"""Verbs for a first look: the demo, the installation check, the list of models."""

from __future__ import annotations

from tactogram.cli.options import Verbs, models_option
from tactogram.cli.printing import Arguments, accuracies, columns, print_result, text_of


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("demo", demo)
    add("--out", default="runs/demo", help="folder for everything it makes (default %(default)s)")
    add("--seed", type=int, default=0)

    add = verbs.add("doctor", doctor)
    add(
        "--device",
        metavar="NAME",
        help="test one device: serial, lsl, daq, dwf (or digilent), audio, null, osc or mouse",
    )

    add = verbs.add("models", models)
    models_option(add)


def demo(a: Arguments) -> None:
    """Simulate, classify, search, generate and evaluate surfaces, and write a report."""
    from tactogram.workflows.demo import demo
    from tactogram.workflows.progress import shown

    with shown() as progress:
        result = demo(a.out, seed=a.seed, progress=progress)
    unmet = result["none_of_these"]
    text = [
        f"simulated strokes classified correctly: {accuracies(result)}",
        f"of {unmet['unknown']} strokes over a surface absent from training, "
        f"{100 * unmet['unknown_rejected']:.0f} % are classified as none of these",
        f"mixtures: {result['mixing']}",
        f"report with pictures and sounds (open it in a browser): {result['report']}",
        "to explore the same in the browser: tactogram studio",
    ]
    print_result(a, result, "\n".join(text))


def doctor(a: Arguments) -> None:
    """Check the installation: what is installed, what is missing and what for, and the compute device."""
    from tactogram.workflows.doctor import doctor

    if a.device:
        _device(a)
        return
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
    lines += [f"! {problem}" for problem in facts["problems"]] or ["no problems found"]
    print_result(a, facts, "\n".join(lines))


def _device(a: Arguments) -> None:
    from tactogram.workflows.rendering.devices import try_device

    facts = try_device(a.device)
    lines = [f"{facts['device']}: {facts['state']}: {facts['line']}"]
    lines += [f"  {name}: {text_of(value)}" for name, value in facts["facts"].items()]
    lines += [
        f"  {path['title']} ({path['direction']}): tested by simulation with: {path['simulated']}; "
        f"real hardware: {path['hardware']}"
        for path in facts["paths"]
    ]
    lines.append(f"  tactogram {facts['tactogram']}, Python {facts['python']}, {facts['platform']}")
    print_result(a, facts, "\n".join(lines))


def models(a: Arguments) -> None:
    """List the models."""
    from tactogram.models import available

    found = {
        name: m.model_dump(mode="json", exclude={"folder", "package", "name"})
        | {"recipes": list(m.recipes())}
        for name, m in available(a.models).items()
    }
    rows = [
        (name, str(m["year"]), f"{'+'.join(m['needs']) or '-'} -> {m['gives']}", m["title"])
        for name, m in found.items()
    ]
    print_result(a, found, columns(rows))
