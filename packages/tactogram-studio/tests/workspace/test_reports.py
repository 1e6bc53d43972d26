import json
import os
import subprocess
import sys

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.workflows.results_table import table
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.reports import (
    is_simulated,
    marked_simulated,
    matching,
    published_cells,
    readable_file,
    report_files,
)


@pytest.fixture(name="workspace")
def workspace_fixture(tmp_path):
    """Give a workspace with two runs, one of them on simulated data, and files that are not reports."""
    for number, name in enumerate(("old", "new")):
        run = tmp_path / "runs" / name
        (run / "figures").mkdir(parents=True)
        (run / "recipe.toml").write_text('model = "stroke_cnn"\n')
        (run / "data.json").write_text(json.dumps({"simulated": name == "new"}))
        for file in ("report.html", "evaluation.json", "metrics.json", "figures/curve.png"):
            (run / file).write_text("{}")
            os.utime(run / file, (number + 1, number + 1))
    (tmp_path / "photo.png").write_bytes(b"no report's")
    (tmp_path / "studio" / "state").mkdir(parents=True)
    (tmp_path / "studio" / "state" / "report.html").write_text("a secret")
    return Workspace.at(tmp_path)


def test_reports_come_newest_first_and_before_their_numbers(workspace):
    assert [item.path for item in report_files(workspace)] == [
        "runs/new/report.html",
        "runs/new/evaluation.json",
        "runs/new/figures/curve.png",
        "runs/old/report.html",
        "runs/old/evaluation.json",
        "runs/old/figures/curve.png",
    ]
    assert {item.folder: item.simulated for item in report_files(workspace)} == {
        "runs/new": True,
        "runs/old": False,
    }


@pytest.mark.parametrize("name", ["../x.html", "/etc/passwd.html", "runs/new/../../../x.json"])
def test_nothing_outside_of_the_workspace_is_shown(workspace, name):
    with pytest.raises(ParameterError, match="outside"):
        readable_file(workspace, name)


@pytest.mark.parametrize("name", ["studio/state/report.html", "runs/new/recipe.toml", "runs/new"])
def test_only_reports_are_shown(workspace, name):
    with pytest.raises(ParameterError, match="can be shown here"):
        readable_file(workspace, name)


def test_a_missing_report_is_refused(workspace):
    with pytest.raises(DataError, match="no such file"):
        readable_file(workspace, "runs/new/gone.html")


def test_a_link_that_leads_out_is_not_followed(workspace, tmp_path_factory):
    outside = tmp_path_factory.mktemp("outside") / "x.html"
    outside.write_text("elsewhere")
    (workspace.folder / "x.html").symlink_to(outside)
    with pytest.raises(ParameterError, match="outside"):
        readable_file(workspace, "x.html")


@pytest.mark.parametrize(
    ("values", "simulated"),
    [
        ({"simulated": True}, True),
        ({"data": {"name": "stroking9 (simulated)"}}, True),
        ({"data": "simulated: stroking30"}, True),
        ({"data": {"name": "lmt108", "simulated": False}}, False),
        ([1, 2], False),
    ],
)
def test_results_are_marked_as_simulated(values, simulated):
    assert marked_simulated(values) is simulated


def test_a_folder_without_numbers_is_not_marked_as_simulated(tmp_path):
    assert not is_simulated(tmp_path)


def test_the_table_has_every_figure_with_data_and_difference():
    rows = table()
    assert len(published_cells(rows)) == len(rows)
    row = {"model": "m", "what": "error", "published": 0.5, "where": "Table 1", "ours": 0.75, "sd": 0.01}
    row |= {"data": "made (simulated)", "split": "by item", "seeds": 3, "recipe": "", "note": "other data"}
    [cells] = published_cells([row])
    assert (cells["Published"], cells["Ours"], cells["Difference"]) == (
        "0.5\nTable 1",
        "0.75 ± 0.01",
        "+0.25",
    )
    assert (cells["Seeds"], cells["Data and split"]) == ("3", "made (simulated)\nby item")


def test_a_search_matches_rows_with_all_words():
    rows = table()
    both = published_cells(rows, "stroke_cnn simulated")
    one = published_cells(rows, "stroke_cnn")
    assert 0 < len(both) < len(one) < len(rows)
    assert matching("a B", ["xA", "b"])
    assert not matching("a c", ["xA", "b"])


def test_a_missing_figure_has_no_difference():
    row = dict.fromkeys(("where", "data", "split", "recipe", "note"), "")
    row |= {"model": "m", "what": "w", "published": None, "ours": 1.0, "sd": None, "seeds": 1}
    [cells] = published_cells([row])
    assert (cells["Published"], cells["Difference"]) == ("none\n", "")


def test_importing_the_pages_loads_nothing_that_takes_long():
    """A third of the start was scipy.signal and what it imports; `import scipy` loads them on first use."""
    slow = ("torch", "matplotlib.pyplot", "scipy.signal", "scipy.stats", "scipy.optimize", "openpyxl")
    program = (
        "import importlib, sys\n"
        "from tactogram_studio.application import PAGES\n"
        "for name in PAGES: importlib.import_module(f'tactogram_studio.pages.{name}')\n"
        f"loaded = [name for name in {slow} if name in sys.modules]\n"
        "assert loaded == [], loaded\n"
    )
    done = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
