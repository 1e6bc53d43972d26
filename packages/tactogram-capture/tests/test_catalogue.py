"""Sources by address, and the list of available ones."""

import subprocess
import sys

import pytest

from tactogram.errors import DeviceError, MissingExtraError, TactogramError
from tactogram.extras import device_errors, imported
from tactogram_capture import Source, find_sources, open_source
from tactogram_capture.catalogue import parse_address

OPENED = {
    "twelite": "twelite:/dev/tactogram-none?sender=1013C85",
    "serial": "serial:/dev/tactogram-none?baud=9600&unit=g",
    "lsl": "lsl:tactogram-none?find_s=0.05",
    "audio": "audio:tactogram-none?rate=48000",
    "ni": "ni:Dev1/ai0:2?rate=10000&kind=acceleration",
    "digilent": "digilent:?channels=1,2",
}


@pytest.mark.parametrize("kind", [*OPENED, "log", "simulated"])
def test_every_kind_is_a_source(kind, tmp_path):
    log = tmp_path / "a.txt"
    log.write_text("x\n1\n2\n")
    address = OPENED.get(kind) or {"log": f"log:{log}", "simulated": "simulated:twelite"}[kind]
    source = open_source(address)

    assert isinstance(source, Source)
    assert source.name == address
    assert {"samples", "lost", "rejected", "rate", "simulated"} <= set(source.facts())


@pytest.mark.parametrize("kind", OPENED)
def test_without_device_or_driver_opening_is_one_clear_line(kind):
    with pytest.raises((DeviceError, MissingExtraError)) as caught, open_source(OPENED[kind]):
        pass
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 400


@pytest.mark.parametrize(
    ("address", "told"),
    [
        ("nothing", "a source must be one of audio:NAME"),
        ("bluetooth:1", "a source must be one of audio:NAME"),
        ("twelite:", "twelite: must name the port after the colon"),
        ("twelite:/dev/x?sender=hello", "7 hex digits"),
        ("twelite:/dev/x?baud=ten", "baud: must be a valid integer"),
        ("twelite:/dev/x?speed=1", "unknown key 'speed'; known here: baud"),
        ("twelite:/dev/x?baud=9600&baud=1", "each option may be given once"),
        ("twelite:/dev/x?baud", "baud: must be a valid integer"),
        ("twelite:/dev/x?&", "options must be like"),
        ("serial:/dev/x?unit=furlong", "unit must be one of"),
        ("simulated:human", "the simulated device must be twelite, got 'human'"),
        ("simulated:twelite?loss=2", "loss"),
        ("ni:ai0", "channels must be like Dev1/ai0:2"),
        ("digilent:?channels=0", "channels must be numbers from 1"),
        ("audio:?channels=2&axes=left", "axes must be 2 different names"),
        ("lsl:", "must name a stream"),
        ("log:/dev/tactogram-none.log", "no such file"),
        ("log:/dev/\0", "must not contain a null character, got 'log:/dev/"),
        ("serial:/dev/x\0?baud=9600", "must not contain a null character"),
        ("simulated:twelite?log=%00", "must not contain a null character"),
    ],
)
def test_an_invalid_address_is_refused_in_one_line(address, told):
    with pytest.raises(TactogramError, match=told) as caught:
        open_source(address)
    assert "\n" not in str(caught.value)


def test_options_are_typed_and_their_defaults_documented():
    _, place, options = parse_address("simulated:twelite?rate=690&loss=0.02&form=semicolon&paced=false")

    assert place == "twelite"
    assert (options.rate, options.loss, options.form, options.paced) == (690.0, 0.02, "semicolon", False)


def test_the_list_names_available_and_missing_sources():
    found = find_sources(find_s=0.05)

    assert {one["kind"] for one in found} == {"serial", "lsl", "audio", "ni", "digilent", "simulated"}
    for one in found:
        assert (one["address"] is None) or parse_address(one["address"].partition("?")[0])
        assert one["missing"] is None or "\n" not in one["missing"]


def test_a_missing_library_is_named_by_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(
        MissingExtraError, match=r"install the extra devices: pip install 'tactogram\[devices\]'"
    ):
        imported("serial", extra="devices", what="sensors on a serial port")


def test_a_missing_driver_is_named(tmp_path, monkeypatch):
    (tmp_path / "sounddevice.py").write_text("raise OSError('PortAudio library not found')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    with pytest.raises(DeviceError, match="libportaudio2"):
        imported("sounddevice", extra="devices", what="audio inputs")


def test_a_library_that_fails_to_import_is_reported(tmp_path, monkeypatch):
    (tmp_path / "tactogram_broken.py").write_text("import tactogram_not_there\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(MissingExtraError, match="installed but does not import; reinstall the extra lsl"):
        imported("tactogram_broken", extra="lsl", what="nothing")


def test_output_of_a_library_during_import_is_not_shown(tmp_path, monkeypatch, capfd):
    (tmp_path / "tactogram_loud.py").write_text("import sys\nprint('a')\nprint('b', file=sys.stderr)\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    imported("tactogram_loud", extra="dwf", what="nothing")

    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (FileNotFoundError("libdwf.so: cannot open"), "dwf:1: libdwf.so: cannot open; it needs WaveForms"),
        (AttributeError("'NoneType' object has no attribute 'x'"), "it needs WaveForms"),
        (RuntimeError("busy\nnow"), "dwf:1: busy now$"),
        (ValueError("failed", -401), "dwf:1: failed, -401$"),
        (KeyError(), "dwf:1: KeyError$"),
    ],
)
def test_errors_of_drivers_become_one_line(error, told):
    with pytest.raises(DeviceError, match=told), device_errors("dwf:1", library="dwfpy"):
        raise error


def test_modules_of_one_system_are_not_needed_to_import_sources():
    """Windows has neither pseudo-terminals nor fcntl, yet sensors can be read."""
    code = (
        "import sys\n"
        "for name in ('fcntl', 'termios', 'tty'): sys.modules[name] = None\n"
        "import tactogram_capture.session.journal, tactogram_capture.session.console\n"
        "from tactogram_capture import open_source\n"
        "with open_source('simulated:twelite?paced=false') as source: print(len(source.read()))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout == "10\n", done.stderr


def test_a_sensor_needs_no_statistics_to_start():
    code = "import sys, tactogram_capture; print('scipy.stats' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_a_missing_port_is_named_once():
    with pytest.raises(DeviceError) as told, open_source("serial:/dev/tty-not-there?rate=100") as source:
        source.read(0.01)
    assert str(told.value) == "/dev/tty-not-there: No such file or directory"
