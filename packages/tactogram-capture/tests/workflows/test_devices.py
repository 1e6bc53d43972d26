"""The list of device paths: the document is made from it, and every self-test says one line."""

import re
import sys
from pathlib import Path

import pytest

from tactogram.cli import main
from tactogram.errors import MissingExtraError, ParameterError
from tactogram_capture.workflows import devices
from tactogram_capture.workflows.devices import PATHS, device_names, try_device

DOCUMENT = Path(__file__).parents[4] / "docs" / "devices.md"


def test_the_document_holds_the_list():
    _, table, _ = re.split(r"<!-- /?devices -->\n", DOCUMENT.read_text(encoding="utf-8"))
    rows = [
        f"| {p.title} | {p.direction} | {p.extra or 'none'} | {p.simulated} | {p.hardware} | "
        + (f"`{p.name}` |" if p.name else "none |")
        for p in PATHS
    ]
    assert table.splitlines()[2:] == rows


def test_no_path_has_touched_real_hardware_so_far():
    assert {path.hardware for path in PATHS} == {"none so far"}
    assert set(device_names()) == set(devices._TESTS)


@pytest.mark.parametrize("name", [n for n in device_names() if n != "lsl"])
def test_a_self_test_says_one_line_whatever_is_plugged_in(name, capfd):
    found = try_device(name)
    assert found["state"] in ("works", "no hardware", "missing", "failed")
    assert "\n" not in found["line"]
    assert len(found["line"]) < 400
    assert found["paths"]
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("name", ["null"])
def test_what_needs_no_hardware_works(name):
    assert try_device(name)["state"] == "works"


def test_a_missing_library_is_said_with_its_extra(monkeypatch):
    def missing(kind):
        raise MissingExtraError(f"pyserial is needed for {kind}; install the extra devices")

    monkeypatch.setattr(devices, "find_devices", missing)
    found = try_device("serial")
    assert found["state"] == "missing"
    assert "the extra devices" in found["line"]


def test_outputs_are_tried_with_what_plays_on_them(monkeypatch):
    monkeypatch.setitem(sys.modules, "tactogram_playback", None)
    found = try_device("mouse")
    assert found["state"] == "missing"
    assert found["line"].endswith("pip install 'tactogram[playback]'")


@pytest.mark.parametrize(("name", "test"), devices.ALSO.items())
def test_a_device_is_tried_by_the_name_that_its_source_has_too(name, test, monkeypatch):
    monkeypatch.setitem(devices._TESTS, test, lambda: ("works", "tried", {}))
    found = try_device(name)
    assert (found["device"], found["line"]) == (test, "tried")


def test_an_unknown_device_is_refused():
    with pytest.raises(ParameterError, match="device must be one of serial, lsl"):
        try_device("toaster")


def test_doctor_tries_a_device(capsys):
    assert main(["device", "null"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("null: works:")
    assert "real hardware: none so far" in text
    assert main(["device", "toaster"]) == 1
