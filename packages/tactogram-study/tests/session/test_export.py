import json
import shutil

import pytest

from tactogram.errors import DataError
from tactogram_study.answers import cells, read_answers, write_answers
from tactogram_study.session.export import export_bids
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import simulate
from tactogram_study.study_file import Study


@pytest.fixture(scope="module")
def taken(tmp_path_factory, make_study_once):
    folder = tmp_path_factory.mktemp("taken")
    with SessionStore(folder / "session", make_study_once("two_area")) as store:

        def play(participant, page):
            for presented in page.presented:
                store.log_played(
                    participant.code,
                    page.token,
                    presented.slot,
                    sha256="a" * 64,
                    level="gain=1",
                    display="audio",
                )

        simulate(store, 2, effect=SimulatedEffect(d_prime=1.0), play=play)
        yield store


@pytest.fixture(scope="module")
def bids(taken, tmp_path_factory):
    return export_bids(taken, tmp_path_factory.mktemp("bids") / "set")


def test_a_bids_folder_is_valid_and_holds_every_answer(taken, bids, bids_issues):
    assert bids_issues(bids) == []
    tables = sorted(bids.glob("sub-*/ses-1/beh/*_beh.tsv"))
    assert len(tables) == 2
    assert sum(len(path.read_text().splitlines()) - 1 for path in tables) == len(taken.answers())
    assert len(list(bids.glob("sub-*/ses-1/beh/*_events.tsv"))) == 2
    assert json.loads((bids / "dataset_description.json").read_text())["Simulated"] is True
    assert "0 participants and 2 simulated participants" in (bids / "README").read_text()


@pytest.mark.parametrize(
    ("name", "changes", "practice"),
    [
        ("threshold", {"design.most_trials": 2, "practice.trials": 1}, {}),
        ("abx", {"design.repeats": 1, "practice.trials": 1}, {"practice": "practice"}),
    ],
)
def test_names_are_levels_of_the_columns_that_hold_keys(tmp_path, bids_issues, name, changes, practice):
    study = Study.load(name, changes=changes)
    with SessionStore(tmp_path / "session", study) as store:
        simulate(store, 1)
        folder = export_bids(store, tmp_path / "bids")
    [sidecar] = folder.glob("sub-*/ses-1/beh/*_beh.json")
    facts = json.loads(sidecar.read_text(encoding="utf-8"))
    names = {key: name.texts["en"] for key, name in study.display_names.items()}
    assert facts["stimulus"]["Levels"] == names | practice
    assert "Levels" not in facts["question"]
    assert bids_issues(folder) == []


def test_what_bids_does_not_allow_is_found(bids, tmp_path, bids_issues):
    folder = tmp_path / "set"
    shutil.copytree(bids, folder)
    (folder / "dataset_description.json").write_text('{"Name": "x"}')
    [first, second] = sorted(folder.glob("sub-*/ses-1/beh/*_beh.tsv"))
    second.with_suffix(".json").write_text("{}")
    first.with_suffix(".json").unlink()
    assert {"JSON_KEY_REQUIRED BIDSVersion", "TSV_ADDITIONAL_COLUMNS_UNDEFINED answer"} <= set(
        bids_issues(folder)
    )


def test_a_folder_that_holds_something_is_left_alone(taken, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(DataError, match="is not empty; give a new folder"):
        export_bids(taken, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_the_tidy_table_comes_back_as_the_store_holds_it(taken, tmp_path):
    write_answers(tmp_path / "a.csv", taken.answers())
    assert cells(read_answers(tmp_path / "a.csv")) == cells(taken.answers())
