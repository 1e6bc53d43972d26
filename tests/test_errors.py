"""Messages: one printable line, with long values shortened."""

import re

from tactogram.errors import (
    MOST_VALUE,
    DataError,
    ParameterError,
    Remedy,
    one_line,
    remedies_in,
    shown,
    with_remedies,
)


def test_a_long_value_in_any_message_loses_its_middle():
    value = "a" + "x" * 5000 + "b"
    message = str(DataError(f"/some/file: cell must be a number, got {value!r}; write\none"))
    assert re.fullmatch(r"/some/file: cell must be a number, got 'ax+ … x+b'; write one", message)
    assert len(message) < 150
    assert len(str(DataError(" ".join([value] * 9)))) <= 1000
    assert str(DataError("the file's rate is not the run's, got 'short'")).endswith("the run's, got 'short'")


def test_an_error_carries_what_was_wrong_with_which_argument():
    error = ParameterError("rate must be > 0 Hz, got -1", parameter="rate", value=-1, expected="> 0 Hz")
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


def test_a_remedy_is_found_again_in_a_message():
    error = DataError(f"no rate in the file; give {Remedy('rate', 1000)}, and omit {Remedy('time')}")
    assert str(error) == "no rate in the file; give `rate=1000`, and omit `time`"
    assert remedies_in(str(error)) == (("rate", "1000"), ("time", None))


def test_each_face_says_a_remedy_in_its_own_words():
    said = with_remedies("give `rate=1000`, omit `time`", lambda remedy: f"<{remedy.parameter}>")
    assert said == "give <rate>, omit <time>"


def test_what_is_in_other_backquotes_is_no_remedy():
    assert remedies_in("see `tactogram data copy` and `config.steps=3`") == ()
