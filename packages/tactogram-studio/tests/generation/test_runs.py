"""Runs and state of the page Make: same samples as the command, comparison with recordings, results and history."""

import shlex
import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.cli.command import main
from tactogram.datasets import create_store
from tactogram.datasets.ratings.ratings import EVOKED, Ratings
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_signal
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.training.train import train
from tactogram_studio.generation.runs import (
    APART,
    MARGIN,
    NEIGHBOURS,
    GeneratingRuns,
    cropped,
    levels_db,
    point_of,
    positions,
    weights_at,
)
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.pages.make.page import MakePage
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive

VOICES = "studio/first/voices"


PLACES = np.array([[0.2, 0.2], [0.8, 0.2], [0.5, 0.8], [0.5, 0.45], [0.2, 0.7]])


unit = st.floats(0, 1)


@pytest.fixture
def state(workspace):
    """Give the state of a new page."""
    return state_of(workspace)


def state_of(folder):
    place = Workspace.at(folder)
    return MakePageState(place, ResultArchive(place.studio_folder / "kept"), GeneratingRuns(place), {})


def test_the_first_run_is_chosen_with_a_valid_form(state):
    assert state.run.name == VOICES
    assert state.run.kind.simulated
    assert len(state.form.materials) == 9

    ((number, made),) = state.runs.generate(state.request)

    assert number == 1
    assert made.axes == state.run.kind.axes


def test_a_model_that_comes_trained_is_last_and_generates_from_words(state):
    assert [run.title for run in state.runs.finished()][-1] == "texture_flow, ready to use"
    state.choose("texture_flow")
    assert (len(state.form.materials), "image" in state.form.instead) == (84, False)
    state.set(words={"rough": 6.0}, seconds=0.5)

    ((_, made),) = state.runs.generate(state.request)

    assert state.form.words[:2] == ("dry", "sleek")
    assert made.seconds == 0.5
    assert state.command().startswith("tactogram generate texture_flow --words rough=6 --seconds 0.5")


def test_a_run_of_images_leaves_the_unticked_words_open(tmp_path):
    rng = np.random.default_rng(0)
    items = [f"i{number}" for number in range(6)]
    rows = [(rater, item, word) for item in items for rater in ("r1", "r2") for word in WORDS]
    ratings = Ratings(*zip(*rows, strict=True), rng.integers(0, 2, len(rows)).astype(float), EVOKED)
    shown = [(item, Image(rng.integers(0, 256, (20, 20, 3), np.uint8))) for item in items]
    store = tmp_path / "data/seen"
    create_store(store, [], name="seen", licence="-", simulated=True, ratings=ratings, photographs=shown)
    train("texture_flow", store, recipe="tiny", split="all", out=tmp_path / "runs/drawn")
    state = state_of(tmp_path)
    state.choose("runs/drawn")
    state.set(words={"rough": 6.0}, seed=3)

    ((_, made),) = state.runs.generate(state.request)

    assert state.form.words == WORDS
    assert (state.form.some_words, state.form.gives, state.form.materials) == (True, "image", ())
    loaded = state.runs.load(state.run)
    [same] = generate(loaded, {"words": {"rough": 5 / 6}}, seed=3)
    np.testing.assert_array_equal(made.pixels, same.pixels)
    assert state.command() == "tactogram generate runs/drawn --words rough=6 --seed 3 --out made.png"


def test_the_command_generates_the_same_samples(state, tmp_path, monkeypatch, capsys):
    state.set(material={"tile": 0.7, "carpet": 0.35}, seconds=0.5, seed=11, count=2)
    pieces = [made.samples for _, made in state.runs.generate(state.request)]
    monkeypatch.chdir(state.workspace.folder)

    words = shlex.split(state.command())
    out = str(tmp_path / "made.npz")
    code = main([*words[1:-1], out])

    assert code in (0, None)
    assert len(pieces) == 2
    for number, samples in enumerate(pieces, start=1):
        assert np.array_equal(read_signal(tmp_path / f"made-{number}.npz").samples, samples)
    capsys.readouterr()


def test_generation_can_end_between_results(state):
    request = state.request.changed(count=5, seconds=0.1)

    assert [number for number, _ in state.runs.generate(request, proceed=lambda number: number < 3)] == [1, 2]


def test_a_run_is_loaded_once(state):
    assert state.runs.load(state.run) is state.runs.load(state.run)


def test_the_map_is_computed_once_and_stored(state, monkeypatch):
    places = state.runs.places(state.run)
    monkeypatch.setattr(GeneratingRuns, "generate", lambda *_, **__: pytest.fail("generated again"))

    again = GeneratingRuns(state.workspace).places(state.run)

    assert again == pytest.approx(places, abs=1e-4)
    assert places.shape == (9, 2)


def test_the_nearest_recordings_by_spectrum_are_of_the_material(state):
    material = state.form.materials[0]
    [(_, made)] = state.runs.generate(state.request.changed(material={material: 1.0}))

    method, found = state.runs.nearest(state.run, made)

    assert method == "by their spectra"
    assert len(found) == 3
    assert found[0][0].startswith(f"{material} (simulated recording, ")
    assert found[0][1].unit == made.unit
    assert found[0][2] is True
    assert state.runs.classifier_for(state.run) is None


