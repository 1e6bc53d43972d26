"""Damaged session files."""

import pytest

from tactogram_study.session.file import DamagedSessionError
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_participants import simulate


def test_pages_that_do_not_fit_the_study_are_reported_as_damage(make_study, tmp_path):
    with SessionStore(tmp_path, make_study("staircase")) as store:
        simulate(store, 1)
        store._connection.execute("UPDATE pages SET responses = replace(responses, 'which', 'whicg')")
        with pytest.raises(DamagedSessionError, match="do not fit the study: KeyError"):
            store.progress()


def test_answers_to_a_damaged_session_are_refused_and_the_error_is_the_files(damaged):
    folder = damaged(statements=["DROP TABLE device"])
    with SessionStore(folder) as store, pytest.raises(DamagedSessionError, match="no such table: device"):
        store.enrol("P99", simulated=True, device={"px_per_mm": 4})
