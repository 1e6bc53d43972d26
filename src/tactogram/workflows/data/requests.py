"""Requests on data sets and files of signals."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.request import ON, Argument, Option, Request
from tactogram.workflows.signal_options import SignalOptions

_WORKERS = Option("processes (default: all cores)", least=1)


@dataclass(frozen=True)
class ImportRequest(Request):
    """A published data set to import into a store."""

    set_name: Annotated[
        str, Argument("one of `tactogram data list`; `folder` for MATERIAL/*.wav and the like", "SET")
    ]
    path: Annotated[Path | str, Argument(metavar="PATH")]
    out: Annotated[Path | str | None, Option("the new store", "DIR")] = None
    _: KW_ONLY
    preview: Annotated[
        bool, Option("show what each column is read as and which files would be skipped; no store is written")
    ] = False
    mapping: Annotated[
        Path | str | None, Option("what the columns of the tables hold, of the set `folder`", "FILE.toml")
    ] = None
    save_mapping: Annotated[
        Path | str | None,
        Option("with --preview: write the mapping that it shows, to be edited", "FILE.toml"),
    ] = None
    skip_bad: Annotated[bool, Option("report broken files and continue without them")] = False
    options: Annotated[
        Mapping[str, Any] | None,
        Option("facts that the files do not state, e.g. rate=1000", "KEY=VALUE", "--set"),
    ] = None
    workers: Annotated[int | None, _WORKERS] = None
    progress: ProgressCallback = silent


@dataclass(frozen=True)
class SimulationRequest(Request):
    """A data set to simulate into a store that must not exist.

    With ``photographs`` the store has photographs of each surface, at places that do not overlap, for learning from
    photographs, and its recordings have none of their own. The recordings are the same for any number of ``workers``,
    and on Ray.
    """

    set_name: Annotated[str, Argument(metavar="SET")]
    out: Annotated[Path | str, Option(metavar="DIR")]
    _: KW_ONLY
    seed: Annotated[int, Option()] = 0
    per_class: Annotated[int | None, Option("recordings per class", "N")] = None
    rate: Annotated[float | None, Option(metavar="HZ")] = None
    seconds: Annotated[float | None, Option("length of a recording")] = None
    speeds_mm_s: Annotated[
        tuple[float, ...] | None,
        Option("stroking speeds (default: the paper's)", "MM_S,MM_S,...", "--speeds"),
    ] = None
    photographs: Annotated[
        int, Option("photographs of each surface, up to 9 places (default: one picture)", "N")
    ] = 0
    raters: Annotated[
        int | None, Option("simulated raters, in sets with ratings (default: the paper's)", "N")
    ] = None
    signals: Annotated[int | None, Option("display signals of ultrasonic (default: the paper's 39)", "N")] = (
        None
    )
    random: Annotated[int | None, Option("surfaces to draw, of the set `surfaces` (default: 100)", "N")] = (
        None
    )
    workers: Annotated[int | None, _WORKERS] = None
    on: Annotated[str, ON] = ""
    progress: ProgressCallback = silent


@dataclass(frozen=True)
class AdditionRequest(SignalOptions):
    """A signal file to add to a store as a recording; it is on the disk when the workflow returns."""

    path: Annotated[Path | str, Argument(metavar="DIR")]
    file: Annotated[Path | str, Argument(metavar="FILE")]
    _: KW_ONLY
    material: Annotated[str, Option(metavar="NAME")]
    stream: Annotated[str | None, Option("name of the stream (default: the store's only one)")] = None
    speed_mm_s: Annotated[float | None, Option("stroking speed, mm/s", "MM_S", "--speed", least=0)] = None
    force_n: Annotated[float | None, Option("normal force, N", "N", "--force", least=0)] = None
    contactor: Annotated[str | None, Option("what touched the surface", "NAME")] = None
    session: Annotated[str | None, Option("name of the session", "NAME")] = None
    subject: Annotated[str | None, Option("who stroked, as a code", "NAME")] = None
    photograph: Annotated[Path | str | None, Option("photograph of the surface", "FILE")] = None
    simulated: Annotated[bool, Option("the signal was computed, not measured")] = False


@dataclass(frozen=True)
class RatingRequest(Request):
    """Tables of ratings to add to a store, of one scale and the same words; all are added or none.

    ``settings`` are ``column.rater``, ``column.WORD``, … (the table's heading of it), ``words`` and ``ignore`` (names
    separated by commas), ``without`` (items to leave out), ``answers`` (texts, from the lowest to the highest score),
    ``item`` (``plate{:0>2}``, or one for each file, separated by commas) and ``encoding``.
    """

    path: Annotated[Path | str, Argument(metavar="DIR")]
    files: Annotated[
        Sequence[Path | str],
        Argument(
            "a row per score, or a column per word; or an export of PsychoPy, jsPsych, Qualtrics or Google Forms",
            "FILE",
        ),
    ]
    _: KW_ONLY
    scale: Annotated[str, Option("7-point, evoked, LOW:HIGH or LOW:HIGH:STEP")] = "7-point"
    replace: Annotated[bool, Option("replace existing ratings")] = False
    settings: Annotated[
        Mapping[str, Any] | None,
        Option(
            "column.rater=HEADING (or item, word, score, order, session, a word), words=A,B, ignore=A,B, "
            "without=A,B, answers=A,B, item=plate{:0>2}, encoding=cp932",
            "KEY=VALUE",
            "--set",
        ),
    ] = None


@dataclass(frozen=True)
class ConversionRequest(SignalOptions):
    """A signal to write in another format, with its metadata; ``target`` may be ``source``.

    ``unit``, ``rate``, ``axes``, ``time``, ``sheet`` and ``part`` state what ``source`` does not; of a
    haptic file ``rate`` is that of the carrier. A photograph is drawn as a relief (`tactogram.rendering.photo_relief`):
    its brightness is no prediction of how a material feels.
    """

    source: Annotated[
        Path | str, Argument("a signal, a haptic file, a folder of them, or a photograph to draw", "A")
    ]
    target: Annotated[Path | str, Argument("a file, by suffix; a folder if A is one", "B")]
    _: KW_ONLY
    format: Annotated[
        str | None,
        Option(
            "format of B, one of --list: if several share its suffix (.json), or for a folder",
            flag="--format --to",
        ),
    ] = None
    axis: Annotated[
        str | None,
        Option(
            "write one axis; formats that hold one take DFT321 of three, else the mean", "NAME|dft321|mean"
        ),
    ] = None
    full_scale: Annotated[
        float | None,
        Option("value of 1 in a haptic B, or of integer full scale in A, in the signal's unit", "X"),
    ] = None
    modality: Annotated[
        str | None, Option('of HJIF and formats like it, e.g. "Vibrotactile Texture" (default: by unit)')
    ] = None
    display: Annotated[
        str | None,
        Option(
            "motor of a pattern of on and off, whose shortest_ms holds (default: phone-on-off)", "NAME|FILE"
        ),
    ] = None
    map: Annotated[
        Literal["envelope", "pitch", "bands"] | None,
        Option(
            "map the sound A to touch: a tone with its strength (envelope) or at its pitch, or a tone for each band"
        ),
    ] = None
    play_at: Annotated[
        float | None,
        Option("finger speed for a signal over displacement, or a photograph (then 100)", "MM_S", above=0),
    ] = None
    width_mm: Annotated[
        float | None, Option("width that the photograph A shows (default: 100)", "MM", "--width", above=0)
    ] = None
    resample_to: Annotated[float | None, Option("rate of B", "HZ", "--resample")] = None
    subtype: Annotated[str | None, Option("sample format of B, e.g. PCM_16, PCM_24, FLOAT")] = None


@dataclass(frozen=True)
class DataExportRequest(Request):
    """A store to write as a data set of the Hugging Face Hub."""

    path: Annotated[Path | str, Argument(metavar="DIR")]
    _: KW_ONLY
    out: Annotated[Path | str, Option("new folder", "FOLDER")]
    push: Annotated[str | None, Option("also upload it, e.g. as lab/cork", "REPO")] = None
