"""Previews of a study: a participant's page without a session."""

from contextlib import closing

from tactogram_study.participants.sessions import SessionRegistry
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
