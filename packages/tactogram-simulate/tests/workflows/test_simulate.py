from dataclasses import replace

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import item_of, open_store
from tactogram.datasets.ratings.words import WORDS
from tactogram.datasets.store import writer
from tactogram.errors import ParameterError
from tactogram_simulate import materials, sets, simulate_to_store, studies
from tactogram_simulate.sets import SETS
from tactogram_simulate.studies import study


@pytest.fixture
def one_plate(monkeypatch):
    """Leave one of the twelve plates: a height field takes its time."""
    plates = materials.PLATES[8:9]
    monkeypatch.setattr(studies, "PLATES", plates)
    monkeypatch.setattr(sets, "PLATES", plates)
    facts = replace(sets.SETS["ultrasonic"], surfaces=tuple(plate.surface for plate in plates))
    monkeypatch.setitem(sets.SETS, "ultrasonic", facts)


def test_the_store_of_the_ultrasonic_study(one_plate, tmp_path):
    facts = simulate_to_store(
        "ultrasonic", tmp_path / "one", seed=0, per_class=2, seconds=0.5, raters=3, workers=1
    )
    store = open_store(tmp_path / "one")
    surfaces = [info for info in store.index if info.material]
    signals = [info for info in store.index if not info.material]
    assert (len(surfaces), len(signals)) == (2, 39)
    assert {store.streams_of(info.id) for info in surfaces} == {("strain",)}
    assert {store.streams_of(info.id) for info in signals} == {("drive",)}
    assert sorted(info.session for info in surfaces) == [
        "plate09-m01",
        "plate09-m02",
    ]
    assert {item_of(info) for info in store.index} == set(store.ratings.items)
    assert store.simulated
    assert store.ratings.words == WORDS
    assert (facts["raters"], facts["items"], facts["materials"]) == (3, 40, 1)
    again = simulate_to_store(
        "ultrasonic", tmp_path / "two", seed=0, per_class=2, seconds=0.5, raters=3, workers=1
    )
    assert again["sha256"] == facts["sha256"]


def test_the_store_of_the_image_study(tmp_path, capsys):
    out = tmp_path / "images"
    assert main(["data", "simulate", "tactile_images", "--out", str(out), "--per-class", "1"]) == 0
    store = open_store(out)
    assert len(store) == 0
    assert len(store.photograph_keys()) == 16
    assert store.ratings.items == tuple(f"image{n:03d}" for n in range(1, 17))
    assert set(store.ratings.items) == set(store.photographs_by_material)
    assert "simulated" in capsys.readouterr().out


def test_four_sets_of_images_are_each_seen_by_thirty_of_37():
    """Hatori et al. 2025, Sec. II-B: "the number of participants adjusted to 30 per set"."""
    ratings = study("tactile_images", seed=0, per_class=1).ratings
    assert len(ratings.raters) == 37
    seen = ~np.isnan(ratings.cube).all(2)
    assert set(seen.sum(1)) == {30}
    of_set = {
        name: {i for i, s in zip(ratings.item, ratings.session, strict=True) if s == name}
        for name in set(ratings.session)
    }
    assert sorted(of_set) == ["set1", "set2", "set3", "set4"]
    assert {len(items) for items in of_set.values()} == {4}
    assert sum(len(items) for items in of_set.values()) == 16


def test_an_items_name_does_not_say_what_it_shows():
    one, other = (
        dict(study("tactile_images", seed=seed, per_class=1, raters=1).photographs) for seed in (0, 0)
    )
    assert all(np.array_equal(one[name].pixels, other[name].pixels) for name in one)
    contrasts = [image.pixels.std() for image in one.values()]
    made = [studies.tactile_image(family, 0, seed=0).pixels.std() for family in studies.FAMILIES]
    assert sorted(contrasts) == sorted(made)
    assert contrasts != made


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"set_name": "stroking9", "raters": 3}, "stroking9 has no ratings"),
        ({"set_name": "tactile_images", "raters": 0}, "at least one simulated rater"),
        ({"set_name": "tactile_images", "per_class": 0}, "per_class must be greater than or equal to 1"),
        ({"set_name": "tactile_images", "seconds": 2.0}, "holds images alone"),
    ],
)
def test_what_makes_no_sense_is_refused_and_leaves_nothing(options, said, tmp_path):
    with pytest.raises(ParameterError, match=said):
        simulate_to_store(out=tmp_path / "store", seed=0, **options)
    assert not list(tmp_path.iterdir())


