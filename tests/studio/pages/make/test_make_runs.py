"""Runs behind the page Make: what they make is what the verb makes, and what a result is held against."""

import json
import shlex
import threading

import numpy as np
import pytest

from tactogram.cli.command import main
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image
from tactogram.signal.io import read_signal, write_image
from tactogram.studio.pages.make.desk import MOST_BESIDE, MakePageState
from tactogram.studio.pages.make.form import GenerationRequest
from tactogram.studio.pages.make.runs import RunCatalogue, cropped
from tactogram.studio.workspace.folder import Workspace
from tactogram.studio.workspace.shelf import ResultArchive

VOICES = "studio/first/voices"


@pytest.fixture
def desk(workspace):
    place = Workspace.at(workspace)
    return MakePageState(place, ResultArchive(place.studio_folder / "kept"), RunCatalogue(place), {})


@pytest.fixture
def studio_page(desk):
    from tactogram.studio.pages.make.page import MakePage

    return MakePage(None, desk)


def test_the_first_run_is_chosen_with_a_form_that_can_be_made_of(desk):
    assert desk.choice.name == VOICES
    assert desk.choice.kind.simulated
    assert len(desk.form.materials) == 9

    ((number, made),) = desk.runs.make(desk.asked)

    assert number == 1
    assert made.axes == desk.choice.kind.axes


def test_the_command_line_makes_the_same_samples(desk, tmp_path, monkeypatch, capsys):
    desk.set(weights={"tile": 0.7, "carpet": 0.35}, seconds=0.5, seed=11, count=2)
    pieces = [made.samples for _, made in desk.runs.make(desk.asked)]
    monkeypatch.chdir(desk.workspace.folder)

    words = shlex.split(desk.command())
    out = str(tmp_path / "made.npz")
    code = main([*words[1:-1], out])

    assert code in (0, None)
    assert len(pieces) == 2
    for number, samples in enumerate(pieces, start=1):
        assert np.array_equal(read_signal(tmp_path / f"made-{number}.npz").samples, samples)
    capsys.readouterr()


def test_making_ends_between_pieces_when_asked_to(desk):
    asked = desk.asked.with_changes(count=5, seconds=0.1)

    assert [number for number, _ in desk.runs.make(asked, go_on=lambda number: number < 3)] == [1, 2]


def test_a_run_is_loaded_once(desk):
    assert desk.runs.load(desk.choice) is desk.runs.load(desk.choice)


def test_the_map_is_worked_out_once_and_kept(desk, monkeypatch):
    places = desk.runs.places(desk.choice)
    monkeypatch.setattr(RunCatalogue, "make", lambda *_, **__: pytest.fail("made again"))

    again = RunCatalogue(desk.workspace).places(desk.choice)

    assert again == pytest.approx(places, abs=1e-4)
    assert places.shape == (9, 2)


def test_the_nearest_recordings_by_spectrum_are_of_the_material(desk):
    material = desk.form.materials[0]
    made = next(made for _, made in desk.runs.make(desk.asked.with_changes(weights={material: 1.0})))

    how, found = desk.runs.nearest(desk.choice, made)

    assert how == "by their spectra"
    assert len(found) == 3
    assert found[0][0].startswith(f"{material} (simulated recording, ")
    assert found[0][1].unit == made.unit
    assert found[0][2] is True
    assert desk.runs.classifier_for(desk.choice) is None


def test_without_its_data_nothing_is_compared(desk, tmp_path):
    choice = desk.choice
    lost = type(choice)(
        choice.folder, choice.name, choice.facts, choice.kind, {"path": "/etc", "sha256": "0"}
    )

    with pytest.raises(DataError, match="not in this workspace"):
        desk.runs.nearest(lost, next(made for _, made in desk.runs.make(desk.asked)))


@pytest.mark.parametrize("name", ["../..", "/etc", "studio/first/surfaces", "no\0name"])
def test_what_is_no_run_of_the_workspace_is_refused(desk, name):
    with pytest.raises((DataError, ParameterError)):
        desk.runs.choice(name)


def test_a_run_that_was_deleted_is_told_in_a_sentence(desk):
    with pytest.raises(DataError, match="runs/gone: no finished run of this workspace; it was deleted"):
        desk.runs.choice("runs/gone")


