"""Requests: the parameters of a workflow, declared once for Python and the command line.

A request is a frozen dataclass in a module that imports nothing heavy. A field annotated with `Option` or `Argument` is
also one of the verb; the others (callbacks, loaded runs) are for Python alone. `takes` gives a workflow the request's
parameters as its own signature, so ``track("ultrasonic", steps=5)`` and ``tactogram track --display ultrasonic --steps
5`` share names, types, defaults and bounds. Such a module does without postponed annotations: `declared` reads them.
"""

import inspect
import math
from collections.abc import Callable, Iterator
from dataclasses import Field, dataclass, fields
from functools import wraps
from typing import Annotated, Any, ClassVar, Literal, ParamSpec, Protocol, TypeVar, cast, get_args, get_origin

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class Option:
    """Help, spelling and bounds of a parameter; the command line adds the default to the help.

    ``metavar`` names the value, or each of a pair; ``flag`` replaces ``--NAME`` (several are separated by spaces);
    ``const`` is the value of an option given without one. Bounds are inclusive except ``above``.
    """

    help: str = ""
    metavar: str | tuple[str, ...] | None = None
    flag: str | None = None
    const: str | None = None
    least: float | None = None
    above: float | None = None
    most: float | None = None

    def check(self, name: str, value: float) -> None:
        """Refuse a number that is not finite or out of bounds."""
        expected = [
            f"{sign} {bound:g}"
            for sign, bound in (("at least", self.least), (">", self.above), ("at most", self.most))
            if bound is not None
        ]
        inside = (
            (self.least is None or value >= self.least)
            and (self.above is None or value > self.above)
            and (self.most is None or value <= self.most)
        )
        if not math.isfinite(value):
            raise ParameterError(f"{name} must be a finite number, got {value}")
        if not inside:
            raise ParameterError(f"{name} must be {' and '.join(expected)}, got {value:g}")


@dataclass(frozen=True)
class Argument(Option):
    """A positional argument of the command line; one with a default may be omitted."""


class Request:
    """Base of the requests: numbers are checked against their bounds."""

    def __post_init__(self) -> None:
        for field, option, kind in declared(type(self)):
            value = getattr(self, field.name)
            if isinstance(value, int | float):
                option.check(field.name, value)
            elif get_origin(kind) is Literal and value not in get_args(kind):
                raise ParameterError(
                    f"{field.name} must be one of {', '.join(get_args(kind))}, got {value!r}"
                )


class _Dataclass(Protocol):
    __dataclass_fields__: ClassVar[dict[str, Any]]


def declared(request: type[Request]) -> Iterator[tuple[Field[Any], Option, Any]]:
    """Yield the fields that the command line has, each with its option and its type."""
    for field in fields(cast(type[_Dataclass], request)):
        kind: Any = field.type
        if isinstance(kind, str) and kind.startswith("Annotated"):
            raise TypeError(f"{request.__name__}: its module must not postpone annotations")
        if get_origin(kind) is Annotated:
            yield field, kind.__metadata__[0], kind.__origin__


P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")


def takes(request: Callable[P, R]) -> Callable[[Callable[[R], T]], Callable[P, T]]:
    """Give a function of one request the parameters of that request."""

    def decorate(function: Callable[[R], T]) -> Callable[P, T]:
        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            return function(request(*args, **kwargs))

        call.__signature__ = inspect.signature(request)  # type: ignore[attr-defined]
        return call

    return decorate


ON = Option("engine: ray starts Ray on this machine, ray:ADDRESS takes a cluster", "ray[:ADDRESS]")
SWEEP_ON = Option("engine of a sweep: Ray on this machine, or ray:ADDRESS for a cluster", "ray[:ADDRESS]")
PROCESSES = Option("processes of this machine (default: one per core; on a GPU one)", "N", least=1)