def test_a_comparison_needs_the_training_data(state):
    lost = replace(state.run, data={"path": "/etc", "sha256": "0"})
    [(_, made)] = state.runs.generate(state.request)

    with pytest.raises(DataError, match="not in this workspace"):
        state.runs.nearest(lost, made)


@pytest.mark.parametrize("name", ["../..", "/etc", "studio/first/surfaces", "no\0name"])
def test_other_folders_are_refused_as_runs(state, name):
    with pytest.raises((DataError, ParameterError)):
        state.runs.get(name)


def test_a_deleted_run_is_refused_with_a_reason(state):
    with pytest.raises(
        DataError, match="runs/gone: no such finished run in this workspace; it may have been"
    ):
        state.runs.get("runs/gone")


@pytest.mark.parametrize("name", ["", "made:", "made:../../x", "other:1", "kept:20200101-000000-000000"])
def test_a_missing_result_is_none(state, name):
    assert state.find(name) is None


def test_the_smallest_crop_is_a_pixel():
    image = Image(np.zeros((10, 10, 3), np.uint8))

    assert cropped(image, (0.99, 0.99, 1.0, 1.0)).size == (1, 1)
    assert cropped(image, (0.0, 0.0, 1e-6, 1e-6)).size == (1, 1)
    assert cropped(image, None) is image


def test_a_cancelled_generation_ends_although_another_has_begun(state):
    page = MakePage(None, state)
    first, before = threading.Event(), len(state.made.all())
    results = state.runs.generate(state.request.changed(count=3, seconds=0.1))

    def generate(request, *, proceed):
        assert proceed(1)
        page.cancel()
        page._cancelled = threading.Event()  # as the next generation does
        return results if proceed(2) else results[:1]

    state.runs.generate = generate
    page._cancelled = first

    assert page._generate(state.request, first) == []
    assert first.is_set()
    assert len(state.made.all()) == before


@given(unit, unit)
def test_weights_are_shares_of_the_nearest(x, y):
    weight = weights_at((x, y), PLACES)

    assert weight.sum() == pytest.approx(1)
    assert np.all(weight >= 0)
    used = np.flatnonzero(weight)
    assert len(used) <= NEIGHBOURS
    distance = np.linalg.norm(PLACES - [x, y], axis=1)
    assert distance[used].max() <= np.sort(distance)[NEIGHBOURS - 1] + 1e-9


@pytest.mark.parametrize("number", range(len(PLACES)))
def test_on_a_material_it_is_that_material(number):
    assert weights_at(PLACES[number], PLACES).tolist() == [float(k == number) for k in range(len(PLACES))]


@given(st.floats(0.05, 0.95), st.floats(0.05, 0.95), st.floats(0, 6.28))
@settings(max_examples=200)
def test_a_small_step_changes_the_mix_a_little(x, y, angle):
    step = 1e-4 * np.array([np.cos(angle), np.sin(angle)])

    change = np.abs(weights_at((x, y), PLACES) - weights_at(np.array([x, y]) + step, PLACES)).max()

    assert change < 0.03  # at most the omitted shares below one percent, and the slope


def test_halfway_between_two_materials_both_have_the_same_weight():
    weight = weights_at((0.5, 0.2), np.array([[0.2, 0.2], [0.8, 0.2]]))

    assert weight == pytest.approx([0.5, 0.5])


def test_similar_spectra_are_close_together():
    rng = np.random.default_rng(0)
    features = np.array([[0, 0, 0, 0], [1, 0, 1, 0], [20, 0, 20, 0], [0, 15, 0, 15]]) + rng.normal(
        0, 0.01, (4, 4)
    )

    place = positions(features)

    def apart(i, j):
        return np.linalg.norm(place[i] - place[j])

    assert apart(0, 1) < apart(0, 3) < apart(2, 3)
    assert place.min() >= MARGIN - 1e-9
    assert place.max() <= 1 - MARGIN + 1e-9
    assert np.array_equal(place, positions(features))


def test_identical_materials_have_separate_places():
    place = positions(np.zeros((3, 5)))

    distances = [np.linalg.norm(place[i] - place[j]) for i in range(3) for j in range(i)]
    assert min(distances) >= 0.99 * APART


def test_one_material_has_a_place():
    assert positions(np.ones((1, 4))).shape == (1, 2)
    assert weights_at((0.1, 0.9), positions(np.ones((1, 4)))).tolist() == [1.0]


def test_the_handle_is_at_the_centre_of_the_weights():
    assert point_of({"a": 1, "b": 1}, "abcde", PLACES) == pytest.approx([0.5, 0.2])
    assert point_of({"c": 0.3}, "abcde", PLACES) == pytest.approx([0.5, 0.8])
    assert point_of({}, "abcde", PLACES) == [0.5, 0.5]


def test_levels_cover_the_shared_bands():
    rng = np.random.default_rng(0)
    signals = [Signal(rng.normal(size=(1, n)), 1000.0, "N") for n in (500, 2000)]

    level = levels_db(signals)

    assert level.shape[0] == 2
    assert level.shape[1] >= 8
    assert np.ptp(level) <= 60
