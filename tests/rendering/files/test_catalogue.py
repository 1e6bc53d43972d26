"""Formats by name, suffix and content."""

from pathlib import Path

import pytest
from tests.rendering.files.test_conversion import FORMATS, effect

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files import check_file, write_haptic
from tactogram.rendering.files.catalogue import (
    file_name,
    format_for,
    haptic_labels,
    haptic_suffixes,
    recognised_format,
)


@pytest.mark.parametrize("format", FORMATS)
def test_a_shared_suffix_is_told_by_what_is_in_it(tmp_path, format):
    write_haptic(tmp_path / "x.json", effect(), format=format)
    assert check_file(tmp_path / "x.json")["format"] == format


def test_a_file_is_written_in_the_format_of_its_suffix_or_of_a_name():
    assert format_for(Path("x.AHAP")).name == "ahap"
    assert format_for(Path("x.wav")) is None
    assert format_for(Path("x.wav"), "haptic").name == "haptic"
    with pytest.raises(
        ParameterError, match=r"x.json: several formats are written as .json; format must be one of"
    ):
        format_for(Path("x.json"))
    with pytest.raises(ParameterError, match="haptic format must be one of ahap"):
        format_for(Path("x.ahap"), "ahpa")


def test_a_name_has_the_format_where_several_share_the_suffix():
    assert file_name("tap", "ahap") == "tap.ahap"
    assert file_name("tap", "android") == "tap-android.json"


def test_every_format_names_an_engine_that_the_docs_name():
    engines = (Path(__file__).parents[3] / "docs/engines.md").read_text()
    labels = haptic_labels()
    assert set(labels) == set(FORMATS)
    for name, form in FORMATS.items():
        assert form.engine.split(",")[0].removeprefix("The ").split(" and ")[0] in engines, name
        assert labels[name].endswith(f"{form.title} ({form.suffix})")
    assert labels["haptic"].startswith("Unity and Unreal, on Quest: ")
    assert labels["android"] == "Android waveform (.json)"
    assert [*labels][:3] == ["android", "android_basic", "android_envelope"]


def test_each_suffix_is_listed_once():
    suffixes = haptic_suffixes()
    assert len(set(suffixes)) == len(suffixes)
    assert {form.suffix for form in FORMATS.values()} == set(suffixes)


@pytest.mark.parametrize("document", [{}, {"unknown": 1}, "text", None])
def test_a_document_that_no_format_recognises_is_refused(document):
    with pytest.raises(DataError, match="x.json: is none of ahap, .*; name its format"):
        recognised_format(document, Path("x.json"))
