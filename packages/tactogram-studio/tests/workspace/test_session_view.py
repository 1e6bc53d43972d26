import io
import zipfile
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_studio.workspace.session_view import (
    address_of,
    answers_rows,
    device_text,
    folder_of,
    peeking_text,
    share_of,
    since_text,
    view_of,
)
from tactogram_study.session.store import SessionStore
from tactogram_study.workflows.answers import export_zip
from tactogram_study.workflows.sessions import simulate_session


def test_the_view_says_where_everybody_is(session):
    later = datetime.now(UTC) + timedelta(seconds=300)
    first, second = view_of(session, now=later).rows
    assert (first.status, first.place, first.since, first.quiet) == (
        "active",
        "trial 3 of 4",
        "5 min ago",
        True,
    )
    assert first.device == "6.25 px/mm, 59.9 Hz, finger 480 and 510 mm/s"
    assert (second.status, second.place, second.quiet) == (
        "not begun",
        "consent not given yet",
        False,
    )
    assert second.since == "no answer yet"
    assert view_of(session).summary() == "2 participants, 1 going on, 1 not begun; 4 answers"


def test_the_latest_answers_tell_nothing_of_how_the_study_comes_out(session):
    rows = answers_rows(view_of(session).latest)
    assert [row[:4] for row in rows] == [
        ["P1", "2", "which", "A"],
        ["P1", "1", "which", "A"],
        ["P1", "practice 1", "which", "A"],
    ]
    assert not any("generated" in cell or "recorded" in cell for row in rows for cell in row)


def test_who_looks_at_results_early_is_warned(session):
    assert peeking_text(view_of(session)).startswith(
        "Of 2 enrolled, 1 has not finished and 1 has not begun; the"
    )
    session.end()
    assert peeking_text(view_of(session)) == ""


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (None, "no answer yet"),
        (5, "5 s ago"),
        (600, "10 min ago"),
        (7200, "2 h ago"),
        (400_000, "5 days ago"),
    ],
)
def test_times_since_an_answer(seconds, text):
    assert since_text(seconds) == text


@pytest.mark.parametrize(("status", "share"), [("active", 0.25), ("finished", 1.0), ("aborted", 0.25)])
def test_a_staircase_that_ends_early_is_done_whole(status, share):
    assert share_of({"status": status, "trials": 40, "of": 160}) == share


def test_addresses_of_sessions_go_there_and_back():
    assert folder_of(address_of("sessions/pilot").removeprefix("/experiment/")) == "sessions/pilot"
    assert device_text({"pointer": "pen", "other": 1}) == "pen"


def test_simulated_participants_of_a_session_have_a_folder_of_their_own(session):
    folder = session.path.parent
    made = simulate_session(folder, participants=2, effect={"d_prime": 1})
    assert Path(made["folder"]) == folder.with_name("pilot-simulated")
    assert len(view_of(session).rows) == 2
    again = simulate_session(made["folder"], participants=1)
    assert again["folder"] == made["folder"]
    with SessionStore(Path(made["folder"])) as other:
        other_view = view_of(other)
        assert other_view.summary().startswith("3 simulated participants, 3 finished")
        assert other.study == session.study
    with pytest.raises(ParameterError, match="participants must be at least 1"):
        simulate_session(folder, participants=0)


def test_simulated_participants_never_go_where_people_are(session):
    folder = session.path.parent
    with SessionStore(folder.with_name("pilot-simulated"), session.study) as other:
        other.enrol("P7")
    with pytest.raises(DataError, match="people took this study"):
        simulate_session(folder, participants=1)


@pytest.mark.parametrize(
    ("kind", "name"), [("tables", "answers.notes.csv"), ("bids", "sub-P1_ses-1_task-abx_beh.tsv")]
)
def test_downloads_hold_the_whole_export(session, kind, name):
    called, data = export_zip(session.path.parent, kind=kind)
    assert called == f"pilot-{kind}.zip"
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        assert file.testzip() is None
        assert name in {Path(path).name for path in file.namelist()}
