import numpy as np
import pytest

from tactogram.errors import DataError
from tactogram_studio.generation.runs import (
    GeneratingRuns,
)
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.pages.make.files import store_motion
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive


@pytest.fixture
def state(workspace):
    """Give the state of a new page."""
    return state_of(workspace)


def state_of(folder):
    place = Workspace.at(folder)
    return MakePageState(place, ResultArchive(place.studio_folder / "kept"), GeneratingRuns(place), {})


def test_a_motion_is_followed(state):
    name = store_motion(
        state.motions, "hand.csv", b"time_s,speed_mm_s,force_n\n0,200,1\n1,200,1\n1.1,200,0\n2,0,0\n"
    )
    state.choose("texture_flow")
    state.set(material={"corduroy": 1.0}, motion=state.workspace.name_of(state.motions / name))

    ((_, made),) = state.runs.generate(state.request)

    assert made.seconds == 2
    assert made.samples[0, :2000].std() > 1
    assert np.ptp(made.samples[0, 3000:]) == 0
    assert f"--motion studio/motions/{name}" in state.command()
    state.set(motion="simulated", seconds=0.5)
    ((_, other),) = state.runs.generate(state.request)
    assert other.seconds == 0.5


def test_what_is_no_motion_is_not_stored(state):
    with pytest.raises(DataError, match=r"^bad.csv: line 1: expected columns of time_s"):
        store_motion(state.motions, "bad.csv", b"a,b\n1,2\n")
    assert not any(file.name.startswith(("bad", ".bad")) for file in state.motions.glob("*"))
