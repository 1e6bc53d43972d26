"""Parameters of a function, read from its signature and its numpydoc docstring.

A verb is one function with plain annotations. Its checks (`checked`), its options on the command line
(`tactogram.cli.verbs`) and its page in the reference are made from what this module reads. A module with such a
function postpones its annotations, and imports what is heavy inside the function: its parameters are read without it.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterable
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cache, wraps
from pathlib import Path
from pydoc import locate
from typing import Annotated, Any, ParamSpec, TypeVar, cast

from annotated_types import Ge, Gt, Le
from docstring_parser import DocstringStyle, parse
from pydantic import ConfigDict, TypeAdapter, ValidationError

from tactogram.errors import ParameterError
from tactogram.signal.io.atomic import sole_writer

Positive = Annotated[float, Gt(0)]
Count = Annotated[int, Ge(1)]
Share = Annotated[float, Ge(0), Le(1)]
Settings = dict[str, Any]
"""Values by name, of any type: on the command line ``KEY=VALUE``, read as TOML."""

P = ParamSpec("P")
R = TypeVar("R")
F = TypeVar("F", bound=Callable[..., Any])
_BOUNDS = (
    "greater_than",
    "greater_than_equal",
    "less_than",
    "less_than_equal",
    "finite_number",
    "literal_error",
)
"""Faults of a value of the right type."""
_CONFIG = ConfigDict(arbitrary_types_allowed=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Parameter:
    """A parameter: its type, its default (``inspect.Parameter.empty`` if it is required), and its text."""

    name: str
    annotation: str
    """The type as it is written, without None."""
    kind: Any
    """`typing.Any` where the type is known to type checkers alone."""
    default: Any
    text: str
    positional: bool

    def check(self, value: Any) -> Any:
        """Return a value as the parameter's type; `ParameterError` if it is of another or out of bounds."""
        if self.kind is Any or value is self.default:
            return value
        try:
            return _adapter(self.kind).validate_python(value)
        except ValidationError as error:
            fault = next((detail for detail in error.errors() if detail["type"] in _BOUNDS), None)
            expected = self.annotation if fault is None else fault["msg"].removeprefix("Input should be ")
            raise ParameterError.must(self.name, f"be {expected}", value) from None


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind, config=_CONFIG)


def with_further(more: Callable[[], Iterable[Parameter]]) -> Callable[[F], F]:
    """Add parameters that are known when they are asked for to a function, which takes them by ``**``."""

    def decorate(function: F) -> F:
        function.further_parameters = more  # type: ignore[attr-defined]
        return function

    return decorate


def parameters(function: Callable[..., Any]) -> tuple[Parameter, ...]:
    """Return the parameters of a function in their order, without callbacks: those have no text in the docstring."""
    function = inspect.unwrap(function)
    return (*_own(function), *getattr(function, "further_parameters", tuple)())


@cache
def _own(function: Callable[..., Any]) -> tuple[Parameter, ...]:
    documented = parse(inspect.getdoc(function) or "", DocstringStyle.NUMPYDOC)
    texts = {
        name.strip(): " ".join((described.description or "").split())
        for described in documented.params
        for name in described.arg_name.split(",")
    }
    known = vars(sys.modules[function.__module__])
    for name, text in texts.items():
        if text.startswith("As of `"):
            named = text.split("`")[1]
            other = known.get(named) or locate(named)
            texts[name] = next(entry.text for entry in parameters(cast(Any, other)) if entry.name == name)
    return tuple(
        Parameter(
            name,
            str(argument.annotation).removesuffix(" | None").replace(" | ", " or "),
            _resolved(argument.annotation, known),
            argument.default,
            texts[name],
            argument.kind is not inspect.Parameter.KEYWORD_ONLY,
        )
        for name, argument in inspect.signature(function).parameters.items()
        if name in texts
    )


def summary(function: Callable[..., Any]) -> str:
    """Return the first sentence of a function's docstring."""
    return parse(inspect.getdoc(function) or "", DocstringStyle.NUMPYDOC).short_description or ""


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """Check the arguments of a function against its annotations before it runs, as the `sole_writer` of its ``out``.

    `ParameterError` names the first fault, or the process that writes there.
    """
    signature = inspect.signature(function)
    rest = next((one.name for one in signature.parameters.values() if one.kind is one.VAR_KEYWORD), "")

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        bound = signature.bind(*args, **kwargs)
        known = {parameter.name: parameter for parameter in parameters(function)}
        for held in (bound.arguments, bound.arguments.get(rest, {})):
            for name in held.keys() & known.keys():
                held[name] = known[name].check(held[name])
        if unknown := bound.arguments.get(rest, {}).keys() - known.keys():
            raise TypeError(f"{function.__name__}() got an unexpected keyword argument {min(unknown)!r}")
        out = (bound.arguments | bound.arguments.get(rest, {})).get("out")
        with sole_writer(Path(out)) if out and not hasattr(function, "shares_out") else nullcontext():
            return function(*bound.args, **bound.kwargs)

    return call


def shares_out(function: F) -> F:
    """Allow several processes to write to one ``out`` of a function."""
    function.shares_out = True  # type: ignore[attr-defined]
    return function


def _resolved(annotation: Any, known: dict[str, Any]) -> Any:
    """Return the type that a postponed annotation names; `typing.Any` if a name in it is not imported."""
    if not isinstance(annotation, str):
        return annotation
    try:
        return eval(annotation, known)
    except NameError:
        return Any
