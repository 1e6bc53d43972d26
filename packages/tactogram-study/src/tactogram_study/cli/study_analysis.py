"""Verbs that analyse a study, and its power: `study analyse`, `power`."""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

from tactogram.cli.printing import Printer
from tactogram.cli.verbs import Verb
from tactogram.workflows import Argument, Option, Request
from tactogram_study.workflows.requests import AnalysisRequest


@dataclass(frozen=True)
class _PowerRequest(Request):
    design: Annotated[
        str,
        Argument(
            "a power table, see `study designs`; or a study, whose margin, alpha and trials are used",
            "TABLE|FILE|NAME",
        ),
    ]
    _: KW_ONLY
    participants: Annotated[tuple[int, ...], Option("numbers of participants", "N,N,…")] = ()
    trials: Annotated[tuple[int, ...], Option("trials per participant", "N,N,…")] = ()
    effect: Annotated[float | None, Option("true effect")] = None
    person_sd: Annotated[float | None, Option("standard deviation of effects between people")] = None
    trial_sd: Annotated[float | None, Option("standard deviation of single answers")] = None
    margin: Annotated[float | None, Option("margin of equivalence")] = None
    items: Annotated[int | None, Option("number of items compared with each other")] = None
    simulations: Annotated[int, Option("studies of simulated participants per row")] = 2000
    seed: Annotated[int, Option("seed of the simulations")] = 0


def _analyse(request: AnalysisRequest, show: Printer) -> None:
    from tactogram_study.workflows.analysis import analyse_study

    result = analyse_study(**vars(request))
    text = result.pop("text")
    show(
        result,
        "\n".join([text, *result["notes"]]) + f"\nwritten: {', '.join(result['files'])} in {result['out']}",
    )


def _power(request: _PowerRequest, show: Printer) -> None:
    from tactogram_study.workflows.power import study_power

    with show.progress() as progress:
        result = study_power(**vars(request) | {"progress": progress})
    show(result, result.pop("text"))


VERBS = {
    "study analyse": Verb(AnalysisRequest, _analyse, folders=("designs", "languages")),
    "study power": Verb(_PowerRequest, _power, folders=("designs", "languages")),
}
