"""Simulated participants take a study through the real pages, with one kill of the server in the middle."""

import pytest
from benchmarks.experiments import studies_in_browser
from benchmarks.experiments.browser_participants import browser_path
from benchmarks.experiments.study_cases import STUDIES

from tactogram.errors import DataError, DeviceError
from tactogram_study.study_file import Study, shipped_studies


def test_studies_of_every_shipped_design_are_taken():
    kinds = {name: Study.load(name).design.kind for name in shipped_studies()}
    assert {kinds[name] for name in STUDIES} == set(kinds.values())


def test_what_is_lost_twice_or_stored_otherwise_is_found():
    class Row:
        def __init__(self, answer):
            self.participant, self.more, self.answer = "S001", {"token": "trial-1.1"}, answer

    key = ("S001", "trial-1.1")
    studies_in_browser._check([], [], [Row("41.9")], {key: ["42"]})
    for rows, given in (
        ([], {key: ["A"]}),
        ([Row("A")], {}),
        ([Row("A"), Row("A")], {key: ["A"]}),
        ([Row("B")], {key: ["A"]}),
        ([Row("43")], {key: ["42"]}),
    ):
        with pytest.raises(DataError):
            studies_in_browser._check([], [], rows, given)


@pytest.mark.slow
def test_two_simulated_participants_take_a_study_whose_server_is_killed(tmp_path):
    pytest.importorskip("playwright")
    pytest.importorskip("nicegui")
    try:
        browser_path()
    except DeviceError as error:
        pytest.skip(str(error))
    facts = studies_in_browser.take_study(
        "plate-words",
        tmp_path,
        changes={"grid.count": 2, "design.words": ["rough", "dry"]},
        effect={"shift": {"plate01": 2.0}},
        participants=2,
        at_once=2,
    )
    assert facts["killed"] == 1
    assert facts["pages"] == 2 * (2 + 2)
    assert facts["answers"] == 2 * (1 + 2 * 2 + 1)
    assert facts["bids_problems"] == []
    assert facts["simulated"] is True
