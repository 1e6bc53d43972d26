import pytest

from tactogram.errors import ParameterError
from tactogram_studio import study_server
from tactogram_studio.application import ServerAnnouncement
from tactogram_study.participants.prepared_stimuli import PreparedStimuli
from tactogram_study.session.store import SessionStore
from tactogram_study.workflows.sessions import begin_session

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
