"""Parameters of workflows in the API reference, from the requests that declare them.

A function with ``@takes(Request)`` has the request's fields as its signature, each with its help. The signature and the
list of parameters are taken from there, so that pages and ``--help`` say the same.
"""

import inspect
import re
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

from docutils import nodes
from sphinx.application import Sphinx

from tactogram.workflows.request import Option

SECTIONS = ("Returns", "Yields", "Raises")


def short(kind: Any) -> str:
    """Return a type as a reader wants it: no module names, and "optional" instead of None."""
    inner = [one for one in get_args(kind) if one is not NoneType]
    optional = NoneType in get_args(kind)
    text = " or ".join(map(short, inner)) if optional else inspect.formatannotation(kind)
    text = re.sub(r"ForwardRef\('([^']+)'[^)]*\)", r"\1", text)
    text = re.sub(r"\b[a-z_]+(?:\.[A-Za-z_]+)*\.(?=[A-Z])|\btyping\.", "", text).replace(" | ", " or ")
    return f"{text}, optional" if optional else text


def declared_parameters(function: Any) -> list[str]:
    """Return numpydoc lines of the parameters that have a help."""
    lines = []
    for name, parameter in inspect.signature(function).parameters.items():
        if get_origin(parameter.annotation) is Annotated:
            kind, option = get_args(parameter.annotation)[:2]
            if isinstance(option, Option):
                lines += [f"{name} : {short(kind)}", f"    {option.help}"]
    return lines


def add_parameters(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Insert the parameters before the first section of a docstring."""
    if what == "function" and (parameters := declared_parameters(obj)):
        heads = [place for place, line in enumerate(lines) if line.strip() in SECTIONS]
        place = min(heads, default=len(lines))
        lines[place:place] = ["", "Parameters", "----------", *parameters, ""]


def plain_signature(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str, None] | None:
    """Return the signature of a workflow without types, and without the addresses of default callbacks."""
    if what != "function" or not declared_parameters(obj):
        return None
    known = inspect.signature(obj)
    plain = [
        parameter.replace(
            annotation=parameter.empty, default=None if callable(parameter.default) else parameter.default
        )
        if parameter.default is not parameter.empty
        else parameter.replace(annotation=parameter.empty)
        for parameter in known.parameters.values()
    ]
    return str(known.replace(parameters=plain, return_annotation=known.empty)), None


def set_dashes(app: Sphinx, doctree: nodes.document) -> None:
    """Set the dash between a parameter and its text, since those in prose are options and left alone."""
    for text in list(doctree.findall(nodes.Text)):
        if text == " -- ":
            text.parent.replace(text, nodes.Text(" – "))


def setup(app: Sphinx) -> dict[str, bool]:
    """Run before napoleon reads the docstrings."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", add_parameters, priority=400)
    app.connect("autodoc-process-signature", plain_signature)
    app.connect("doctree-read", set_dashes)
    return {"parallel_read_safe": True}
