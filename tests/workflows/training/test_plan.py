"""What a training is of."""

from dataclasses import replace

import pytest

from tactogram.datasets import open_store
from tactogram.errors import ParameterError
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
