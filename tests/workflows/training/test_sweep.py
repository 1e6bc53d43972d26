"""Sweeps that are refused before Ray is started; one on Ray is in `workers/test_ray_cluster.py`."""

import pytest

from tactogram.errors import ParameterError
from tactogram.workflows.training.plan import TrainingRequest
from tactogram.workflows.training.sweep import SearchSpace, drop_torn_states, sweep


def test_a_range_or_choices_are_drawn_from():
    space = SearchSpace.model_validate(
        {
            "measure": "m",
            "goal": "min",
            "vary": {"a": {"choices": [1, "x"]}, "b": {"low": 1, "high": 9, "integer": True}},
        }
    )
    assert space.vary["a"].choices == (1, "x")
    assert (space.vary["b"].low, space.vary["b"].high, space.trials) == (1, 9, 16)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("choices = [16]", "low = 1", "vary.config.batch_size: must have choices, or low and high"),
        ("choices = [16]", "low = 3, high = 2", "low must be < high, got 3 and 2"),
        ("low = 1e-9", "low = -1", "low must be > 0 with log, got -1"),
        ("choices = [16]", "low = 1.5, high = 3, integer = true", "must be whole with integer"),
        ('goal = "max"', 'goal = "best"', "goal: must be 'max' or 'min'"),
        ("seed = 1", "sed = 1", "unknown key 'sed'; known here: goal, measure"),
    ],
)
def test_a_wrong_space_is_refused(space, old, new, message):
    space.write_text(space.read_text().replace(old, new))
    with pytest.raises(ParameterError, match=message):
        SearchSpace.load(space)


def test_a_sweep_needs_ray_and_a_folder(store, space):
    with pytest.raises(ParameterError, match="on must be ray or ray:ADDRESS for a sweep, got ''"):
        sweep(TrainingRequest("stroke_cnn", store), space, out=None, on="")
    with pytest.raises(ParameterError, match="out must be a folder for a sweep"):
        sweep(TrainingRequest("stroke_cnn", store), space, out=None)


def test_states_that_a_kill_cut_short_are_dropped(tmp_path):
    for name, text in (("1", '{"trials": []}'), ("2", ""), ("3", '{"trials": [')):
        (tmp_path / f"experiment_state-{name}.json").write_text(text)
    drop_torn_states(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["experiment_state-1.json"]
    drop_torn_states(tmp_path / "none")
