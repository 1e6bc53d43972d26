"""How rated signals, rated images, and surfaces beside rated signals are shared out."""

import numpy as np
import pytest

from tactogram.datasets import EVOKED, Ratings, Recording, create_store
from tactogram.errors import ParameterError
from tactogram.model import ImageKind, SignalKind
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal
from tactogram.training.run import Run
from tactogram.workflows.training.loaded_run import LoadedRun
from tactogram.workflows.training.rated_examples import RatingData

FACTS = {"name": "test", "licence": "CC0-1.0", "simulated": True}


def signal(seed, *, axes=1, unit="1"):
    names = tuple("xyzw"[:axes])
    return Signal(np.random.default_rng(seed).standard_normal((axes, 40)), 100.0, unit, names)


def ratings_of(items, **changes):
    rows = [(rater, item) for item in items for rater in ("r1", "r2")]
    score = np.array([float(number % 2 + 1 - (changes != {})) for number in range(len(rows))])
    return Ratings(
        tuple(r for r, _ in rows), tuple(i for _, i in rows), ("rough",) * len(rows), score, **changes
    )


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """Four plates measured five times, ten rated signals, and one signal and one plate that nobody rated."""
    plates = [
        Recording(
            streams={"strain": signal(100 * p + m, axes=4, unit="V")},
            material=f"plate{p}",
            session=f"plate{p}-m{m}",
            source=f"plate{p}/{m}",
        )
        for p in range(5)
        for m in range(5)
    ]
    drives = [
        Recording(streams={"drive": signal(n)}, labels={"item": f"signal{n:02d}"}, source=f"signal{n}")
        for n in range(11)
    ]
    rated = ratings_of([*(f"plate{p}" for p in range(4)), *(f"signal{n:02d}" for n in range(10))])
    path = tmp_path_factory.mktemp("both") / "s"
    return create_store(path, plates + drives, ratings=rated, **FACTS)


@pytest.fixture(scope="module")
def images(tmp_path_factory):
    """Twenty rated images, two pictures each of the first five, and one that nobody rated."""
    rng = np.random.default_rng(0)
    pictures = [
        (f"image{n:02d}", Image(rng.integers(0, 256, (8, 8, 3), np.uint8))) for n in [*range(21), *range(5)]
    ]
    rated = ratings_of([f"image{n:02d}" for n in range(20)], scale=EVOKED)
    path = tmp_path_factory.mktemp("images") / "s"
    return create_store(path, [], photographs=pictures, ratings=rated, **FACTS)


def split_of(data, *, split="", by="recording", seed=0, prepare=None):
    return data.split(list(data.store.index), prepare or Preparation(), split=split, by=by, seed=seed)


def items_of(data, split, part):
    return [example.item for example in data.examples(split, part, Preparation())]


def test_rated_signals_are_split_by_item(both):
    data = RatingData(both, "ratings")
    found = split_of(data, prepare=Preparation(stream="drive"))
    parts = {part: set(items_of(data, found, part)) for part in ("train", "validation", "test")}
    assert set.union(*parts.values()) == {f"signal{n:02d}" for n in range(10)}
    assert sum(map(len, parts.values())) == 10
    assert {part: len(held) for part, held in parts.items()} == {"train": 7, "validation": 1, "test": 2}
    assert split_of(data, prepare=Preparation(stream="drive")).parts == found.parts
    assert split_of(data, prepare=Preparation(stream="drive"), seed=1).parts != found.parts


def test_measurements_of_a_surface_stay_together_where_signals_are_learned_from(both):
    data = RatingData(both, "ratings")
    found = split_of(data, prepare=Preparation(stream="strain"))
    parts = [set(items_of(data, found, part)) for part in ("train", "validation", "test")]
    assert not parts[0] & parts[2]
    assert not parts[0] & parts[1]
    assert set.union(*parts) == {f"plate{p}" for p in range(4)}


