"""What splits promise: nothing on two sides, every recording used, the same seed the same split."""

import json
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from tests.datasets.store.sample_photographs import by_recording, store_of

from tactogram.datasets import (
    RecordingInfo,
    Region,
    Segment,
    Split,
    split_fractions,
)
from tactogram.errors import DataError, LeakError


@st.composite
def indices(draw, least=1):
    """Recordings of some materials, sessions, subjects and speeds."""
    counts = draw(st.lists(st.integers(least, 12), min_size=1, max_size=5))
    return [
        RecordingInfo(
            id=f"{m}-{i}",
            material=f"m{m}",
            session=f"day{draw(st.integers(0, 4))}",
            subject=f"s{i % 3}",
            speed_mm_s=100.0 * (1 + i % 4),
            source=f"m{m}/{i}.wav",
        )
        for m, count in enumerate(counts)
        for i in range(count)
    ]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"test": (Segment("a"),)}, "recording a is in test and in train"),
        ({"validation": (Segment("b"),)}, "recording b is in test and in validation"),
        (
            {"by": "session", "groups": {"a": "monday", "b": "monday"}},
            "session 'monday' is in train and in test",
        ),
        (
            {"by": "block", "gap_s": 0.5, "train": (Segment("a", 0, 1),), "test": (Segment("a", 1.4, 2),)},
            "recording a: train and test must lie 0.5 s apart, got 0.4 s",
        ),
        (
            {
                "by": "block",
                "train": (Segment("a", 0, 3), Segment("a", 0.5, 1)),
                "test": (Segment("a", 2, 4),),
            },
            "got -1 s at 2 s",
        ),
        ({"by": "block", "train": (Segment("a"),), "test": (Segment("a", 2, 4),)}, "got -inf s at 2 s"),
        (
            {"train": (Segment("a", 0, 1),), "test": (Segment("a", 9, 10),)},
            "recording a is in test and in train",
        ),
    ],
)
def test_a_leak_is_an_error(changes, says):
    whole = Split((Segment("a"),), (), (Segment("b"),), "recording")
    with pytest.raises(LeakError, match=says):
        replace(whole, **changes)


@given(index=indices(least=3), seed=st.integers(0, 9))
def test_what_is_written_down_comes_back(tmp_path_factory, index, seed):
    path = tmp_path_factory.mktemp("split") / "split.json"
    split = split_fractions(index, by="recording", seed=seed)
    split.save(path)
    assert Split.load(path) == split


def test_a_leak_in_a_file_is_found(tmp_path):
    path = tmp_path / "split.json"
    Split((Segment("a"),), (), (Segment("b"),), "recording").save(path)
    values = json.loads(path.read_text())
    values["test"].append(["a", 0.0, None])
    path.write_text(json.dumps(values))
    with pytest.raises(LeakError):
        Split.load(path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x", "not a JSON document"),
        ("{}", "not a split"),
        ('{"format": "tactogram-split", "version": 9}', "version must be 1, got 9"),
        ('{"format": "tactogram-split", "version": 1}', "train: is missing"),
    ],
)
def test_a_broken_file_is_refused_in_one_line(tmp_path, text, says):
    path = tmp_path / "split.json"
    path.write_text(text)
    with pytest.raises(DataError, match=says):
        Split.load(path)


@pytest.mark.parametrize(
    ("first", "second", "gap", "fine"),
    [
        (Region("a"), Region("a"), 0, False),
        (Region("a"), Region("b"), 9, True),
        (Region("a", 0, 0, 10, None), Region("a", 10), 0, True),
        (Region("a", 0, 0, 10, None), Region("a", 10), 1, False),
        (Region("a", 0, 0, 11, None), Region("a", 10), 0, False),
        (Region("a", 0, 0, 10, 10), Region("a", 14, 4, 20, 20), 4, True),
        (Region("a", 0, 0, 10, 10), Region("a", 4, 15, 20, 20), 5, True),
        (Region("a", 0, 0, 10, 10), Region("a", 4, 15, 20, 20), 6, False),
    ],
)
def test_regions_that_touch_leak(first, second, gap, fine):
    def split():
        held = {"train": (first,), "test": (second,)}
        return Split((Segment("r"),), (), (), "recording", photographs=held, photograph_gap=gap)

    if fine:
        split()
    else:
        with pytest.raises(LeakError, match=r"photograph a: its regions in train and test"):
            split()


def test_the_same_pixels_twice_in_one_part_are_no_leak():
    held = {"train": (Region("a"), Region("a", 3))}
    Split((Segment("r"),), (), (), "recording", photographs=held, photograph_gap=5)


def test_a_split_of_before_photographs_loads_and_is_the_same_value(tmp_path):
    store = store_of(tmp_path, {"cork": 1})
    plain = by_recording(store)
    plain.save(tmp_path / "split.json")
    assert "photograph" not in (tmp_path / "split.json").read_text()
    assert Split.load(tmp_path / "split.json") == plain
    assert set(plain.as_dict()) == {"train", "validation", "test", "by", "seed", "gap_s", "groups"}
