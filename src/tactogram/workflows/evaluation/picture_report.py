"""Report and comparison of generated pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.datasets import Examples, part_examples
from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.attention_maps import attention_maps, attention_note
from tactogram.evaluation.pictures.distances import MEASURES
from tactogram.evaluation.pictures.figures import PictureCase, failures_figure, pictures_figure
from tactogram.evaluation.pictures.inversion import InversionLoss
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportTable, save_figure
from tactogram.features.photo_pairs import WeakPairs
from tactogram.training.picture_learner import PictureLearner
from tactogram.training.seeds import torch_seeded
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import LoadedRun, load_run, test_part

MOST_SHOWN = 9
"""Materials in a figure: as many as in the paper's Figure 3."""
MOST_PAIRS = 256
"""Pairs of the test part that are evaluated, evenly spread over it."""
BATCH = 32


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
                [cases(index, attention=True) for index in first], picture, attention_notes=notes
            ),
            "A crop of a photograph of the test part, the picture of a recording of the same material (a weak pair: it "
            "is not of the same place), the generated picture, and the Grad-CAM of the layer that its title names.",
        )
    )
    errors = (pairs.real - pairs.made).abs().mean(dim=(1, 2, 3)).tolist()
    blocks.append(
        ReportFigure(
            failures_figure(
                [cases(index) for index in range(len(errors))], errors, picture, measure="mean absolute error"
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
        column = generated_pairs(loaded, tested, MOST_PAIRS, progress)
        first = next(iter(columns.values()), column)
        if column.materials != first.materials or not torch.equal(column.photo, first.photo):
            raise ParameterError(
                f"{run}: tested on other pairs than {next(iter(columns))}; train on one split"
            )
        columns[name], picture = column, picture_generator(loaded).translation.picture
        if name in attention:
            photo = column.photo[[places[0] for places in column.by_material().values()][:MOST_SHOWN]]
            model = picture_generator(loaded)
            maps[name], notes[name] = _attention(model, photo), attention_note(model.gan.bare_generator)
    if picture is None:
        raise ParameterError("at least one run is needed, got none")
    reference = next(iter(columns.values()))
    cases = [
        PictureCase(
            material,
            reference.photo[places[0]],
            {"recorded": reference.real[places[0]]}
            | {name: pairs.made[places[0]] for name, pairs in columns.items()},
            {name: values[row] for name, values in maps.items()} or None,
        )
        for row, (material, places) in enumerate(list(reference.by_material().items())[:MOST_SHOWN])
    ]
    return save_figure(out, pictures_figure(cases, picture, attention_notes=notes))


def _cases(loaded: LoadedRun, pairs: PicturePairs) -> Any:
    model = picture_generator(loaded)

    def case(index: int, *, attention: bool = False) -> PictureCase:
        pictures = {"recorded": pairs.real[index], "made": pairs.made[index]}
        maps = None
        if attention:
            maps = {"made": _attention(model, pairs.photo[index : index + 1])[0]}
        return PictureCase(pairs.materials[index], pairs.photo[index], pictures, maps)

    return case


def _attention(model: PictureLearner[Any], photo: Tensor) -> Tensor:
    """Return Grad-CAM of photographs, shape (photograph, row, column)."""
    return attention_maps(model.gan.bare_generator.eval(), photo, *model.conditioning(photo))


@dataclass(frozen=True, eq=False)
class PicturePairs:
    """Photographs, shape (pair, 1, row, column), the recorded and the generated pictures of each, and the materials."""

    photo: Tensor
    real: Tensor
    made: Tensor
    materials: tuple[str, ...]
    label_accuracy: float | None

    def by_material(self) -> dict[str, NDArray[np.intp]]:
        """Return the places of each material's pairs."""
        return {
            name: np.flatnonzero(np.equal(self.materials, name).astype(bool))
            for name in sorted(set(self.materials))
        }


def generates_pictures(loaded: LoadedRun) -> bool:
    """Return whether a run generates spectrogram pictures from photographs."""
    return isinstance(loaded.model, PictureLearner)


def picture_generator(loaded: LoadedRun) -> PictureLearner[Any]:
    """Return the model of a run that generates spectrogram pictures; refuse others."""
    if not isinstance(loaded.model, PictureLearner):
        raise ParameterError(f"{loaded.facts.name} makes no spectrogram pictures of photographs")
    return loaded.model


def training_and_test(loaded: LoadedRun) -> tuple[Examples, Examples]:
    """Return training and test part; the same part twice where the protocol splits crops."""
    store, split = test_part(loaded.run)
    train, test = (
        part_examples(store, split, part, loaded.as_trained, label=loaded.run.data["label"])
        for part in ("train", "train" if picture_generator(loaded).config.window_protocol else "test")
    )
    return train, test


def pairs_of_test(loaded: LoadedRun, test: Examples) -> WeakPairs:
    """Return the pairs of the test part."""
    translation = picture_generator(loaded).translation
    pairs: WeakPairs | None = (
        translation.pairs(test, "test") if translation.config.window_protocol else translation.unseen(test)
    )
    if pairs is None:
        raise ParameterError(
            f"{loaded.run.name}: the test part has no photograph and recording that are large enough"
        )
    return pairs


def generated_pairs(
    loaded: LoadedRun, pairs: WeakPairs, most: int, progress: ProgressCallback
) -> PicturePairs:
    """Return at most ``most`` of the pairs, evenly spread, with the pictures that the run generates."""
    model = picture_generator(loaded)
    places = np.unique(np.linspace(0, len(pairs) - 1, min(len(pairs), most)).round().astype(int))
    batches, generated, correct = [], [], []
    with torch_seeded(loaded.recipe.seed, "judge pictures"):  # pix2pix draws its dropout in use
        for begin in range(0, len(places), BATCH):
            batch = pairs.batch(places[begin : begin + BATCH])
            batches.append(batch)
            generated.append(model.make(batch.photo).float().cpu())
            if model.predictor is not None:
                correct.append(model.predictor.probabilities(batch.photo).argmax(1).cpu() == batch.label)
            progress("make pictures", begin + len(batch.photo), len(places))
    sources = [pairs.photo_sources[crop // pairs.crops.per_photo] for crop in pairs.pairs[places, 0]]
    return PicturePairs(
        torch.cat([batch.photo for batch in batches]),
        torch.cat([batch.picture for batch in batches]),
        torch.cat(generated),
        tuple(source.material for source in sources),
        float(torch.cat(correct).float().mean()) if correct else None,
    )
