"""Messages: one printable line, with long values shortened."""

import json
import pickle
import re

from tactogram.errors import (
    MOST_VALUE,
    DataError,
    Message,
    ParameterError,
    Remedy,
    one_line,
    remedies_of,
    shown,
)


def test_a_long_value_in_any_message_loses_its_middle():
    value = "a" + "x" * 5000 + "b"
    message = str(DataError(f"/some/file: cell must be a number, got {value!r}; write\none"))
    assert re.fullmatch(r"/some/file: cell must be a number, got 'ax+ … x+b'; write one", message)
    assert len(message) < 150
    assert len(str(DataError(" ".join([value] * 9)))) <= 1000
    assert str(DataError("the file's rate is not the run's, got 'short'")).endswith("the run's, got 'short'")


def test_an_error_carries_what_was_wrong_with_which_argument():
    error = ParameterError("must be > 0 Hz, got -1", parameter="rate", value=-1, expected="> 0 Hz")
    assert isinstance(error, ValueError)
    assert (error.parameter, error.value, error.expected, error.remedy) == ("rate", -1, "> 0 Hz", "")
    assert str(error) == "rate must be > 0 Hz, got -1"


def test_a_value_is_shown_without_formatting_all_of_it():
    assert shown("short") == "'short'"
    assert shown([1, 2]) == "[1, 2]"
    assert len(shown(list(range(10_000)))) <= MOST_VALUE
    assert shown("a" + "x" * 10_000 + "b").startswith("'ax")


def test_a_foreign_error_is_one_line():
    assert one_line(OSError("no\n  such file")) == "no such file"
    assert one_line(RuntimeError(-5, "device gone")) == "-5, device gone"
    assert one_line(KeyError()) == "KeyError"
    assert one_line(ValueError("x" * 300)) == "x" * 197 + "..."


def test_a_file_name_that_is_not_utf_8_is_printable():
    assert str(DataError("caf\udce9.wav: not a WAV file")) == r"caf\udce9.wav: not a WAV file"


def test_a_remedy_is_a_field_of_the_error():
    remedies = (Remedy("give it,", "rate", 1000), Remedy("omit", "time"))
    error = DataError("a.csv", "no rate in the file", remedy=remedies)
    assert str(error) == "a.csv: no rate in the file; give it, `rate=1000`, or omit `time`"
    assert (error.message.place, error.message.problem) == ("a.csv", "no rate in the file")
    assert remedies_of(error.message) == remedies
    assert remedies_of(str(error)) == ()


def test_each_face_says_a_remedy_and_the_parameter_in_its_own_words():
    error = ParameterError.must("rate", "be > 0", -1, remedy=Remedy("omit", "rate"))
    said = error.message.in_words(lambda remedy: f"{remedy.advice} <{remedy.parameter}>", {"rate": "--rate"})
    assert said == "--rate must be > 0, got -1; omit <rate>"


def test_an_error_in_another_keeps_its_remedies_and_names_a_place_once():
    inner = DataError("a.csv: row 3", "no number", remedy=Remedy("choose", "axes", "x"))
    for place in ("a.csv", "a.csv: row 3", ""):
        assert DataError(place, inner).message == "a.csv: row 3: no number; choose `axes=x`"
    outer = DataError("take 1", inner, remedy=Remedy("leave it out by", "skip_bad"))
    assert str(outer) == "take 1: a.csv: row 3: no number; choose `axes=x`, or leave it out by `skip_bad`"
    assert inner.message.within("a.csv") == "row 3: no number; choose `axes=x`"


def test_an_error_and_its_message_survive_other_processes():
    error = DataError("a.csv", "no rate", remedy=Remedy("give it,", "rate", 1000))
    copied = pickle.loads(pickle.dumps(error))  # noqa: S301 - its own
    assert (str(copied), copied.message.remedies) == (str(error), error.message.remedies)
    message = pickle.loads(pickle.dumps(error.message))  # noqa: S301 - its own
    assert (message, message.place, message.remedies) == (str(error), "a.csv", error.message.remedies)
    assert json.loads(json.dumps([message])) == [str(error)]


def test_backquotes_in_a_text_are_no_remedy():
    assert Message("see `tactogram data copy` and `config.steps=3`").remedies == ()
