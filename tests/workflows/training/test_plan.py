"""What a training is of."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image as Pillow

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.training.plan import TrainingRequest, plan_of, planned, select

OWN_SPLIT = {"frictgan": "examples", "visual_tactile_gan": "source-split"}


def test_a_run_says_all_that_its_training_is_of(run):
    plan = plan_of(run)
    assert plan.identity == run.data["run_id"]
    assert plan.config.steps == 60
    assert {plan.store.info(segment.id).material for segment in plan.parts.train} == {"cork", "foam", "tile"}


@pytest.mark.parametrize("model", ["frictgan", "visual_tactile_gan"])
def test_where_the_paper_splits_windows_no_recording_is_kept_apart(model, store):
    published, ours = (
        planned(TrainingRequest(model, store, recipe="paper", changes=changes)).parts
        for changes in (None, {f"config.{'pairs.' * (model != 'frictgan')}protocol": OWN_SPLIT[model]})
    )
    assert (len(published.train), len(published.test)) == (40, 0)
    assert len(ours.test) == 8


def test_select_by_fields_and_labels(store):

    index = open_store(store).index
    assert len(select(index, {"speed_mm_s": "100.0", "material": "cork|tile"})) == 10
    assert len(select(index, {"material": "!cork|tile"})) == 20
    assert len(select(index, {"recording": "3"})) == 4
    nameless = replace(index[0], material=None)
    assert select([*index, nameless], {"material": ""}) == [nameless]
    assert select([*index, nameless], {"material": "!"}) == list(index)
    with pytest.raises(ParameterError, match="no recording has material=glass"):
        select(index, {"material": "glass"})


@pytest.mark.parametrize(
    "words",
    ["train stroke_statistics --data s", "crossval stroke_statistics --data s", "data like s touch.wav"],
)
def test_a_store_of_photographs_alone_is_named_as_such(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("carpet", "tile"):
        (tmp_path / "photos" / name).mkdir(parents=True)
        Pillow.new("RGB", (3, 2), (len(name), 2, 3)).save(tmp_path / "photos" / name / "1.png")
    write_signal("touch.wav", Signal(np.ones((1, 100), np.float32), 1000.0, "1", ("z",)))
    assert main(["data", "import", "folder", "photos", "--out", "s"]) == 0
    assert main(words.split()) == 1
    assert "there are no recordings" in capsys.readouterr().err
