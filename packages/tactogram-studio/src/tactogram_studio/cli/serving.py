"""Verb that serves a study: the pages of its participants, and its progress to the experimenter."""

import sys
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any

from tactogram.cli.printing import Printer, lines_of
from tactogram.cli.verbs import Verb
from tactogram.workflows import Argument, Option
from tactogram_studio.cli.studio import ServerOptions, bound_port, shown_qr_code


@dataclass(frozen=True)
class _RunRequest(ServerOptions):
    study: Annotated[
        str,
        Argument(
            "a study: a TOML file, or one of `study list`; or the folder of a session to continue",
            "FILE|NAME|DIR",
        ),
    ]
    _: KW_ONLY
    out: Annotated[str | None, Option("folder of the session; created, or continued", "DIR")] = None
    device: Annotated[
        str,
        Option(
            "device for played_by = 'server' or 'stream': audio, audio:NAME or null; for 'stream' also digilent "
            "or osc:HOST:PORT"
        ),
    ] = "audio"
    full_scale: Annotated[
        float | None, Option("the device's full scale, in the unit of the display's drive", "X")
    ] = None
    track: Annotated[
        Mapping[str, Any] | None,
        Option("keep a Digilent's carrier at the transducer's resonance, as of `stream`", "KEY=VALUE"),
    ] = None
    participants: Annotated[
        tuple[str, ...],
        Option("codes to enrol beforehand; otherwise people get one as they join", "CODE,CODE,…"),
    ] = ()
    changes: Annotated[
        Mapping[str, Any] | None, Option("change a value of the study", "KEY=VALUE", "--set")
    ] = None


def _run(request: _RunRequest, show: Printer) -> None:
    from pathlib import Path

    from tactogram_study.study_file import Study
    from tactogram_study.workflows.stimuli import limited_lines

    def ready(facts: dict[str, Any]) -> None:
        addresses = {
            "experimenter": facts["experimenter"],
            "participants": facts["join"],
            **{f"participant {code}": address for code, address in facts["codes"].items()},
            "participants, by another": facts["addresses"],
            "certificate, SHA-256": facts["certificate_sha256"],
        }
        show(facts, lines_of(addresses) + ("" if port.loopback else shown_qr_code(facts["join"])))
        show.notes(limited_lines(facts["limited"]))
        sys.stdout.flush()
        sys.stderr.write("Ctrl-C ends it; run again to continue\n")

    if not Path(request.study).is_dir():
        Study.load(request.study, changes=request.changes)  # a wrong name is reported before a port in use

    with bound_port(request) as port:
        from tactogram_studio.study_server import run_study

        run_study(
            request.study,
            request.out,
            port,
            changes=request.changes or {},
            codes=list(request.participants),
            open_browser=request.open_browser,
            device=request.device,
            full_scale=request.full_scale,
            track=request.track,
            ready=ready,
        )
    sys.stderr.write("tactogram: the study's server ended; all answers are stored\n")


VERBS = {"study run": Verb(_RunRequest, _run, folders=("designs", "languages"))}
