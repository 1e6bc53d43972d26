"""Requests of evaluations and of ladders of mixes."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.request import Argument, Option, Request

if TYPE_CHECKING:
    from tactogram.workflows.training.loaded_run import LoadedRun


@dataclass(frozen=True)
class EvaluationRequest(Request):
    """A run to evaluate, by default on the test part of its own data; classes of other data are matched by name."""

    run: Annotated["Path | str | LoadedRun", Argument(metavar="RUN")]
    _: KW_ONLY
    data: Annotated[
        Path | str | None, Option("data set to evaluate on (default: the run's own test part)", "DIR")
    ] = None
    unknown: Annotated[bool, Option("also use the materials that were left out of training")] = False
    evaluation: Annotated[
        Mapping[str, Any] | None,
        Option(
            "for a generator: steps, window_s, longest_s, most or seed of the reference models", "KEY=VALUE"
        ),
    ] = None
    given: Annotated[
        str | None,
        Option("for a generator: the condition that describes surfaces, if it takes several", "CONDITION"),
    ] = None
    rater: Annotated[
        Path | str | None,
        Option("for a generator conditioned on words: the rater model that scores it", "RUN"),
    ] = None
    progress: ProgressCallback = silent


@dataclass(frozen=True)
class MixRequest(Request):
    """A generator and two of its materials to mix."""

    run: Annotated["Path | str | LoadedRun", Argument(metavar="RUN")]
    start: Annotated[str, Argument(metavar="A")]
    end: Annotated[str, Argument(metavar="B")]
    _: KW_ONLY
    mode: Annotated[Literal["sum", "add"], Option("weights that sum to 1, or A at 1 and B added")] = "sum"
    steps: Annotated[int, Option("weights of B from 0 to 1", least=2)] = 11
    signals: Annotated[int, Option("signals measured at each step", least=2)] = 6
    speed_mm_s: Annotated[float | None, Option("stroking speed, mm/s", "MM_S", "--speed")] = None
    force_n: Annotated[float | None, Option("normal force, N", "N", "--force")] = None
    seconds: Annotated[float | None, Option("length of each (default: the model's own)")] = None
    seed: Annotated[int, Option()] = 0
    out: Annotated[
        Path | str | None, Option("folder for figure, sounds and JSON (default RUN/mixing/A-B-MODE)", "DIR")
    ] = None
    reuse: bool = False
    """Return the ladder in ``out`` if it is of the same request."""
    progress: ProgressCallback = silent

    @property
    def condition(self) -> dict[str, float]:
        """Speed and force, where given."""
        known = {"speed_mm_s": self.speed_mm_s, "force_n": self.force_n}
        return {name: value for name, value in known.items() if value is not None}
