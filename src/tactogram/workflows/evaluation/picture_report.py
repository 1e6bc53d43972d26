"""Report and comparison of generated pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.attention_maps import attention_maps, attention_note
from tactogram.evaluation.pictures.distances import MEASURES
from tactogram.evaluation.pictures.figures import PictureCase, failures_figure, pictures_figure
from tactogram.evaluation.pictures.inversion import InversionLoss
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportTable, save_figure
from tactogram.training.picture_learner import PictureLearner
from tactogram.workflows.evaluation.picture_pairs import (
    MOST_PAIRS,
    PicturePairs,
    generated_pairs,
    pairs_of_test,
    picture_generator,
    training_and_test,
)
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import LoadedRun, load_run

MOST_SHOWN = 9
"""Materials in a figure: as many as in the paper's Figure 3."""


def picture_sections(
    loaded: LoadedRun, figures: dict[str, Any], pairs: PicturePairs, losses: dict[str, InversionLoss]
) -> list[ReportSection]:
    """Return the sections of a report on a run's pictures."""
    rows = [
        (MEASURES[name][0] if name in MEASURES else name, value, MEASURES.get(name, ("", "–"))[1])
        for name, value in figures["values"].items()
    ]
    caption = f"{figures['pictures']} pairs of the test part. {figures['protocol']}."
    missing = "".join(f" {name} is missing: {why}." for name, why in figures["missing"].items())
    blocks: list[Any] = [ReportTable(("measure", "value", "better"), rows, caption + missing)]
    cases = _cases(loaded, pairs)
    picture = picture_generator(loaded).translation.picture
    first = [places[0] for places in pairs.by_material().values()][:MOST_SHOWN]
    notes = {"made": attention_note(picture_generator(loaded).gan.bare_generator)}
    blocks.append(
        ReportFigure(
            pictures_figure(
                [cases(place, attention=True) for place in first], picture, attention_notes=notes
            ),
            "A crop of a photograph of the test part, the picture of a recording of the same material (a weak pair: it "
            "is not of the same place), the generated picture, and the Grad-CAM of the layer that its title names.",
        )
    )
    errors = (pairs.real - pairs.made).abs().mean(dim=(1, 2, 3)).tolist()
    blocks.append(
        ReportFigure(
            failures_figure(
                [cases(place) for place in range(len(errors))], errors, picture, measure="mean absolute error"
            ),
            "The worst, by measured error, one per material.",
        )
    )
    leak = figures["leak"]
    blocks.append(
        ReportTable(
            ("share of the tested crops", "photographs", "recordings"),
            [
                (text, leak[f"photo_{key}"], leak[f"recording_{key}"])
                for text, key in (
                    ("crops of one that was trained on", "known"),
                    ("crops that overlap one that was trained on", "overlaps"),
                    ("crops that were trained on themselves", "same"),
                )
            ],
            f"Leaks from training to test under the protocol: {leak['protocol']}.",
        )
    )
    sections = [ReportSection("Pictures", blocks)]
    if losses:
        lost = [(name, loss.floor, loss.inversion, loss.total, loss.network) for name, loss in losses.items()]
        table = ReportTable(
            (
                "measure",
                "other recordings",
                "pictured and inverted",
                "generated and inverted",
                "the network's part",
            ),
            lost,
            "Mean over materials, lower is better. Recordings converted to pictures and back lose phase and resolution "
            "alone; the further loss of generated pictures is the network's.",
        )
        sections.append(ReportSection("From pictures back to vibration", [table]))
    return sections


def compare_pictures(
    runs: Mapping[str, Path | str],
    out: Path,
    *,
    attention: Sequence[str] = (),
    progress: ProgressCallback = silent,
) -> Path:
    """Draw the pictures that several runs generate from the same photographs, a row per material: Figures 3 and 4.

    ``runs`` are by name, trained on one split. ``out`` is .png or .svg. The Grad-CAM of runs in ``attention`` is drawn
    too.

    Raises `ParameterError` if the runs were not tested on the same pairs.
    """
    columns: dict[str, PicturePairs] = {}
    maps: dict[str, Tensor] = {}
    notes: dict[str, str] = {}
    picture = None
    for name, run in runs.items():
        loaded = load_run(run)
        tested = pairs_of_test(loaded, training_and_test(loaded)[1])
        found = generated_pairs(loaded, tested, MOST_PAIRS, progress)
        first = next(iter(columns.values()), found)
        if found.materials != first.materials or not torch.equal(found.photo, first.photo):
            raise ParameterError(
                f"{run}: tested on other pairs than {next(iter(columns))}; train on one split"
            )
        columns[name], picture = found, picture_generator(loaded).translation.picture
        if name in attention:
            photo = found.photo[[places[0] for places in found.by_material().values()][:MOST_SHOWN]]
            model = picture_generator(loaded)
            maps[name], notes[name] = _attention(model, photo), attention_note(model.gan.bare_generator)
    if picture is None:
        raise ParameterError("at least one run is needed, got none")
    one = next(iter(columns.values()))
    cases = [
        PictureCase(
            material,
            one.photo[places[0]],
            {"recorded": one.real[places[0]]}
            | {name: pairs.made[places[0]] for name, pairs in columns.items()},
            {name: values[row] for name, values in maps.items()} or None,
        )
        for row, (material, places) in enumerate(list(one.by_material().items())[:MOST_SHOWN])
    ]
    return save_figure(out, pictures_figure(cases, picture, attention_notes=notes))


def _cases(loaded: LoadedRun, pairs: PicturePairs) -> Any:
    model = picture_generator(loaded)

    def case(place: int, *, attention: bool = False) -> PictureCase:
        pictures = {"recorded": pairs.real[place], "made": pairs.made[place]}
        maps = None
        if attention:
            maps = {"made": _attention(model, pairs.photo[place : place + 1])[0]}
        return PictureCase(pairs.materials[place], pairs.photo[place], pictures, maps)

    return case


def _attention(model: PictureLearner[Any], photo: Tensor) -> Tensor:
    """Return Grad-CAM of photographs, shape (photograph, row, column)."""
    return attention_maps(model.gan.bare_generator.eval(), photo, *model.conditioning(photo))
