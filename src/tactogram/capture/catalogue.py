"""Catalogue of sources: one address each, ``kind:place?option=value&…``, and the devices at hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl

from pydantic import BaseModel, ConfigDict, Field

from tactogram.capture.logs.log import kind_of
from tactogram.capture.source import Source
from tactogram.capture.sources.audio import AudioFormat, AudioSource, audio_inputs
from tactogram.capture.sources.digilent import DigilentSource, ScopeFormat, digilent_devices
from tactogram.capture.sources.lsl import LslSource
from tactogram.capture.sources.nidaq import AnalogFormat, NiSource, ni_devices
from tactogram.capture.sources.serial_csv import CsvFormat, CsvSource
from tactogram.capture.sources.twelite import TweliteSource
from tactogram.capture.stream.byte_stream import BAUD, Replay, SerialPort
from tactogram.capture.stream.raw_log import log_facts, log_pieces
from tactogram.capture.twelite.simulator import SimulatedPort, SimulatedReceiver
from tactogram.errors import DeviceError, MissingExtraError, ParameterError
from tactogram.extras import imported, lsl
from tactogram.validation import validated


class TweliteOptions(BaseModel):
    """Options of ``twelite:PORT``."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    baud: int = Field(default=BAUD, ge=300, le=12_000_000)
    sender: str | None = None
    """Serial number of the sensor; by default the first one heard."""
    rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Nominal rate, Hz; the measured one stands beside it."""
    scale: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """What samples are multiplied by; 0.9765625 is the sensor's data sheet instead of its firmware."""
    log: str | None = None
    """A new file for all bytes."""


class SerialOptions(CsvFormat):
    """Options of ``serial:PORT``: how lines are to be read, and these."""

    baud: int = Field(default=BAUD, ge=300, le=12_000_000)
    log: str | None = None
    """A new file for all bytes."""


class LslOptions(BaseModel):
    """Options of ``lsl:NAME``."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    type: str | None = None
    """Find it by its type instead: ``lsl:?type=Acceleration``."""
    unit: str | None = None
    find_s: float = Field(default=3.0, gt=0, le=60)
    """How long to look for it."""


class LogOptions(CsvFormat):
    """Options of ``log:FILE``: how a board's lines are to be read, and these."""

    kind: str | None = Field(default=None, pattern="^(twelite|serial)$")
    sender: str | None = None


class SimulatedOptions(SimulatedReceiver):
    """Options of ``simulated:twelite``: what a simulated receiver does, and these."""

    file: str | None = None
    """A recording that the sensor feels: three axes in m/s^2."""
    paced: bool = True
    """Whether packets come when they are due; else as fast as they are read."""
    log: str | None = None
    """A new file for all bytes."""


class StoreReplayOptions(SimulatedReceiver):
    """Options of ``played:STORE``: what a simulated receiver does, and these."""

    materials: str = ""
    """Stroked in turn, separated by commas; ``all`` is every one. By default a session says what is stroked."""
    each_s: float = Field(default=5.0, gt=0, allow_inf_nan=False)
    """How long each is."""
    log: str | None = None
    """A new file for all bytes."""


@dataclass(frozen=True)
class AddressKind:
    """A kind of address.

    Parameters
    ----------
    example : str
    what : str
    options : type of BaseModel
    open : callable
        From address, place and options to a source, not entered yet.
    """

    example: str
    what: str
    options: type[BaseModel]
    open: Callable[[str, str, Any], Source]


def open_source(address: str) -> Source:
    """Return the source that an address names, not opened yet: entering it as a context opens the device.

    Parameters
    ----------
    address : str
        ``twelite:/dev/ttyUSB0``, ``serial:COM3?baud=230400&unit=g``, ``lsl:NAME``, ``audio:NAME``,
        ``ni:Dev1/ai0:2?rate=10000``, ``digilent:``, ``log:FILE``, ``simulated:twelite?loss=0.02&rate=330``. The
        options of each kind are the fields of its model in `KINDS`.

    Raises
    ------
    ParameterError
        If it names nothing, or an option is wrong; one line.
    """
    kind, place, options = parsed(address)
    return KINDS[kind].open(address, place, options)


def parsed(address: str) -> tuple[str, str, BaseModel]:
    """Return kind, place and options of an address.

    Raises
    ------
    ParameterError
        If it is none.
    """
    name, colon, rest = address.partition(":")
    if not colon or name not in KINDS:
        known = ", ".join(kind.example for kind in KINDS.values())
        raise ParameterError(f"a source must be one of {known}; got {address!r}")
    place, _, query = rest.partition("?")
    pairs = parse_qsl(query.replace("+", "%2B"), keep_blank_values=True)
    if query and len(pairs) != len(query.split("&")):
        raise ParameterError(f"{address}: options must be like rate=330&loss=0.02, got {query!r}")
    values = dict(pairs)
    if len(values) != len(pairs):
        raise ParameterError(f"{address}: each option may be given once, got {query!r}")
    return name, place, validated(KINDS[name].options, values, where=address)


def sources(*, find_s: float = 0.5) -> list[dict[str, Any]]:
    """Return what is there to be read from, and what could not be looked for.

    Parameters
    ----------
    find_s : float
        How long to look for streams of Lab Streaming Layer.

    Returns
    -------
    list of dict
        ``kind``, ``address`` (to be given to `open_source`; None where nothing was found), ``what``, and ``missing``
        (one line that says what is not installed; None otherwise).
    """
    found: list[dict[str, Any]] = []
    for kind, look in _LOOKS.items():
        try:
            there = look(find_s)
        except (MissingExtraError, DeviceError) as error:
            found.append({"kind": kind, "address": None, "what": KINDS[kind].what, "missing": str(error)})
            continue
        found += [{"kind": kind, "address": a, "what": what, "missing": None} for a, what in there.items()]
        if not there:
            found.append({"kind": kind, "address": None, "what": f"no {KINDS[kind].what}", "missing": None})
    simulated = KINDS["simulated"]
    found.append({"kind": "simulated", "address": simulated.example, "what": simulated.what, "missing": None})
    return found


