"""Requests of rendering, calibration, tracking and playback."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tactogram.errors import ParameterError
from tactogram.workflows.request import Argument, Option, Request
from tactogram.workflows.signal_options import SignalOptions

if TYPE_CHECKING:
    from tactogram.rendering.level import Level
    from tactogram.rendering.transducer.digilent import AnalogDiscovery

DISPLAY = "NAME|FILE"
_DISPLAY_CHANGES = Option("change a value of the display, e.g. limit=2", "KEY=VALUE", "--set")


@dataclass(frozen=True)
class DisplayRequest(Request):
    """A display to show, or all to list."""

    name: Annotated[str | None, Argument("display to show (default: list all)", DISPLAY)] = None
    changes: Annotated[Mapping[str, Any] | None, _DISPLAY_CHANGES] = None


@dataclass(frozen=True)
class RenderRequest(SignalOptions):
    """A signal to render for a display."""

    file: Annotated[Path | str, Argument("the signal", "FILE")]
    display: Annotated[str, Option("one of `displays`, or a TOML file", DISPLAY)]
    out: Annotated[
        Path | str, Option("the drive: .wav, .csv, .npz …; F.report.json is written next to it", "F")
    ]
    _: KW_ONLY
    level: Annotated[
        "str | Level", Option("physical, sensation, sensation=DB, gain=FACTOR or peak=SHARE", "LEVEL")
    ]
    how: Annotated[
        str | None,
        Option("how axes become one: dft321, mean, channels or the name of an axis", "WAY", "--as"),
    ] = None
    speed_mm_s: Annotated[
        float | None, Option("finger speed, for a signal over displacement", "MM_S", "--speed")
    ] = None
    calibration: Annotated[
        Path | str | None,
        Option("calibration of an electrovibration display, as `calibrate` wrote it", "F.toml"),
    ] = None
    person: Annotated[str | None, Option("person, where the calibration holds several", "NAME")] = None
    report_figure: Annotated[bool, Option("also draw the report: F.report.png", flag="--figure")] = False
    changes: Annotated[Mapping[str, Any] | None, _DISPLAY_CHANGES] = None


@dataclass(frozen=True)
class SweepRequest(Request):
    """A sweep that measures a display's response."""

    display: Annotated[str, Argument(metavar=DISPLAY)]
    out: Annotated[Path | str, Option(metavar="F")]
    _: KW_ONLY
    seconds: Annotated[float, Option("length of the sweep, s")] = 10.0
    share: Annotated[float, Option("amplitude as a share of the display's limit", above=0, most=1)] = 0.25
    band: Annotated[tuple[float, float] | None, Option("Hz; by default the display's", ("LO", "HI"))] = None
    changes: Annotated[Mapping[str, Any] | None, _DISPLAY_CHANGES] = None


@dataclass(frozen=True)
class ResponseRequest(SignalOptions):
    """A display's response to identify from a sweep and its recordings."""

    played: Annotated[Path | str, Argument("the sweep, as `sweep` wrote it", "PLAYED")]
    recorded: Annotated[
        Sequence[Path | str], Argument("the measured output; several takes are averaged", "RECORDED")
    ]
    out: Annotated[Path | str, Option(metavar="F.csv")]
    _: KW_ONLY
    band: Annotated[tuple[float, float] | None, Option("Hz; by default the sweep's", ("LO", "HI"))] = None
    axis: Annotated[str | None, Option("axis of the recordings, where they have several")] = None


@dataclass(frozen=True)
class CalibrationRequest(Request):
    """Pairs of voltage and friction to fit for an electrovibration display."""

    pairs: Annotated[
        Path | str,
        Argument("columns voltage_v_rms, friction; person and normal_force_n if known", "PAIRS.csv"),
    ]
    out: Annotated[Path | str, Option(metavar="F.toml")]
    _: KW_ONLY
    normal_force_n: Annotated[
        float | None, Option("normal force, where the table does not state it", "N", "--force")
    ] = None
    confidence: Annotated[float, Option("confidence of the intervals")] = 0.95


@dataclass(frozen=True)
class TrackRequest(Request):
    """A transducer whose resonance the carrier follows.

    ``changes`` are values of `TrackingSettings`, `MeasurementTiming` (``timing.settle_s``), `ScopeSettings`
    (``scope.rate``) and of the simulated `BenchSettings` (``bench.drift_hz_per_s``), by key.
    """

    display: Annotated[str, Option("ultrasonic, output = 'envelope'", DISPLAY)]
    _: KW_ONLY
    generator: Annotated[str, Option("digilent[:SERIAL], or simulated with its own bench", "DEVICE")] = (
        "simulated"
    )
    amps_per_volt: Annotated[float | None, Option("1 over the shunt's resistance in ohm", "A_V")] = None
    volts_per_volt: Annotated[float, Option("factor of the voltage probe", "V_V")] = 1.0
    skew_s: Annotated[float, Option("delay of the current's sample after the voltage's", "S", "--skew")] = 0.0
    share: Annotated[float, Option("share of the largest voltage", above=0, most=1)] = 0.25
    steps: Annotated[int, Option("steps after the lock", least=1, most=1_000_000)] = 100
    every_s: Annotated[
        float,
        Option("seconds from step to step; 0 is as fast as possible", "S", "--every", least=0, most=3600),
    ] = 0.0
    channel: Annotated[int, Option("channel of the generator")] = 1
    seed: Annotated[int, Option("seed of the simulated bench", least=0)] = 0
    changes: Annotated[
        Mapping[str, Any] | None,
        Option(
            "e.g. method=dither_conductance, timing.settle_s=0.1, scope.rate=200000, bench.drift_hz_per_s=1",
            "KEY=VALUE",
            "--set",
        ),
    ] = None
    out: Annotated[Path | str | None, Option("log of everything measured", "F.csv")] = None
    status: Callable[[str], None] | None = None
    """Receives a line now and then."""
    opened: "Callable[..., AnalogDiscovery] | None" = None
    """Opens the generator, in tests."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.generator.partition(":")[0] not in ("digilent", "simulated"):
            raise ParameterError(
                f"generator must be digilent, digilent:SERIAL or simulated, got {self.generator!r}"
            )


@dataclass(frozen=True)
class PlayRequest(Request):
    """A rendered drive to play on a device."""

    file: Annotated[Path | str, Argument("as `render` wrote it for the display", "DRIVE")]
    display: Annotated[str, Option("that display; a Digilent needs an envelope's", DISPLAY)]
    _: KW_ONLY
    device: Annotated[
        str, Option("digilent[:SERIAL], audio[:NAME], or null, with no actuator connected", "DEVICE")
    ] = "digilent"
    channel: Annotated[int, Option("channel of the Digilent")] = 1
    loop_s: Annotated[
        float | None, Option("repeat the drive for this time", "SECONDS", "--loop", above=0, most=1e6)
    ] = None
    strength: Annotated[float, Option("share of the drive, on audio and null", least=0, most=1)] = 1.0
    full_scale: Annotated[
        float | None,
        Option("voltage of the amplifier at the sound card's full scale, for a display driven in V", "V"),
    ] = None
    opened: "Callable[..., AnalogDiscovery] | None" = None
    """Opens the generator, in tests."""
