"""Evaluation of a run's pictures: distances of pictures, and of the signals inverted from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.datasets import Examples
from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.attention_maps import attention_maps, attention_note
from tactogram.evaluation.pictures.distances import MEASURES, PictureEvaluator, PictureWeights
from tactogram.evaluation.pictures.figures import PictureCase, failures_figure, pictures_figure
from tactogram.evaluation.pictures.inversion import InversionLoss, inversion_loss, mean_loss
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportTable, save_figure
from tactogram.features.pair_leak import pair_leak
from tactogram.features.photo_pairs import WeakPairs
from tactogram.model import PictureGenerator
from tactogram.training.seeds import torch_seeded
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import LoadedRun, load_run, part_examples, test_part

MOST_PAIRS = 256
"""Pairs of the test part that are judged, evenly spread over it."""
MOST_INVERTED = 12
"""Pictures of each material whose signals are judged."""
MOST_SHOWN = 9
"""Materials in the figure: as many as the paper's Figure 3 has."""
BATCH = 32


def generates_pictures(loaded: LoadedRun) -> bool:
    """Whether a run turns photographs into spectrogram pictures."""
    return isinstance(loaded.model, PictureGenerator)


def _generator(loaded: LoadedRun) -> PictureGenerator:
    if not isinstance(loaded.model, PictureGenerator):
        raise ParameterError(f"{loaded.facts.name} makes no spectrogram pictures of photographs")
    return loaded.model


def _attention(model: PictureGenerator, photo: Tensor) -> Tensor:
    """Return Grad-CAM of photographs, shape (photograph, row, column)."""
    return attention_maps(model.gan.bare_generator.eval(), photo, *model.conditioning(photo))


