"""Parts of a stream: its motion, its mix over time, and files that could not be written."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from tactogram.errors import ParameterError
from tactogram_playback.workflows.session import (
    MotionFile,
    SimulatedHand,
    check_files,
    gliding,
    motion_of,
    only_surface,
)


def test_motion_is_simulated_or_that_of_a_file(tmp_path):
    file = tmp_path / "hand.csv"
    file.write_text("time_s,x_mm,force_n\n0,0,0.5\n0.1,10,0.5\n0.2,20,0.5\n")
    assert isinstance(motion_of("simulated", None, seconds=1.0, seed=0), SimulatedHand)
    assert isinstance(motion_of(str(file), None, seconds=1.0, seed=0), MotionFile)


def test_a_mix_glides_to_another_and_stays_there():
    weights = []
    engine = SimpleNamespace(names=("cork", "tile"), set_weights=weights.append)
    at = gliding(engine, {"cork": 1.0}, {"tile": 0.5}, 2.0)
    for now_s in (-1.0, 0.0, 1.0, 2.0, 9.0):
        at(now_s)
    assert weights == [
        {"cork": 1.0, "tile": 0.0},
        {"cork": 1.0, "tile": 0.0},
        {"cork": 0.5, "tile": 0.25},
        {"cork": 0.0, "tile": 0.5},
        {"cork": 0.0, "tile": 0.5},
    ]


@pytest.mark.parametrize(
    ("out", "figure", "says"),
    [
        (Path("sent.xyz"), None, "out must end in one of .*, got sent.xyz"),
        (None, Path("sent.pdf"), "figure must end in .png, got sent.pdf"),
        (None, Path(__file__) / "sent.png", "cannot be written"),
    ],
)
def test_files_that_could_not_be_written_are_refused(out, figure, says):
    with pytest.raises(ParameterError, match=says):
        check_files(out, figure)


def test_a_display_of_one_surface_is_not_given_two():
    two = [SimpleNamespace(name="cork"), SimpleNamespace(name="tile")]
    with pytest.raises(ParameterError, match="streams one surface at a time.*got cork, tile"):
        only_surface(two, "electrovibration")
