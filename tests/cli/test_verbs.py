"""Requests as options: types, defaults, bounds and names."""

import argparse
import inspect
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from importlib import import_module
from typing import Annotated, Any, Literal

import pytest

from tactogram.cli.functions import FunctionVerb
from tactogram.cli.parser import make_parser, verb_places
from tactogram.cli.verbs import Verb, add_options, flags_of, request_of, with_options
from tactogram.errors import ParameterError
from tactogram.workflows.request import Argument, Option, Request, takes


@dataclass(frozen=True)
class Example(Request):
    file: Annotated[str, Argument("a file", "FILE")]
    _: KW_ONLY
    count: Annotated[int, Option("how many", least=1)] = 5
    share: Annotated[float | None, Option(above=0, most=1)] = None
    how: Annotated[Literal["sum", "add"], Option()] = "sum"
    band: Annotated[tuple[float, float] | None, Option("Hz", ("LO", "HI"))] = None
    sizes: Annotated[tuple[int, ...], Option()] = ()
    folders: Annotated[Sequence[str], Option(flag="--folder")] = ()
    changes: Annotated[Mapping[str, Any] | None, Option(flag="--set")] = None
    names: Annotated[Mapping[str, str] | None, Option()] = None
    mix: Annotated[Mapping[str, float] | None, Option(metavar="A=1,B=2")] = None
    on: Annotated[bool | None, Option()] = None
    sound: Annotated[bool, Option("no sound", flag="--silent")] = True
    resume: Annotated[str | None, Option(const="")] = None
    progress: Any = print


VERB = Verb(Example, lambda request, show: None)


def parsed(*words):
    parser = argparse.ArgumentParser()
    add_options(parser, VERB)
    return request_of(VERB, parser.parse_args(["x.wav", *words]))


def test_what_is_omitted_has_the_default_of_the_request():
    assert parsed() == Example("x.wav")


def test_values_have_the_types_of_the_request():
    words = "--count 2 --share 0.5 --how add --band 20 1000 --sizes 3,4 --folder a --folder b --set a.b=[1] --set c=d "
    words += "--names x=1 --mix a-b=0.6,c=0.4 --on off --silent --resume"
    assert parsed(*words.split()) == Example(
        "x.wav",
        count=2,
        share=0.5,
        how="add",
        band=(20.0, 1000.0),
        sizes=(3, 4),
        folders=["a", "b"],
        changes={"a.b": [1], "c": "d"},
        names={"x": "1"},
        mix={"a-b": 0.6, "c": 0.4},
        on=False,
        sound=False,
        resume="",
    )


def test_a_mix_may_have_spaces():
    assert parsed("--mix", "a b=0.5, c=1").mix == {"a b": 0.5, "c": 1.0}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--mix a", "--mix must be A=1,B=2, got 'a'"),
        ("--mix a=x", "--mix must be A=1,B=2, got"),
        ("--mix =1", "--mix must be A=1,B=2, got"),
        ("--mix a=1,a=2", "--mix names 'a' twice"),
        ("--names a", "--names must be KEY=VALUE, got 'a'"),
        ("--set a", "--set must be KEY=VALUE, got 'a'"),
        ("--sizes 1,x", "--sizes needs whole numbers separated by commas, got '1,x'"),
        ("--count 0", "count must be at least 1, got 0"),
        ("--share 2", "share must be > 0 and at most 1, got 2"),
        ("--share nan", "share must be a finite number, got nan"),
    ],
)
def test_a_wrong_value_is_refused_by_its_option(words, message):
    with pytest.raises(ParameterError) as refused:
        parsed(*words.split())
    assert str(refused.value).startswith(message)


def test_python_refuses_the_same_values():
    for wrong in ({"count": 0}, {"share": float("inf")}, {"how": "mean"}):
        with pytest.raises(ParameterError, match=next(iter(wrong))):
            Example("x.wav", **wrong)


def test_an_error_names_options_in_place_of_parameters():
    message = "`changes` and `file` exclude each other; `unknown` stays, as sound"
    assert (
        with_options(message, flags_of(VERB))
        == "--set and file exclude each other; `unknown` stays, as sound"
    )
    assert with_options("sound must be low", flags_of(VERB)) == "--silent must be low"
    assert (
        with_options("give `count=3` or `rate=1000`", flags_of(VERB))
        == "give `--count 3` or `--set rate=1000`"
    )


def test_a_function_takes_the_parameters_of_a_request():
    @takes(Example)
    def double(request):
        """Return twice the count."""
        return 2 * request.count

    assert double("x.wav", count=3) == 6
    assert list(inspect.signature(double).parameters)[:3] == ["file", "count", "share"]
    with pytest.raises(TypeError):
        double("x.wav", amount=3)


def test_help_states_the_defaults():
    parser = argparse.ArgumentParser()
    add_options(parser, VERB)
    text = " ".join(parser.format_help().split())
    assert "how many (default 5)" in text
    assert "--band LO HI Hz" in text


def verbs():
    places = verb_places()
    for module in dict.fromkeys(place.module for place in places.values()):
        declared = import_module(module).VERBS
        assert set(declared) == {words for words, place in places.items() if place.module == module}
        yield from declared.items()


def test_every_verb_runs_the_request_that_it_declares():
    for words, verb in verbs():
        if isinstance(verb, FunctionVerb):
            assert verb.load().__doc__, words
            continue
        request = next(iter(inspect.signature(verb.run).parameters.values()))
        named = request.annotation
        assert verb.request is named or verb.request.__name__ == named, words


def imported(code: str, *names: str) -> set[str]:
    """Those of ``names`` that a new interpreter has imported after ``code``, without coverage and what it imports."""
    code = f"import sys; from tactogram.cli.parser import make_parser\n{code}\nprint(*sys.modules)"
    environment = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_")}
    ran = subprocess.run(
        [sys.executable, "-c", code], check=True, env=environment, capture_output=True, text=True
    )
    return set(names) & set(ran.stdout.split())


def test_no_verb_imports_numpy_before_it_runs():
    words = list(verb_places())
    code = f"for words in {words!r}: make_parser(words.split())"
    assert imported(code, "numpy", "pydantic", "torch", "dataclasses") == {"dataclasses"}


def test_help_imports_no_verb():
    assert not imported("make_parser(['--help'])", "dataclasses", "tactogram.cli.verbs")


def test_usage_of_every_verb_can_be_shown():
    for action in make_parser()._actions:
        if isinstance(action, argparse._SubParsersAction):
            for parser in action.choices.values():
                assert parser.format_help()
