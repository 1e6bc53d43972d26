"""Requests of simulated participants and analyses."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tactogram.workflows import Argument, Option, ProgressCallback, Request, silent

if TYPE_CHECKING:
    from tactogram.datasets import Scale

CHANGES = Option("change a value of the study", "KEY=VALUE", "--set")


@dataclass(frozen=True)
class ParticipantsRequest(Request):
    """Simulated participants to take a study, into a session folder."""

    study: Annotated[Path | str, Argument(metavar="FILE|NAME")]
    out: Annotated[Path | str, Option("folder of the session; created, or continued", "DIR")]
    _: KW_ONLY
    participants: Annotated[int, Option("number of simulated participants", "N", least=1)] = 20
    effect: Annotated[
        Mapping[str, Any] | None,
        Option("true effect, e.g. d_prime=1 or shift.generated=-10 (default: none)", "KEY=VALUE"),
    ] = None
    seed: Annotated[int, Option("seed of their answers")] = 0
    play: Annotated[bool, Option("generate and render stimuli and log their hashes")] = False
    changes: Annotated[Mapping[str, Any] | None, CHANGES] = None
    progress: ProgressCallback = silent


@dataclass(frozen=True)
class AnalysisRequest(Request):
    """Answers to analyse, of a session or a table.

    ``columns`` and ``constants`` read a foreign table; see `tactogram_study.session.answer_import.TableMapping`.
    ``analysis.json`` and ``analysis.txt`` keep the keys of items and conditions in every language. Figures use the
    names where a font with their letters is installed; else English names, or keys.
    """

    source: Annotated[
        Path | str,
        Argument("a table of answers (.csv, .tsv, .parquet), or a session's folder", "FILE|STORE"),
    ]
    out: Annotated[
        Path | str, Option("folder for report.html, analysis.json, analysis.txt and the figures", "DIR")
    ]
    _: KW_ONLY
    design: Annotated[
        str | None,
        Option(
            "only rows of this design; for a foreign table the design of all its rows: see `study designs`"
        ),
    ] = None
    margins: Annotated[
        Mapping[str, float] | None,
        Option(
            "margin of equivalence that replaces the study file's, e.g. which=0.1; reported as set afterwards",
            "QUESTION=VALUE",
            "--margin",
        ),
    ] = None
    alpha: Annotated[
        float | None, Option("significance level that replaces the study file's; likewise reported")
    ] = None
    practice: Annotated[bool, Option("analyse the practice trials instead of those that count")] = False
    targets: Annotated[
        Path | str | None, Option("target scores: ratings, or answers to a study of words", "F")
    ] = None
    targets_scale: Annotated["str | Scale", Option("scale of the target scores", "SCALE")] = "7-point"
    reference: Annotated[
        str | None, Option("condition whose mean scores are the targets instead", "CONDITION")
    ] = None
    columns: Annotated[
        Mapping[str, str] | None,
        Option(
            "foreign table: heading of one of our columns, e.g. participant=subject",
            "NAME=HEADING",
            "--column",
        ),
    ] = None
    constants: Annotated[
        Mapping[str, str] | None,
        Option(
            "foreign table: value of a column in every row, e.g. question=which", "NAME=VALUE", "--constant"
        ),
    ] = None
    encoding: Annotated[str, Option("encoding of a foreign table (default: detected)")] = ""
    draws: Annotated[int, Option("draws of the bootstraps")] = 2000
    seed: Annotated[int, Option("seed of the bootstraps")] = 0
    figures: Annotated[bool, Option("write no PNG", flag="--no-figures")] = True
    language: Annotated[
        str,
        Option(
            "language of item and condition names in the report; by default English, or the study's first"
        ),
    ] = ""