def test_a_form_comes_back_with_its_history(desk):
    desk.set(speed_mm_s=None, seed=5)
    desk.commit()
    desk.set(seed=6)
    desk.commit()

    again = MakePageState(desk.workspace, desk.shelf, desk.runs, json.loads(json.dumps(desk.held)))

    assert again.asked.seed == 6
    again.undo()
    assert again.asked.seed == 5
    again.undo()
    assert again.asked.seed == 0
    again.redo()
    assert again.asked.seed == 5
    with pytest.raises(ParameterError, match="Nothing to undo"):
        MakePageState(desk.workspace, desk.shelf, desk.runs, {}).undo()


def test_results_are_held_shown_kept_and_still_there_after_a_reload(desk):
    made = next(made for _, made in desk.runs.make(desk.asked))
    first, second = (desk.put(desk.asked, desk.choice, 1, made) for _ in range(2))
    desk.show([first])
    desk.show([second])
    desk.add_comparison(f"made:{first.id}")
    kept = desk.shelf.keep_copy(second)
    desk.record_kept(f"made:{second.id}", kept)

    again = MakePageState(desk.workspace, desk.shelf, desk.runs, json.loads(json.dumps(desk.held)))

    assert again.current_result().id == second.id
    assert [held.id for held in again.results()] == [second.id, first.id]
    assert [held.id for _, held in again.compared()] == [first.id]
    assert again.kept_id(f"made:{second.id}") == kept.id
    assert kept.facts["run"] == VOICES
    assert kept.facts["simulated"] is True
    assert kept.facts["condition"]["weights"] == desk.asked.weights
    assert np.array_equal(kept.signal().samples, made.samples)
    again.rename(f"made:{second.id}", "my cork")  # here, and where it is kept
    assert [again.current_result().title, again.shelf.get(kept.id).title] == ["my cork"] * 2
    desk.shelf.remove(kept.id)
    assert again.kept_id(f"made:{second.id}") == ""


def test_only_so_many_stand_beside(desk):
    made = next(made for _, made in desk.runs.make(desk.asked.with_changes(seconds=0.1)))
    names = [f"made:{desk.put(desk.asked, desk.choice, 1, made).id}" for _ in range(MOST_BESIDE + 1)]
    for name in names[:-1]:
        desk.add_comparison(name)

    with pytest.raises(ParameterError, match="take one away"):
        desk.add_comparison(names[-1])
    desk.remove_comparison(names[0])
    desk.add_comparison(names[-1])
    assert len(desk.compared()) == MOST_BESIDE


@pytest.mark.parametrize("name", ["", "made:", "made:../../x", "other:1", "kept:20200101-000000-000000"])
def test_a_result_that_is_gone_is_none(desk, name):
    assert desk.find(name) is None


def test_a_part_of_a_photograph_is_a_file_for_the_command_line(desk):
    pixels = np.arange(40 * 60 * 3, dtype=np.uint8).reshape(40, 60, 3)
    write_image(desk.photographs() / "stone-1.png", Image(pixels))
    asked = GenerationRequest(photo="studio/photos/stone-1.png", crop=(0.5, 0.25, 1.0, 0.75))

    name = desk.photo_file(asked)

    part = desk.runs.photograph(GenerationRequest(photo=name))
    assert np.array_equal(part.pixels, pixels[10:30, 30:60])
    assert desk.photo_file(asked) == name
    assert desk.photo_file(asked.with_changes(crop=None)) == asked.photo


def test_the_least_part_is_a_pixel():
    image = Image(np.zeros((10, 10, 3), np.uint8))

    assert cropped(image, (0.99, 0.99, 1.0, 1.0)).size == (1, 1)
    assert cropped(image, (0.0, 0.0, 1e-6, 1e-6)).size == (1, 1)
    assert cropped(image, None) is image


def test_what_was_cancelled_ends_although_something_else_is_made_since(desk, studio_page):
    first, before = threading.Event(), len(desk.made.all())
    pieces = desk.runs.make(desk.asked.with_changes(count=3, seconds=0.1))

    def make(asked, *, go_on):
        assert go_on(1)
        studio_page.cancel()
        studio_page._cancelled = threading.Event()  # as making anew does
        return pieces if go_on(2) else pieces[:1]

    desk.runs.make = make
    studio_page._cancelled = first

    assert studio_page._made(desk.asked, first) == []
    assert first.is_set()
    assert len(desk.made.all()) == before
