import socket

import pytest

from tactogram.cli import main
from tactogram_study.session.store import SessionStore
from tactogram_study.workflows.sessions import (
    begin_session,
)


def test_the_shipped_studies_are_listed(printed):
    listed = printed("study", "list")
    assert listed["two-area"]["trials"] == 90
    assert listed["image-words"]["design"] == "rating"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["check", "nothing"], "nothing: no such study; shipped ones are abx"),
        (["check", "STUDY", "--set", "level=loud"], "level must be one of physical"),
        (["check", "STUDY", "--set", "display=x"], "stimulus buzz: display must be one of"),
        (["check", "abx", "--set", "grid.source.simulated=fabric/{item}"], "simulated set must be one of"),
        (["check", "abx", "--set", "grid.source.simulated=stroking9/x"], "stroking9 has artificial-grass"),
        (["check", "plate-words", "--set", "grid.source.simulated_image=dot/1"], "with a family of"),
        (
            ["simulate", "STUDY", "--out", "OUT", "--effect", "dprime=1"],
            "effect: unknown key 'dprime'; known here: b",
        ),
        (
            ["simulate", "STUDY", "--out", "OUT", "--participants", "0"],
            "participants must be greater than or equal to 1, got 0",
        ),
        (["export", "OUT"], "export needs a target; give --out, or --bids"),
        (["export", "OUT", "--out", "a.csv"], "no study was begun here"),
        (["withdraw", "OUT", "P1"], "no study was begun here"),
    ],
)
def test_what_is_wrong_is_one_line(study_file, tmp_path, capsys, arguments, message):
    places = {"STUDY": str(study_file), "OUT": str(tmp_path / "none")}
    assert main(["study", *(places.get(a, a) for a in arguments)]) == 1
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1
    assert not (tmp_path / "none").exists()


def test_a_wrong_name_is_told_before_a_port_in_use(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert main(["study", "run", "two-aera", "--out", "x", "--no-open", "--port", port]) == 1
    assert "two-aera: no such study; shipped ones are " in capsys.readouterr().err


def test_a_session_is_looked_after_from_the_command_line(study_file, tmp_path, printed, capsys):
    folder = begin_session(study_file, tmp_path / "session")
    with SessionStore(folder) as store:
        store.enrol("P1", device={"px_per_mm": 4})
    assert printed("study", "note", folder, "The fan was on", "--participant", "P1")["notes"] == 1
    assert printed("study", "abort", folder, "P1")["state"] == "aborted"
    assert printed("study", "abort", folder, "P1", "--undo")["state"] == "going"
    assert printed("study", "end", folder)["ended"]
    known = printed("study", "progress", folder)
    assert (known["participants"][0]["device"], known["notes"][0]["participant"]) == ({"px_per_mm": 4}, "P1")
    assert printed("study", "end", folder, "--undo")["ended"] is None
    assert main(["study", "progress", str(folder)]) == 0
    assert "P1    not begun  0 of 4" in capsys.readouterr().out
    assert main(["study", "abort", str(folder), "P9"]) == 1
    assert capsys.readouterr().err == "tactogram: no participant has the code 'P9'\n"


def test_languages_are_listed_with_what_they_lack_and_printed_for_translation(
    study_file, tmp_path, printed, capsys, monkeypatch
):
    monkeypatch.setenv("TACTOGRAM_LANGUAGES", "")
    own = tmp_path / "nl.toml"
    assert main(["study", "languages", "en"]) == 0
    own.write_text(capsys.readouterr().out.replace('name = "English"', 'name = "Nederlands"'), "utf-8")
    listed = printed("study", "languages", "--languages", own)
    assert listed["nl"] == {"name": "Nederlands", "missing_texts": []}
    own.write_text('next = "Verder"', encoding="utf-8")
    study_file.write_text(f'languages = ["nl", "en"]\n{study_file.read_text()}')
    lacks = printed("study", "check", study_file)["missing_texts"]
    assert list(lacks) == ["nl"]
    assert "begin" in lacks["nl"]
    assert "next" not in lacks["nl"]
    assert main(["study", "check", str(study_file)]) == 0
    assert f"missing_texts: nl {len(lacks['nl'])}: name, reload, language," in capsys.readouterr().out
