"""Reading: broken files, and what players accept."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from tests.rendering.files.test_conversion import FORMATS, effect

from tactogram.errors import DataError
from tactogram.rendering.files import check_file, read_haptic, write_haptic
from tactogram.rendering.files.documents import Notes
from tactogram.rendering.files.reading import decoded


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a JSON document"),
        (b"{", "not a JSON document"),
        (b"\xff\xfe", "not a JSON document"),
        (b'{"Pattern": [NaN]}', "NaN is not a JSON number"),
        (b"[" * 200_000, "not a JSON document"),
        (b'{"Pattern": 1e999}', "not valid AHAP"),
        (b"[]", "not valid AHAP"),
        (b'{"Pattern": []}', "not valid AHAP .Apple.: Pattern"),
    ],
)
def test_broken_files_are_refused_in_one_line(tmp_path, content, message):
    (tmp_path / "x.ahap").write_bytes(content)
    with pytest.raises(DataError, match=message) as caught:
        read_haptic(tmp_path / "x.ahap")
    assert "\n" not in str(caught.value)


HAPTIC = (
    '{"version": {"major": 1, "minor": 0, "patch": 0}, "signals": {"continuous": {"envelopes": {"amplitude": '
    '[{"time": 0, "amplitude": 1}, {"time": %s, "amplitude": 1}]}}}}'
)
ANDROID = '{"format": "android-waveform", "timings": [%s], "amplitudes": [%s]}'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HAPTIC % "1e300", "1e\\+300 s at 8000 Hz are more than 33554432 samples; cut the file"),
        (HAPTIC % ("9" * 400), "an integer must have at most 64 bits"),
        (HAPTIC % ("9" * 5000), "an integer must have at most 64 bits, got thousands of digits"),
        (ANDROID % (2**62, 1), "more than 33554432 samples; cut the file"),
        (ANDROID % (",".join("1" * 1_000_001), 1), "timings: must have at most 1000000 entries"),
    ],
)
def test_a_document_that_would_fill_the_memory_is_refused(tmp_path, text, message):
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(DataError, match=message) as caught:
        read_haptic(tmp_path / "x.json")
    assert len(str(caught.value)) < 500


def test_a_missing_file_and_a_strange_json_are_named(tmp_path):
    with pytest.raises(DataError, match="no such file"):
        check_file(tmp_path / "x.ahap")
    (tmp_path / "x.json").write_text('{"a": 1}')
    with pytest.raises(DataError, match="is none of ahap, android, android_basic, android_envelope, gamepad"):
        check_file(tmp_path / "x.json")


def test_our_description_that_was_damaged_is_refused(tmp_path):
    write_haptic(tmp_path / "x.ahap", effect(), format="ahap")
    document = json.loads((tmp_path / "x.ahap").read_text())
    document["Metadata"]["Description"] = '{"tactogram": 1, "rate": "x"}'
    (tmp_path / "x.ahap").write_text(json.dumps(document))
    with pytest.raises(DataError, match="description: rate: must be a valid number"):
        read_haptic(tmp_path / "x.ahap")


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    document=st.recursive(
        st.none()
        | st.booleans()
        | st.integers()
        | st.floats(allow_nan=False, allow_infinity=False)
        | st.text(),
        lambda inner: (
            st.lists(inner)
            | st.dictionaries(
                st.sampled_from(
                    [
                        "Pattern",
                        "Event",
                        "signals",
                        "perceptions",
                        "timings",
                        "effects",
                        "pattern",
                        "description",
                    ]
                ),
                inner,
            )
        ),
        max_leaves=20,
    ),
    format=st.sampled_from(sorted(FORMATS)),
)
def test_any_json_is_valid_or_named_wrong(document, format):
    notes = Notes()
    file = decoded(document, FORMATS[format], notes)
    lines = [*notes.problems, *notes.warnings]
    assert all(isinstance(line, str) and line and "\n" not in line for line in lines)
    assert notes.problems or len(file.signal)


def test_golden_files_of_the_formats_are_valid():
    folder = Path(__file__).parent / "golden"
    for name in ("min.hjif", "my.haptic"):
        assert check_file(folder / name)["valid"]


CASES = Path(__file__).parent / "cases"


def test_what_decays_dies_away_and_what_overlaps_is_no_weaker():
    decay = read_haptic(CASES / "ahap_decay-decay.ahap").events.joined
    assert decay.at(np.array([0.0, 0.31, 0.9])) == pytest.approx([1, 0, 0], abs=0.01)
    overlap = read_haptic(CASES / "ahap_overlap-overlap.ahap").events.joined
    assert overlap.at(np.array([0.2, 0.5, 0.8])) == pytest.approx([0.64, 0.646, 0.64], abs=0.001)


@pytest.mark.parametrize(
    ("name", "warning"),
    [
        (
            "haptic_frequency_past_end-clip.haptic",
            "frequency breakpoints must be within the amplitude envelope",
        ),
        ("haptic_version_major_only-clip.haptic", "version must have a minor and a patch: taken as 0"),
    ],
)
def test_what_players_accept_is_valid_with_a_warning(name, warning):
    found = check_file(CASES / name)
    assert (found["valid"], found["problems"], len(found["warnings"])) == (True, [], 1)
    assert found["warnings"][0].startswith(warning)
    assert read_haptic(CASES / name).events.seconds == 1.0


def test_a_text_with_a_mark_or_in_utf_16_is_read(tmp_path):
    text = (CASES / "haptic_version_major_only-clip.haptic").read_text()
    for encoding in ("utf-8-sig", "utf-16"):
        (tmp_path / "x.haptic").write_text(text, encoding=encoding)
        assert len(read_haptic(tmp_path / "x.haptic").events.transients) == 1


def test_an_ahap_may_have_commas_at_the_end_of_lists_and_objects(tmp_path):
    """Apple's own samples have them, and its players read them."""
    (tmp_path / "latch.ahap").write_text(
        """{
    "Version" : 1.0,
    "Metadata" : { "Description" : "a latch, ] and a spring", },
    "Pattern" : [
        { "Event" : { "Time" : 0.25, "EventType" : "HapticTransient", "EventParameters" : [
            { "ParameterID" : "HapticIntensity", "ParameterValue" : 0.5 },
        ] } },
    ],
}"""
    )
    file = read_haptic(tmp_path / "latch.ahap")
    assert [(tap.time, tap.amplitude) for tap in file.events.transients] == [(0.25, 0.25)]
    assert file.metadata == {"comment": "a latch, ] and a spring"}
    assert check_file(tmp_path / "latch.ahap")["warnings"] == [
        "the last member of a list or object must not have a comma: left out"
    ]


def test_a_haptic_clip_must_be_json(tmp_path):
    """Meta's reader refuses a comma at the end."""
    (tmp_path / "x.haptic").write_text(HAPTIC % 1 + ",")
    (tmp_path / "y.haptic").write_text((HAPTIC % 1).replace("]}", ",]}"))
    for name in ("x", "y"):
        with pytest.raises(DataError, match="not a JSON document"):
            read_haptic(tmp_path / f"{name}.haptic")
