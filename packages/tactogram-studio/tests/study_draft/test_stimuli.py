import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata
from tactogram_studio.study_draft.draft import StudyDraft, copy_study, free_name
from tactogram_studio.study_draft.stimuli import (
    listed,
    named_keys,
    place_signal,
    stimulus_names,
    summary,
    with_source,
)
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive, SignalSources
from tactogram_study.study_file import Study


@pytest.fixture
def workspace(tmp_path):
    return Workspace.at(tmp_path)


@pytest.fixture
def draft(workspace):
    """Give a function that returns the draft of one's own copy of a shipped study."""
    return lambda name: StudyDraft.open(copy_study(workspace, name, free_name(workspace, name)))


@pytest.mark.parametrize("name", ["two-area", "display-words", "reconstruction"])
def test_a_grid_listed_one_by_one_has_the_same_stimuli_and_names(name, draft):
    made, before = draft(name), Study.load(name)
    listed(made)
    after = Study.of(made.values)
    assert after.all_stimuli == before.all_stimuli
    assert after.display_names == before.display_names
    assert stimulus_names(made) == [stimulus.name for stimulus in before.all_stimuli]
    assert set(named_keys(made)) == set(after.display_names)


def test_a_large_grid_is_not_listed(draft):
    made = draft("evoked-words")
    with pytest.raises(ParameterError, match="320 stimuli are too many to list one by one"):
        listed(made)
    assert made.get(("grid", "count")) == 320


def test_another_source_takes_the_place_of_the_former_and_its_settings():
    former = {"name": "a", "simulated": "stroking9/tile", "autoregressive": True, "seconds": 1.0}
    assert with_source(former, "file", "a.wav") == {"name": "a", "seconds": 1.0, "file": "a.wav"}
    other = with_source(former, "simulated", "stroking9/cloth")
    assert other == former | {"simulated": "stroking9/cloth"}
    assert summary(other) == "simulated stroking9/cloth, from an autoregressive model of it, 1 s"


def test_a_kept_result_is_copied_beside_the_study_and_a_file_is_not(workspace, draft):
    made, shelf = draft("abx"), ResultArchive(workspace.studio_folder / "kept")
    kept = shelf.keep(Signal(np.ones(100), 1000.0, "1"), title="cork / tile", facts={"simulated": True})
    copied = place_signal(workspace, made.path, SignalSources(workspace, shelf).select(f"kept:{kept.id}"))
    shelf.remove(kept.id)
    assert copied.startswith("my_abx_stimuli/cork_-_tile-")
    assert read_metadata(made.path.parent / copied) == {"simulated": True}
    (workspace.folder / "own.csv").write_text("time,x\n0,1\n0.1,2\n")
    own = SignalSources(workspace, shelf).select("file:own.csv")
    assert place_signal(workspace, made.path, own) == "../own.csv"
