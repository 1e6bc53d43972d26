"""Samples of runs, finished or not."""

import json
import shutil

import pytest

from tactogram.errors import ParameterError
from tactogram_studio.tasks.run_samples import sample, sample_choices

STORE = "studio/first/surfaces"


def test_a_sample_is_selected_by_name(workspace, tmp_path):
    run = tmp_path / "voices"
    shutil.copytree(workspace / "studio/first/voices", run)
    names = [f"luncheon-mat-0{number}" for number in (1, 2, 3)]
    names = ["artificial-grass", "carpet", "cloth", "cork-sheet", *names, "punched-plastic-sheet", "tile"]
    assert sample_choices(run) == names
    assert sample(run, of="tile")["of"] == "tile"
    assert (run / "samples/end-tile.wav").is_file()
    with pytest.raises(ParameterError, match="must be of one of artificial-grass, .* got 'foam'"):
        sample(run, of="foam")
    (run / "model.json").unlink()  # an unfinished run: the names come from its data
    data = json.loads((run / "data.json").read_text())
    (run / "data.json").write_text(json.dumps({**data, "path": str(workspace / STORE)}))
    assert sample_choices(run) == names
