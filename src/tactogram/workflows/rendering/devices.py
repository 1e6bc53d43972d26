"""Paths to devices, how each was tested, and a self-test that a user can run and report.

`docs/devices.md` and the names of the self-test are made from `PATHS`.
"""

from __future__ import annotations

import platform
import time
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Literal

import numpy as np

from tactogram.capture.catalogue import SOURCES, find_devices
from tactogram.errors import DeviceError, MissingExtraError, ParameterError
from tactogram.extras import device_errors, imported, silenced

State = Literal["works", "no hardware", "missing", "failed"]

UNTOUCHED = "none so far"


@dataclass(frozen=True)
class DevicePath:
    """A way to or from a device.

    ``name`` is the kind of capture source that lists it, empty if none does. ``extra`` installs its library;
    ``simulated`` is the stand-in for the device in tests, ``hardware`` the real device it has been used with.
    """

    name: str
    title: str
    direction: Literal["in", "out", "in and out"]
    extra: str
    simulated: str
    hardware: str = UNTOUCHED


PATHS: tuple[DevicePath, ...] = (
    DevicePath(
        "serial",
        "TWE-Lite receivers on a serial port",
        "in",
        "devices",
        "a simulated receiver on a pseudo-terminal",
    ),
    DevicePath(
        "serial",
        "boards that send lines of numbers (Arduino, Teensy)",
        "in",
        "devices",
        "pseudo-terminals and logs",
    ),
    DevicePath("lsl", "Lab Streaming Layer", "in", "lsl", "outlet and inlet in one process"),
    DevicePath("ni", "National Instruments (NI-DAQmx)", "in", "daq", "a stand-in for its library"),
    DevicePath("digilent", "Digilent oscilloscopes (WaveForms)", "in", "dwf", "a stand-in for its library"),
    DevicePath(
        "digilent",
        "Digilent Analog Discovery as generator, envelope on its AM node",
        "out",
        "dwf",
        "a stand-in for its library",
    ),
    DevicePath(
        "audio", "audio inputs", "in", "devices", "a stand-in for its library; miniaudio's null input"
    ),
    DevicePath(
        "audio",
        "audio displays and actuators on a sound card",
        "out",
        "devices",
        "a stand-in for PortAudio's library; miniaudio on its null device",
    ),
    DevicePath(
        "",
        "game engines over OSC",
        "in and out",
        "devices",
        "a sender in Python over loopback; no game engine",
    ),
)


def device_names() -> tuple[str, ...]:
    """Return the names of self-tests."""
    return tuple(dict.fromkeys(path.name for path in PATHS if path.name))


def try_device(name: str) -> dict[str, Any]:
    """Test a path as far as possible on this machine; a device never makes it raise an error.

    ``name`` is one of `device_names`, or another kind of capture source whose devices can be listed.

    Returns
    -------
    dict
        ``device``, ``state`` (``works``, ``no hardware``, ``missing``: a library or driver, or ``failed``), ``line``
        (one sentence), ``facts`` (by device), ``paths`` (of `PATHS`), ``tactogram``, ``python``, ``platform``.

    Raises
    ------
    ParameterError
        If there is no such path.
    """
    if name not in SOURCES:
        known = ", ".join(device_names())
        raise ParameterError(f"device must be one of {known}, or a kind of capture source, got {name!r}")
    state: State
    try:
        state, line, facts = _audio() if name == "audio" else _source(name)
    except MissingExtraError as error:
        state, line, facts = "missing", str(error), {}
    except DeviceError as error:
        needs = "was not found" in str(error) or "needs" in str(error)
        state, line, facts = "missing" if needs else "no hardware", str(error), {}
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


def _source(kind: str) -> ProbeResult:
    """List the devices of a kind of capture source; none is opened."""
    found = find_devices(kind)
    if not found:
        return "no hardware", "the driver works; no device is connected", {"devices": []}
    return "works", f"devices: {', '.join(found)}; none was opened", {"devices": list(found)}


def _audio() -> ProbeResult:
    """Play half a second of silence on the default output, and measure its latency."""
    sounddevice = imported("sounddevice", extra="devices", what="the audio backend")
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
