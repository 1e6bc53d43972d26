"""Tables 3 and 4: cells are trained once, compared in pairs, chosen on the validation part."""

import pytest
import torch
from made_up_pictures import MadeUpWorkflows

from tactogram.errors import ParameterError
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import (
    artifacts,
    picture_cells,
    visual_tactile_gan_table3 as table3,
)


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), picture_cells, artifacts)


@pytest.fixture(autouse=True)
def no_weights(monkeypatch, tmp_path):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))


def test_table_3_is_chosen_on_the_validation_part_and_tested_against_the_chosen_cell(tmp_path):
    """Neshov et al. 2026, Sec. 4.2: "compare each configuration against the best-performing one"."""
    found = table3.run(tmp_path, paper=False, progress=silent, trainings=3)
    assert len(found["cells"]) == 16
    assert found["chosen"] == "3x1"
    assert found["cells"]["3x1"]["p"]["l1"] is None
    assert found["cells"]["1x1"]["p"]["l1"] < 0.05
    assert "3x1*" in found["text"]
    assert "0.3113 ± 0.0087" in found["text"]
    assert "simulated" in found["text"]
    assert (tmp_path / "figure2.png").read_bytes().startswith(b"\x89PNG")


def test_some_cells_of_table_3_are_a_table_without_a_surface(tmp_path, made_up):
    found = table3.run(tmp_path, paper=False, progress=silent, trainings=1, cells="1x4, 2x2")
    assert list(found["cells"]) == ["1x4", "2x2"]
    assert found["figure"] is None
    assert len(made_up.trained) == 2
    with pytest.raises(ParameterError, match="cells must be some of 1x1.*got '5x1'"):
        table3.run(tmp_path, paper=False, progress=silent, cells="5x1")


def test_crop_split_trains_on_all_recordings_in_runs_of_its_own(tmp_path, made_up):
    table3.run(tmp_path, paper=False, progress=silent, trainings=1, cells="3x3")
    assert made_up.split == ""
    found = table3.run(
        tmp_path, paper=False, progress=silent, trainings=1, cells="3x3", protocol="crop-split"
    )
    assert (found["protocol"], made_up.split) == ("crop-split", "all")
    assert made_up.trained[-1][2]["config.pairs.protocol"] == "crop-split"
    assert (tmp_path / "runs" / "3x3-crop-split-0").is_dir()
