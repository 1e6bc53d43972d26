"""Catalogue of the verbs, and the start of the command."""

import inspect
import os
import subprocess
import sys
from importlib import import_module

import pytest

from tactogram.cli import catalogue, main
from tactogram.cli.catalogue import EXTRAS, overview, verb_places
from tactogram.cli.verbs import flags_of
from tactogram.parameters import parameters, summary


def verbs():
    places = verb_places()
    for module in dict.fromkeys(place.module for place in places.values()):
        declared = import_module(module).VERBS
        assert set(declared) == {words for words, place in places.items() if place.module == module}
        yield from declared.items()


def test_every_verb_is_a_documented_function():
    for words, verb in verbs():
        function = verb.load()
        assert summary(function), words
        known = parameters(function)
        assert all(one.text for one in known), words
        required = {
            name
            for name, one in inspect.signature(function).parameters.items()
            if one.default is one.empty and one.kind is not one.VAR_KEYWORD
        }
        assert required <= {one.name for one in known} | {"progress", "show"}, words
        flags = [flag for flag in flags_of(verb).values() if flag.startswith("--")]
        assert len({one.name for one in known}) == len(known), words
        assert len(set(flags)) == len(flags), words


@pytest.mark.parametrize("words", [*verb_places(), "--version"])
def test_help_of_every_verb_can_be_shown(words, capsys):
    assert main([*words.split(), "--help"] if words != "--version" else [words]) == 0
    assert capsys.readouterr().out.strip()


def test_the_overview_has_every_verb_and_that_of_a_group_its_own(capsys):
    text = overview()
    assert all(f"  {words.split()[0]} " in text for words in verb_places())
    assert main(["data", "--help"]) == 0
    assert capsys.readouterr().out == overview("data")
    assert [line.split()[1] for line in overview("data").splitlines() if line.startswith("  data ")] == [
        words.split()[1] for words in verb_places() if words.startswith("data ")
    ]
    assert main([]) == 2
    assert main(["data"]) == 2


def test_the_extras_name_every_verb_of_their_distributions():
    known = {(extra, words) for extra, listed in EXTRAS.items() for words in listed}
    for words, place in verb_places().items():
        extra = place.module.partition(".")[0].removeprefix("tactogram").removeprefix("_")
        if extra:
            assert known & {(extra, words), (extra, words.split()[0])}, words
    assert {words for _, words in known} <= {
        part for words in verb_places() for part in (words, words.split()[0])
    }


@pytest.mark.parametrize(
    ("words", "extra"), [("stream", "playback"), ("demo", "simulate"), ("data simulate", "simulate")]
)
@pytest.mark.parametrize("further", [[], ["--help"]], ids=["verb", "help"])
def test_a_verb_that_is_not_installed_names_its_extra_in_its_help_too(
    words, extra, further, monkeypatch, capsys
):
    monkeypatch.setattr(catalogue, "_packages", tuple)
    assert main([*words.split(), *further]) == 2
    assert capsys.readouterr().err == (
        f"tactogram: `tactogram {words}` comes with an extra: pip install 'tactogram[{extra}]'\n"
    )


def imported(code: str, *names: str) -> set[str]:
    """Those of ``names`` that a new interpreter has imported after ``code``, without coverage and what it imports."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_")}
    ran = subprocess.run(
        [sys.executable, "-c", f"import sys\n{code}\nsys.stderr.write(' '.join(sys.modules))"],
        check=True,
        env=environment,
        capture_output=True,
        text=True,
    )
    return set(names) & set(ran.stderr.split())


def test_help_imports_no_verb_and_nothing_heavy():
    code = "from tactogram.cli import main; assert main(['--help']) == 0"
    assert not imported(code, "numpy", "pydantic", "cyclopts", "tactogram.parameters")


def test_the_modules_of_the_verbs_import_nothing_heavy():
    modules = {place.module for place in verb_places().values()}
    assert not imported(f"import {', '.join(sorted(modules))}", "torch", "scipy", "pandas", "matplotlib")