REQUEST = {"set_name": "surfaces", "random": 2, "per_class": 2, "seconds": 0.2, "raters": 2, "workers": 1}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return simulate_to_store(out=tmp_path_factory.mktemp("whole") / "store", **REQUEST)


@pytest.mark.parametrize("when", [("rate", 1), ("simulate", 2)])
def test_an_interrupted_simulation_goes_on_to_the_same_store(when, whole, tmp_path, monkeypatch):
    monkeypatch.setattr(writer, "KEPT_S", 0)
    made = []

    def interrupted(stage, done, total, note=""):
        if (stage, done) == when:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate_to_store(out=tmp_path / "store", progress=interrupted, **REQUEST)
    (left,) = tmp_path.glob("store.part-*") if when[0] == "simulate" else [None]
    if left is not None:  # as of a process that has ended
        left.rename(left.with_name(f"{left.name.rpartition('-')[0]}-{2**22 + 1}"))
    again = simulate_to_store(
        out=tmp_path / "store",
        progress=lambda stage, done, total, note="": made.append((stage, done)),
        **REQUEST,
    )
    assert again == whole | {"store": str(tmp_path / "store")}
    assert min(done for stage, done in made if stage == "simulate") == (3 if when[0] == "simulate" else 1)
    assert [done for stage, done in made if stage == "rate"] == ([] if when[0] == "simulate" else [2])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["store"]


@pytest.fixture
def few_surfaces(monkeypatch):
    """Two of the nine: each takes most of a second to make."""
    nine = SETS["stroking9"]
    monkeypatch.setitem(SETS, "stroking9", replace(nine, surfaces=nine.surfaces[1:3]))


@pytest.mark.usefixtures("few_surfaces")
def test_a_simulated_store_says_the_command_that_makes_it(tmp_path):
    options = {"seed": 3, "per_class": 1, "seconds": 0.5, "rate": 500.0}
    with pytest.raises(ParameterError, match="workers must be greater than or equal to 1"):
        simulate_to_store("stroking9", tmp_path / "store", workers=-1, **options)
    assert not (tmp_path / "store").exists()
    simulate_to_store("stroking9", tmp_path / "store", workers=1, **options)
    said = open_store(tmp_path / "store").facts.source
    assert said == "tactogram data simulate stroking9 --seed 3 --per-class 1 --seconds 0.5 --rate 500"


@pytest.mark.usefixtures("few_surfaces")
def test_a_simulated_set_takes_other_speeds_and_says_so(tmp_path):
    options = {"seed": 3, "per_class": 1, "seconds": 0.5, "workers": 1}
    simulate_to_store("stroking9", tmp_path / "store", speeds_mm_s=(50.0, 100.0), **options)
    store = open_store(tmp_path / "store")
    assert sorted({info.speed_mm_s for info in store.index}) == [50.0, 100.0]
    assert store.facts.source.endswith("--seconds 0.5 --speeds 50,100")
    for speeds, words in (((), "1 to 2000"), ((0.0,), "1 to 2000"), ((50.0, 50.0), "speeds must differ")):
        with pytest.raises(ParameterError, match=words):
            simulate_to_store("stroking9", tmp_path / "no", speeds_mm_s=speeds, **options)
    code = main(["data", "simulate", "stroking9", "--speeds", "fast", "--out", str(tmp_path / "no")])
    assert code == 1
    assert not (tmp_path / "no").exists()
