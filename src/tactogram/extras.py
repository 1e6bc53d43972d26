"""The one place where libraries of devices are imported, and where what their drivers say becomes one line.

None of them is needed to learn, generate or judge, so each stands in an extra. What fails is of three kinds, and a user
does something else about each: the library is not installed (`MissingExtraError`: install the extra), the library is
there but its driver is not, or the device did not open or stopped answering (both `DeviceError`).
"""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from importlib import import_module
from types import ModuleType

from tactogram.errors import DeviceError, MissingExtraError, TactogramError

DRIVERS = {
    "sounddevice": "PortAudio, a system library (Debian: libportaudio2)",
    "nidaqmx": "NI-DAQmx, National Instruments' driver",
    "dwfpy": "WaveForms, Digilent's driver",
    "pylsl": "liblsl, the library of Lab Streaming Layer",
}
"""What a library needs besides itself, by the library's name."""

# Lab Streaming Layer writes its diary to stderr unless told otherwise; -2 is errors only.
_LSL_SETTINGS = "[log]\nlevel = -2\n"


def imported(name: str, *, extra: str, what: str) -> ModuleType:
    """Return the module ``name`` of a package of the extra ``extra``.

    What it prints while it is imported (some drivers' libraries say there that the driver is missing) is not shown.

    Parameters
    ----------
    name : str
        For example ``"serial"``, ``"pythonosc.udp_client"``.
    extra : str
        The extra of this package that brings it.
    what : str
        What it is needed for, as the end of "is needed for …": ``"boards on a serial port"``.

    Raises
    ------
    MissingExtraError
        If it is not installed; one line with the extra's name.
    DeviceError
        If it is installed and does not import because a driver is missing; one line with the driver's name.
    """
    package = name.partition(".")[0]
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            return import_module(name)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package:
            raise _broken(name, error, extra) from error
        raise MissingExtraError(
            f"{package} is needed for {what} and is not installed; install the extra {extra}: "
            f"pip install 'tactogram[{extra}]'"
        ) from error
    except (ImportError, OSError, RuntimeError, AssertionError, AttributeError) as error:
        if package in DRIVERS:
            raise DeviceError(
                f"{package} is installed, but what it needs was not found: {DRIVERS[package]}; "
                f"install that for {what} ({one_line(error)})"
            ) from error
        raise _broken(name, error, extra) from error


@contextmanager
def device_errors(device: str, *, library: str = "") -> Iterator[None]:
    """Turn what a driver raises within into a `DeviceError` of one line.

    Parameters
    ----------
    device : str
        What is being opened or used, as the user named it: ``"ni:Dev1/ai0:2"``.
    library : str
        The library in use; where its driver is missing, the line says which one that is.

    Raises
    ------
    DeviceError
        For every exception that is not one of this package's own.
    """
    try:
        yield
    except TactogramError:
        raise
    except Exception as error:
        driver = _missing_driver(error)
        needs = f"; it needs {DRIVERS[library]}" if driver and library in DRIVERS else ""
        why = one_line(error).rstrip(".")
        if isinstance(error, OSError) and error.errno in (errno.ENOENT, errno.EACCES) and not driver:
            # The system's words once; pyserial has them, the number and the name of the port twice.
            why = os.strerror(error.errno)
        raise DeviceError(f"{device.rstrip(':')}: {why}{needs}") from error


@contextmanager
def silenced() -> Iterator[None]:
    """Keep what compiled libraries write to the process's stderr from the user while the block runs.

    PortAudio, ALSA and liblsl tell their story there, line after line, whether or not anything is wrong; what is wrong
    they also return as an error. Where stderr has no file behind it, nothing is changed.
    """
    try:
        kept = os.dup(2)
    except OSError:
        yield
        return
    try:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        with suppress(OSError):
            os.dup2(kept, 2)
        os.close(kept)


def lsl(what: str = "Lab Streaming Layer") -> ModuleType:
    """Return ``pylsl``, told to keep its diary to itself unless the user's own settings say otherwise.

    Raises
    ------
    MissingExtraError, DeviceError
        As `imported`.
    """
    module = imported("pylsl", extra="lsl", what=what)
    if "LSLAPICFG" not in os.environ and hasattr(module, "set_config_content"):
        module.set_config_content(_LSL_SETTINGS)
    return module


def one_line(error: BaseException) -> str:
    """Return what ``error`` says in one line of at most 200 characters, or its kind where it says nothing."""
    # Some libraries raise a text and a number: as a pair they would be printed like one.
    said = ", ".join(map(str, error.args)) if str(error).startswith("(") else str(error)
    text = " ".join(said.split()) or type(error).__name__
    return text if len(text) <= 200 else f"{text[:197]}..."


def _missing_driver(error: BaseException) -> bool:
    """Tell whether a driver's library is what is missing: each says it in its own way."""
    name = type(error).__name__
    return (
        "DaqNotFound" in name
        or "NotInstalled" in name
        or (isinstance(error, FileNotFoundError | OSError) and "lib" in str(error).lower())
        or (isinstance(error, AttributeError) and "NoneType" in str(error))
    )


def _broken(name: str, error: BaseException, extra: str) -> MissingExtraError:
    return MissingExtraError(
        f"{name} is installed but does not import; reinstall the extra {extra} ({one_line(error)})"
    )