def evaluate_pictures(
    run: Path | str | LoadedRun,
    *,
    weights: PictureWeights | None = None,
    most: int = MOST_PAIRS,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Return how far the pictures of ``run`` are from those of recordings that it was not trained on.

    Parameters
    ----------
    run : path or LoadedRun
        Of a model that turns photographs into spectrogram pictures.
    weights : PictureWeights, optional
        Where the networks of LPIPS and FID are; by default in torch's cache.
    most : int
        Pairs that are judged.

    Returns
    -------
    dict
        What `PictureJudgement.as_dict` gives; ``per_material`` the log-spectral distance of each; ``label_accuracy``
        where the model names surfaces; ``leak``, what of the test part was trained on (`PairLeak`); ``inversion``,
        whose the loss of the inverted signals is (`InversionLoss`, with ``network`` and ``share_of_inversion``);
        ``split`` and
        ``simulated``.

    Raises
    ------
    ParameterError
        If the model makes no pictures, or no photograph or recording of the test part is large enough.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    return _judged(loaded, weights, most, progress)[0]


def evaluate_run_pictures(
    run: Path | str | LoadedRun,
    *,
    weights: PictureWeights | None = None,
    most: int = MOST_PAIRS,
    progress: ProgressCallback = silent,
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return the figures of `evaluate_pictures` and the sections of a report on them."""
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    found, pairs, losses = _judged(loaded, weights, most, progress)
    return found, _sections(loaded, found, pairs, losses)


def _judged(
    loaded: LoadedRun, weights: PictureWeights | None, most: int, progress: ProgressCallback
) -> tuple[dict[str, Any], _PicturePairs, dict[str, InversionLoss]]:
    translation = _generator(loaded).translation
    picture = translation.picture
    train, test = _parts(loaded)
    tested = _tested(loaded, test)
    pairs = _pairs(loaded, tested, most, progress)
    found = PictureEvaluator(picture, weights=weights or PictureWeights())(pairs.real, pairs.made).as_dict()
    plain = PictureEvaluator(picture, networks=False)
    found["per_material"] = {
        name: plain(pairs.real[places], pairs.made[places]).values["log_spectral_distance_db"]
        for name, places in pairs.by_material().items()
        if len(places) > 1
    }
    if pairs.named_rightly is not None:
        found["label_accuracy"] = pairs.named_rightly
    leak = pair_leak(translation.pairs(train), tested)
    found["leak"] = asdict(leak) | {"leaks": leak.leaks}
    losses = _inversion(loaded, pairs, train, test, progress)
    found["inversion"] = {
        name: asdict(loss) | {"network": loss.network, "share_of_inversion": loss.share_of_inversion}
        for name, loss in losses.items()
    }
    found |= {"split": loaded.run.data["split"], "simulated": loaded.simulated}
    return found, pairs, losses


@dataclass(frozen=True, eq=False)
class _PicturePairs:
    """Photographs (pair, 1, row, column), the pictures of their pairs and those made of them, and the materials."""

    photo: Tensor
    real: Tensor
    made: Tensor
    materials: tuple[str, ...]
    named_rightly: float | None

    def by_material(self) -> dict[str, NDArray[np.intp]]:
        return {
            name: np.flatnonzero(np.equal(self.materials, name).astype(bool))
            for name in sorted(set(self.materials))
        }


def _parts(loaded: LoadedRun) -> tuple[Examples, Examples]:
    """Return training and test part; the same twice where the protocol splits crops instead."""
    store, split = test_part(loaded.run)
    train, test = (
        part_examples(store, split, part, loaded.as_trained, label=loaded.run.data["label"])
        for part in ("train", "train" if _generator(loaded).translation.crop_protocol else "test")
    )
    return train, test


def _tested(loaded: LoadedRun, test: Examples) -> WeakPairs:
    """Return the pairs of the test part."""
    translation = _generator(loaded).translation
    pairs: WeakPairs | None = (
        translation.pairs(test, "test") if translation.crop_protocol else translation.unseen(test)
    )
    if pairs is None:
        raise ParameterError(
            f"{loaded.run.name}: the test part has no photograph and recording that are large enough to be judged by"
        )
    return pairs


def _pairs(loaded: LoadedRun, pairs: WeakPairs, most: int, progress: ProgressCallback) -> _PicturePairs:
    model = _generator(loaded)
    places = np.unique(np.linspace(0, len(pairs) - 1, min(len(pairs), most)).round().astype(int))
    batches, made, named = [], [], []
    with torch_seeded(loaded.recipe.seed, "judge pictures"):  # pix2pix draws its dropout in use
        for begin in range(0, len(places), BATCH):
            batch = pairs.batch(places[begin : begin + BATCH])
            batches.append(batch)
            made.append(model.make(batch.photo).float().cpu())
            if model.predictor is not None:
                named.append(model.predictor.probabilities(batch.photo).argmax(1).cpu() == batch.label)
            progress("make pictures", begin + len(batch), len(places))
    sources = [pairs.photo_sources[crop // pairs.crops.per_photo] for crop in pairs.pairs[places, 0]]
    return _PicturePairs(
        torch.cat([batch.photo for batch in batches]),
        torch.cat([batch.picture for batch in batches]),
        torch.cat(made),
        tuple(source.material for source in sources),
        float(torch.cat(named).float().mean()) if named else None,
    )


def _inversion(
    loaded: LoadedRun, pairs: _PicturePairs, train: Examples, test: Examples, progress: ProgressCallback
) -> dict[str, InversionLoss]:
    """Return the loss of the inverted signals, the mean over materials."""
    translation = _generator(loaded).translation
    picture, places = translation.picture, pairs.by_material()
    held: dict[str, list[list[Any]]] = {name: [[], []] for name in places}
    # Crops of the same recordings have no floor: a recording beside itself is no other recording.
    parts = (test,) if translation.crop_protocol else (test, train)
    for side, part in enumerate(parts):
        for example in part:
            if example.material in held and len(example.signal) >= picture.length:
                held[example.material][side].append(example.signal)
    losses = []
    for done, (name, (real, others)) in enumerate(held.items(), 1):
        if real:
            made = pairs.made[places[name][:MOST_INVERTED]]
            losses.append(inversion_loss(real, made, picture, others=others, seed=loaded.recipe.seed))
        progress("invert pictures", done, len(held))
    return mean_loss(losses) if losses else {}


def compare_pictures(
    runs: Mapping[str, Path | str],
    out: Path,
    *,
    attention: Sequence[str] = (),
    progress: ProgressCallback = silent,
) -> Path:
    """Draw what several runs make of the same photographs, a row per material, beside a recording: Figures 3 and 4.

    Parameters
    ----------
    runs : mapping from str to path
        By what they are called; trained on one split.
    out : Path
        The figure, .png or .svg.
    attention : sequence of str
        Runs whose Grad-CAM is drawn too.

    Raises
    ------
    ParameterError
        If the runs were not tested on the same pairs.
    """
    columns: dict[str, _PicturePairs] = {}
    maps: dict[str, Tensor] = {}
    notes: dict[str, str] = {}
    picture = None
    for name, run in runs.items():
        loaded = load_run(run)
        tested = _tested(loaded, _parts(loaded)[1])
        found = _pairs(loaded, tested, MOST_PAIRS, progress)
        first = next(iter(columns.values()), found)
        if found.materials != first.materials or not torch.equal(found.photo, first.photo):
            raise ParameterError(
                f"{run}: tested on other pairs than {next(iter(columns))}; train on one split"
            )
        columns[name], picture = found, _generator(loaded).translation.picture
        if name in attention:
            photo = found.photo[[places[0] for places in found.by_material().values()][:MOST_SHOWN]]
            model = _generator(loaded)
            maps[name], notes[name] = _attention(model, photo), attention_note(model.gan.bare_generator)
    if picture is None:
        raise ParameterError("at least one run is needed, got none")
    one = next(iter(columns.values()))
    cases = [
        PictureCase(
            material,
            one.photo[places[0]],
            {"recorded": one.real[places[0]]}
            | {name: held.made[places[0]] for name, held in columns.items()},
            {name: values[row] for name, values in maps.items()} or None,
        )
        for row, (material, places) in enumerate(list(one.by_material().items())[:MOST_SHOWN])
    ]
    return save_figure(out, pictures_figure(cases, picture, attention_notes=notes))


# -- the report -----------------------------------------------------------------------------------------------


def _sections(
    loaded: LoadedRun, found: dict[str, Any], pairs: _PicturePairs, losses: dict[str, InversionLoss]
) -> list[ReportSection]:
    rows = [
        (MEASURES[name][0] if name in MEASURES else name, value, MEASURES.get(name, ("", "–"))[1])
        for name, value in found["values"].items()
    ]
    caption = f"{found['pictures']} pairs of the test part. {found['protocol']}."
    missing = "".join(f" {name} is missing: {why}." for name, why in found["missing"].items())
    blocks: list[Any] = [ReportTable(("measure", "value", "better"), rows, caption + missing)]
    cases = _cases(loaded, pairs)
    picture = _generator(loaded).translation.picture
    first = [places[0] for places in pairs.by_material().values()][:MOST_SHOWN]
    notes = {"made": attention_note(_generator(loaded).gan.bare_generator)}
    blocks.append(
        ReportFigure(
            pictures_figure(
                [cases(place, attention=True) for place in first], picture, attention_notes=notes
            ),
            "A crop of a photograph of the test part, the picture of a recording of the same material (a weak pair: it "
            "is not of the same place), the picture made, and where the last layer was active (Grad-CAM).",
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
    leak = found["leak"]
    blocks.append(
        ReportTable(
            ("of what was tested", "photographs", "recordings"),
            [
                (what, leak[f"photo_{key}"], leak[f"recording_{key}"])
                for what, key in (
                    ("crops of one that was trained on", "known"),
                    ("crops that overlap one that was trained on", "overlaps"),
                    ("crops that were trained on themselves", "same"),
                )
            ],
            f"What the protocol, {leak['protocol']}, lets pass from training to test; shares of the tested crops.",
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
                "made and inverted",
                "the network's part",
            ),
            lost,
            "Mean over materials, lower is better. Whose the loss is: recordings made to pictures and back pay for "
            "phase and resizing alone; what generated pictures add is the network's.",
        )
        sections.append(ReportSection("From pictures back to vibration", [table]))
    return sections


def _cases(loaded: LoadedRun, pairs: _PicturePairs) -> Any:
    model = _generator(loaded)

    def case(place: int, *, attention: bool = False) -> PictureCase:
        pictures = {"recorded": pairs.real[place], "made": pairs.made[place]}
        maps = None
        if attention:
            maps = {"made": _attention(model, pairs.photo[place : place + 1])[0]}
        return PictureCase(pairs.materials[place], pairs.photo[place], pictures, maps)

    return case
