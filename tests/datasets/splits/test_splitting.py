"""Splits at random, in order, in folds and by blocks."""

import math
from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import assume, given, strategies as st

from tactogram.datasets import RecordingInfo
from tactogram.datasets.splits.splitting import (
    contiguous_blocks,
    kfold,
    natural_order,
    split_fractions,
    split_last,
)
from tactogram.errors import ParameterError

GROUPS = ("session", "subject", "material", "condition")


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


def ids(segments):
    return [segment.id for segment in segments]


def all_ids(split):
    return sorted(id for part in split.parts.values() for id in ids(part))


@given(
    index=indices(),
    by=st.sampled_from(("recording", *GROUPS)),
    test=st.floats(0, 0.6),
    validation=st.floats(0, 0.3),
    seed=st.integers(0, 2**32),
)
def test_fractions_use_every_recording_once(index, by, test, validation, seed):
    try:
        split = split_fractions(index, by=by, test=test, validation=validation, seed=seed)
    except ParameterError as error:
        assert "would be empty" in str(error)  # noqa: PT017
        return
    assert all_ids(split) == sorted(info.id for info in index)
    assert split.train
    assert bool(split.test) == (test > 0)
    assert bool(split.validation) == (validation > 0)
    again = split_fractions(index[::-1], by=by, test=test, validation=validation, seed=seed)
    assert {p: set(held) for p, held in again.parts.items()} == {
        p: set(held) for p, held in split.parts.items()
    }
    if by != "recording":
        sides = {(split.groups[s.id], part) for part, held in split.parts.items() for s in held}
        assert max(Counter(group for group, _ in sides).values()) == 1


@given(index=indices(least=3), seed=st.integers(0, 1000))
def test_every_part_has_every_material(index, seed):
    split = split_fractions(index, seed=seed)
    material = {info.id: info.material for info in index}
    for part in split.parts.values():
        assert {material[id] for id in ids(part)} == set(material.values())


def test_fractions_are_those_asked_for():
    index = [RecordingInfo(id=f"{m}-{i}", material=str(m)) for m in range(20) for i in range(50)]
    split = split_fractions(index, test=0.2, validation=0.1, seed=0)
    assert [len(part) for part in split.parts.values()] == [700, 100, 200]
    assert split != split_fractions(index, test=0.2, validation=0.1, seed=1)


@given(
    index=indices(),
    by=st.sampled_from(("recording", *GROUPS)),
    folds=st.integers(2, 6),
    seed=st.integers(0, 99),
)
def test_kfold_tests_every_recording_once(index, by, folds, seed):
    try:
        splits = kfold(index, folds, by=by, seed=seed, validation=0.2)
    except ParameterError as error:
        assert "needs at least" in str(error)  # noqa: PT017
        return
    tested = [id for split in splits for id in ids(split.test)]
    assert sorted(tested) == sorted(info.id for info in index)
    for split in splits:
        assert all_ids(split) == sorted(info.id for info in index)
        assert split.train
    assert splits == kfold(index, folds, by=by, seed=seed, validation=0.2)


def test_kfold_tests_every_class_in_every_fold():
    index = [
        RecordingInfo(id=f"{m}{c}{i}", material=str(m), contactor=c)
        for m in range(5)
        for c in ("pen", "finger")
        for i in range(4)
    ]
    for split in kfold(index, 4, seed=3, label="material+contactor"):
        assert Counter(id[:-1] for id in ids(split.test)) == dict.fromkeys({i.id[:-1] for i in index}, 1)


def test_kfold_with_fewer_recordings_than_folds_says_what_to_do():
    index = [RecordingInfo(id=str(i), material="cork") for i in range(3)]
    with pytest.raises(
        ParameterError, match="cork: needs at least 4 recordings of a class, got 3; .*`split=blocks`"
    ):
        kfold(index, 4, seed=0)


def test_last_is_by_number_not_by_letter():
    index = [
        RecordingInfo(id=f"{m}{i}", material=m, source=f"{m}/take{i}.wav")
        for i in (10, 9, 2, 1)
        for m in "ab"
    ]
    split = split_last(index, 2, validation=1)
    assert set(ids(split.test)) == {"a9", "a10", "b9", "b10"}
    assert set(ids(split.validation)) == {"a2", "b2"}
    assert set(ids(split.train)) == {"a1", "b1"}


def test_the_recording_number_goes_before_the_source():
    index = [RecordingInfo(id=str(n), source=f"{9 - n}.wav", labels={"recording": str(n)}) for n in range(9)]
    shuffled = index[4:] + index[:4]
    assert [info.id for info in sorted(shuffled, key=natural_order)] == [str(n) for n in range(9)]


def test_last_refuses_a_material_with_too_few():
    index = [RecordingInfo(id=str(i), material="cork") for i in range(8)]
    with pytest.raises(ParameterError, match="cork must have more than 8 recordings, got 8"):
        split_last(index, 8)


@given(
    lengths=st.lists(st.floats(1.0, 500.0), min_size=1, max_size=4),
    blocks=st.integers(2, 12),
    gap_s=st.floats(0.0, 0.05),
)
def test_blocks_cover_every_recording_and_keep_the_gap(lengths, blocks, gap_s):
    index = [RecordingInfo(id=str(i)) for i in range(len(lengths))]
    seconds = {str(i): length for i, length in enumerate(lengths)}
    assume(min(lengths) / blocks > gap_s)
    splits = contiguous_blocks(index, seconds, blocks=blocks, gap_s=gap_s)
    assert len(splits) == blocks
    for id, length in seconds.items():
        tested = [s for split in splits for s in split.test if s.id == id]
        assert tested[0].start_s == 0
        assert tested[-1].stop_s is None
        for before, after in pairwise(tested):
            assert before.stop_s == after.start_s
        for split in splits:
            [test] = [s for s in split.test if s.id == id]
            for train in (s for s in split.train if s.id == id):
                end, stop = test.stop_s or length, train.stop_s or length
                distance = train.start_s - end if train.start_s > test.start_s else test.start_s - stop
                assert distance == pytest.approx(gap_s, abs=1e-6)


def test_blocks_too_short_for_their_gaps_are_refused():
    with pytest.raises(ParameterError, match=r"a.wav of 1 s is too short for 2 blocks"):
        contiguous_blocks([RecordingInfo(id="a", source="a.wav")], {"a": 1.0}, blocks=2, gap_s=0.6)


@pytest.mark.parametrize("by", GROUPS)
def test_what_is_not_known_cannot_be_split_by(by):
    with pytest.raises(ParameterError, match=f"a.wav has no {by}: split by recording"):
        split_fractions([RecordingInfo(id="a", source="a.wav")], by=by, seed=0)


@pytest.mark.parametrize("bad", [{"test": -0.1}, {"test": 0.9, "validation": 0.1}, {"test": math.nan}])
def test_shares_that_are_none_are_refused(bad):
    with pytest.raises(ParameterError, match="must be below 1"):
        split_fractions([RecordingInfo(id=str(i)) for i in range(9)], seed=0, **bad)
