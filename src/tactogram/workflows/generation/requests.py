"""Requests of generation."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Annotated

from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.request import Argument, Option
from tactogram.workflows.signal_options import SignalOptions

SPEEDS_MM_S, FORCES_N = (30.0, 60.0, 120.0, 240.0, 400.0), (0.3, 1.0, 3.0)
"""Of the strokes that a clone is made of."""
STROKE_S = 4.0


@dataclass(frozen=True)
class CloneRequest(SignalOptions):
    """Surfaces to clone: each recording and photograph, named like its file, each material of the model, and words.

    ``unit``, ``rate``, ``axes``, ``time``, ``sheet`` and ``part`` state what the files of the recordings do not.
    """

    recordings: Annotated[Sequence[Path | str], Argument("one stroke of each surface", "FILE")] = ()
    _: KW_ONLY
    out: Annotated[Path | str, Option("folder of the run", "RUN")]
    speed: Annotated[float | None, Option("speed of the recordings, mm/s, if known", "MM_S", above=0)] = None
    force: Annotated[float | None, Option("normal force of the recordings, N, if known", "N", above=0)] = None
    materials: Annotated[
        Sequence[str], Option("material of the model, instead of a recording", "NAME", "--material")
    ] = ()
    images: Annotated[
        Sequence[Path | str],
        Option(
            "photograph of a surface, instead of a recording, for a model trained on some", "FILE", "--image"
        ),
    ] = ()
    words: Annotated[
        Mapping[str, float] | None,
        Option("scores from 1 to 7 by word, instead of a recording", "rough=6,sticky=2"),
    ] = None
    speeds: Annotated[tuple[float, ...], Option("speeds to generate strokes at, mm/s", "MM_S,…")] = (
        SPEEDS_MM_S
    )
    forces: Annotated[tuple[float, ...], Option("forces to generate strokes at, N", "N,…")] = FORCES_N
    seconds: Annotated[float, Option("length of each stroke", above=0)] = STROKE_S
    model: Annotated[str, Option("run that generates the strokes", "RUN")] = "texture_flow"
    seed: Annotated[int, Option()] = 0
    progress: ProgressCallback = silent