def test_both_splits_surfaces_by_session_and_trains_on_every_rated_signal(both):
    data = RatingData(both, "both")
    found = split_of(data, by="session")
    train = items_of(data, found, "train")
    assert [item for item in train if item.startswith("signal")] == [f"signal{n:02d}" for n in range(10)]
    assert all(item.startswith("plate") for item in items_of(data, found, "test"))
    by_recording = split_of(data, by="recording")
    assert set(items_of(data, by_recording, "test")) == {f"plate{p}" for p in range(4)}
    assert "plate4" not in train
    sessions = [{both.info(s.id).session for s in found.parts[part]} - {None} for part in ("train", "test")]
    assert not sessions[0] & sessions[1]


def test_the_kind_of_both_is_that_of_the_rated_signals(both):
    data = RatingData(both, "both")
    kind = data.kind(data.examples(split_of(data, by="session"), "train", Preparation()))
    assert isinstance(kind, SignalKind)
    assert (kind.unit, len(kind.axes), kind.words, kind.scale) == ("1", 1, ("rough",), (1.0, 7.0))
    assert kind.materials == ("plate0", "plate1", "plate2", "plate3")
    assert kind.simulated


def test_images_are_split_by_item_and_are_learned_from_where_there_are_no_recordings(images):
    data = RatingData(images, "ratings")
    assert data.of_images
    found = split_of(data)
    parts = [items_of(data, found, part) for part in ("train", "validation", "test")]
    assert [len(set(part)) for part in parts] == [14, 2, 4]
    assert not set(parts[0]) & set(parts[2])
    assert sum(map(len, parts)) == 25
    one = data.examples(found, "train", Preparation())[0]
    assert one.image.pixels.shape == (8, 8, 3)
    np.testing.assert_array_equal(one.rated.scores, data.ratings.rated(one.item).scores)


def test_the_kind_of_images_names_the_items_trained_on(images):
    data = RatingData(images, "images")
    found = split_of(data)
    kind = data.kind(data.examples(found, "train", Preparation()))
    assert kind == ImageKind(("rough",), (0.0, 1.0), tuple(sorted(set(items_of(data, found, "train")))), True)


def test_all_keeps_nothing_apart(both, images):
    for data, count in ((RatingData(both, "both"), 30), (RatingData(images, "images"), 25)):
        found = split_of(data, split="all")
        assert [
            len(data.examples(found, part, Preparation())) for part in ("train", "validation", "test")
        ] == [
            count,
            0,
            0,
        ]


def test_a_store_that_does_not_fit_is_refused(tmp_path, both, images):
    bare = create_store(tmp_path / "bare", [Recording(streams={"a": signal(0)}, material="m")], **FACTS)
    with pytest.raises(ParameterError, match="has no ratings; `tactogram data rate`"):
        split_of(RatingData(bare, "ratings"))
    with pytest.raises(ParameterError, match="split must be all, or omitted, .* got 'last=2'"):
        split_of(RatingData(both, "ratings"), split="last=2")
    with pytest.raises(ParameterError, match="rated surfaces and rated signals .* got 0 and 0"):
        split_of(RatingData(images, "both"))
    with pytest.raises(ParameterError, match="none of its photographs was rated"):
        split_of(RatingData(both, "images"))
    with pytest.raises(ParameterError, match="none of its recordings has the stream 'sound' and was rated"):
        split_of(RatingData(both, "ratings"), prepare=Preparation(stream="sound"))


@pytest.mark.parametrize(
    "kind",
    [
        ImageKind(("rough", "sleek"), (0.0, 1.0), ("image01",), True),
        SignalKind(100.0, "1", ("x",), ("cork",), words=("rough",), scale=(1.0, 7.0)),
    ],
)
def test_a_run_remembers_its_kind(tmp_path, kind):
    run = Run(tmp_path)
    run.write_json("model.json", {"version": 1, "kind": vars(kind), "notes": []})
    assert run.kind() == kind


def test_a_run_of_images_has_no_kind_of_signal(tmp_path):
    class Facts:
        name = "painter"

    kind = ImageKind(("rough",), (0.0, 1.0), ("image01",), True)
    run = LoadedRun(Run(tmp_path / "r"), Facts(), None, kind, None)
    assert run.simulated
    with pytest.raises(ParameterError, match="r: painter is of images, not of signals"):
        _ = run.kind
