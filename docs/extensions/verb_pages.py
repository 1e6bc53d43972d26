"""Pages of the command line, one per verb, written from the argument parser before the pages are read."""

import argparse
from functools import partial
from importlib import import_module
from inspect import Parameter
from pathlib import Path

from sphinx.application import Sphinx

from tactogram.cli.functions import FunctionVerb, flags_of
from tactogram.cli.parser import make_parser, verb_places
from tactogram.parameters import parameters, summary

GUIDES = {
    "start": ("guide", "devices"),
    "data": ("data", "import", "ratings", "simulated-raters", "export"),
    "training": ("runs", "scale", "scale-training", "measures", "export"),
    "generating": ("guide", "scale"),
    "recognising": ("measures",),
    "files": ("haptic-files", "haptic-formats", "engines", "table-files"),
    "rendering": ("displays",),
    "actuating": ("ultrasonic-display", "carrier-tracking", "electrovibration", "devices"),
    "streaming": ("streaming", "stream-displays", "stream-messages"),
    "capturing": ("capture", "capture-sessions"),
    "studying": ("studies", "study-files"),
    "study_sessions": ("studies", "study-tablets", "study-answers"),
    "study_analysis": ("study-analysis", "study-accuracy"),
    "studio": ("studio", "studio-data", "touch", "server-safety"),
    "benchmarking": ("benchmark", "benchmark-results"),
    "reproducing": ("results",),
    "serving": ("studies",),
}
"""Pages that explain the verbs of each module of the command line."""
WIDTH = 84


def children(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the parsers of the verbs within a parser."""
    actions = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    return dict(actions[0].choices) if actions else {}


def described(parser: argparse.ArgumentParser) -> list[str]:
    """Return the Markdown lines of a verb: description, usage, and every argument and option."""
    words = parser.prog.removeprefix("tactogram ")
    verb = import_module(verb_places()[words].module).VERBS[words]
    if isinstance(verb, FunctionVerb):
        return described_function(words, verb)
    parser.formatter_class = partial(argparse.HelpFormatter, width=WIDTH)
    formatter = parser._get_formatter()
    usage = parser.format_usage().removeprefix("usage: ")
    lines = [f"{parser.description}\n", f"```text\n{usage}```\n", f"```{{program}} {parser.prog}\n```\n"]
    for action in sorted(parser._actions, key=lambda action: bool(action.option_strings)):
        if not isinstance(action, argparse._HelpAction):
            name = formatter._format_action_invocation(action)
            text = formatter._expand_help(action) if action.help else ""
            lines.append(f"````{{option}} {name}\n{text}\n````\n")
    return lines


def described_function(words: str, verb: FunctionVerb) -> list[str]:
    """Return the Markdown lines of a verb that is a function."""
    flags = flags_of(verb)
    known = parameters(verb.load())
    placed = {name for name, flag in flags.items() if not flag.startswith("-")}
    usage = " ".join(
        ["tactogram", words, *(one.name.upper() for one in known if one.name in placed), "[options]"]
    )
    lines = [
        f"{summary(verb.load())}\n",
        f"```text\n{usage}\n```\n",
        f"```{{program}} tactogram {words}\n```\n",
    ]
    for one in known:
        name = one.name.upper() if one.name in placed else f"{flags[one.name]} {one.name.upper()}"
        default = f" (default {one.default})" if one.default else ""
        required = one.default is Parameter.empty
        lines.append(f"````{{option}} {name}\n{one.text}{'' if required else default}\n````\n")
    return lines


def page(name: str, parser: argparse.ArgumentParser) -> str:
    """Return the page of a verb, or of a group of verbs."""
    inner = children(parser)
    guides = [
        guide
        for words, place in verb_places().items()
        if words.split()[0] == name
        for guide in GUIDES[place.module.rpartition(".")[2]]
    ]
    lines = [f"# {name}\n"]
    if inner:
        for verb, sub in inner.items():
            lines += [f"## {name} {verb}\n", *described(sub)]
    else:
        lines += described(parser)
    links = ", ".join(f"{{doc}}`/{guide}`" for guide in dict.fromkeys(guides))
    return "\n".join([*lines, f"See also: {links}\n"])


def write_pages(app: Sphinx) -> None:
    """Write ``verbs/NAME.md``, each only if it changed, and the table of all verbs."""
    folder = Path(app.srcdir) / "verbs"
    folder.mkdir(exist_ok=True)
    pages = {f"{name}.md": page(name, parser) for name, parser in children(make_parser()).items()}
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
