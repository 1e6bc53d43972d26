import io
import re
import zipfile
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_studio import study_server
from tactogram_studio.application import ServerAnnouncement
from tactogram_studio.pages.studies.catalogue import (
    counts_of,
    new_session_folder,
    pairs_of,
    power_rows,
    workspace_sessions,
    workspace_studies,
)
from tactogram_studio.pages.studies.experiment_view import (
    address_of,
    answers_rows,
    device_text,
    folder_of,
    peeking_text,
    share_of,
    since_text,
    view_of,
)
from tactogram_studio.pages.studies.joining import reachable_roots
from tactogram_studio.study_draft.draft import copy_study
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.participants.prepared_stimuli import PreparedStimuli
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import shipped_studies
from tactogram_study.workflows.answers import export_zip
from tactogram_study.workflows.sessions import begin_session, simulate_session

SHORT = {"design.repeats": 4, "practice": {"trials": 1}, "grid.items": ["tile"]}


@pytest.fixture
def session(tmp_path):
    """Give a session of a short ABX study: P1 is at its third trial, P2 reads the consent."""
    folder = begin_session("abx", tmp_path / "sessions" / "pilot", changes=SHORT)
    with SessionStore(folder) as store:
        for code in ("P1", "P2"):
            store.enrol(code)
        store.submit("P1", "consent", {"consent": "agreed"}, device={"px_per_mm": 6.25, "refresh_hz": 59.94})
        for token in ("practice-1.1", "trial-1.1", "trial-2.1"):
            store.submit(
                "P1", token, {"which": "A"}, device={"finger_speed_mm_s_a": 480.2, "finger_speed_mm_s_b": 510}
            )
        yield store


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


def test_the_catalogue_lists_every_design_and_what_is_wrong_with_a_file(session, tmp_path):
    workspace = Workspace.at(tmp_path)
    copied = copy_study(workspace, "threshold", "threshold")
    copied.with_name("broken.toml").write_text("[design]\nkind = 'abx'\n")
    bare = re.sub(r"\[analysis.margins.*?(?=\n\[)", "", copied.read_text(encoding="utf-8"), flags=re.S)
    copied.with_name("bare.toml").write_text(bare, encoding="utf-8")
    found = {study.name: study for study in workspace_studies(workspace)}
    assert set(shipped_studies()) < set(found)
    assert found["studies/threshold.toml"].question_text.startswith("How weak")
    assert "margins: staircase ±3 dB" in found["threshold"].line
    assert "margins: none, so that equivalence cannot be shown" in found["studies/bare.toml"].line
    assert found["studies/broken.toml"].error
    [one] = workspace_sessions(workspace)
    assert (one.name, one.line) == ("sessions/pilot", "abx: 2 participants, 1 going on, 1 not begun")


def test_a_session_that_cannot_be_opened_is_listed_with_its_reason(tmp_path):
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "answers.sqlite").write_bytes(b"not a database " * 100)
    [one] = workspace_sessions(Workspace.at(tmp_path))
    assert "answers.sqlite is damaged" in one.error


@pytest.mark.parametrize("name", ["../x", "", "a b", "-a", "x" * 41, "pilot-simulated", "pilot"])
def test_names_of_sessions_that_cannot_be_are_refused(session, tmp_path, name):
    with pytest.raises(ParameterError):
        new_session_folder(Workspace.at(tmp_path), name)


def test_forms_are_read_in_a_line():
    assert counts_of("10, 20", "participants") == (10, 20)
    assert pairs_of("participant=subject, value = hit", "headings") == {
        "participant": "subject",
        "value": "hit",
    }
    with pytest.raises(ParameterError, match="participants must be whole numbers"):
        counts_of("ten", "participants")
    with pytest.raises(ParameterError, match="headings must be KEY=VALUE, got 'participant'"):
        pairs_of("participant", "headings")
    assert power_rows([{"participants": 10, "power": 0.5}]) == (
        ["participants", "shows the effect"],
        [["10", "0.50"]],
    )


def test_a_study_that_cannot_be_served_is_refused_before_it_is_workspace_sessions(tmp_path, monkeypatch):
    monkeypatch.setattr(study_server, "serve", lambda *_, **__: pytest.fail("served"))
    with pytest.raises(ParameterError, match="no such study"):
        study_server.run_study("nothing", tmp_path / "session", None)
    with pytest.raises(ParameterError, match="a new session of a study needs out"):
        study_server.run_study("abx", None, None)
    with pytest.raises(DataError, match="no study was begun here"):
        study_server.run_study(tmp_path, None, None)
    with pytest.raises(ParameterError, match="never a name"):
        study_server.run_study("abx", tmp_path / "session", None, codes=["Hanako"])
    with pytest.raises(ParameterError, match="full scale"):
        study_server.run_study(
            "abx", tmp_path / "session", None, changes={"played_by": "server", "display": "voice-coil"}
        )
    assert not (tmp_path / "session").exists()


def test_a_session_goes_on_as_it_was_begun_under_the_addresses_that_others_are_given(session, monkeypatch):
    served, told = [], []
    monkeypatch.setattr(study_server, "serve", lambda *given, **options: served.append((*given, options)))
    monkeypatch.setattr(PreparedStimuli, "start", lambda self: None)  # nobody feels them
    study_server.run_study(session.path.parent, None, "port", codes=["p1", "P3"], ready=told.append)
    [(studio, listening, options)] = served
    assert (listening, options["path"]) == ("port", "/experiment/pilot")
    assert [one.code for one in session.participants()] == ["P1", "P2", "P3"]
    roots = ("https://192.0.2.7:1", "https://192.0.2.8:1")
    options["ready"](ServerAnnouncement(f"{roots[0]}/experiment/pilot?token=x", roots, "AA:BB"))
    [facts] = told
    join = studio.sessions.open(session.path.parent).join_path
    assert (facts["join"], facts["addresses"]) == (f"{roots[0]}{join}", [f"{roots[1]}{join}"])
    assert all(address.startswith(f"{roots[0]}/take/") for address in facts["codes"].values())
    assert facts["certificate_sha256"] == "AA:BB"
    studio.sessions.close()
    with pytest.raises(ParameterError, match="omit out and changes"):
        study_server.run_study(session.path.parent, None, None, changes={"seed": 2})


def test_a_qr_code_leads_where_a_tablet_can_go():
    numbers = ("https://192.0.2.7:1", "https://198.51.100.7:1")
    assert (
        reachable_roots("https://127.0.0.1:1", numbers)
        == reachable_roots("https://127.0.0.2:1", numbers)
        == numbers
    )
    assert reachable_roots(numbers[1], numbers) == numbers[::-1]
    assert reachable_roots("https://lab.example", numbers) == (*numbers, "https://lab.example")
    assert reachable_roots("http://[::1]:1", ()) == ("http://[::1]:1",)
