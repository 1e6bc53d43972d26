"""Simulated sets."""

from dataclasses import replace

import numpy as np
import pytest
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from tactogram.datasets import open_store
from tactogram.errors import ParameterError
from tactogram_simulate import make, simulate_to_store, simulated_sets, tasks
from tactogram_simulate.sensor import GRAVITY
from tactogram_simulate.sets import SETS, STROKING_9
from tactogram_simulate.stroke import LENGTH_MM


def test_the_same_seed_gives_the_same_bits_in_any_order():
    todo = tasks("stroking30", seed=3, per_class=1, seconds=1)[5:7]
    ids = [make(task).id for task in todo]
    assert [make(task).id for task in reversed(todo)] == ids[::-1]
    assert make(replace(todo[0], seed=4)).id not in ids


def test_takes_differ_and_take_n_does_not_depend_on_how_many_there_are():
    few = [make(task).id for task in tasks("stroking9", seed=0, per_class=1, seconds=0.5)[4:6]]
    many = [make(task).id for task in tasks("stroking9", seed=0, per_class=2, seconds=0.5)[8:12]]
    assert len(set(many)) == 4
    assert few == many[::2]


def test_a_recording_says_what_it_is():
    r = make(tasks("stroking30", seed=0, seconds=4)[0])
    assert r.simulated
    assert (r.material, r.contactor, r.speed_mm_s, r.session) == ("carpet1", "finger", 100.0, "take-1")
    acceleration = r.stream("acceleration")
    assert (acceleration.rate, acceleration.unit, acceleration.axes) == (330.0, "m/s^2", ("x", "y", "z"))
    assert acceleration.seconds == pytest.approx(4, abs=0.02)
    assert np.linalg.norm(acceleration.samples.mean(1)) == pytest.approx(GRAVITY, rel=0.02)
    assert r.stream("force").samples.min() > 0
    assert r.stream("friction").unit == "1"
    assert r.stream("position").axes == ("x", "y")
    assert np.ptp(r.stream("position").axis("x")) == pytest.approx(1e-3 * LENGTH_MM, rel=0.2)
    assert r.labels == {"recording": "1"}
    assert any("packets" in line for line in r.history)
    assert r.image.mm_per_pixel == pytest.approx(0.15)


def test_the_layouts_are_those_of_the_paper():
    """Saga et al., Sec. II-C: "30 types of combinations between the objects and contactors"."""
    todo = tasks("stroking30", seed=0)
    assert len({(t.surface, t.contactor) for t in todo}) == 30
    assert {t.speed_mm_s for t in todo} == {100.0, 200.0, 400.0}
    assert len(todo) == 30 * 3 * 3
    assert {t.seconds for t in todo} == {180.0}
    nine = tasks("stroking9", seed=0, per_class=1)
    assert len(nine) == 9
    assert {t.seconds * t.rate for t in nine} == {4000.0}
    assert all(text.startswith("simulated") for text in simulated_sets().values())


@pytest.mark.parametrize("rate", [330.0, 1000.0, 6000.0, 10_000.0])
def test_rates(rate):
    signal = make(tasks("stroking9", seed=0, per_class=1, seconds=0.5, rate=rate)[4]).stream("acceleration")
    assert signal.rate == rate
    assert len(signal) == pytest.approx(rate / 2, abs=2)


def test_the_classes_are_separable_but_not_trivially():
    features, classes, takes = [], [], []
    for task in tasks("stroking30", seed=0, per_class=3, seconds=6.1, own_images=False):
        if task.speed_mm_s != 200 or task.surface % 5:  # every fifth surface, with either contactor
            continue
        signal = make(task).stream("acceleration")
        n = len(signal) // 200
        windows = signal.samples[:, : n * 200].reshape(3, n, 200)
        power = np.abs(np.fft.rfft(windows * np.hanning(200), axis=-1)) ** 2
        bands = np.stack([power[..., a : a + 6].mean(-1) for a in range(1, 97, 6)], -1)
        features.append(np.log(bands + 1e-9).transpose(1, 0, 2).reshape(n, -1))
        classes += [f"{task.surface}-{task.contactor}"] * n
        takes += [task.take] * n
    x, y, take = np.concatenate(features), np.array(classes), np.array(takes)
    judge = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto").fit(x[take < 3], y[take < 3])
    accuracy = np.mean(judge.predict(x[take == 3]) == y[take == 3])
    assert 0.4 < accuracy < 0.99


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"set_name": "x"}, "simulated set must be one of stroking30, .*, tactile_images, got 'x'"),
        ({"per_class": 0}, "per_class must be at least 1, got 0"),
        ({"seconds": 0.0}, "seconds must be 0.1 to 3600, got 0"),
        ({"rate": 5.0}, "rate must be 50 to 20000 Hz, got 5"),
        ({"seed": -1}, "seed must be >= 0, got -1"),
    ],
)
def test_what_cannot_be_simulated_is_refused(options, message):
    with pytest.raises(ParameterError, match=message):
        tasks(**({"set_name": "stroking9", "seed": 0} | options))


def test_a_store_is_marked_simulated_and_the_same_from_any_number_of_processes(tmp_path, monkeypatch):
    from tactogram.datasets import open_store
    from tactogram_simulate import simulate_to_store

    nine = SETS["stroking9"]
    monkeypatch.setitem(SETS, "stroking9", replace(nine, surfaces=nine.surfaces[:1]))
    report = simulate_to_store("stroking9", tmp_path / "s", seed=1, per_class=4, seconds=0.5, workers=2)
    store = open_store(tmp_path / "s")
    assert report["simulated"]
    assert store.simulated
    assert all(info.simulated for info in store.index)
    assert len(store) == 4
    alone = simulate_to_store("stroking9", tmp_path / "t", seed=1, per_class=4, seconds=0.5, workers=1)
    assert alone["sha256"] == report["sha256"]


def test_a_store_of_several_photographs_each(tmp_path, monkeypatch):
    few = replace(SETS["stroking9"], surfaces=STROKING_9[:1])
    monkeypatch.setitem(SETS, "stroking9", few)
    common = {"seed": 0, "per_class": 1, "seconds": 0.2, "workers": 1}
    with pytest.raises(ParameterError, match="room for"):
        simulate_to_store("stroking9", tmp_path / "no", photographs=10, **common)
    assert list(tmp_path.iterdir()) == []
    report = simulate_to_store("stroking9", tmp_path / "s", photographs=2, **common)
    assert (report["recordings"], report["photographs"]) == (1, 2)
    store = open_store(tmp_path / "s")
    assert {len(keys) for keys in store.photographs_by_material.values()} == {2}
    assert all(store.image(info.id) is None for info in store.index)
    assert "--photographs 2" in store.facts.source
