"""Paths to devices, how each was tested, and a self-test that a user can run and report.

`docs/devices.md` and the names of the self-test are made from ``devices.toml``.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DeviceError, MissingDriverError, MissingExtraError, ParameterError
from tactogram.extras import device_errors, imported, lsl, silenced
from tactogram.parameters import checked
from tactogram.text_files import read_toml
from tactogram_capture.catalogue import SOURCES, find_devices

State = Literal["works", "no hardware", "missing", "failed"]

UNTOUCHED = "none so far"
LOOPS = 20


@dataclass(frozen=True)
class DevicePath:
    """A way to or from a device.

    Several may share a ``name`` of the self-test. ``extra`` installs its library; ``simulated`` is the stand-in for the
    device in tests, ``hardware`` the real device it has been used with.
    """

    name: str
    title: str
    direction: Literal["in", "out", "in and out"]
    extra: str
    simulated: str
    hardware: str = UNTOUCHED


FILE = Path(__file__).with_suffix(".toml")
PATHS = tuple(DevicePath(**path) for path in read_toml(FILE)["path"])
ALSO = {"digilent": "dwf", "ni": "daq", "twelite": "serial"}
"""Names of sources and backends that share a self-test."""


def device_names() -> tuple[str, ...]:
    """Return the names of self-tests."""
    return tuple(dict.fromkeys(path.name for path in PATHS if path.name))


@checked
def try_device(name: str) -> dict[str, Any]:
    """Test one device as far as possible on this machine, and say how each way to it was tested.

    Parameters
    ----------
    name : str
        serial, lsl, daq, dwf (or digilent), audio, null, osc or mouse, or a kind of capture source whose devices can
        be listed.

    Returns
    -------
    dict
        ``device``, ``state`` (``works``, ``no hardware``, ``missing``: a library or driver, or ``failed``), ``line``
        (one sentence), ``facts`` (by device), ``paths`` (of `PATHS`), ``tactogram``, ``python``, ``platform``.

    Raises
    ------
    ParameterError
        If there is no such path; a device never makes it raise an error.
    """
    name = ALSO.get(name, name)
    if name not in _TESTS and name not in SOURCES:
        known = ", ".join((*device_names(), *ALSO))
        raise ParameterError.must("device", f"be one of {known}, or a kind of capture source", name)
    state: State
    try:
        state, line, facts = _TESTS[name]() if name in _TESTS else _source(name)
    except (MissingExtraError, MissingDriverError) as error:
        state, line, facts = "missing", str(error), {}
    except DeviceError as error:
        state, line, facts = "no hardware", str(error), {}
    return {
        "device": name,
        "state": state,
        "line": line,
        "facts": facts,
        "paths": [
            {"title": p.title, "direction": p.direction, "simulated": p.simulated, "hardware": p.hardware}
            for p in PATHS
            if p.name == name
        ],
        "tactogram": version("tactogram"),
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


ProbeResult = tuple[State, str, dict[str, Any]]


def _lsl() -> ProbeResult:
    pylsl = lsl()
    with device_errors("lsl", library="pylsl"):
        name = f"tactogram self-test {time.monotonic_ns()}"
        outlet = pylsl.StreamOutlet(pylsl.StreamInfo(name, "test", 1, 1000, "float32", name))
        streams = pylsl.resolve_byprop("name", name, timeout=3.0)
        if not streams:
            return "failed", "the program's own stream was not found: is multicast blocked?", {}
        inlet = pylsl.StreamInlet(streams[0])
        inlet.open_stream(timeout=3.0)
        sent = [float(n) for n in range(LOOPS)]
        for value in sent:
            outlet.push_sample([value])
        got: list[float] = []
        end = time.monotonic() + 2
        while len(got) < LOOPS and time.monotonic() < end:
            chunk, _ = inlet.pull_chunk(timeout=0.1)
            got += [row[0] for row in chunk]
        inlet.close_stream()
    facts = {"sent": LOOPS, "came_back": len(got), "library": pylsl.library_version()}
    if got != sent:
        return "failed", f"{len(got)} of {LOOPS} samples came back over this machine's own network", facts
    return "works", f"{LOOPS} samples came back over this machine's own network; no device was tested", facts


def _source(kind: str) -> ProbeResult:
    """List the devices of a kind of capture source; none is opened."""
    devices = find_devices(kind)
    if not devices:
        return "no hardware", "the driver works; no device is connected", {"devices": []}
    return "works", f"devices: {', '.join(devices)}; none was opened", {"devices": list(devices)}


def _audio() -> ProbeResult:
    """Play half a second of silence on the default output, and measure its latency."""
    try:
        sounddevice = imported("sounddevice", extra="devices", what="the audio backend")
    except (DeviceError, MissingExtraError) as error:
        return _miniaudio(null=False, because=str(error))
    with device_errors("audio"), silenced():
        outputs = [d for d in sounddevice.query_devices() if d["max_output_channels"] > 0]
        facts: dict[str, Any] = {"outputs": [d["name"] for d in outputs]}
        if not outputs:
            return "no hardware", "PortAudio works; no audio output found", facts
        calls: list[int] = []

        def callback(out: Any, frames: int, _time: Any, _flags: Any) -> None:
            out[:] = 0
            calls.append(frames)

        with sounddevice.OutputStream(blocksize=240, latency="low", callback=callback) as playing:
            time.sleep(0.5)
            facts |= {"rate_hz": playing.samplerate, "latency_ms": 1e3 * playing.latency}
        facts["frames_per_call"] = float(np.mean(calls)) if calls else 0.0
    line = f"played silence at {facts['rate_hz']:g} Hz; the device reports a latency of {facts['latency_ms']:.1f} ms"
    return (
        ("works", line, facts)
        if calls
        else ("failed", "the output opened and never requested samples", facts)
    )


def _miniaudio(*, null: bool, because: str = "") -> ProbeResult:
    """Play silence through miniaudio, on its null device or a real one."""
    calls: list[int] = []

    def silence(frames: int) -> NDArray[np.float32]:
        calls.append(frames)
        return np.zeros((frames, 1), np.float32)

    missing = f"no audio output was found by miniaudio, and {because or 'nothing else was tried'}"
    playback = imported("tactogram_playback", extra="playback", what="the null and audio backends")
    try:
        with playback.opened_card(silence, rate=8000, channels=1, buffer_ms=5, null=null) as card:
            begun = time.perf_counter()
            card.start()
            time.sleep(0.5)
            card.stop()
            seconds = time.perf_counter() - begun
    except DeviceError:
        return "no hardware", missing, {}
    facts = {"calls": len(calls), "frames_per_call": float(np.mean(calls)) if calls else 0.0}
    facts["pace"] = sum(calls) / 8000 / seconds
    if not calls:
        return "failed", "the device opened and never requested samples", facts
    line = f"{card.backend}: requested {len(calls)} times {facts['frames_per_call']:.0f} frames in {seconds:.2f} s"
    return "works", f"{line}; silence was played" + (", no actuator connected" if null else ""), facts


def _mouse() -> ProbeResult:
    playback = imported("tactogram_playback", extra="playback", what="a mouse as a finger")
    if not playback.MICE.exists():
        return "no hardware", f"no mouse: {playback.MICE} is missing (a mouse as a finger needs Linux)", {}
    mouse = playback.MouseMotion()
    begin = mouse.poll(0.0)[-1]
    time.sleep(0.5)
    end = mouse.poll(0.5)[-1]
    mouse.close()
    moved = float(np.hypot(end.x_mm - begin.x_mm, end.y_mm - begin.y_mm))
    return (
        "works",
        f"{playback.MICE} opened; moved by {moved:.1f} mm in half a second at 800 counts per inch",
        {"moved_mm": moved},
    )


_TESTS: dict[str, Callable[[], ProbeResult]] = {
    "serial": partial(_source, "serial"),
    "lsl": _lsl,
    "daq": partial(_source, "ni"),
    "dwf": partial(_source, "digilent"),
    "audio": _audio,
    "null": partial(_miniaudio, null=True),
    "mouse": _mouse,
}
