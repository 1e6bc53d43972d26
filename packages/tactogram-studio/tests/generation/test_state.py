import json
from dataclasses import replace

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_studio.generation.runs import (
    GeneratingRuns,
)
from tactogram_studio.generation.state import MOST_COMPARED, MOST_STEPS, MakePageState
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive

VOICES = "studio/first/voices"


@pytest.fixture
def state(workspace):
    """Give the state of a new page."""
    return state_of(workspace)


def state_of(folder):
    place = Workspace.at(folder)
    return MakePageState(place, ResultArchive(place.studio_folder / "kept"), GeneratingRuns(place), {})


def reloaded(state):
    """Return the state of a page after a reload."""
    return MakePageState(state.workspace, state.shelf, state.runs, json.loads(json.dumps(state.storage)))


def test_a_form_survives_a_reload_with_its_history(state):
    state.set(speed_mm_s=None, seed=5)
    state.commit()
    state.set(seed=6)
    state.commit()

    again = reloaded(state)

    assert again.request.seed == 6
    again.undo()
    assert again.request.seed == 5
    again.undo()
    assert again.request.seed == 0
    again.redo()
    assert again.request.seed == 5
    with pytest.raises(ParameterError, match="Nothing to undo"):
        MakePageState(state.workspace, state.shelf, state.runs, {}).undo()


def test_the_history_is_bounded_and_a_change_ends_what_was_undone(state):
    for seed in range(1, MOST_STEPS + 20):
        state.set(seed=seed)
        state.commit()
    assert len(state.storage["past"]) == MOST_STEPS
    state.undo()
    state.set(seed=7)
    state.commit()
    with pytest.raises(ParameterError, match="Nothing to redo"):
        state.redo()


def test_results_are_stored_shown_kept_and_survive_a_reload(state):
    [(_, made)] = state.runs.generate(state.request)
    first, second = (state.store_result(state.request, state.run, 1, made) for _ in range(2))
    state.show([first])
    state.show([second])
    state.add_comparison(f"made:{first.id}")
    kept = state.shelf.keep_copy(second)
    state.record_kept(f"made:{second.id}", kept)

    again = reloaded(state)

    assert again.current_result().id == second.id
    assert [result.id for result in again.results()] == [second.id, first.id]
    assert [result.id for _, result in again.compared()] == [first.id]
    assert again.kept_id(f"made:{second.id}") == kept.id
    assert kept.facts["run"] == VOICES
    assert kept.facts["simulated"] is True
    assert kept.facts["condition"]["material"] == state.request.weights
    assert np.array_equal(kept.signal().samples, made.samples)
    again.rename(f"made:{second.id}", "my cork")  # here, and where it is kept
    assert [again.current_result().title, again.shelf.get(kept.id).title] == ["my cork"] * 2
    state.shelf.remove(kept.id)
    assert again.kept_id(f"made:{second.id}") == ""


def test_the_number_of_compared_results_is_limited(state):
    [(_, made)] = state.runs.generate(replace(state.request, seconds=0.1))
    results = [state.store_result(state.request, state.run, 1, made) for _ in range(MOST_COMPARED + 1)]
    names = [f"made:{result.id}" for result in results]
    for name in names[:-1]:
        state.add_comparison(name)

    with pytest.raises(ParameterError, match="remove one first"):
        state.add_comparison(names[-1])
    state.remove_comparison(names[0])
    state.add_comparison(names[-1])
    assert len(state.compared()) == MOST_COMPARED
