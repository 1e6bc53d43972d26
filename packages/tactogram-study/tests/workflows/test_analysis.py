import json

import numpy as np
import pytest

from tactogram.cli import main
from tactogram_study.analysis.findings import AnalysisSection, Finding
from tactogram_study.simulated_participants import simulated_answers
from tactogram_study.study_file import Study
from tactogram_study.workflows.analysis import (
    JSON_FILE,
    analyse_study,
    named_answers,
    named_section,
    targets_of,
)


@pytest.fixture
def table(tmp_path):
    """Another program's table: answers of simulated participants, under its own headings."""
    rng = np.random.default_rng(0)
    lines = ["subject,texture,hit,robot"]
    lines += [
        f"s{p},{('cork', 'tile')[t % 2]},{int(rng.random() < 0.85)},true" for p in range(6) for t in range(20)
    ]
    path = tmp_path / "theirs.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


THEIRS = ["--constant", "question=which", "--design", "two_area"]
for ours in ("participant=subject", "stimulus=texture", "value=hit", "simulated=robot"):
    THEIRS += ["--column", ours]


def test_another_programs_table_is_analysed_by_a_mapping_of_columns(table, tmp_path, capsys):
    out = tmp_path / "found"
    given = ["study", "analyse", str(table), "--out", str(out), "--margin", "which=0.1", "--json", *THEIRS]
    assert main(given) == 0
    result = json.loads(capsys.readouterr().out)
    [section] = result["sections"]
    [decides] = [f for f in section["findings"] if f["role"] == "confirmatory"]
    assert decides["verdict"] == "shown"
    assert (section["answers"], section["participants"]) == (120, 6)
    assert sorted(file.name for file in out.iterdir()) == sorted(result["files"])
    assert json.loads((out / "analysis.json").read_text())["margins"] == {"which": 0.1}
    assert "shown" in (out / "analysis.txt").read_text()


def test_ratings_of_an_export_need_only_their_design(tmp_path, capsys):
    path, out = tmp_path / "p.csv", tmp_path / "found"
    lines = ["item,rough_slider.response,rough_slider.rt,participant,psychopyVersion,", ",,,p1,2025.1.1,"]
    lines += [
        f"{item},{score},1.5,{who},2025.1.1," for who in ("p1", "p2") for item, score in (("a", 2), ("b", 6))
    ]
    path.write_text("\n".join(lines) + "\n")
    assert main(["study", "analyse", str(path), "--out", str(out), "--design", "rating", "--no-figures"]) == 0
    assert "rows left out without an answer: 1, the first is row 2" in capsys.readouterr().out.splitlines()
    [section] = json.loads((out / "analysis.json").read_text())["sections"]
    assert (section["answers"], section["participants"]) == (4, 2)
    path.write_text(path.read_text().replace("rough_slider", "slider"))
    given = ["study", "analyse", str(path), "--out", str(out), "--design", "rating", "--no-figures"]
    assert main(given) == 1
    said = capsys.readouterr().err
    assert (
        "ratings are not recognised; say which columns are participant, stimulus, question and value" in said
    )
    assert "--column NAME=HEADING`" in said
    assert "--constant question=WORD`" in said
    more = [
        "--column",
        "participant=participant",
        "--column",
        "stimulus=item",
        "--column",
        "value=slider.response",
    ]
    assert main([*given, *more, "--constant", "question=rough"]) == 0
    assert "rows left out without stimulus and answer: 1, the first is row 2" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--margin", "which"], "--margin must be KEY=VALUE"),
        (["--margin", "weight=1"], "a margin must be for one of"),
        (["--column", "participant"], "--column must be KEY=VALUE"),
        (["--draws", "1"], "at least 100"),
        (["--targets", "nowhere.csv"], "no such table of target ratings"),
    ],
)
def test_what_is_wrong_is_said_in_a_line_and_nothing_is_written(table, tmp_path, capsys, more, words):
    out = tmp_path / "found"
    assert main(["study", "analyse", str(table), "--out", str(out), *THEIRS, *more]) == 1
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert not out.exists()


