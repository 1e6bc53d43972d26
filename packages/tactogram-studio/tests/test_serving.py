import io
import json
import sys

import pytest

from tactogram.cli.printing import Printer
from tactogram.errors import DataError, ParameterError
from tactogram_studio import application
from tactogram_studio.serving import run_study, shown_qr_code
from tactogram_study.participants.prepared_stimuli import PreparedStimuli

ADDRESS = "https://192.0.2.7:8123/join/abcdefghijklmnopqrstuv"


@pytest.mark.parametrize(
    ("encoding", "terminal", "shown"),
    [("utf-8", True, True), ("utf-8", False, False), ("euc_jp", True, False)],
)
def test_only_a_terminal_that_has_its_characters_shows_it(monkeypatch, encoding, terminal, shown):
    screen = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(screen, "isatty", lambda: terminal)
    monkeypatch.setattr(sys, "stdout", screen)
    monkeypatch.setenv("COLUMNS", "120")
    assert bool(shown_qr_code(ADDRESS)) == shown


PRINTER = Printer(json=True)


def test_a_study_that_cannot_be_served_is_refused_before_it_begins(tmp_path, monkeypatch):
    monkeypatch.setattr(application, "serve", lambda *_, **__: pytest.fail("served"))
    out = str(tmp_path / "session")
    with pytest.raises(ParameterError, match="no such study"):
        run_study("nothing", out=out, port=0, show=PRINTER)
    with pytest.raises(ParameterError, match="a new session of a study needs out"):
        run_study("abx", port=0, show=PRINTER)
    with pytest.raises(DataError, match="no study was begun here"):
        run_study(str(tmp_path), port=0, show=PRINTER)
    with pytest.raises(ParameterError, match="never a name"):
        run_study("abx", out=out, participants=("Hanako",), port=0, show=PRINTER)
    changes = {"played_by": "server", "display": "voice-coil"}
    with pytest.raises(ParameterError, match="full scale"):
        run_study("abx", out=out, changes=changes, port=0, show=PRINTER)
    assert not (tmp_path / "session").exists()


def test_a_session_goes_on_as_it_was_begun_under_the_addresses_that_others_are_given(
    session, monkeypatch, capsys
):
    served = []
    monkeypatch.setattr(application, "serve", lambda *given, **options: served.append((*given, options)))
    monkeypatch.setattr(PreparedStimuli, "start", lambda self: None)  # nobody feels them
    folder = str(session.path.parent)
    run_study(folder, participants=("p1", "P3"), port=0, show=PRINTER)
    [(studio, _, options)] = served
    assert options["path"] == "/experiment/pilot"
    assert [one.code for one in session.participants()] == ["P1", "P2", "P3"]
    roots = ("https://192.0.2.7:1", "https://192.0.2.8:1")
    options["ready"](application.ServerAnnouncement(f"{roots[0]}/experiment/pilot?token=x", roots, "AA:BB"))
    facts = json.loads(capsys.readouterr().out)
    join = studio.sessions.open(session.path.parent).join_path
    assert (facts["join"], facts["addresses"]) == (f"{roots[0]}{join}", [f"{roots[1]}{join}"])
    assert all(address.startswith(f"{roots[0]}/take/") for address in facts["codes"].values())
    assert facts["certificate_sha256"] == "AA:BB"
    studio.sessions.close()
    with pytest.raises(ParameterError, match="omit out and changes"):
        run_study(folder, changes={"seed": 2}, port=0, show=PRINTER)
