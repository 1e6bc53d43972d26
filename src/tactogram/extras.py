"""Optional device libraries: their import, and their errors as one line.

Training, generation and evaluation need none of them, so each is an extra. There are three kinds of failure, each with
its own remedy: the library is not installed (`MissingExtraError`: install the extra); its driver is missing; or the
device did not open or stopped responding (both `DeviceError`).
"""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from importlib import import_module
from types import ModuleType

from tactogram.errors import DeviceError, MissingDriverError, MissingExtraError, TactogramError, one_line

DRIVERS = {
    "sounddevice": "PortAudio, a system library (Debian: libportaudio2)",
    "nidaqmx": "NI-DAQmx, National Instruments' driver",
    "dwfpy": "WaveForms, Digilent's driver",
    "pylsl": "liblsl, the library of Lab Streaming Layer",
}
"""Driver that a library needs besides itself."""

# By default Lab Streaming Layer logs to stderr; -2 is errors only.
_LSL_SETTINGS = "[log]\nlevel = -2\n"


def imported(name: str, *, extra: str, what: str) -> ModuleType:
    """Import a module such as ``"pythonosc.udp_client"`` that needs an extra, without showing what it prints.

    Parameters
    ----------
    extra : str
        Extra of this package that contains it.
    what : str
        Purpose, to complete "is needed for …": ``"boards on a serial port"``.

    Raises
    ------
    MissingExtraError
        If it is not installed; names the extra.
    DeviceError
        If a driver is missing; names the driver.
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
            raise MissingDriverError(
                f"{package} is installed, but its driver was not found: {DRIVERS[package]}",
                remedy=f"install that for {what} ({one_line(error)})",
            ) from error
        raise _broken(name, error, extra) from error


@contextmanager
def device_errors(device: str, *, library: str = "") -> Iterator[None]:
    """Turn every foreign exception in the block into a `DeviceError` of one line.

    ``device``: device as the user named it: ``"ni:Dev1/ai0:2"``. ``library``: library in use; the error names its
    driver if that is missing.
    """
    try:
        yield
    except TactogramError:
        raise
    except Exception as error:
        driver = _missing_driver(error)
        needs = f"it needs {DRIVERS[library]}" if driver and library in DRIVERS else ""
        why = one_line(error).rstrip(".")
        if isinstance(error, OSError) and error.errno in (errno.ENOENT, errno.EACCES) and not driver:
            # The system's message once; pyserial repeats it, with the number and name of the port.
            why = os.strerror(error.errno)
        kind = MissingDriverError if needs else DeviceError
        raise kind(device.rstrip(":"), why, remedy=needs) from error


@contextmanager
def silenced() -> Iterator[None]:
    """Discard what compiled libraries write to the process's stderr during the block.

    PortAudio, ALSA and liblsl log there whether or not anything is wrong; actual problems are also returned as errors.
    """
    try:
        stderr = os.dup(2)
    except OSError:  # stderr has no file
        yield
        return
    try:
        with open(os.devnull, "wb") as null:
            os.dup2(null.fileno(), 2)
        yield
    finally:
        with suppress(OSError):
            os.dup2(stderr, 2)
        os.close(stderr)


def lsl(what: str = "Lab Streaming Layer") -> ModuleType:
    """Import ``pylsl`` with its log reduced to errors unless the user has settings for it; errors as `imported`."""
    module = imported("pylsl", extra="lsl", what=what)
    if "LSLAPICFG" not in os.environ and hasattr(module, "set_config_content"):
        module.set_config_content(_LSL_SETTINGS)
    return module


def digilents() -> dict[str, str]:
    """Return the connected Digilent devices by address, for sources and generators; errors as `imported`."""
    dwfpy = imported("dwfpy", extra="dwf", what="Digilent devices")
    with device_errors("digilent", library="dwfpy"):
        return {f"digilent:{d.serial_number}": "Digilent device" for d in dwfpy.Device.enumerate()}


def _missing_driver(error: BaseException) -> bool:
    """Return whether a driver's library is missing, which each library reports in its own way."""
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
