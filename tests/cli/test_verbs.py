"""Verbs that are functions: their options, and what is said of wrong ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli.verbs import Verb, flags_of, run
from tactogram.errors import Message, ParameterError, Remedy
from tactogram.parameters import Count, Positive, Settings, Share, checked, parameters, summary


@checked
def mixed(
    source: Path | str,
    files: Sequence[str] = (),
    *,
    rate: Positive | None = None,
    share: Share = 0.5,
    count: Count = 3,
    axes: tuple[str, ...] | None = None,
    mix: Mapping[str, float] | None = None,
    changes: Settings | None = None,
    sound: bool = True,
    seen: list[str] | None = None,
):
    """Mix what is given.

    Parameters
    ----------
    source : Path or str
        A file.
    files : sequence of str
        Further ones.
    rate : float, optional
        Sampling rate, Hz.
    share : float
        Of the first.
    count, axes, mix, changes, sound
        Others.
    """
    return dict(locals())


@checked
def again(
    source: Path | str | Sequence[Path | str],
    *,
    rate: Positive | None = None,
    band: tuple[float, float] | None = None,
    format: str | None = None,
    unit: str | None = None,
    tell: Callable[[str], None] = print,
):
    """Do it again.

    Parameters
    ----------
    source, rate
        As of `mixed`.
    band : tuple of float, optional
        Hz.
    format : str, optional
        Of the file.
    unit
        As of `tactogram.convert`.
    """
    tell("done")
    return {"source": list(source), "band": band, "format": format}


VERB = Verb(f"{__name__}:mixed", lambda result: f"count {result['count']}", lambda result: ["noted"])


def test_parameters_are_those_of_signature_and_docstring():
    known = {one.name: one for one in parameters(mixed)}
    assert list(known) == ["source", "files", "rate", "share", "count", "axes", "mix", "changes", "sound"]
    assert known["rate"].text == "Sampling rate, Hz."
    assert known["source"].positional
    assert not known["rate"].positional
    assert summary(mixed) == "Mix what is given."
    assert [one.text for one in parameters(again)][:2] == ["A file.", "Sampling rate, Hz."]
    assert parameters(again)[-1].text.startswith("Unit of the samples")


def test_options_reach_the_function_as_its_types():
    line = "s3://a.wav b c --rate 5 --axes x,y --mix cork=0.6,tile=0.4 --set a.b=[1] --set c=true --no-sound"
    seen = {}
    verb = Verb(VERB.function, lambda result: seen.update(result) or "")
    assert run("mix", verb, line.split()) == 0
    assert seen["source"] == "s3://a.wav"
    assert list(seen["files"]) == ["b", "c"]
    assert (seen["rate"], seen["axes"], seen["mix"]) == (5.0, ("x", "y"), {"cork": 0.6, "tile": 0.4})
    assert (seen["changes"], seen["sound"], seen["share"]) == ({"a.b": [1], "c": True}, False, 0.5)


def test_notes_name_options_instead_of_parameters(capsys):
    verb = VERB._replace(
        notes=lambda result: [Message("x", Remedy("say", "rate", 5), Remedy("", "unit", "g"))]
    )
    assert run("mix", verb, ["a.wav"]) == 0
    assert capsys.readouterr().err == "note: x; say `--rate 5`, or `--set unit=g`\n"


def test_a_verb_may_advise_something_else_than_an_argument(capsys):
    remedies = Remedy("give", "rate", 5), Remedy("", "axes", "x"), Remedy("not", "rate")
    verb = VERB._replace(notes=lambda result: [Message("x", *remedies)], advice={"rate=": "a file"})
    assert run("mix", verb, ["a.wav"]) == 0
    assert capsys.readouterr().err == "note: x; give a file, or `--axes x`, or not --rate\n"


def test_the_text_is_printed_and_notes_go_to_stderr(capsys):
    assert run("mix", VERB, ["a.wav"]) == 0
    assert capsys.readouterr() == ("count 3\n", "note: noted\n")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "a.wav --rat 3",
            "tactogram mix: Unknown option: --rat. Did you mean --rate?; `tactogram mix --help` lists",
        ),
        ("a.wav --count x", "tactogram mix: Invalid value for --count"),
        ("", "tactogram mix: Parameter SOURCE requires an argument"),
    ],
)
def test_wrong_usage_is_one_line(line, message, capsys):
    assert run("mix", VERB, line.split()) == 2
    said = capsys.readouterr().err
    assert said.startswith(message)
    assert said.count("\n") == 1


def test_help_lists_every_option_with_its_text(capsys):
    run("mix", VERB, ["--help"])
    said = capsys.readouterr().out
    for text in ("Mix what is given.", "Sampling rate, Hz.", "--set", "--json", "print one JSON object"):
        assert text in said
    assert "--seen" not in said


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("rate", -1, "greater than 0"),
        ("rate", float("nan"), "a finite number"),
        ("count", 0, "greater than or equal to 1"),
        ("count", "many", "Count"),
        ("share", 2, "less than or equal to 1"),
        ("mix", [1], "Mapping[str, float]"),
        ("source", np.zeros(3), "Path or str"),
    ],
)
def test_a_wrong_argument_is_named_with_its_value_and_what_is_expected(name, value, expected):
    arguments = {"source": "a.wav", name: value}
    with pytest.raises(ParameterError, match=f"^{name} must be ") as refused:
        mixed(**arguments)
    assert (refused.value.parameter, refused.value.value is value) == (name, True)
    assert expected in refused.value.expected


def test_options_are_spelt_like_parameters_but_for_some():
    flags = flags_of(VERB)
    assert (flags["source"], flags["rate"], flags["changes"]) == ("source", "--rate", "--set")


def shown(out: Path | str, *, show):
    """Print while running.

    Parameters
    ----------
    out : Path or str
        A file.
    """
    show({"out": str(out)}, f"wrote {out}")


def test_a_function_may_print_by_itself_and_its_out_is_an_option(tmp_path, capsys):
    verb = Verb(f"{__name__}:shown", str)
    assert run("shown", verb, ["--out", str(tmp_path / "a.wav")]) == 0
    assert capsys.readouterr().out == f"wrote {tmp_path / 'a.wav'}\n"
    assert run("shown", verb, ["a.wav"]) == 2
    assert flags_of(verb) == {"out": "--out"}


def test_a_list_needs_nothing_else_and_a_result_has_a_status(capsys):
    verb = VERB._replace(
        status=lambda result: result["count"], listing=("list", lambda show: show([], "all"))
    )
    assert run("mix", verb, ["--list"]) == 0
    assert capsys.readouterr().out == "all\n"
    assert run("mix", verb, ["a.wav", "--count", "4"]) == 4


def test_pairs_several_files_second_spellings_and_further_arguments(capsys):
    seen = {}
    told = []
    verb = Verb(
        f"{__name__}:again",
        lambda result: seen.update(result) or "",
        within=lambda: nullcontext({"tell": told.append}),
    )
    assert run("again", verb, ["a", "b", "--band", "-1", "2.5", "--to", "csv"]) == 0
    assert seen == {"source": ["a", "b"], "band": (-1.0, 2.5), "format": "csv"}
    assert told == ["done"]


@checked
def opened(model: str, data: str, *, resume: str | None = None):
    """Open a store.

    Parameters
    ----------
    model, data : str
        Names.
    resume : str, optional
        A run.
    """
    return {"model": model, "data": data, "resume": resume}


@pytest.mark.parametrize(("words", "resume"), [("--resume", ""), ("--resume r", "r"), ("", None)])
def test_an_option_may_be_bare_and_what_python_takes_by_position_may_be_named(words, resume):
    seen = {}
    verb = Verb(
        f"{__name__}:opened", lambda result: seen.update(result) or "", named=("data",), bare=("resume",)
    )
    assert run("open", verb, ["cnn", *words.split(), "--data", "d"]) == 0
    assert seen == {"model": "cnn", "data": "d", "resume": resume}
    assert flags_of(verb)["data"] == "--data"


def test_the_signature_of_a_public_function_is_short_and_every_parameter_has_a_text():
    import tactogram
    from tactogram.workflows.data.convert import READING
    from tactogram.workflows.generation.clone import clone

    for function in (tactogram.train, tactogram.crossval, tactogram.evaluate, clone):
        assert len(str(signature(function))) < 700
        named = signature(function).parameters.keys() - {"progress", "stop", "reading"}
        further = READING if "reading" in signature(function).parameters else ()
        assert {one.name for one in parameters(function)} == {*named, *further}
        assert all(one.text for one in parameters(function))
