"""Form of the page Make: a field for each condition, and the meaning of the sliders."""

import sys
from dataclasses import replace

import pytest
from nicegui import Client, ui

from tactogram.datasets.ratings.words import WORDS
from tactogram.model import ImageKind
from tactogram_studio.generation.runs import GeneratingRuns
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.pages.make.form_view import draw_form, scale_text
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive

IMAGES = ImageKind(WORDS, (0.0, 1.0), ("a",))


def test_the_sliders_of_words_are_explained_by_the_runs_own_scale():
    assert scale_text((1.0, 7.0)) == scale_text(None) == "1 (not at all) to 7 (very)."
    assert "4 half, 7 everybody" in scale_text(IMAGES.scale)
    assert "own ratings, 0 to 100," in scale_text((0.0, 100.0))


CONDITIONS = {
    "temperature_c": '"temperature of the finger", (ConditionOption("temperature", float, "in °C"),), "°C"',
    "coating": '"what the finger is coated with", (ConditionOption("coating", str, "its coating"),)',
}


@pytest.fixture
def state(workspace, tmp_path, monkeypatch):
    """Give the state of a new page for a model that takes conditions of further files."""
    for name, values in CONDITIONS.items():
        text = "from tactogram.model import ConditionOption, ConditionType\n"
        text += f"CONDITION = ConditionType('{name}', {values})"
        (tmp_path / f"made_{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.setenv("TACTOGRAM_CONDITIONS", str(tmp_path))
    place = Workspace.at(workspace)
    made = MakePageState(place, ResultArchive(place.studio_folder / "kept"), GeneratingRuns(place), {})
    model = made.run.model
    made.run = replace(made.run, model=model.model_copy(update={"takes": (*model.takes, *CONDITIONS)}))
    yield made
    for name in CONDITIONS:
        sys.modules.pop(f"made_{name}", None)


def test_a_condition_of_one_file_has_a_field(state):
    with Client(ui.page("")) as client:
        draw_form(state)
    fields = {
        element.props["data-number"]: element
        for element in client.elements.values()
        if "data-number" in element.props
    }
    assert list(fields) == ["speed_mm_s", "force_n", "coating", "temperature_c", "seconds", "seed", "count"]
    assert fields["temperature_c"].props["label"] == "Temperature, °C"
    fields["temperature_c"].set_value(31.5)
    fields["coating"].set_value("silicone")
    assert (state.request.values["temperature_c"], state.request.values["coating"]) == (31.5, "silicone")
    assert "--coating silicone --temperature 31.5" in state.command()
