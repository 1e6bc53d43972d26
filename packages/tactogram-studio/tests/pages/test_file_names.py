"""File names that are not UTF-8: every page lists the workspace all the same."""

import os
import shutil

import pytest

from tactogram_study.study_file import shipped_studies

SHOWN = {"materials": "st�rke", "studies": "study�.toml"}
"""A name that a page shows once its list is drawn."""
PAGES = {
    page: SHOWN.get(page, "") for page in ("", "make", "touch", "train", "send", "live", "reports", *SHOWN)
}


@pytest.fixture(scope="module")
def workspace(surfaces, tmp_path_factory):
    """Give a workspace with a store and files whose names are not UTF-8."""
    folder = tmp_path_factory.mktemp("names") / "workspace"
    shutil.copytree(surfaces, folder)
    shutil.copytree(
        folder / "studio" / "first" / "surfaces", os.fsdecode(os.fsencode(folder) + b"/st\xe4rke")
    )
    plan, study = b'title = "P"\nmaterials = ["a"]\nseconds = 1\n', shipped_studies()["abx"].read_bytes()
    display = b'family = "linear"\nchannels = ["a"]\n'
    for name, data in {
        b"cork\xff.wav": b"RIFF",
        b"cork\xff.png": b"",
        b"report\xff.html": b"<h1>A report</h1>",
        b"plan\xff.toml": plan,
        b"study\xff.toml": study,
        b"display\xff.toml": display,
    }.items():
        with open(os.fsencode(folder) + b"/" + name, "wb") as file:
            file.write(data)
    return folder


def test_every_page_shows_files_whose_names_are_not_utf_8(tab):
    for page, name in PAGES.items():
        assert tab.goto(f"/{page}").status == 200, page
        tab.get_by_role("heading", level=1).wait_for()
        if name:
            tab.get_by_text(name).first.wait_for()
        assert tab.get_by_text("Unexpected error").count() == 0, page
    assert "cork�.wav" in [offer["of"] for offer in tab.request.get("/touch/offers").json()["offers"]]
    answer = tab.request.get("/touch/table?where=file&of=cork%EF%BF%BD.wav")
    assert "this name is not UTF-8 on the disk; rename" in answer.json()["error"]
    tab.wrong.clear()  # the browser notes the refused requests
