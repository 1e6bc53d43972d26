"""Optional libraries that are absent, broken or without a driver, and devices that fail."""

import errno
import os
import sys

import pytest

from tactogram import extras
from tactogram.errors import DeviceError, MissingExtraError, ParameterError
from tactogram.extras import device_errors, imported, silenced


@pytest.fixture
def library(tmp_path, monkeypatch):
    """Return a function that makes an importable library of some source text."""
    monkeypatch.syspath_prepend(tmp_path)

    def make(source, name="some_device_library"):
        (tmp_path / f"{name}.py").write_text(source, encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
        return name

    return make


def test_what_a_library_prints_on_import_is_not_shown(library, capsys):
    module = imported(library("print('hello')\nanswer = 42"), extra="serial", what="boards")
    assert module.answer == 42
    assert capsys.readouterr().out == ""


def test_an_absent_library_names_its_extra():
    with pytest.raises(MissingExtraError) as error:
        imported("no_such_library.part", extra="serial", what="boards on a serial port")
    assert str(error.value) == (
        "no_such_library is needed for boards on a serial port and is not installed; install the extra serial: "
        "pip install 'tactogram[serial]'"
    )


@pytest.mark.parametrize("source", ["import no_such_library", "raise AttributeError('no symbol')"])
def test_a_library_that_does_not_import_is_to_be_reinstalled(library, source):
    with pytest.raises(MissingExtraError, match="does not import; reinstall the extra serial"):
        imported(library(source), extra="serial", what="boards")


def test_a_library_without_its_driver_names_the_driver(library, monkeypatch):
    name = library("raise OSError('libwave.so: cannot open')")
    monkeypatch.setitem(extras.DRIVERS, name, "Wave, a driver")
    with pytest.raises(
        DeviceError, match="its driver was not found: Wave, a driver; install that for boards"
    ):
        imported(name, extra="serial", what="boards")


def test_a_foreign_exception_becomes_a_line_that_begins_with_the_device():
    with pytest.raises(DeviceError, match=r"^serial:/dev/x: gone$"), device_errors("serial:/dev/x:"):
        raise RuntimeError("gone.")
    with pytest.raises(DeviceError) as error, device_errors("serial:/dev/x"):
        raise OSError(errno.EACCES, "could not open port /dev/x: [Errno 13]")
    assert str(error.value) == f"serial:/dev/x: {os.strerror(errno.EACCES)}"
    with (
        pytest.raises(DeviceError, match="it needs liblsl, the library of Lab Streaming Layer"),
        device_errors("lsl:x", library="pylsl"),
    ):
        raise FileNotFoundError("liblsl.so")


def test_an_error_of_our_own_stays_as_it_is():
    with pytest.raises(ParameterError, match="^rate must be > 0$"), device_errors("serial:/dev/x"):
        raise ParameterError("rate must be > 0")


def test_what_compiled_libraries_write_to_stderr_is_discarded(capfd):
    with silenced():
        os.write(2, b"ALSA lib: noise\n")
    os.write(2, b"heard\n")
    assert capfd.readouterr().err == "heard\n"
