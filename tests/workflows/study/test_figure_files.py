import json

import pytest

from tactogram.workflows.study.analysis import JSON_FILE, analyse_study
from tactogram.workflows.study.figure_files import HASHES, hashes_of, remove_earlier


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
    found = analyse_study(tables / "abx.csv", tmp_path, draws=100)
    assert found[HASHES] == hashes_of({name: (tmp_path / name).read_bytes() for name in found[HASHES]})
    found = found["files"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*found, "photo.png"])
    assert not set(stale) & set(found)
    alone = analyse_study(tables / "abx.csv", tmp_path, draws=100, figures=False)["files"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*alone, "photo.png"])


def test_a_figure_that_somebody_changed_is_theirs_and_stays(tmp_path):
    figures = {"abx_correct.png": b"drawn", "abx_shares.png": b"drawn, too"}
    said = {"sections": [], "files": [JSON_FILE, *figures], HASHES: hashes_of(figures)}
    (tmp_path / JSON_FILE).write_text(json.dumps(said))
    (tmp_path / "abx_correct.png").write_bytes(b"with an arrow drawn in")
    (tmp_path / "abx_shares.png").write_bytes(b"drawn, too")
    assert remove_earlier(tmp_path, JSON_FILE, kept=()) == ["abx_shares.png"]
    assert (tmp_path / "abx_correct.png").read_bytes() == b"with an arrow drawn in"


X = hashes_of({"x": b"x"})["x"]


@pytest.mark.parametrize(
    ("said", "removed"),
    [
        ({"sections": [], HASHES: {"a.png": X}}, ["a.png"]),
        (
            {"sections": [], "files": ["a.png"]},
            [],
        ),  # an earlier version said names only: nobody knows if it is as drawn
        ({"sections": [], HASHES: {"../a.png": X, "notes.txt": X, "\0.png": X, "a" * 300 + ".png": X}}, []),
        ({"sections": [], HASHES: {"link.png": X, "folder.png": X, "a.png": 3}}, []),
        ({HASHES: {"a.png": X}}, []),
        ({"sections": [], HASHES: ["a.png"]}, []),
        (["a.png"], []),
        ("{", []),
        ("[" * 100_000, []),
    ],
)
def test_only_what_an_analysis_says_it_wrote_goes(tmp_path, said, removed):
    folder = tmp_path / "out"
    (folder / "folder.png").mkdir(parents=True)
    own = [tmp_path / "a.png", folder / "a.png", folder / "notes.txt"]
    for path in own:
        path.write_text("x")
    (folder / "link.png").symlink_to(tmp_path / "a.png")
    (folder / JSON_FILE).write_text(said if isinstance(said, str) else json.dumps(said))
    assert remove_earlier(folder, JSON_FILE, kept=()) == removed
    assert [path for path in own if not path.is_file()] == [folder / name for name in removed]
    assert (folder / "link.png").is_symlink()
