"""Remedies: what a message advises, found again and said in other words."""

from tactogram.errors import DataError, Remedy, remedies_in, with_remedies


def test_a_remedy_is_found_again_in_a_message():
    error = DataError(f"no rate in the file; give {Remedy('rate', 1000)}, and omit {Remedy('time')}")
    assert str(error) == "no rate in the file; give `rate=1000`, and omit `time`"
    assert remedies_in(str(error)) == (("rate", "1000"), ("time", None))


def test_each_face_says_a_remedy_in_its_own_words():
    said = with_remedies("give `rate=1000`, omit `time`", lambda remedy: f"<{remedy.parameter}>")
    assert said == "give <rate>, omit <time>"


def test_what_is_in_other_backquotes_is_no_remedy():
    assert remedies_in("see `tactogram data copy` and `config.steps=3`") == ()
