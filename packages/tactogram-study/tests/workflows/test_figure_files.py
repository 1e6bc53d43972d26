import pytest

from tactogram_study.workflows.analysis import JSON_FILE, analyse_study


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
