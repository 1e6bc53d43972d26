from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import welch
from scipy.stats import spearmanr

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.errors import ParameterError
from tactogram_simulate import make, tasks
from tactogram_simulate.contact import FINGERTIP, STYLUS
from tactogram_simulate.random_surfaces import (
    FORCES_N,
    SPEEDS_MM_S,
    random_contactor,
    random_surface,
)
from tactogram_simulate.raters import surface_cues
from tactogram_simulate.raters.rules import touch_words
from tactogram_simulate.surfaces import Roughness, Surface


def test_seed_and_number_make_a_surface_and_its_contactor():
    assert random_surface(3, 5) == random_surface(3, 5)
    assert len({random_surface(seed, number) for seed in (0, 1) for number in range(50)}) == 100
    styluses = [random_contactor(0, number, STYLUS) for number in range(200)]
    assert {stylus.name for stylus in styluses} == {"stylus"}
    masses = np.log([stylus.mass_kg / STYLUS.mass_kg for stylus in styluses])
    assert (masses.mean(), masses.std()) == pytest.approx((0, 0.35), abs=0.06)
    assert random_contactor(1, 7, FINGERTIP) == random_contactor(1, 7, FINGERTIP)
    assert random_contactor(1, 7, FINGERTIP) != random_contactor(2, 7, FINGERTIP)


def test_strokes_cover_speeds_and_forces_and_are_felt():
    todo = tasks("surfaces", seed=0, random=200, per_class=4)
    assert len(todo) == 800
    for values, (low, high) in (
        ([task.speed_mm_s for task in todo], SPEEDS_MM_S),
        ([task.force_n for task in todo], FORCES_N),
    ):
        assert low <= min(values) < 1.1 * low
        assert 0.9 * high < max(values) <= high
        assert np.median(values) == pytest.approx(np.sqrt(low * high), rel=0.15)
    recordings = [make(replace(task, seconds=1.0)) for task in todo[:12:4]]
    levels = [r.streams["acceleration"].samples.std(axis=1).max() for r in recordings]
    assert min(levels) > 0.05
    assert max(levels) < 100
    for task, recording in zip(todo[:12:4], recordings, strict=True):
        assert recording.material == random_surface(0, task.surface).name
        assert recording.simulated
        assert (recording.speed_mm_s, recording.force_n) == (task.speed_mm_s, task.force_n)
        assert np.median(recording.streams["force"].samples) == pytest.approx(task.force_n, rel=0.3)


def test_finger_and_stylus_take_turns_on_a_surface():
    todo = tasks("surfaces", seed=0, random=2, per_class=4)
    assert [task.contactor for task in todo] == ["finger", "stylus"] * 4
    assert [make(replace(task, seconds=0.2)).contactor for task in todo[:2]] == ["finger", "stylus"]


def test_surfaces_grow_with_speed_and_hardly_move_or_grow_with_force():
    """Real materials under a stylus: level by speed^1.0 and force^0.2, centroid by speed^0.2."""
    todo = tasks(
        "surfaces", seed=1, random=5, per_class=2, speeds_mm_s=(60.0, 120.0, 240.0), own_images=False
    )
    rows = []
    for surface in range(5):
        at, figures = [], []
        for task in [each for each in todo if each.surface == surface and each.contactor == "stylus"]:
            x = make(task).streams["acceleration"].samples
            frequency, density = welch(x, 2500, nperseg=512)
            density = density.sum(0) * ((frequency >= 20) & (frequency <= 480))
            centroid = (density * frequency).sum() / density.sum()
            at.append(np.log([task.speed_mm_s, task.force_n]))
            figures.append([np.log(density.sum()) / 2, np.log(centroid)])
        rows.append(np.hstack([np.array(at) - np.mean(at, 0), np.array(figures) - np.mean(figures, 0)]))
    table = np.vstack(rows)
    by_speed, by_force = np.linalg.lstsq(table[:, :2], table[:, 2:], rcond=None)[0]
    assert by_speed[0] == pytest.approx(1.0, abs=0.3)
    assert by_force[0] == pytest.approx(0.2, abs=0.2)
    assert by_speed[1] == pytest.approx(0.2, abs=0.25)


def test_speeds_may_be_given():
    todo = tasks("surfaces", seed=0, random=2, per_class=3, speeds_mm_s=(50.0, 200.0))
    assert [task.speed_mm_s for task in todo] == [50.0] * 3 + [200.0] * 3 + [50.0] * 3 + [200.0] * 3
    assert len({(task.surface, task.take) for task in todo}) == 12


@pytest.mark.parametrize(
    ("set_name", "random", "got"), [("stroking9", 5, "5 of stroking9"), ("surfaces", 0, "0 of surfaces")]
)
def test_other_sets_and_no_surfaces_are_refused(set_name, random, got):
    with pytest.raises(ParameterError, match=f"random must be at least 1, of surfaces; got {got}"):
        tasks(set_name, seed=0, random=random)


def test_rougher_surfaces_are_called_rougher():
    rms = (0.002, 0.006, 0.02, 0.06)
    scores = [
        touch_words(surface_cues(Surface(f"rough {height}", (Roughness(height, 1.4, 0.2, 5),), 0.4)))
        for height in rms
    ]
    rough, sleek = np.array(scores)[:, [5, 1]].T
    assert spearmanr(rms, rough)[0] == 1
    assert spearmanr(rms, sleek)[0] == -1


@pytest.mark.slow
def test_the_store_has_strokes_photographs_and_ratings(tmp_path, capsys):
    for name, workers in (("one", "1"), ("two", "2")):
        command = [
            "data",
            "simulate",
            "surfaces",
            "--out",
            str(tmp_path / name),
            "--random",
            "2",
            "--seed",
            "2",
        ]
        command += [
            "--per-class",
            "2",
            "--seconds",
            "0.5",
            "--raters",
            "3",
            "--photographs",
            "4",
            "--workers",
            workers,
        ]
        assert main(command) == 0
    assert "--random 2" in (tmp_path / "one" / "dataset.json").read_text()
    one, two = (open_store(tmp_path / name) for name in ("one", "two"))
    names = tuple(random_surface(2, number).name for number in range(2))
    assert one.sha256 == two.sha256
    assert (one.simulated, len(one)) == (True, 4)
    assert one.ratings.items == names
    assert {name: len(keys) for name, keys in one.photographs_by_material.items()} == dict.fromkeys(names, 4)
    assert "simulated" in capsys.readouterr().out
