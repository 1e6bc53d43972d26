"""Pipelines: each task gives what its verb gives, and refuses runs of another kind."""

import numpy as np
import pytest

import tactogram
from tactogram.errors import ParameterError
from tactogram.rendering import carrier
from tactogram.signal.io import read_signal, write_signal


@pytest.fixture(scope="module")
def shipped():
    return tactogram.load_run("texture_flow")


@pytest.mark.parametrize(
    ("task", "given", "condition"),
    [
        ("material-to-touch", "corduroy", {"material": "corduroy"}),
        ("words-to-touch", {"rough": 6}, {"words": {"rough": 6}}),
    ],
)
def test_a_task_gives_what_generate_gives(shipped, task, given, condition):
    made = tactogram.pipeline(task, shipped)(given, speed_mm_s=120, seconds=1, seed=3)
    (expected,) = tactogram.generate(shipped, {**condition, "speed_mm_s": 120}, seconds=1, seed=3)
    np.testing.assert_array_equal(made.samples, expected.samples)


def test_a_text_may_name_an_effect_and_says_what_it_understood(shipped):
    touch = tactogram.pipeline("text-to-touch", shipped)
    beats = touch("my heartbeat", seconds=5)
    assert (beats.unit, beats.seconds) == ("1", 5)
    np.testing.assert_array_equal(beats.samples, carrier(tactogram.effect("heartbeat", seconds=5)).samples)
    drops = [touch("rain on a tent", seed=seed).samples for seed in (1, 1, 2)]
    np.testing.assert_array_equal(drops[0], drops[1])
    assert (drops[0] != drops[2]).any()
    assert str(touch.understood("wet cork")) == "understood: cork; not understood: wet"
    with pytest.raises(ParameterError, match="heartbeat is an effect, which is not stroked"):
        touch("heartbeat", speed_mm_s=100)
    with pytest.raises(ParameterError, match="must name a material or an effect that is known"):
        touch("a cat")


def test_a_stroke_may_be_a_file_of_another_rate(shipped, texture, tmp_path):
    file = tmp_path / "stroke.wav"
    write_signal(file, texture("cork", 1, rate=1000.0).select("z"))
    again = tactogram.pipeline("stroke-to-touch", shipped)
    made = again(str(file), given_speed_mm_s=100, speed_mm_s=200, seconds=1)
    assert made.rate == shipped.kind.rate
    np.testing.assert_array_equal(
        made.samples,
        again(read_signal(file), given_speed_mm_s=100, speed_mm_s=200, seconds=1).samples,
    )


def test_a_material_is_named_of_a_signal_or_its_file(run, texture, tmp_path):
    write_signal(tmp_path / "tile.csv", texture("tile", 5))
    name = tactogram.pipeline("touch-to-material", run.folder)
    assert name(texture("tile", 5))["material"] == name(tmp_path / "tile.csv")["material"] == "tile"


@pytest.mark.parametrize(
    ("task", "run", "message"),
    [
        ("foto-to-touch", None, "task must be one of text-to-touch, .*, got 'foto-to-touch'"),
        (
            "photo-to-touch",
            None,
            r"no run for photo-to-touch comes .*--for photograph .* pipeline\('photo-to-touch', 'runs/NAME'\)",
        ),
        ("touch-to-material", "texture_flow", "needs a run that gives probabilities, got texture_flow"),
        (
            "words-to-image",
            "texture_flow",
            "needs a run that gives image, got texture_flow, which gives signal",
        ),
    ],
)
def test_a_task_refuses_a_run_that_does_something_else(task, run, message):
    with pytest.raises(ParameterError, match=message):
        tactogram.pipeline(task, run)
