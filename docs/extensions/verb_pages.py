"""Pages of the command line, one per verb, written from the functions before the pages are read."""

from importlib import import_module
from inspect import Parameter
from pathlib import Path

from sphinx.application import Sphinx

from tactogram.cli.catalogue import verb_places
from tactogram.cli.verbs import flags_of
from tactogram.parameters import parameters, summary

GUIDES = {
    "start": ("guide", "devices"),
    "data": ("data", "import", "ratings", "export"),
    "simulating": ("data", "simulated-raters", "five-minutes"),
    "training": ("runs", "scale", "scale-training", "measures", "export"),
    "generating": ("guide", "scale"),
    "recognising": ("measures",),
    "files": ("haptic-files", "haptic-formats", "engines", "table-files"),
    "rendering": ("displays",),
    "playing": (
        "streaming",
        "stream-displays",
        "stream-messages",
        "displays",
        "ultrasonic-display",
        "carrier-tracking",
        "electrovibration",
        "devices",
    ),
    "capturing": ("capture", "capture-sessions"),
    "studying": (
        "studies",
        "study-files",
        "study-tablets",
        "study-answers",
        "study-analysis",
        "study-accuracy",
    ),
    "studio": ("studio", "studio-data", "touch", "server-safety"),
    "benchmarking": ("benchmark", "benchmark-results", "results"),
}
"""Pages that explain the verbs of each module of the command line."""


def described(words: str) -> list[str]:
    """Return the Markdown lines of a verb: description, usage, and every argument and option."""
    module = verb_places()[words].module
    verb = import_module(module).VERBS[words]
    extra = module.partition(".")[0].removeprefix("tactogram").removeprefix("_")
    flags = flags_of(verb)
    known = parameters(verb.load())
    by_place = [one.name for one in known if flags[one.name] == one.name]
    usage = " ".join(["tactogram", words, *map(str.upper, by_place), "[options]"])
    lines = [
        f"{summary(verb.load())}\n",
        *([f"Comes with the extra `{extra}`: `pip install 'tactogram[{extra}]'`.\n"] if extra else []),
        f"```text\n{usage}\n```\n",
        f"```{{program}} tactogram {words}\n```\n",
    ]
    for one in known:
        option = flags[one.name] if isinstance(one.default, bool) else f"{flags[one.name]} {one.name.upper()}"
        name = one.name.upper() if one.name in by_place else option
        default = f" (default {one.default})" if one.default else ""
        required = one.default is Parameter.empty
        lines.append(f"````{{option}} {name}\n{one.text}{'' if required else default}\n````\n")
    return lines


def page(name: str) -> str:
    """Return the page of a verb, or of a group of verbs."""
    places = {words: place for words, place in verb_places().items() if words.split()[0] == name}
    guides = [guide for place in places.values() for guide in GUIDES[place.module.rpartition(".")[2]]]
    lines = [f"# {name}\n"]
    for words in places:
        lines += [*([] if words == name else [f"## {words}\n"]), *described(words)]
    links = ", ".join(f"{{doc}}`/{guide}`" for guide in dict.fromkeys(guides))
    return "\n".join([*lines, f"See also: {links}\n"])


def write_pages(app: Sphinx) -> None:
    """Write ``verbs/NAME.md``, each only if it changed, and the table of all verbs."""
    folder = Path(app.srcdir) / "verbs"
    folder.mkdir(exist_ok=True)
    names = dict.fromkeys(words.split()[0] for words in verb_places())
    pages = {f"{name}.md": page(name) for name in names}
    rows = [
        f"| {{doc}}`{words} </verbs/{words.split()[0]}>` | {place.help} |"
        for words, place in verb_places().items()
    ]
    pages["overview.md"] = "\n".join(["| verb | does |", "| --- | --- |", *rows, ""])
    for old in {path.name for path in folder.glob("*.md")} - set(pages):
        (folder / old).unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages before Sphinx looks for documents."""
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
