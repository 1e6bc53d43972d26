"""Request of a stream, and combinations that are refused before anything moves."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tactogram.errors import ParameterError
from tactogram.workflows.request import Argument, Option
from tactogram.workflows.signal_options import SignalOptions

if TYPE_CHECKING:
    from tactogram.rendering.transducer.digilent import AnalogDiscovery


@dataclass(frozen=True)
class StreamRequest(SignalOptions):
    """Runs and files to stream under a finger; by default ten seconds under a simulated hand, to no actuator."""

    sources: Annotated[
        Sequence[Path | str] | Path | str,
        Argument("generators and signals, streamed at the same time", "RUN|FILE"),
    ]
    _: KW_ONLY
    motion: Annotated[str, Option("where the finger's motion comes from", "simulated|osc|mouse|FILE")] = (
        "simulated"
    )
    backend: Annotated[
        Literal["null", "file", "clock", "audio", "osc", "digilent"], Option("where the blocks go")
    ] = "null"
    display: Annotated[str | None, Option("one of `displays`, or a TOML file", "NAME|FILE")] = None
    level: Annotated[
        str | None, Option("as of `render`; found under a simulated hand before the stream begins", "LEVEL")
    ] = None
    changes: Annotated[
        Mapping[str, Any] | None,
        Option("change a value of the display, e.g. linear.cap_db=10", "KEY=VALUE", "--set"),
    ] = None
    seconds: Annotated[float, Option(above=0, most=24 * 3600)] = 10.0
    mix: Annotated[
        Mapping[str, float] | None,
        Option("weights by material or file stem (default: all the same)", "A=0.6,B=0.4"),
    ] = None
    mix_to: Annotated[
        Mapping[str, float] | None, Option("weights at the end, reached while it plays", "A=0,B=1")
    ] = None
    speed_mm_s: Annotated[
        float | None,
        Option("speed at which signals over time were recorded or are generated", "MM_S", "--speed"),
    ] = None
    along: Annotated[Literal["path", "x", "y"], Option("path or axis over which a surface is laid out")] = (
        "path"
    )
    how: Annotated[str | None, Option("how axes become one: dft321 or an axis's name", "WAY", "--as")] = None
    block_ms: Annotated[float, Option("length of a block", "MS", "--block", above=0, most=5)] = 5.0
    listen: Annotated[str, Option("address that receives motion (default 127.0.0.1:9120)", "HOST:PORT")] = ""
    to: Annotated[
        str, Option("address that receives blocks (default: the sender of the motion)", "HOST:PORT")
    ] = ""
    device: Annotated[
        str | None, Option("a sound card, by name or number; the serial number of a Digilent", "NAME")
    ] = None
    full_scale: Annotated[
        float | None,
        Option("voltage of the amplifier at the sound card's full scale, for a display driven in V", "V"),
    ] = None
    tap_gain: Annotated[
        float, Option("gain of a landing's transient, 0 for none", "GAIN", "--tap", least=0)
    ] = 4.0
    realtime: Annotated[bool, Option("ask the system for real-time priority")] = False
    track: Annotated[
        Mapping[str, Any] | None,
        Option(
            "keep a Digilent's carrier at the transducer's resonance, e.g. amps_per_volt=0.1,every_s=0.5; further keys "
            "as of `track --set`",
            "KEY=VALUE",
        ),
    ] = None
    seed: Annotated[int, Option("seed of noise and simulated hand", least=0)] = 0
    out: Annotated[Path | str | None, Option("file of the blocks sent: .wav, .csv, .npz …", "F")] = None
    figure: Annotated[Path | str | None, Option("its spectrogram under the finger's speed, as .png", "F")] = (
        None
    )
    status: Callable[[str, float], None] | None = None
    """Receives a line now and then, and the time in s."""
    tell: Callable[[str], None] | None = None
    """Receives a line about the display's equaliser before anything plays."""
    opened: "Callable[..., AnalogDiscovery] | None" = None
    """Opens the generator, in tests."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.display is None) != (self.level is None):
            raise ParameterError(
                "a display needs a level and a level a display: give `display` and `level`, or neither"
            )
        if self.backend in ("audio", "digilent") and self.display is None:
            raise ParameterError(
                f"the {self.backend} backend moves an actuator: give its `display`, and `level`"
            )
        if self.track is not None and self.backend != "digilent":
            raise ParameterError(f"the carrier of a Digilent is tracked, got the backend {self.backend}")
        if self.backend == "file" and self.motion in ("osc", "mouse"):
            raise ParameterError(
                f"backend file is not in real time, so motion cannot come from {self.motion}: use clock"
            )