def _ports(find_s: float) -> dict[str, str]:
    ports = imported("serial.tools.list_ports", extra="devices", what="sensors on a serial port")
    # Whether a receiver or a board hangs on it, a port does not say; USB ones are worth naming.
    return {
        f"serial:{p.device}": p.description if p.description not in ("", "n/a") else "serial port"
        for p in ports.comports()
    }


def _streams(find_s: float) -> dict[str, str]:
    streams = lsl().resolve_streams(find_s)
    return {f"lsl:{s.name()}": f"{s.channel_count()} x {s.nominal_srate():g} Hz, {s.type()}" for s in streams}


def _twelite(address: str, place: str, o: TweliteOptions) -> Source:
    port = SerialPort(_needed(place, address, "the port"), o.baud)
    return TweliteSource(port, name=address, sender=o.sender, rate=o.rate, scale=o.scale, log=o.log)


def _serial(address: str, place: str, o: SerialOptions) -> Source:
    port = SerialPort(_needed(place, address, "the port"), o.baud)
    form = CsvFormat(**o.model_dump(include=set(CsvFormat.model_fields)))
    return CsvSource(port, form, name=address, log=o.log)


def _lsl(address: str, place: str, o: LslOptions) -> Source:
    if not place and not o.type:
        raise ParameterError(f"{address}: must name a stream, or its type (?type=Acceleration)")
    return LslSource(place, name=address, kind=o.type, unit=o.unit, find_s=o.find_s)


def _log(address: str, place: str, o: LogOptions) -> Source:
    path = Path(_needed(place, address, "the file"))
    simulated = bool((log_facts(path) or {}).get("simulated"))
    stream = Replay(address, log_pieces(path))
    if (o.kind or kind_of(path)) == "twelite":
        return TweliteSource(stream, name=address, sender=o.sender, rate=o.rate, simulated=simulated)
    form = CsvFormat(**o.model_dump(include=set(CsvFormat.model_fields)))
    return CsvSource(stream, form, name=address, simulated=simulated)


def _simulated(address: str, place: str, o: SimulatedOptions) -> Source:
    if place != "twelite":
        raise ParameterError(f"{address}: what is simulated is twelite, got {place!r}")
    from tactogram.signal.io import read_signal

    receiver = SimulatedReceiver(**o.model_dump(include=set(SimulatedReceiver.model_fields)))
    signal = None if o.file is None else read_signal(o.file)
    port = SimulatedPort(receiver, signal, paced=o.paced)
    return TweliteSource(port, name=address, rate=receiver.rate, log=o.log, simulated=True)


def _played(address: str, place: str, o: StoreReplayOptions) -> Source:
    # A store brings in half of scipy, which no real sensor needs.
    from tactogram.capture.sources.played import StoreReplaySource
    from tactogram.datasets import open_store

    receiver = SimulatedReceiver(**o.model_dump(include=set(SimulatedReceiver.model_fields)))
    store = open_store(_needed(place, address, "the store"))
    names = tuple(name for name in o.materials.split(",") if name)
    return StoreReplaySource(
        store,
        receiver,
        name=address,
        materials=names,
        each_s=o.each_s,
        log=None if o.log is None else Path(o.log),
    )


def _needed(place: str, address: str, what: str) -> str:
    if not place:
        raise ParameterError(f"{address.rstrip(':')}: must name {what} after the colon")
    return place


KINDS: Mapping[str, AddressKind] = {
    "twelite": AddressKind("twelite:/dev/ttyUSB0", "TWE-Lite receiver", TweliteOptions, _twelite),
    "serial": AddressKind(
        "serial:/dev/ttyACM0?baud=115200", "board on a serial port", SerialOptions, _serial
    ),
    "lsl": AddressKind("lsl:NAME", "Lab Streaming Layer stream", LslOptions, _lsl),
    "audio": AddressKind(
        "audio:NAME?rate=48000", "audio input", AudioFormat, lambda a, p, o: AudioSource(p, o, name=a)
    ),
    "ni": AddressKind(
        "ni:Dev1/ai0:2?rate=10000",
        "National Instruments input",
        AnalogFormat,
        lambda a, p, o: NiSource(p, o, name=a),
    ),
    "digilent": AddressKind(
        "digilent:?channels=1,2", "Digilent input", ScopeFormat, lambda a, p, o: DigilentSource(p, o, name=a)
    ),
    "log": AddressKind("log:FILE", "log of a receiver or a board", LogOptions, _log),
    "simulated": AddressKind(
        "simulated:twelite?rate=330&loss=0.02", "simulated TWE-Lite receiver", SimulatedOptions, _simulated
    ),
    "played": AddressKind(
        "played:STORE?loss=0.02",
        "recordings played by a simulated TWE-Lite receiver",
        StoreReplayOptions,
        _played,
    ),
}
"""What an address may begin with."""

_LOOKS: Mapping[str, Callable[[float], dict[str, str]]] = {
    "serial": _ports,
    "lsl": _streams,
    "audio": lambda _: {f"audio:{name}": "audio input" for name in audio_inputs()},
    "ni": lambda _: {f"ni:{name}/ai0": "National Instruments device" for name in ni_devices()},
    "digilent": lambda _: {f"digilent:{serial}": "Digilent device" for serial in digilent_devices()},
}
