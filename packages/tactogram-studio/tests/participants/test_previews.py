"""Previews of a study: a participant's page without a session."""

from contextlib import closing

import pytest

from tactogram.errors import ParameterError
from tactogram_study.participants.sessions import MOST_PREVIEWS, SessionRegistry
from tactogram_study.study_file import Study


def test_a_preview_is_the_first_trial_and_leaves_nothing(tmp_path, write_study, opened):
    path = write_study(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    with closing(SessionRegistry(tmp_path)) as sessions:
        address = sessions.preview(Study.load(path), path)
        ticket = address.removeprefix("/take/").removesuffix("?preview")
        page = opened.client_of(sessions).get(f"/take/{ticket}/page").json()
        assert (page["code"], page["page"]["token"]) == ("PREVIEW1", "trial-1.1")
        session, _ = sessions.state_of(ticket)
        assert session.stimuli.drive(session.store.page("PREVIEW1"), "A")[1].sha256
        folder = session.folder
        assert not folder.is_relative_to(tmp_path)
    assert not folder.exists()
    assert sorted(tmp_path.rglob("*")) == before


def test_only_the_latest_previews_stay_open(tmp_path, write_study):
    path = write_study(tmp_path)
    study = Study.load(path)
    with closing(SessionRegistry(tmp_path)) as sessions:
        tickets = [
            sessions.preview(study, path).removeprefix("/take/").removesuffix("?preview")
            for _ in range(MOST_PREVIEWS + 1)
        ]
        assert [sessions.by_ticket(ticket) is not None for ticket in tickets] == [False] + [
            True
        ] * MOST_PREVIEWS


def test_no_preview_reads_files_from_elsewhere(tmp_path, write_study):
    path = write_study(tmp_path)
    (tmp_path / "workspace").mkdir()
    with (
        closing(SessionRegistry(tmp_path / "workspace")) as sessions,
        pytest.raises(ParameterError, match="outside of the workspace"),
    ):
        sessions.preview(Study.load(path), path)
