import json
import re
from dataclasses import replace

import pytest

from tactogram.cli import main
from tactogram_study.answers import Answers, read_answers, write_answers
from tactogram_study.session.store import SessionStore
from tactogram_study.workflows.analysis import analyse_study
from tactogram_study.workflows.answers import export_study
from tactogram_study.workflows.sessions import begin_session, session_progress, simulate_study


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """Give a session of six simulated participants in the shipped two-area study, made short, without an effect."""
    folder = tmp_path_factory.mktemp("reported") / "pilot"
    changes = {"design.repeats": 2, "practice": {"trials": 1}}
    simulate_study("two-area", folder, participants=6, changes=changes)
    with SessionStore(folder) as store:
        store.note("The fan was on <loud>", code=store.participants()[0].code)
    return folder


@pytest.fixture(scope="module")
def page(session, tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    analyse_study(session, out, draws=200)
    return (out / "report.html").read_text(encoding="utf-8")


def plain(page):
    return " ".join(re.sub(r"<[^>]+>|&nbsp;", " ", re.sub(r"data:[^\"]+", "", page)).split())


def test_the_report_holds_design_people_tests_margins_figures_notes_and_caveats(page):
    text = plain(page)
    for said in (
        "Recorded and generated touch",
        "6 simulated participants",
        "Simulated participants: programs answered",
        "Simulated stimuli: computed",
        "answers about simulated stimuli",
        "Margins, given beforehand in the study&#39;s file: realism ±10 mm (a tenth of the line",
        "which ±0.1 of the share correct (60 % correct is",
        "Confirmatory: the deciding tests",
        "As printed: tests of the publication",
        "SHA-256 of the consent",
        "1 trials",
        "punched plastic sheet",  # its name: the key has hyphens
        "穴あきプラスチックシート",  # beside the key, of what is called how
        "Enrolled: 6 finished",
        "The fan was on &lt;loud&gt;",
        "One that is not shown may still exist",
        "answers to practice trials are left out",
    ):
        assert said in text, said
    assert page.count("<img ") == 2


def test_the_report_never_says_no_difference_and_needs_no_other_file(page):
    assert not re.search(
        r"no (significant )?difference|identical|indistinguishable", plain(page), re.IGNORECASE
    )
    assert "no effect" not in plain(page).casefold()
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)


def test_margins_given_with_the_command_are_said_to_come_afterwards(session, tmp_path, capsys):
    given = [
        "study",
        "analyse",
        str(session),
        "--out",
        str(tmp_path),
        "--margin",
        "realism=25",
        "--draws",
        "200",
    ]
    assert main([*given, "--no-figures", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["given_afterwards"] == {"realism": 25.0}
    assert result["margins"] == {"which": 0.1, "realism": 25.0}
    assert result["margins_beforehand"] == {"which": 0.1, "realism": 10.0}
    text = plain((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "Given afterwards, not as in the study&#39;s file: realism ±25 mm" in text
    assert "margin given afterwards" in text


def test_an_exported_table_is_reported_with_what_stands_beside_it(session, tmp_path):
    export_study(session, out=tmp_path / "answers.csv")
    analyse_study(tmp_path / "answers.csv", tmp_path / "out", draws=200, figures=False)
    text = plain((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    assert "given beforehand" in text
    assert "The fan was on" in text
    assert "Enrolled: 6 finished" in text


def test_who_never_began_is_counted_apart_and_is_no_missing_answer(tmp_path):
    folder = tmp_path / "pilot"
    simulate_study("abx", folder, participants=3, changes={"design.repeats": 4, "grid.items": ["tile"]})
    with SessionStore(folder) as store:
        store.enrol("LATE1", simulated=True)
    analyse_study(folder, tmp_path / "out", draws=200, figures=False)
    text = plain((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    assert "Enrolled: 3 finished, 1 not begun." in text
    assert "ABX: is X A or B? 3." in text
    facts = session_progress(folder)
    assert facts["statuses"] == {"finished": 3, "not begun": 1}
    export_study(folder, bids=tmp_path / "bids")
    table = (tmp_path / "bids" / "participants.tsv").read_text(encoding="utf-8")
    assert re.search(r"sub-LATE1\t4\t.*\tnot begun\t0", table)
    levels = json.loads((tmp_path / "bids" / "participants.json").read_text(encoding="utf-8"))
    assert "not begun" in levels["status"]["Levels"]


def test_the_verb_says_how_many_stand_how(tmp_path, capsys):
    folder = begin_session("abx", tmp_path / "pilot")
    with SessionStore(folder) as store:
        store.enrol("P1")
        store.submit(store.enrol("P2").code, "consent", {"consent": "agreed"})
    assert main(["study", "progress", str(folder)]) == 0
    first, _, *rows = capsys.readouterr().out.splitlines()
    assert first == "abx: 2 participants, 1 going on, 1 not begun; 1 answers"
    assert ["not begun" in rows[0], "going on" in rows[1]] == [True, True]


def test_a_table_alone_says_that_its_study_is_not_known(session, tmp_path):
    export_study(session, out=tmp_path / "answers.csv")
    (tmp_path / "answers.study.json").unlink()
    result = analyse_study(tmp_path / "answers.csv", tmp_path / "out", draws=200, figures=False)
    assert result["margins_beforehand"] is None
    assert "has no study file" in plain((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))


def test_practice_is_analysed_when_asked_for_and_said_so(session, tmp_path):
    result = analyse_study(session, tmp_path, draws=200, figures=False, practice=True)
    assert {section["answers"] for section in result["sections"]} == {6, 12}
    assert "Practice trials, which do not count." in plain(
        (tmp_path / "report.html").read_text(encoding="utf-8")
    )


def test_what_devices_measured_stands_in_the_report(session, tmp_path):
    export_study(session, out=tmp_path / "answers.csv")
    whole = read_answers(tmp_path / "answers.csv")
    rows = [
        replace(row, more={**row.more, "device_finger_speed_mm_s": str(480 + k % 3), "device_pointer": "pen"})
        for k, row in enumerate(whole)
    ]
    write_answers(tmp_path / "answers.csv", Answers(tuple(rows)))
    analyse_study(tmp_path / "answers.csv", tmp_path / "out", draws=200, figures=False)
    text = plain((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    assert "Mean speed of the finger over the area, mm/s, as measured 481 480 482" in text
    assert "What was moved" not in text
