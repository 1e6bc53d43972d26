"""Hints: nearest names, and commands that can be pasted."""

import shlex
import shutil

import pytest

from tactogram.cli import main
from tactogram.cli.catalogue import nearest_verb, verb_places
from tactogram.cli.hints import in_words
from tactogram.errors import DataError, ParameterError, Remedy


@pytest.mark.parametrize(
    ("words", "likely"),
    [
        ("generat r --out x.wav", "did you mean `tactogram generate`?"),
        ("trian stroke_cnn", "did you mean `tactogram train`?"),
        ("data smulate x", "did you mean `tactogram data simulate`?"),
        ("simulate stroking9", "did you mean `tactogram data simulate` or `tactogram study simulate`?"),
        ("xyzzy", "no verb 'xyzzy'; `tactogram --help` lists all"),
        ("study xyzzy", "no verb 'study xyzzy'; `tactogram study --help` lists all"),
    ],
)
def test_a_mistyped_verb_is_answered_with_the_nearest(words, likely, capsys):
    assert main(words.split()) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert likely in last
    assert len(last) < 150


def test_every_verb_is_one():
    for verb in verb_places():
        assert nearest_verb([*verb.split(), "--help"], verb_places()) is None
    for words in ([], ["--version"], ["study"], ["data", "--help"]):
        assert nearest_verb(words, verb_places()) is None


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        ("studio --port 0", "studio"),
        ("study run abx", "studio"),
        ("study list", "study"),
        ("live", "capture"),
        ("stream runs/a", "playback"),
        ("track --help", "playback"),
    ],
)
def test_a_verb_of_a_distribution_that_is_missing_names_its_extra(words, extra):
    missing = ("studio", "study", "live", "stream", "track")
    installed = [verb for verb in verb_places() if verb.split()[0] not in missing]
    installed += ["study list"] if extra == "studio" else []
    assert f"pip install 'tactogram[{extra}]'" in nearest_verb(words.split(), installed)


def test_the_nearest_name_is_offered():
    error = ParameterError.one_of("material", ("carpet", "tile"), "tiel")
    assert in_words(error, {"material": "--material"}, []) == (
        "--material must be one of carpet, tile, got 'tiel'; did you mean 'tile'?"
    )
    outer = DataError("m.toml: material must be one of carpet, tile, got 'tiel'")
    outer.__cause__ = error
    assert in_words(outer, {}, []).endswith("; did you mean 'tile'?")
    far = ParameterError.one_of("a", ("x", "y"), "unheard-of")
    assert in_words(far, {}, []).endswith("got 'unheard-of'")


def test_an_option_is_added_to_the_command():
    error = DataError("no rate", remedy=(Remedy("give it, e.g.", "rate", 1000), Remedy("omit", "rate")))
    assert in_words(error, {"rate": "--rate"}, ["convert", "my file.csv", "x.wav"]) == (
        "no rate; give it, e.g. `tactogram convert 'my file.csv' x.wav --rate 1000`, or omit --rate"
    )


def test_an_option_replaces_the_one_in_the_command():
    words = ["convert", "a.csv", "--time", "ticks", "--unit=g"]
    flags = {"time": "--time", "unit": "--unit", "options": "--set"}

    def said(words, name, value):
        return in_words(DataError("x", remedy=Remedy("use", name, value)), flags, words)

    assert said(words, "time", "none") == "x; use `tactogram convert a.csv --unit=g --time none`"
    assert said(words, "unit", "N") == "x; use `tactogram convert a.csv --time ticks --unit N`"
    words = ["data", "import", "folder", "a", "--set", "rate=9"]
    assert said(words, "mapping", "m.toml").endswith("--set rate=9 --set mapping=m.toml`")


def test_only_the_parameter_and_the_remedies_become_options():
    error = ParameterError.must("rate", "be as the `rate=9` of the file", 8, remedy=Remedy("omit", "rate"))
    assert in_words(error, {"rate": "--rate"}, ["convert"]) == (
        "--rate must be as the `rate=9` of the file, got 8; omit --rate"
    )


def test_the_answer_to_a_table_without_a_rate_can_be_pasted(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "all/cork").mkdir(parents=True)
    (tmp_path / "t.csv").write_text("a\n" + "\n".join(str(k % 7) for k in range(2000)) + "\n")
    shutil.copy("t.csv", "all/cork")
    for words in (["convert", "t.csv", "x.npz"], ["data", "import", "folder", "all", "--out", "store"]):
        assert main(words) == 1
        offered = capsys.readouterr().err.strip().rpartition("`tactogram ")[2].partition("`")[0]
        assert "1000" in offered
        assert main(shlex.split(offered)) == 0
        capsys.readouterr()