def test_a_table_without_the_columns_is_refused(table, tmp_path, capsys):
    assert main(["study", "analyse", str(table), "--out", str(tmp_path / "x")]) == 1
    assert "lacks the column" in capsys.readouterr().err


def test_targets_are_means_over_raters(tmp_path):
    path = tmp_path / "plates.csv"
    path.write_text("rater,item,word,score\na,plate01,rough,2\nb,plate01,rough,5\n")
    assert targets_of(path) == {"plate01": {"rough": 3.5}}


def test_targets_can_be_the_answers_to_a_study_of_plates(tmp_path):
    path = tmp_path / "plates.csv"
    rows = ["study,participant,trial,design,question,stimulus,answer,value"]
    rows += ["plates,a,1,rating,rough,plate01,2,2", "plates,b,1,rating,rough,plate01,5,5"]
    path.write_text("\n".join(rows) + "\n")
    assert targets_of(path) == {"plate01": {"rough": 3.5}}


def test_a_design_that_is_not_there_is_named(tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("study,participant,design,question,answer\ns,a,abx,which,A\n")
    with pytest.raises(Exception, match="no rows of design 'rating', but abx"):
        analyse_study(path, tmp_path / "out", design="rating")


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """Give tables of a few made answers: of two designs, and of one of them."""
    folder = tmp_path_factory.mktemp("tables")
    heading = "study,participant,trial,design,question,stimulus,answer,value"
    rows = [
        f"made,P{person},{trial},{design},which,tile,A,{(person + trial) % 2}"
        for design in ("abx", "two_area")
        for person in range(3)
        for trial in range(1, 5)
    ]
    (folder / "both.csv").write_text("\n".join([heading, *rows]) + "\n")
    (folder / "abx.csv").write_text("\n".join([heading, *rows[:12]]) + "\n")
    return folder


def test_an_earlier_analysis_leaves_no_figure_beside_a_new_report_and_own_files_stay(tables, tmp_path):
    earlier = analyse_study(tables / "both.csv", tmp_path, draws=100)["files"]
    stale = sorted(name for name in earlier if name.startswith("two_area") and name.endswith(".png"))
    assert stale
    (tmp_path / "photo.png").write_bytes(b"mine")
    found = analyse_study(tables / "abx.csv", tmp_path, draws=100)["files"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*found, "photo.png"])
    assert not set(stale) & set(found)
    alone = analyse_study(tables / "abx.csv", tmp_path, draws=100, figures=False)["files"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*alone, "photo.png"])


@pytest.mark.parametrize(
    "said", ["{", "[]", '{"files": 3}', '{"files": ["../a.png", "notes.txt", "\\u0000.png", 3]}']
)
def test_nothing_else_is_removed(said, tables, tmp_path):
    folder = tmp_path / "found"
    folder.mkdir()
    (folder / JSON_FILE).write_text(said)
    for path in (tmp_path / "a.png", folder / "notes.txt"):
        path.write_bytes(b"mine")
    analyse_study(tables / "abx.csv", folder, figures=False, draws=100)
    assert (tmp_path / "a.png").exists()
    assert (folder / "notes.txt").exists()


def test_what_is_read_has_names_and_whole_words_only():
    names = {"tile": "floor tile", "cork-sheet": "cork sheet", "generated": "made"}
    table = [{"texture": "tile", "generated mean": 2.0, "verdict": "tile"}]
    found = Finding("tile over tile-2", "t", "check", "generated minus recorded, mm", 1.0)
    section = AnalysisSection("Which?", "two_area", "which", 2, 4, True, (found,), {"per texture": table})
    named = named_section(section, names)
    assert named.findings[0].of == "floor tile over tile-2"
    assert named.findings[0].measure == "made minus recorded, mm"
    assert list(named.tables.values()) == [[{"texture": "floor tile", "made mean": 2.0, "verdict": "tile"}]]
    assert named_section(section, {}) is section
    answers = simulated_answers(Study.load("threshold", changes={"design.most_trials": 4}), 1)
    assert "floor tile" in named_answers(answers, names).unique("condition")
