"""What learners get: cut first, prepared then, with the conditions that are known."""

import numpy as np
import pytest

from tactogram.datasets import Examples, Recording, Segment, create_store
from tactogram.datasets.examples import signal_kind
from tactogram.errors import ParameterError
from tactogram.model import Example
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal


def noise(seed, *, samples=1000, rate=1000.0, axes=("x", "y", "z"), unit="m/s^2"):
    return Signal(np.random.default_rng(seed).standard_normal((len(axes), samples)), rate, unit, axes)


def store_of(folder, *recordings):
    return create_store(folder / "store", recordings, name="test", licence="CC0-1.0")


def whole(store):
    return [Segment(info.id) for info in store.index]


@pytest.fixture
def store(tmp_path):
    picture = Image(np.random.default_rng(0).integers(0, 256, (4, 5, 3), dtype=np.uint8), 0.5)
    return store_of(
        tmp_path,
        Recording(
            streams={"acceleration": noise(1), "sound": noise(2, rate=8000.0, axes=("z",), unit="1")},
            material="cork",
            contactor="pen",
            speed_mm_s=100.0,
            force_n=0.5,
            ratings={"rough": 6.0},
            labels={"item": "cork 7"},
            image=picture,
            simulated=True,
        ),
        Recording(streams={"acceleration": noise(3)}, material="jeans"),
    )


def test_a_segment_is_cut_before_it_is_prepared(store):
    prepare = Preparation(axes=("y",), band=(20.0, 200.0), rate=500.0)
    [info, _] = store.index
    [example] = Examples(store, [Segment(info.id, 0.2, 0.7)], prepare)
    expected = prepare.apply(store.signal(info.id, "acceleration").cut(200, 700))
    np.testing.assert_array_equal(example.signal.samples, expected.samples)
    assert (example.signal.rate, example.signal.axes) == (500.0, ("y",))


def test_conditions_are_those_that_are_known(store):
    first, second = Examples(store, whole(store), Preparation())
    assert set(first.condition) == {"speed_mm_s", "force_n", "contactor", "words", "image"}
    assert first.condition["words"] == {"rough": 6.0}
    assert first.condition["image"].mm_per_pixel == 0.5
    assert first.material == "cork"
    assert dict(second.condition) == {}


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("material", ("cork", "jeans")),
        ("material+contactor", ("cork-pen", "jeans")),
        ("item", ("cork 7", "jeans")),
        (lambda info: info.contactor, ("pen",)),
    ],
)
def test_classes_are_as_asked_for(store, label, expected):
    examples = Examples(store, whole(store), Preparation(), label=label)
    assert examples.materials == expected
    assert signal_kind(examples).materials == expected


def test_an_unknown_label_is_refused(store):
    with pytest.raises(ParameterError, match="label must be"):
        Examples(store, whole(store), Preparation(), label="colour")[0]


def test_what_was_prepared_is_read_from_the_cache(store, tmp_path, monkeypatch):
    prepare = Preparation(band=(20.0, 200.0))
    first = Examples(store, whole(store), prepare, cache_dir=tmp_path / "cache")
    first.prepare_all(workers=2)
    expected = first[1].signal.samples.copy()
    monkeypatch.setattr(Preparation, "apply", lambda *_: pytest.fail("prepared again"))
    again = Examples(store, whole(store), prepare, cache_dir=tmp_path / "cache")
    np.testing.assert_array_equal(again[1].signal.samples, expected)
    assert not list((tmp_path / "cache").glob(".*.part*"))


def test_another_preparation_is_not_taken_from_the_cache(store, tmp_path):
    cache = tmp_path / "cache"
    [one] = Examples(store, whole(store)[:1], Preparation(rate=500.0), cache_dir=cache)
    [two] = Examples(store, whole(store)[:1], Preparation(rate=250.0), cache_dir=cache)
    assert (one.signal.rate, two.signal.rate) == (500.0, 250.0)


def test_the_temporary_cache_goes_with_the_object(store):
    examples = Examples(store, whole(store), Preparation())
    assert len(examples[0].signal) == 1000
    folder = examples._cache
    assert folder.is_dir()
    del examples
    assert not folder.exists()


def test_all_that_is_prepared_is_counted(store):
    seen = []
    Examples(store, whole(store), Preparation()).prepare_all(
        progress=lambda done, total: seen.append((done, total))
    )
    assert seen == [(1, 2), (2, 2)]


def test_a_segment_beyond_the_end_is_refused(store):
    with pytest.raises(ParameterError, match="must begin within its 1 s"):
        Examples(store, [Segment(store.index[0].id, 1.0)], Preparation())[0]


def test_an_unknown_recording_is_refused(store):
    with pytest.raises(ParameterError, match="recording must be one of"):
        Examples(store, [Segment("0" * 16)], Preparation())


def test_simulated_is_told(store):
    assert signal_kind(Examples(store, whole(store), Preparation())).simulated
    assert not signal_kind(Examples(store, whole(store)[1:], Preparation())).simulated


@pytest.mark.parametrize(
    ("other", "says"),
    [
        (noise(2, rate=500.0), r"one rate, got 1000 and 500 Hz; prepare.rate"),
        (
            noise(2, axes=("x",)),
            r"same axes, got x,y,z and x; prepare.axes.* prepare.stream=NAME",
        ),
        (
            noise(2, unit="V"),
            r"one unit and domain, got m/s\^2 over time and V over time; prepare.stream",
        ),
    ],
)
def test_mixed_kinds_are_refused_and_the_option_named(other, says):
    with pytest.raises(ParameterError, match=says):
        signal_kind([Example("a", noise(1)), Example("b", other)])


def test_no_examples_have_no_kind(store):
    with pytest.raises(ParameterError, match="no examples"):
        signal_kind(Examples(store, [], Preparation()))
